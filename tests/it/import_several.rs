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
            ..
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
    let import_all = |files: &[[&str; 3]], height: Option<&str>| {
        let names = ["a.geojsonl", "b.geojsonl"];
        let files = names.into_iter().zip(files);
        let pile = files.fold(Pile::new(), |pile, (name, properties)| {
            pile.put(name, &three(*properties))
        });
        let options = Options {
            height: height.map(Into::into),
            ..Options::default()
        };
        import(&pile.files, &options, &|_, _| {})
    };
    let of = |files: &[[&str; 3]], height| {
        let imported = import_all(files, height).unwrap();
        assert_eq!(imported.scene.objects.len(), 3 * files.len());
        let warnings = imported.warnings.into_iter();
        let of_heights = warnings.filter(|warning| warning.what.contains("kept flat"));
        of_heights
            .map(|w| (w.object.is_some(), w.what))
            .collect::<Vec<_>>()
    };
    let [(false, named)] = &of(&[["{\"top\":1}"; 3], ["{\"h\":1}"; 3]], Some("top"))[..] else {
        panic!("not one warning");
    };
    assert!(named.contains("\"top\"; 3 features kept flat"), "{named}");
    let [(false, usual)] = &of(&[["{}"; 3]], None)[..] else {
        panic!("not one warning");
    };
    assert!(
        usual.contains("measuredHeight") && usual.contains("--height"),
        "{usual}"
    );
    // Where some have one, those that have none are named.
    let some = of(&[["{}", "{\"top\":2}", "{\"h\":1}"]], Some("top"));
    assert_eq!(some.len(), 2);
    assert!(some.iter().all(|(is_object, _)| *is_object));
    // A name that no feature of any file has is most likely wrong.
    for (files, expected) in [
        (
            &[
                ["{\"h\":1}", "{\"b\":null}", "{\"a\":[]}"],
                ["{\"h\":1}"; 3],
            ][..],
            "are: a, b, h",
        ),
        (&[["{}", "null", "{}"]], "are: none at all"),
    ] {
        let error = import_all(files, Some("top")).unwrap_err();
        assert!(matches!(error, ImportError::NoSuchHeight { .. }), "{error}");
        let told = error.to_string();
        assert!(
            told.contains("\"top\"") && told.ends_with(expected),
            "{told}"
        );
    }
    // Where there is no height behind a name that is right, features are flat.
    let [(false, empty)] = &of(&[["{\"top\":null}"; 3]], Some("top"))[..] else {
        panic!("not one warning");
    };
    assert!(empty.contains("\"top\"; 3 features kept flat"), "{empty}");
}

/// Triangles of 10 m around places, one object each.
fn triangles(places: &[[f64; 3]]) -> String {
    let triangle = |(at, [x, y, z]): (usize, &[f64; 3])| {
        let (x10, y10) = (x + 10.0, y + 10.0);
        format!("o o{at}\nv {x} {y} {z}\nv {x10} {y} {z}\nv {x10} {y10} {z}\nf -3 -2 -1\n")
    };
    places.iter().enumerate().map(triangle).collect()
}

/// Delft, and UTM at 57 degrees north, which is as far from 0 0 0.
const ON_GLOBE: [f64; 3] = [3_923_500.0, 299_700.0, 5_003_000.0];
const ON_PLANE: [f64; 3] = [550_000.0, 6_350_000.0, 12.0];

#[test]
fn earth_centred_files_are_told_of_first_and_once() {
    let pile = |files: &[&[[f64; 3]]]| {
        let names = ["a.obj", "b.obj", "c.obj"];
        let files = names.into_iter().zip(files);
        files.fold(Pile::new(), |pile, (name, places)| {
            pile.put(name, &triangles(places))
        })
    };
    let tilted = [
        "a.obj: ",
        "EPSG:4978",
        "z does not point up",
        "EPSG:32631",
        "4.37",
        "52.0",
    ];
    assert_told(&pile(&[&[ON_GLOBE]]), &[&tilted]);
    let three = pile(&[&[ON_GLOBE], &[ON_GLOBE, ON_GLOBE], &[ON_GLOBE]]);
    // Ids of the three repeat; what is first is told.
    let told = &three.warnings()[0];
    assert!(tilted.iter().all(|word| told.contains(word)), "{told}");
    assert!(told.ends_with("so it is with 2 more files"), "{told}");
    // One stray object does not make a city earth-centred.
    let stray = ["1 of 3 objects lies far from the rest"];
    let mixed = pile(&[&[ON_PLANE, ON_PLANE, ON_GLOBE]]);
    assert_told(&mixed, &[&stray]);
    let mixed = pile(&[&[ON_GLOBE, ON_PLANE, ON_GLOBE]]);
    assert_told(&mixed, &[&tilted, &stray]);
    assert_told(&pile(&[&[ON_PLANE]]), &[]);
}

#[test]
fn a_city_that_does_not_lie_level_is_told_of() {
    /// Delft's latitude: how far the axis of the globe is from up there.
    const TILT_DEG: f64 = 38.0;
    let places: Vec<[f64; 3]> = (0..48)
        .map(|at| {
            [
                f64::from(at % 6) * 30.0,
                f64::from(at / 6) * 30.0,
                f64::from(at * 7 % 5),
            ]
        })
        .collect();
    let turned = |angle: f64| {
        let (sin, cos) = angle.to_radians().sin_cos();
        let turn = |&[x, y, z]: &[f64; 3]| [x, y * cos - z * sin, y * sin + z * cos];
        triangles(&places.iter().map(turn).collect::<Vec<_>>())
    };
    assert_told(&Pile::new().put("a.obj", &turned(0.0)), &[]);
    assert_told(&Pile::new().put("a.obj", &turned(12.0)), &[]);
    let told = [
        "a.obj: its objects lie in a plane",
        "degrees from level",
        "--up",
    ];
    assert_told(&Pile::new().put("a.obj", &turned(90.0)), &[&told]);
    let pile = Pile::new().put("a.obj", &turned(TILT_DEG));
    assert_told(&pile, &[&told]);
    assert!(pile.warnings()[0].contains(" 38 degrees"));
}

/// Tiles keep the axes of the globe, where the axis of the earth is 39 degrees from up.
#[test]
fn only_tiles_of_the_globe_are_tilted_of_real_cities() {
    for (file, tilted) in [
        ("glb/3dbag-sibbe/content/2_2_3.glb", true),
        ("glb/tokyo-chiyoda-11581.glb", false),
        ("obj/tokyo-chiyoda-11581.obj", false),
        ("geojson/tokyo-minato-28106.geojson.gz", false),
        ("cityjson/delft.json", false),
        ("cityjson/zurich_subset_lod2.json", false),
        ("cityjson/vienna.city.jsonl", false),
    ] {
        let Some(path) = crate::written::real(file) else {
            return;
        };
        let imported = crate::written::import_one(&path, &Options::default()).unwrap();
        let mut told = imported.warnings.iter().map(ToString::to_string);
        let found = told.find(|warning| warning.contains("degrees from level"));
        assert_eq!(found.is_some(), tilted, "{file}: {found:?}");
        if let Some(warning) = found {
            let (_, told) = warning.split_once("in a plane ").unwrap();
            let tilt_deg: f64 = told.split(' ').next().unwrap().parse().unwrap();
            // The land itself is not level either.
            assert!((tilt_deg - 39.0).abs() < 3.0, "{warning}");
        }
    }
}
