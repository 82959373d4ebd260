use std::fmt::Write as _;

use citylod::import::{ImportError, Imported, Options};

use crate::desk::Desk;
use crate::written::{feature, import_content, import_one, real};

/// Houses on a grid: the first of them at a corner, how far apart, how wide, how high.
#[derive(Clone, Copy)]
struct Town {
    corner: [f64; 2],
    apart: f64,
    wide: f64,
    high: f64,
    houses: u32,
}

/// Delft in degrees: a house is 10 m wide.
const DEGREES: Town = Town {
    corner: [4.35, 52.0],
    apart: 0.000_3,
    wide: 0.000_1,
    high: 9.0,
    houses: 12,
};
/// The same in metres.
const METRES: Town = Town {
    corner: [84_000.0, 446_000.0],
    apart: 30.0,
    wide: 10.0,
    ..DEGREES
};

impl Town {
    fn boxes(self) -> Vec<(String, [f64; 6])> {
        let Self {
            corner: [x, y],
            apart,
            wide,
            high,
            ..
        } = self;
        let house = |at: u32| {
            let (x, y) = (x + f64::from(at % 4) * apart, y + f64::from(at / 4) * apart);
            (format!("h{at}"), [x, y, 0.0, x + wide, y + wide, high])
        };
        (0..self.houses).map(house).collect()
    }

    fn obj(self) -> String {
        obj(&self.boxes())
    }
}

fn obj(boxes: &[(String, [f64; 6])]) -> String {
    let mut text = String::new();
    for (id, [x0, y0, z0, x1, y1, z1]) in boxes {
        let _ = writeln!(
            text,
            "o {id}\nv {x0} {y0} {z0}\nv {x1} {y0} {z0}\nv {x1} {y1} {z1}\nf -3 -2 -1"
        );
    }
    text
}

fn open(text: &str) -> Result<Imported, ImportError> {
    import_content("town.obj", text.as_bytes())
}

/// What is said of the file, and nothing else may be.
fn told(text: &str) -> Vec<String> {
    let imported = open(text).unwrap();
    assert!(imported.warnings.iter().all(|w| w.object.is_none()));
    imported.warnings.into_iter().map(|w| w.what).collect()
}

fn assert_words(told: &str, words: &[&str]) {
    for word in words {
        assert!(told.contains(word), "{word}: {told}");
    }
}

#[test]
fn degrees_with_heights_are_refused_with_the_way_out() {
    let one = Town {
        houses: 1,
        ..DEGREES
    };
    let around_zero = Town {
        corner: [-0.000_4, -0.000_4],
        ..DEGREES
    };
    let island = Town {
        apart: 2.0,
        ..DEGREES
    };
    for town in [DEGREES, one, around_zero, island] {
        let error = open(&town.obj()).unwrap_err();
        assert!(
            matches!(error, ImportError::LooksLikeDegrees { .. }),
            "{error}"
        );
        assert_words(
            &error.to_string(),
            &[
                "town.obj: ",
                "look like degrees",
                "no wider than 0.10 mm",
                "9.0 m tall",
                "--crs EPSG:4326",
            ],
        );
    }
    let turned = Town {
        corner: [35.68, 139.75],
        ..DEGREES
    };
    let error = open(&turned.obj()).unwrap_err().to_string();
    assert_words(
        &error,
        &["latitude stands before longitude", "exchange the two"],
    );
    // One that is astray does not hide the others.
    let mut boxes = DEGREES.boxes();
    boxes.push(("zero".into(), [0.0, 0.0, 0.0, 0.0001, 0.0001, 3.0]));
    assert!(open(&obj(&boxes)).is_err());
}

#[test]
fn degrees_that_may_be_metres_are_told_of() {
    let flat = Town {
        high: 0.0,
        ..DEGREES
    };
    let model = Town {
        high: 0.000_5,
        ..DEGREES
    };
    for town in [flat, model] {
        let [told] = &told(&town.obj())[..] else {
            panic!("not one warning");
        };
        assert_words(
            told,
            &[
                "look like degrees",
                "0.10 mm",
                "--crs EPSG:4326, if they are some",
            ],
        );
    }
    // The whole city is one object.
    let city = ("city".to_owned(), [4.3, 51.95, 0.0, 4.4, 52.05, 110.0]);
    let [told] = &told(&obj(&[city]))[..] else {
        panic!("not one warning");
    };
    assert_words(told, &["0.10 m wide and 110 m tall", "--crs EPSG:4326"]);
}

/// As glTF that was written without a thought of its axes: latitude along z.
#[test]
fn degrees_along_the_wrong_axes_are_refused() {
    let upright = DEGREES
        .boxes()
        .into_iter()
        .map(|(id, [x0, y0, z0, x1, y1, z1])| (id, [x0, -z1, y0, x1, -z0, y1]));
    let upright: Vec<_> = upright.collect();
    let error = open(&obj(&upright)).unwrap_err().to_string();
    assert_words(&error, &["--crs EPSG:4326 and --up z"]);
}

/// Of a file that says that it is in metres.
#[test]
fn degrees_that_are_stated_to_be_metres_are_told_of() {
    let options = Options {
        crs: Some("EPSG:28992".into()),
        ..Options::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("town.obj");
    std::fs::write(&path, DEGREES.obj()).unwrap();
    let imported = import_one(&path, &options).unwrap();
    assert_eq!(imported.warnings.len(), 1, "{:?}", imported.warnings);
    let told = &imported.warnings[0].what;
    assert_words(
        told,
        &["look like degrees, but EPSG:28992 is stated", "reproject"],
    );
}

#[test]
fn metres_are_not_taken_for_degrees() {
    let house = Town {
        corner: [0.0, 0.0],
        houses: 1,
        ..METRES
    };
    let few = Town {
        corner: [4.0, 52.0],
        ..METRES
    };
    let thin = Town {
        wide: 0.1,
        high: 8.0,
        ..few
    };
    let sheds = Town {
        wide: 1.0,
        apart: 0.5,
        high: 2.0,
        ..few
    };
    let flat = Town { high: 0.0, ..few };
    let towers = Town { high: 400.0, ..few };
    for town in [METRES, house, few, thin, sheds, flat, towers] {
        assert_eq!(told(&town.obj()), [""; 0]);
    }
    let points = "o a\nv 4 52 0\nv 4 52 9\nl 1 2\no b\nv 5 52 0\nv 5 52 9\nl 3 4\n";
    assert_eq!(told(points), [""; 0]);
}

#[test]
fn objects_far_from_the_rest_are_told_of_once() {
    let with = |strays: &[(&str, [f64; 6])]| {
        let mut boxes = METRES.boxes();
        boxes.extend(strays.iter().map(|(id, of)| ((*id).to_owned(), *of)));
        told(&obj(&boxes))
    };
    let zero = [0.0, 0.0, 0.0, 10.0, 10.0, 9.0];
    let [told] = &with(&[("zero", zero)])[..] else {
        panic!("not one warning");
    };
    assert_words(
        told,
        &[
            "1 of 13 objects lies far",
            "\"zero\" reaches 454 km",
            "no more than 74 m",
        ],
    );
    // One vertex that is astray.
    let [told] = &with(&[(
        "wide",
        [84_010.0, 446_010.0, 0.0, 1_084_010.0, 446_020.0, 9.0],
    )])[..] else {
        panic!("not one warning");
    };
    assert_words(told, &["\"wide\" reaches 1000 km"]);
    // Aloft.
    let aloft = with(&[(
        "aloft",
        [84_010.0, 446_010.0, 36_000.0, 84_020.0, 446_020.0, 36_009.0],
    )]);
    assert_words(&aloft[0], &["\"aloft\" reaches 36 km"]);
    // A village beside the town, however small the town.
    let near = [93_000.0, 446_000.0, 0.0, 93_010.0, 446_010.0, 9.0];
    assert_eq!(with(&[("near", near)]), [""; 0]);
}

#[test]
fn several_strays_are_counted_and_a_country_has_none() {
    let mut boxes = Town {
        houses: 40,
        ..METRES
    }
    .boxes();
    for at in 0..3 {
        let x = f64::from(at) * 100.0;
        boxes.push((format!("stray{at}"), [x, 0.0, 0.0, x + 10.0, 10.0, 9.0]));
    }
    let [told] = &told(&obj(&boxes))[..] else {
        panic!("not one warning");
    };
    assert_words(
        told,
        &[
            "3 of 43 objects lie far",
            "the farthest, \"stray0\", reaches",
        ],
    );
    let country = Town {
        apart: 40_000.0,
        houses: 40,
        ..METRES
    };
    assert_eq!(self::told(&country.obj()), [""; 0]);
    let two = [&METRES.boxes()[..1], &[("b".to_owned(), [0.0; 6])]].concat();
    assert_eq!(self::told(&obj(&two)), [""; 0], "none of two is the rest");
}

#[test]
fn objects_taller_than_anything_are_told_of_once() {
    let mut boxes = METRES.boxes();
    boxes[3].1[5] = 3_250.0;
    let [told] = &told(&obj(&boxes))[..] else {
        panic!("not one warning");
    };
    assert_words(
        told,
        &["1 object is taller than 1000 m", "\"h3\" has 3250 m"],
    );
    boxes[5].1[5] = 9_000.0;
    let [told] = &self::told(&obj(&boxes))[..] else {
        panic!("not one warning");
    };
    assert_words(
        told,
        &["2 objects are taller", "the tallest, \"h5\", has 9000 m"],
    );
    // The tallest tower there is, and land in one piece.
    boxes[3].1[5] = 828.0;
    boxes[5].1 = [80_000.0, 440_000.0, 0.0, 85_000.0, 447_000.0, 1_500.0];
    assert_eq!(self::told(&obj(&boxes)), [""; 0]);
}

/// What an import ends with, of each format.
#[test]
fn what_was_left_out_or_kept_flat_is_summed_up() {
    let square = "[[[139.75,35.68],[139.7501,35.68],[139.7501,35.6801],[139.75,35.68]]]";
    let of = |properties: &str| feature(properties, square);
    let elsewhere = feature(r#"{"h":1}"#, &square.replace("139.7", "4.7"));
    let point = r#"{"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[139.75,35.68]}}"#;
    let nothing = r#"{"type":"Feature","properties":{},"geometry":null}"#;
    let empty = feature(r#"{"h":1}"#, "[]");
    let lines = [
        of(r#"{"h":9}"#),
        of("{}"),
        of("{}"),
        of(r#"{"h":0}"#),
        of(r#"{"h":"tall"}"#),
        of(r#"{"class":"Tree"}"#),
        elsewhere,
        point.to_owned(),
        point.to_owned(),
        nothing.to_owned(),
        empty,
        r#"{"type":"Feature","properties":3,"geometry":[]}"#.to_owned(),
    ];
    let desk = Desk::new();
    desk.write("a.geojsonl", lines.join("\n").as_bytes());
    desk.write(
        "b.obj",
        b"v 379000 3949000 0\nv 379009 3949000 0\no none\no p\np 1\nv nan 0 0\no lost\np 3\n",
    );
    let group = crate::written::solid()
        .replace("EPSG/0/6677", "EPSG/0/32654")
        .replace(
            "\"CityObjects\":{",
            "\"CityObjects\": { \"bare\": {\"type\": \"Building\"},",
        );
    desk.write("c.city.json", group.as_bytes());
    let run = desk.run(
        "import a.geojsonl b.obj c.city.json -o city.citylod --warnings 0 --except-class Tree",
    );
    assert_eq!(run.code, Some(0), "{}", run.err);
    let told: Vec<_> = run
        .err
        .lines()
        .filter(|l| l.contains(" left out: ") || l.contains(" flat: "))
        .collect();
    let expected = [
        "2 features kept flat: no height",
        "1 feature kept flat: a height of 0",
        "1 feature kept flat: a height that is none",
        "1 object left out: of a class that was not asked for",
        "1 feature left out: too far from the others",
        "2 features left out: neither a Polygon nor a MultiPolygon",
        "1 feature left out: no geometry",
        "1 feature left out: no position that can be used",
        "1 feature left out: cannot be read",
        "1 object left out: no face, line or point",
        "1 object left out: no vertex that can be used",
        "1 object left out: no geometry",
    ];
    assert_eq!(told, expected, "{}", run.err);
}

#[test]
fn real_cities_make_sense() {
    for file in [
        "geojson/tokyo-chiyoda-11581.geojson.gz",
        "cityjson/delft.json",
        "cityjson/zurich_subset_lod2.json",
        "cityjson/multi_lod.json",
        "cityjson/rotterdam_subset.json",
        "cityjson/DH_01_subs.city.json",
        "cityjson/multisurface_with_material.json",
        "cityjson/vienna.city.jsonl",
        "cityjson/geomtemplate.city.jsonl",
        "cityjson/railway.city.jsonl",
        "obj/tokyo-chiyoda-11581.obj",
        "glb/tokyo-chiyoda-11581.glb",
        "glb/3dbag-sibbe/content/1_1_0.glb",
    ] {
        let Some(path) = real(file) else {
            return;
        };
        let imported = import_one(&path, &Options::default()).unwrap();
        for warning in &imported.warnings {
            for words in [
                "look like degrees",
                "far from the rest",
                "taller than",
                "nothing is known",
            ] {
                assert!(!warning.what.contains(words), "{warning}");
            }
        }
    }
}
