use std::path::PathBuf;

use citylod::import::{ImportError, Imported, Options, import};
use tempfile::TempDir;

use crate::written::feature;

/// Files that are imported together, in the order in which they were put there.
struct Pile {
    folder: TempDir,
    files: Vec<PathBuf>,
}

impl Pile {
    fn new() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
            files: Vec::new(),
        }
    }

    fn put(mut self, name: &str, content: &str) -> Self {
        let path = self.folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        self.files.push(path);
        self
    }

    /// A box of 10 m at this easting, in a format that cannot say where it lies.
    fn bare(self, name: &str, x: f64) -> Self {
        let far = x + 10.0;
        let id = name.trim_end_matches(".obj");
        let text = format!("o {id}\nv {x} 0 0\nv {far} 0 0\nv {far} 10 9\nf 1 2 3\n");
        self.put(name, &text)
    }

    /// A footprint of 10 m there, in a system that is stated.
    fn stated(self, name: &str, x: f64) -> Self {
        let far = x + 10.0;
        let ring = format!("[[[{x},0],[{far},0],[{far},10],[{x},10],[{x},0]]]");
        let crs = r#""crs":{"type":"name","properties":{"name":"EPSG:6677"}}"#;
        let feature = feature("{\"h\":1}", &ring);
        let text = format!(r#"{{"type":"FeatureCollection",{crs},"features":[{feature}]}}"#);
        self.put(name, &text)
    }

    fn import(&self) -> Result<Imported, ImportError> {
        import(&self.files, &Options::default(), &|_, _| {})
    }

    /// The warnings, each with the name of its file.
    fn warnings(&self) -> Vec<String> {
        let imported = self.import().unwrap();
        let told = imported.warnings.iter().map(|warning| {
            let file = warning.path.file_name().unwrap().to_string_lossy();
            format!("{file}: {}", warning.what)
        });
        told.collect()
    }
}

fn assert_told(pile: &Pile, expected: &[&[&str]]) {
    let told = pile.warnings();
    assert_eq!(told.len(), expected.len(), "{told:?}");
    for (told, words) in told.iter().zip(expected) {
        for word in *words {
            assert!(told.contains(word), "{word}: {told}");
        }
    }
}

#[test]
fn files_that_lie_side_by_side_are_one_city() {
    assert_told(&Pile::new().bare("a.obj", 0.0).bare("b.obj", 9_000.0), &[]);
    assert_told(
        &Pile::new()
            .stated("a.geojson", 0.0)
            .stated("b.geojson", 9e6),
        &[&["taken"]],
    );
}

#[test]
fn a_file_without_a_system_is_taken_to_lie_with_the_others() {
    let near = Pile::new().bare("a.obj", 9_000.0).stated("b.geojson", 0.0);
    assert_told(&near, &[&["a.obj: states no", "lie in EPSG:6677"]]);
    assert!(!near.warnings()[0].contains("km"));
    let far = Pile::new()
        .stated("b.geojson", 0.0)
        .bare("a.obj", -40_000.0);
    assert_told(
        &far,
        &[&[
            "a.obj: states no",
            "lie in EPSG:6677",
            "40 km from",
            "b.geojson",
        ]],
    );
}

#[test]
fn files_far_apart_are_told_of() {
    let pile = Pile::new()
        .bare("a.obj", 0.0)
        .bare("b.obj", 50_000.0)
        .bare("c.obj", 50_100.0);
    assert_told(
        &pile,
        &[&["b.obj: it lies 50 km from", "a.obj", "neither states"]],
    );
}

#[test]
fn files_too_far_apart_for_a_city_are_refused() {
    for (pile, wrong, other) in [
        (
            Pile::new().bare("a.obj", 0.0).bare("b.obj", 455_000.0),
            "b.obj",
            "a.obj",
        ),
        (
            Pile::new()
                .stated("b.geojson", 0.0)
                .bare("a.obj", 455_000.0),
            "a.obj",
            "b.geojson",
        ),
        (
            Pile::new()
                .bare("a.obj", 455_000.0)
                .stated("b.geojson", 0.0),
            "a.obj",
            "b.geojson",
        ),
    ] {
        let error = pile.import().unwrap_err();
        let ImportError::FarApart {
            path,
            other: far,
            km,
        } = &error
        else {
            panic!("{error}");
        };
        assert!(path.ends_with(wrong) && far.ends_with(other), "{error}");
        assert_eq!(*km, 455.0);
        assert!(error.to_string().contains("separate scenes"), "{error}");
    }
    // What says where it lies may lie anywhere.
    let stated = Pile::new()
        .stated("a.geojson", 0.0)
        .stated("b.geojson", 455_000.0);
    assert!(stated.import().is_ok());
}

#[test]
fn a_system_without_a_name_is_told_of_once() {
    let nameless =
        r#"{"type":"FeatureCollection","crs":{"type":"name","properties":{}},"features":["#;
    let feature = feature("{\"h\":1}", "[[[0,100],[10,100],[10,110],[0,100]]]");
    let pile = Pile::new()
        .put("a.geojson", &format!("{nameless}{feature}]}}"))
        .stated("b.geojson", 0.0);
    let told = pile.warnings();
    assert!(
        told.iter().all(|told| !told.contains("first position")),
        "{told:?}"
    );
    assert!(
        told.iter()
            .any(|told| told.contains("taken to lie in EPSG:6677")),
        "{told:?}"
    );
}

/// One word about the file, not one about each feature.
#[test]
fn heights_that_no_feature_has_are_told_of_once() {
    let square = format!("[{}]", crate::written::SQUARE);
    let three = |properties: [&str; 3]| {
        properties
            .map(|properties| feature(properties, &square))
            .join("\n")
    };
    let of = |properties, height: Option<&str>| {
        let pile = Pile::new().put("a.geojsonl", &three(properties));
        let options = Options {
            height: height.map(Into::into),
            ..Options::default()
        };
        let imported = import(&pile.files, &options, &|_, _| {}).unwrap();
        assert_eq!(imported.scene.objects.len(), 3);
        let warnings = imported.warnings.into_iter();
        let of_heights = warnings.filter(|warning| warning.what.contains("kept flat"));
        of_heights
            .map(|w| (w.object.is_some(), w.what))
            .collect::<Vec<_>>()
    };
    let [(false, named)] = &of(["{\"h\":1}"; 3], Some("top"))[..] else {
        panic!("not one warning");
    };
    assert!(named.contains("\"top\"; 3 features kept flat"), "{named}");
    let [(false, usual)] = &of(["{}"; 3], None)[..] else {
        panic!("not one warning");
    };
    assert!(
        usual.contains("measuredHeight") && usual.contains("--height"),
        "{usual}"
    );
    // Where some have one, those that have none are named.
    let some = of(["{}", "{\"top\":2}", "{\"h\":1}"], Some("top"));
    assert_eq!(some.len(), 2);
    assert!(some.iter().all(|(is_object, _)| *is_object));
}
