use citylod::import::{ImportError, Imported, Options, Place, Warning};

use crate::desk::Desk;
use crate::written::{SQUARE, assert_warnings, feature, import_one, solid};

/// Farthest that a place may be off where vertices of one house in two formats are projected, m.
const TOLERANCE_M: f64 = 1e-6;

/// A city of one house, in four formats, with its corners at these places.
const FORMATS: [&str; 4] = ["a.geojson", "a.obj", "a.city.json", "a.gltf"];

fn content(name: &str, corners: &[[f64; 2]; 4], crs: Option<&str>) -> String {
    match name.split_once('.').unwrap().1 {
        "geojson" => geojson(corners, crs),
        "obj" => obj(corners),
        "gltf" => gltf(corners),
        _ => cityjson(corners, crs),
    }
}

fn geojson(corners: &[[f64; 2]; 4], crs: Option<&str>) -> String {
    let ring: Vec<_> = corners.iter().chain(&corners[..1]).collect();
    let crs = crs.map_or(String::new(), |name| {
        format!(r#""crs":{{"type":"name","properties":{{"name":"{name}"}}}},"#)
    });
    let feature = feature(r#"{"h":9}"#, &format!("[{ring:?}]"));
    format!(r#"{{{crs}"type":"FeatureCollection","features":[{feature}]}}"#)
}

fn obj(corners: &[[f64; 2]; 4]) -> String {
    let vertices = corners
        .iter()
        .flat_map(|[x, y]| [0, 9].map(|z| format!("v {x} {y} {z}\n")));
    let vertices: String = vertices.collect();
    format!("o f\n{vertices}f 1 2 3\nf 4 5 6 7 8\n")
}

fn cityjson(corners: &[[f64; 2]; 4], crs: Option<&str>) -> String {
    let metadata = crs.map_or(String::new(), |name| {
        let code = name.trim_start_matches("EPSG:");
        format!(
            r#""metadata":{{"referenceSystem":"https://www.opengis.net/def/crs/EPSG/0/{code}"}},"#
        )
    });
    let vertices: Vec<_> = corners
        .iter()
        .flat_map(|[x, y]| [0.0, 9.0].map(|z| [*x, *y, z]))
        .collect();
    format!(
        r#"{{"type":"CityJSON","version":"2.0",{metadata}"transform":{{"scale":[1,1,1],"translate":[0,0,0]}},
        "CityObjects":{{"f":{{"type":"Building","geometry":[{{"type":"MultiSurface","lod":"1","boundaries":[[[0,1,2]],[[3,4,5,6,7]]]}}]}}}},
        "vertices":{vertices:?}}}"#
    )
}

/// Y up; where the house lies is in the node, as floats of 32 bits would not hold it.
fn gltf(corners: &[[f64; 2]; 4]) -> String {
    let [x, y] = corners[0];
    let far = [corners[2][0] - x, corners[2][1] - y];
    format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"name":"f","mesh":0,"translation":[{x},0,{}]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"extensions":{{"KHR_draco_mesh_compression":{{"bufferView":0,"attributes":{{}}}}}}}}]}}],
        "extensionsUsed":["KHR_draco_mesh_compression"],
        "accessors":[{{"componentType":5126,"type":"VEC3","count":8,"min":[0,0,{}],"max":[{},9,0]}}]}}"#,
        -y, -far[1], far[0]
    )
}

fn house(x: f64, y: f64, size: f64) -> [[f64; 2]; 4] {
    [[x, y], [x + size, y], [x + size, y + size], [x, y + size]]
}

fn degrees() -> [[f64; 2]; 4] {
    house(139.75, 35.68, 0.0001)
}

/// Asserts what is said of the file; of the object in glTF it is said that it is kept as a box.
fn assert_told(imported: &Imported, expected: &[&str]) {
    let of_file = |w: &&Warning| w.object.is_none() && w.place == Place::File;
    let found: Vec<_> = imported.warnings.iter().filter(of_file).collect();
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!(found.what.contains(expected), "{found:?}");
    }
}

/// It imported, with this system told.
fn told(name: &str, content: &str, crs: Option<&str>) -> Result<Imported, ImportError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    let options = Options {
        crs: crs.map(Into::into),
        ..Options::default()
    };
    import_one(&path, &options)
}

#[test]
fn degrees_that_are_said_to_be_some_are_projected_in_every_format() {
    let expected = told("a.geojson", &content("a.geojson", &degrees(), None), None).unwrap();
    let expected = expected.scene.objects[0].bounds.to_array();
    assert!(
        (expected[3] - expected[0] - 9.0).abs() < 1.0,
        "{expected:?}"
    );
    for name in FORMATS {
        for crs in ["EPSG:4326", "urn:ogc:def:crs:OGC:1.3:CRS84", "EPSG:6697"] {
            let imported = told(name, &content(name, &degrees(), None), Some(crs)).unwrap();
            assert_told(&imported, &[]);
            assert_eq!(imported.scene.crs.as_deref(), Some("EPSG:32654"), "{name}");
            let found = imported.scene.objects[0].bounds.to_array();
            for (found, expected) in found.iter().zip(expected) {
                // The box of a compressed mesh is kept in 32 bits.
                let most = if name == "a.gltf" { 0.01 } else { TOLERANCE_M };
                assert!((found - expected).abs() < most, "{name}: {found}");
            }
        }
        let older = told(name, &content(name, &degrees(), None), Some("EPSG:4301")).unwrap();
        assert_told(&older, &["EPSG:4301 are read as those of WGS 84"]);
    }
}

#[test]
fn degrees_of_which_nothing_is_said_are_refused() {
    for name in ["a.obj", "a.city.json", "a.gltf"] {
        let error = told(name, &content(name, &degrees(), None), None).unwrap_err();
        assert!(
            matches!(error, ImportError::LooksLikeDegrees { .. }),
            "{error}"
        );
        let words = error.to_string();
        assert!(
            words.contains(name) && words.contains("--crs EPSG:4326"),
            "{words}"
        );
    }
}

#[test]
fn metres_that_are_said_to_be_some_stay_as_they_are() {
    let metres = house(85_000.0, 446_000.0, 10.0);
    for name in FORMATS {
        let text = content(name, &metres, None);
        let imported = told(name, &text, Some("EPSG:28992")).unwrap();
        assert_told(&imported, &[]);
        assert_eq!(imported.scene.crs.as_deref(), Some("EPSG:28992"), "{name}");
        let bounds = imported.scene.objects[0].bounds;
        assert_eq!(bounds.min().truncate().to_array(), metres[0], "{name}");
        let imported = told(name, &text, Some("EPSG:9999")).unwrap();
        assert_told(
            &imported,
            &["nothing is known here of the system EPSG:9999"],
        );
    }
}

#[test]
fn a_system_that_the_file_contradicts_is_refused() {
    let metres = house(85_000.0, 446_000.0, 10.0);
    for name in ["a.geojson", "a.city.json"] {
        let text = content(name, &metres, Some("EPSG:28992"));
        let error = told(name, &text, Some("EPSG:2056")).unwrap_err();
        assert!(
            matches!(error, ImportError::CrsContradicted { .. }),
            "{error}"
        );
        let words = error.to_string();
        for word in [
            name,
            "states that it lies in EPSG:28992",
            "--crs says EPSG:2056",
            "leave --crs out",
        ] {
            assert!(words.contains(word), "{words}");
        }
        // The same plane with heights.
        let imported = told(name, &text, Some("EPSG:7415")).unwrap();
        assert_warnings(&imported, &[]);
    }
    // Behind the features too.
    let square = feature(r#"{"h":1}"#, &format!("[{SQUARE}]"));
    let late = format!(
        r#"{{"type":"FeatureCollection","features":[{square}],"crs":{{"type":"name","properties":{{"name":"EPSG:28992"}}}}}}"#
    );
    let error = told("a.geojson", &late, Some("EPSG:2056")).unwrap_err();
    assert!(
        matches!(error, ImportError::CrsContradicted { .. }),
        "{error}"
    );
    assert_warnings(&told("a.geojson", &late, Some("EPSG:28992")).unwrap(), &[]);
}

#[test]
fn what_is_said_to_be_degrees_and_is_none_is_refused() {
    for name in ["a.obj", "a.city.json", "a.gltf"] {
        let turned = content(name, &house(35.68, 139.75, 0.0001), None);
        let metres = content(name, &house(85_000.0, 446_000.0, 10.0), None);
        for (text, expected) in [
            (turned, &["such as 35.68, 139.75", "exchange the two"]),
            (metres, &["such as 85000, 4460", "name the system"]),
        ] {
            let error = told(name, &text, Some("EPSG:4326")).unwrap_err();
            assert!(matches!(error, ImportError::NoDegrees { .. }), "{error}");
            let words = error.to_string();
            assert!(expected.iter().all(|word| words.contains(word)), "{words}");
        }
    }
    // One that lies elsewhere is left out, and told why.
    let text = obj(&degrees())
        + &obj(&house(4.3, 52.0, 0.0001)).replace("f 1 2 3\nf 4 5 6 7 8", "f -1 -2 -3");
    let imported = told("a.obj", &text, Some("EPSG:4326")).unwrap();
    assert_eq!(imported.scene.objects.len(), 1);
    assert_warnings(
        &imported,
        &[(
            "f",
            "line 12, column 1",
            "all its vertices are not finite, off the globe or over 15 degrees",
        )],
    );
}

#[test]
fn feet_and_places_from_the_middle_of_the_earth_are_refused_with_the_way_out() {
    let house = house(985_000.0, 212_000.0, 30.0);
    for (name, crs, words) in [
        (
            "a.geojson",
            "EPSG:2263",
            ["in US survey feet", "ogr2ogr -t_srs EPSG:4326"],
        ),
        (
            "a.geojson",
            "EPSG:2222",
            ["in feet", "ogr2ogr -t_srs EPSG:4326"],
        ),
        (
            "a.geojson",
            "EPSG:4978",
            ["from the middle of the earth", "ogr2ogr"],
        ),
        (
            "a.city.json",
            "EPSG:2263",
            ["in US survey feet", "crs_reproject"],
        ),
        (
            "a.city.json",
            "EPSG:4123",
            ["are degrees", "--crs EPSG:4123 if x is longitude"],
        ),
    ] {
        let refused = |stated: Option<&str>, crs: Option<&str>| {
            let error = told(name, &content(name, &house, stated), crs).unwrap_err();
            assert!(matches!(error, ImportError::Unsupported { .. }), "{error}");
            let told = error.to_string();
            assert!(words.iter().all(|word| told.contains(word)), "{told}");
        };
        refused(Some(crs), None);
        if crs != "EPSG:4123" {
            refused(None, Some(crs));
        }
    }
    let late = format!(
        r#"{{"type":"FeatureCollection","features":[{}],"crs":{{"type":"name","properties":{{"name":"EPSG:2263"}}}}}}"#,
        feature(r#"{"h":1}"#, &format!("[{SQUARE}]"))
    );
    assert!(told("a.geojson", &late, None).is_err());
    for name in ["a.obj", "a.gltf"] {
        assert!(told(name, &content(name, &house, None), Some("EPSG:2263")).is_err());
    }
}

#[test]
fn systems_of_which_nothing_is_known_are_told_of() {
    let unknown = solid().replace("EPSG/0/6677", "EPSG/0/9999");
    let imported = told("a.city.json", &unknown, None).unwrap();
    assert_warnings(
        &imported,
        &[(
            "",
            "/metadata/referenceSystem",
            "nothing is known here of the system EPSG:9999",
        )],
    );
}

/// In a sequence each feature may name it.
#[test]
fn a_system_that_is_named_over_and_over_is_told_of_once() {
    let one = geojson(&house(85_000.0, 446_000.0, 10.0), Some("EPSG:9999"));
    let imported = told("a.geojsonl", &[one.as_str(); 3].join("\n"), None).unwrap();
    let unknown = imported
        .warnings
        .iter()
        .filter(|w| w.what.contains("nothing is known"));
    assert_eq!(unknown.count(), 1);
}

/// As it is typed: also a city that states degrees, of which the caller says which comes first.
#[test]
fn the_command_takes_a_system_for_a_city() {
    let desk = Desk::new();
    desk.write(
        "a.city.json",
        cityjson(&degrees(), Some("EPSG:4326")).as_bytes(),
    );
    desk.refuses(
        "import a.city.json -o a.citylod",
        1,
        &[
            "a.city.json",
            "EPSG:4326, whose coordinates are degrees",
            "--crs EPSG:4326",
        ],
    );
    let run = desk.run("import a.city.json -o a.citylod --crs epsg:4326");
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(run.err.contains("EPSG:32654"), "{}", run.err);
    desk.refuses(
        "import a.city.json -o a.citylod --crs 4326",
        2,
        &["such as EPSG:"],
    );
}
