use citylod::import::{ImportError, Imported, Options, import};

use crate::desk::Desk;
use crate::written::{SQUARE, assert_warnings, feature, import_content};

/// A footprint of three positions from (x, y) on, `size` large.
fn triangle(x: f64, y: f64, size: f64) -> String {
    let (far_x, far_y) = (x + size, y + size);
    format!("[[[{x},{y}],[{far_x},{y}],[{far_x},{far_y}],[{x},{y}]]]")
}

fn lines(footprints: &[String]) -> Imported {
    let features: Vec<String> = footprints
        .iter()
        .map(|f| feature(r#"{"h":1}"#, f))
        .collect();
    import_content("x.geojsonl", features.join("\n").as_bytes()).unwrap()
}

fn crs(name: &str) -> String {
    format!(r#""crs":{{"type":"name","properties":{{"name":"{name}"}}}}"#)
}

/// A collection of one footprint, with a `crs` before the features and one behind.
fn collection(before: &str, footprint: &str, behind: &str) -> String {
    let member = |name: &str| match name {
        "" => r#""note":0"#.to_owned(),
        name => crs(name),
    };
    format!(
        r#"{{{},"type":"FeatureCollection","features":[{}],{}}}"#,
        member(before),
        feature(r#"{"h":1}"#, footprint),
        member(behind)
    )
}

/// It imported.
fn between(before: &str, footprint: &str, behind: &str) -> Result<Imported, ImportError> {
    let text = collection(before, footprint, behind);
    import_content("x.geojson", text.as_bytes())
}

#[test]
fn metres_without_a_system_are_told_of_once() {
    let square = format!("[{SQUARE}]");
    let imported = lines(&[square.clone(), square.clone()]);
    assert_eq!(imported.scene.crs, None);
    let told = "no coordinate reference system is given";
    assert_eq!(
        imported
            .warnings
            .iter()
            .filter(|w| w.what.contains(told))
            .count(),
        1
    );
    assert!(imported.warnings[0].what.contains("taken as metres"));
    assert_warnings(&between("EPSG:6677", &square, "").unwrap(), &[]);
    assert_warnings(&lines(&[triangle(139.7, 35.7, 0.001)]), &[]);
}

#[test]
fn latitude_before_longitude_is_told_of_where_it_can_be_seen() {
    let told = |imported: &Imported| {
        let warnings = imported.warnings.iter();
        warnings
            .filter(|w| w.what.contains("latitude before longitude"))
            .count()
    };
    let turned = triangle(35.7, 139.7, 0.001);
    let imported = lines(&[turned.clone(), turned.clone()]);
    assert_eq!(told(&imported), 1);
    assert!(imported.warnings[0].what.contains("such as 35.7, 139.7"));
    assert!(!imported.warnings[0].what.contains("no coordinate"));
    // Whatever the other files say, and where they are too far apart.
    let beside = |crs: &str, x: f64| {
        let folder = tempfile::tempdir().unwrap();
        let other = folder.path().join("other.geojson");
        let square = triangle(x, x, 500.0);
        std::fs::write(&other, collection(crs, &square, "")).unwrap();
        let path = folder.path().join("turned.geojson");
        std::fs::write(&path, feature(r#"{"h":1}"#, &turned)).unwrap();
        import(&[other, path], &Options::default(), &|_, _| {})
    };
    assert_eq!(told(&beside("EPSG:6677", 1000.0).unwrap()), 1);
    assert_eq!(told(&beside("", 20_000.0).unwrap()), 1);
    let refused = beside("EPSG:6677", 500_000.0).unwrap_err().to_string();
    assert!(
        refused.contains("too far for one city; positions such as 35.7, 139.7"),
        "{refused}"
    );
    // A house in metres, and places that may be either.
    assert_eq!(told(&lines(&[triangle(35.7, 139.7, 10.0)])), 0);
    assert_eq!(told(&lines(&[triangle(52.01, 4.36, 0.001)])), 0);
    // The file says that they are degrees, whose order GeoJSON sets.
    let stated = between("EPSG:4326", &turned, "").unwrap();
    assert_eq!(told(&stated), 1);
    assert!(stated.scene.objects.is_empty());
}

#[test]
fn metres_near_the_origin_that_are_read_as_degrees_are_told_of() {
    let warnings = |size: f64, before: &str| {
        let imported = between(before, &triangle(10.0, 20.0, size), "").unwrap();
        let warnings = imported.warnings.into_iter();
        warnings
            .filter(|w| w.what.contains("over a degree wide"))
            .count()
    };
    assert_eq!(warnings(8.0, ""), 1);
    assert_eq!(warnings(0.5, ""), 0);
    assert_eq!(warnings(8.0, "EPSG:4326"), 0);
    assert_eq!(warnings(8.0, "EPSG:6677"), 0);
}

#[test]
fn a_crs_behind_the_features_counts_where_they_were_read_so() {
    let (square, degrees) = (format!("[{SQUARE}]"), triangle(139.7, 35.7, 0.001));
    for (footprint, behind, crs) in [
        (&square, "EPSG:6677", "EPSG:6677"),
        (&degrees, "EPSG:4326", "EPSG:32654"),
        (&degrees, "OGC:CRS84", "EPSG:32654"),
    ] {
        let imported = between("", footprint, behind).unwrap();
        assert_eq!(imported.scene.crs.as_deref(), Some(crs), "{behind}");
        assert_warnings(&imported, &[]);
    }
    let older = between("", &degrees, "EPSG:4267").unwrap();
    assert_warnings(
        &older,
        &[("", "/crs", "EPSG:4267 are read as those of WGS 84")],
    );
    assert_warnings(&between("EPSG:6677", &square, "EPSG:6677").unwrap(), &[]);
    // It ties the file to the others as one before the features does.
    let folder = tempfile::tempdir().unwrap();
    let paths = ["EPSG:6677", "EPSG:28992"].map(|name| {
        let path = folder.path().join(format!("{}.geojson", &name[5..]));
        let feature = feature("{}", &square);
        let text = format!(
            r#"{{"type":"FeatureCollection","features":[{feature}],{}}}"#,
            crs(name)
        );
        std::fs::write(&path, text).unwrap();
        path
    });
    let both = import(&paths, &Options::default(), &|_, _| {});
    assert!(
        matches!(both, Err(ImportError::CrsMismatch { .. })),
        "{both:?}"
    );
}

#[test]
fn a_crs_behind_features_that_were_read_otherwise_is_told_of() {
    let (square, degrees) = (format!("[{SQUARE}]"), triangle(139.7, 35.7, 0.001));
    let behind = |what: &'static str| ("", "/crs", what);
    assert_warnings(
        &between("", &degrees, "EPSG:6677").unwrap(),
        &[behind(
            "EPSG:6677 is stated behind the features, which were read as longitudes and",
        )],
    );
    // Degrees of a system that is not known here would be taken as metres if it came before them.
    assert_warnings(
        &between("", &degrees, "EPSG:9999").unwrap(),
        &[behind(
            "move it before them if they are metres; if they are degrees, leave it out",
        )],
    );
    assert_warnings(
        &between("EPSG:6677", &square, "EPSG:28992").unwrap(),
        &[behind(
            "EPSG:28992 is stated behind the features, which were read as metres",
        )],
    );
    let metres = between("", &square, "EPSG:4326").unwrap();
    assert_eq!(metres.warnings.len(), 2, "{:?}", metres.warnings);
    assert!(
        metres.warnings[1]
            .what
            .contains("EPSG:4326 is stated behind")
    );
    let none_left = between("EPSG:4326", &square, "EPSG:6677").unwrap();
    assert_eq!(none_left.scene.objects.len(), 0, "1010 is no longitude");
}

/// What concerns the whole file comes before what concerns its objects, of which there are many.
#[test]
fn a_word_on_the_whole_file_is_not_hidden_by_many_on_its_objects() {
    let desk = Desk::new();
    let degrees = triangle(139.7, 35.7, 0.001);
    let features: Vec<String> = (0..30)
        .map(|at| feature(if at == 0 { r#"{"h":1}"# } else { "{}" }, &degrees))
        .collect();
    let text = format!(
        r#"{{"type":"FeatureCollection","features":[{}],{}}}"#,
        features.join(","),
        crs("EPSG:6677")
    );
    desk.write("c.geojson", text.as_bytes());
    let run = desk.run("import c.geojson -o c.citylod --warnings 1");
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(
        run.err.contains("EPSG:6677 is stated behind the features"),
        "{}",
        run.err
    );
}
