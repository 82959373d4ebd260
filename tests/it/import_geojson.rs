use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use citylod::import::{ImportError, Imported, Options, import};

use crate::written::{
    SQUARE, assert_warnings, feature, fixture, import_content, import_one, real, summary,
};

fn city(name: &str) -> Imported {
    import_one(&fixture(&format!("geojson/{name}")), &Options::default()).unwrap()
}

/// That metres are taken for such, where no file says where it lies.
const METRES: (&str, &str, &str) = ("", "the file", "taken as metres");

fn ids(imported: &Imported) -> Vec<&str> {
    imported
        .scene
        .objects
        .iter()
        .map(|o| o.id.as_str())
        .collect()
}

#[test]
fn a_collection_of_footprints() {
    let imported = city("collection.geojson");
    assert_eq!(imported.scene.crs.as_deref(), Some("EPSG:32654"));
    let found: Vec<_> = summary(&imported)
        .iter()
        .map(|(id, class, bounds, triangles)| (*id, *class, bounds[2], bounds[5], *triangles))
        .collect();
    assert_eq!(
        found,
        [
            ("a", "Tower", 0.0, 12.5, 12),
            ("7", "Building", 0.0, 9.0, 20),
            ("in properties", "Building", 0.0, 4.0, 8),
        ]
    );
    assert_warnings(
        &imported,
        &[
            ("7", "/features/1", "1 ring not closed"),
            ("in properties", "/features/2", "a Point is no footprint"),
        ],
    );
    let attributes = imported.scene.objects[0].attributes.as_ref().unwrap();
    assert_eq!(attributes.get(), r#"{"height":12.5,"class":"Tower"}"#);
}

#[test]
fn degrees_are_projected() {
    let imported = city("collection.geojson");
    let size = imported.scene.objects[0].bounds.size();
    // 0.001° of longitude at 35.7° and of latitude, turned by the convergence of 0.76°.
    assert!((size.x - 92.0).abs() < 0.2, "{size}");
    assert!((size.y - 112.1).abs() < 0.2, "{size}");
}

#[test]
fn metres_holes_ground_and_walls() {
    let imported = city("metres.geojson");
    assert_eq!(imported.scene.crs.as_deref(), Some("EPSG:6677"));
    assert_eq!(
        summary(&imported),
        [
            ("flat", "Building", [0.0, 0.0, 5.0, 10.0, 10.0, 5.0], 7),
            ("high", "Building", [0.0, 0.0, 5.0, 10.0, 10.0, 25.0], 28),
            ("wall", "Building", [0.0, 0.0, 5.0, 10.0, 0.0, 9.0], 2),
        ]
    );
    let square = &imported.scene.objects[1];
    assert_eq!(square.footprint_area, 100.0);
    assert_warnings(
        &imported,
        &[("flat", "/features/0", "no height; kept flat")],
    );
}

#[test]
fn records_and_lines() {
    let imported = city("records.geojsons");
    assert_eq!(ids(&imported), ["x", "y"]);
    assert_warnings(&imported, &[METRES]);
    let imported = city("lines.geojsonl");
    assert_eq!(ids(&imported), ["x", "feature-1"]);
    assert_warnings(
        &imported,
        &[
            METRES,
            ("feature-1", "line 3, column 1", "no height"),
            (
                "point",
                "line 4, column 1",
                "a Point is no footprint and is not taken; left out",
            ),
        ],
    );
    assert_eq!(imported.scene.crs, None);
}

#[test]
fn a_doubtful_feature_is_a_warning() {
    let imported = city("doubtful.geojson");
    assert_eq!(
        ids(&imported),
        ["open", "two points", "infinite", "no height", "sound"]
    );
    assert_warnings(
        &imported,
        &[
            METRES,
            ("open", "/features/0", "1 ring not closed"),
            (
                "two points",
                "/features/1",
                "1 ring of fewer than three distinct points",
            ),
            ("infinite", "/features/2", "1 position not finite"),
            ("nothing", "/features/3", "no geometry; left out"),
            ("empty", "/features/4", "no positions; left out"),
            ("too deep", "/features/5", "not those of a Polygon"),
            ("words", "/features/6", "not those of a Polygon"),
            (
                "no height",
                "/features/7",
                "h is \"tall\", which is no height",
            ),
            ("feature-8", "/features/8", "missing field `type`"),
            (
                "feature-9",
                "/features/9",
                "\"Building\" is no type of a feature",
            ),
        ],
    );
}

/// Null island, and a city on the other side of the globe.
#[test]
fn what_lies_far_from_the_first_feature_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.geojsonl");
    let at = |id: &str, lon: f64, lat: f64| {
        let (east, north) = (lon + 1e-4, lat + 1e-4);
        format!(
            r#"{{"type":"Feature","id":"{id}","properties":{{"height":3}},"geometry":{{"type":"Polygon","coordinates":[[[{lon},{lat}],[{east},{lat}],[{east},{north}],[{lon},{lat}]]]}}}}"#
        )
    };
    let features = [
        at("delft", 4.36, 52.01),
        at("berlin", 13.4, 52.52),
        at("null island", 0.0, 0.0),
        at("sydney", 151.2, -33.87),
    ];
    std::fs::write(&path, features.join("\n")).unwrap();
    let imported = import(&[path], &Options::default(), &|_, _| {}).unwrap();
    assert_eq!(ids(&imported), ["delft", "berlin"]);
    let far = "3 positions not finite, off the globe or over 15 degrees";
    assert_warnings(
        &imported,
        &[
            ("null island", "line 3, column 1", far),
            ("sydney", "line 4, column 1", far),
        ],
    );
}

/// One feature astray before a city, and a file that lies elsewhere than the ones before.
#[test]
fn a_file_of_which_most_lies_too_far_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, places: &[[f64; 2]]| {
        let features: Vec<String> = places
            .iter()
            .map(|[x, y]| {
                let (east, north) = (x + 1e-4, y + 1e-4);
                let ring = format!("[[[{x},{y}],[{east},{y}],[{east},{north}],[{x},{y}]]]");
                feature(r#"{"height":3}"#, &ring)
            })
            .collect();
        let path = folder.path().join(name);
        std::fs::write(&path, features.join("\n")).unwrap();
        path
    };
    let (delft, tokyo, null) = ([4.36, 52.01], [139.7, 35.7], [0.0, 0.0]);
    let in_delft = write("delft.geojsonl", &[delft, delft]);
    let refused = |files: &[std::path::PathBuf], words: &[&str]| {
        let error = import(files, &Options::default(), &|_, _| {}).unwrap_err();
        let told = error.to_string();
        for word in words {
            assert!(told.contains(word), "{word}: {told}");
        }
    };
    refused(
        &[write("astray.geojsonl", &[null, delft, tokyo])],
        &[
            "astray.geojsonl: 2 of its 3 features lie over 15 degrees from",
            "of the first one, at longitude 0, latitude 0;",
            "remove that one",
            "separate scenes",
        ],
    );
    let in_tokyo = write("tokyo.geojsonl", &[tokyo, tokyo]);
    refused(
        &[in_delft.clone(), in_tokyo],
        &[
            "tokyo.geojsonl: 2 of its 2 features",
            "from EPSG:32631, the UTM zone of the files before; import the file into",
        ],
    );
    refused(
        &[
            in_delft.clone(),
            write("south.geojsonl", &[null, delft, delft]),
        ],
        &[
            "2 of its 3",
            "files before, or from the latitude of the first one near it, at longitude 0",
        ],
    );
    // One astray in front is no measure of latitude, if the zone is given and it lies far from it.
    let kept = [in_delft, write("front.geojsonl", &[tokyo, delft, delft])];
    let imported = import(&kept, &Options::default(), &|_, _| {}).unwrap();
    assert_eq!(imported.scene.objects.len(), 4);
    let told = |what: &str| {
        imported
            .warnings
            .iter()
            .filter(|w| w.what.contains(what))
            .count()
    };
    assert_eq!(told("the UTM zone of the files before"), 1);
}

/// Metres lie in no zone that they could be far from.
#[test]
fn positions_in_metres_are_not_told_of_zones() {
    let ring = "[[[1e9,1e9],[1e999,1e9],[1e9,2e9],[1e9,1e9]]]";
    let imported = import_content("x.geojson", feature(r#"{"h":1}"#, ring).as_bytes()).unwrap();
    let dropped = "1 position not finite, dropped";
    assert!(
        imported.warnings.iter().any(|w| w.what.contains(dropped)),
        "{:?}",
        imported.warnings
    );
}

#[test]
fn the_height_named_by_the_caller_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.geojson");
    std::fs::write(
        &path,
        feature(r#"{"height":3,"roof":"8 m"}"#, &format!("[{SQUARE}]")),
    )
    .unwrap();
    for (height, top) in [(None, 3.0), (Some("roof"), 8.0)] {
        let options = Options {
            height: height.map(Into::into),
            ..Options::default()
        };
        let imported = import_one(&path, &options).unwrap();
        assert_eq!(imported.scene.objects[0].bounds.max().z, top, "{height:?}");
        assert_warnings(&imported, &[METRES]);
    }
}

/// As `OpenStreetMap` has it: heights count from the ground, also of what begins above it.
#[test]
fn parts_begin_where_they_say() {
    let flat = format!("[{SQUARE}]");
    let at_5 = flat.replace(",0]", ",0,5]").replace(",10]", ",10,5]");
    for (properties, coordinates, bounds, problem) in [
        (r#"{"height":9,"min_height":4}"#, &flat, [4.0, 9.0], ""),
        (r#"{"height":9,"min_height":4}"#, &at_5, [9.0, 14.0], ""),
        (
            r#"{"building:levels":5,"building:min_level":"3"}"#,
            &flat,
            [9.0, 15.0],
            "",
        ),
        (r#"{"height":0,"building:levels":2}"#, &flat, [0.0, 6.0], ""),
        (
            r#"{"height":3,"min_height":12}"#,
            &flat,
            [12.0, 15.0],
            "begins 12 m above the ground and its height is 3 m",
        ),
        (
            r#"{"height":9,"min_height":"low"}"#,
            &flat,
            [0.0, 9.0],
            "min_height is \"low\", which is no height",
        ),
        (r#"{"height":0,"min_height":4}"#, &flat, [0.0, 0.0], ""),
    ] {
        let imported = import_content("x.geojson", feature(properties, coordinates).as_bytes());
        let imported = imported.unwrap();
        let found = imported.scene.objects[0].bounds;
        assert_eq!([found.min().z, found.max().z], bounds, "{properties}");
        let told = imported.warnings.iter().filter(|w| w.object.is_some());
        let told: Vec<_> = told.map(|w| w.what.as_str()).collect();
        assert_eq!(told.len(), usize::from(!problem.is_empty()), "{told:?}");
        assert!(told.iter().all(|told| told.contains(problem)), "{told:?}");
    }
}

/// Degrees in a system that is thought to be in metres, and files that do not say where they lie.
#[test]
fn doubts_about_where_a_file_lies_are_warnings() {
    let ring = "[[[0.001,50],[0.002,50],[0.002,50.001],[0.001,50]]]";
    let crs = r#"{"crs":{"type":"name","properties":{"name":"EPSG:CODE"}},"type":"FeatureCollection","features":["#;
    let text = |code: &str| crs.replace("CODE", code) + &feature("{\"h\":1}", ring) + "]}";
    for (code, told) in [
        ("9999", &["look like degrees", "nothing is known here"][..]),
        ("28992", &["look like degrees"]),
        ("4267", &["WGS 84"]),
    ] {
        let imported = import_content("x.geojson", text(code).as_bytes()).unwrap();
        assert_eq!(imported.warnings.len(), told.len(), "{code}");
        for (warning, words) in imported.warnings.iter().zip(told) {
            assert!(warning.what.contains(words), "{code}");
        }
    }
    let bare = fixture("obj/bare.obj");
    let stated = fixture("cityjson/solid.city.json");
    for files in [[bare.clone(), stated.clone()], [stated, bare.clone()]] {
        let imported = import(&files, &Options::default(), &|_, _| {}).unwrap();
        assert_eq!(*imported.warnings[0].path, bare);
        assert!(
            imported.warnings[0]
                .what
                .contains("taken to lie in EPSG:6677")
        );
    }
    let degrees = crate::written::solid().replace("EPSG/0/6677", "EPSG/0/6697");
    match import_content("x.city.json", degrees.as_bytes()) {
        Err(ImportError::Unsupported { feature, .. }) => assert!(feature.contains("EPSG:6697")),
        other => panic!("{other:?}"),
    }
}

#[test]
fn ids_of_any_kind_survive() {
    let square = format!("[{SQUARE}]");
    let base = feature(r#"{"h":1}"#, &square);
    for (id, expected) in [
        (r#""千代田""#.to_owned(), "千代田".to_owned()),
        (r#""\u6771\"""#.to_owned(), "東\"".to_owned()),
        (format!("\"{}\"", "x".repeat(10_000)), "x".repeat(10_000)),
        ("1.50".to_owned(), "1.50".to_owned()),
        ("null".to_owned(), "feature-0".to_owned()),
        ("{}".to_owned(), "feature-0".to_owned()),
    ] {
        let text = base.replace("\"f\"", &id);
        let twice = format!("{text}\n{text}");
        let imported = import_content("x.geojsonl", twice.as_bytes()).unwrap();
        assert_eq!(imported.scene.objects.len(), 2);
        assert_eq!(imported.scene.objects[0].id, expected);
    }
}

#[test]
fn files_share_the_zone_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let at = |x: f64, y: f64| {
        let ring = [(0.0, 0.0), (0.001, 0.0), (0.0, 0.001), (0.0, 0.0)]
            .map(|(dx, dy)| format!("[{},{}]", x + dx, y + dy))
            .join(",");
        feature("{\"h\":1}", &format!("[[{ring}]]"))
    };
    let west = write("west.geojson", &at(5.9, 45.0));
    let east = write("east.geojson", &at(6.1, 45.0));
    let both = import(
        &[west.clone(), east.clone()],
        &Options::default(),
        &|_, _| {},
    )
    .unwrap();
    assert_eq!(both.scene.crs.as_deref(), Some("EPSG:32631"));
    let [a, b] = both.scene.objects.as_slice() else {
        panic!("{both:?}");
    };
    let apart = b.bounds.min().x - a.bounds.min().x;
    assert!((apart - 15_770.0).abs() < 60.0, "{apart}");
    let alone = import_one(&east, &Options::default()).unwrap();
    assert_eq!(alone.scene.crs.as_deref(), Some("EPSG:32632"));
    let south = import_content("s.geojson", at(18.4, -33.9).as_bytes()).unwrap();
    assert_eq!(south.scene.crs.as_deref(), Some("EPSG:32734"));
    assert!(south.scene.objects[0].bounds.min().y > 6_000_000.0);
    let grid = fixture("geojson/metres.geojson");
    let mixed = import(&[grid, west], &Options::default(), &|_, _| {});
    assert!(matches!(mixed, Err(ImportError::CrsMismatch { .. })));
}

#[test]
fn a_second_array_of_features_is_warned_of() {
    let imported = import_content("x.geojson", b"{\"features\":[],\n\"features\":[]}");
    assert_warnings(
        &imported.unwrap(),
        &[("", "line 2, column 1", "a second array")],
    );
}

/// Writes features of 1 MB of coordinates each.
fn write_large(path: &Path, features: usize) {
    let mut ring = String::from("[[1000,0]");
    while ring.len() < 1 << 20 {
        let _ = write!(
            ring,
            ",[10{}.25,{}.5]",
            ring.len() % 90 + 10,
            ring.len() % 97
        );
    }
    ring += ",[1000,0]]";
    let feature = feature("{\"h\":1}", &format!("[{ring}]"));
    let mut file = std::fs::File::create(path).unwrap();
    file.write_all(b"{\"type\":\"FeatureCollection\",\"features\":[")
        .unwrap();
    for i in 0..features {
        let comma = if i == 0 { "" } else { ",\n" };
        file.write_all(comma.as_bytes()).unwrap();
        file.write_all(feature.as_bytes()).unwrap();
    }
    file.write_all(b"]}").unwrap();
}

/// Not a test of its own: `memory_follows_the_objects_and_not_the_file` runs it in a process whose
/// peak memory is of nothing else.
#[test]
#[ignore = "run by memory_follows_the_objects_and_not_the_file"]
fn import_and_print_peak_memory() {
    let Some(path) = std::env::var_os("CITYLOD_TEST_FILE") else {
        return;
    };
    let imported = import_one(Path::new(&path), &Options::default()).unwrap();
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let peak = status.lines().find(|l| l.starts_with("VmHWM")).unwrap();
    println!("\n{} objects, {peak}", imported.scene.objects.len());
}

#[cfg(target_os = "linux")]
#[test]
fn memory_follows_the_objects_and_not_the_file() {
    const GROWTH_KB: u64 = 4 * 1024;
    let folder = tempfile::tempdir().unwrap();
    let peak_kb = |features: usize| -> u64 {
        let path = folder.path().join(format!("{features}.geojson"));
        write_large(&path, features);
        let output = std::process::Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "import_geojson::import_and_print_peak_memory"])
            .args(["--ignored", "--nocapture"])
            .env("CITYLOD_TEST_FILE", &path)
            .output()
            .unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let line = text.lines().find(|l| l.contains("VmHWM")).unwrap();
        assert!(line.starts_with(&format!("{features} objects")), "{line}");
        line.split_whitespace()
            .rev()
            .nth(1)
            .unwrap()
            .parse()
            .unwrap()
    };
    let (small, large) = (peak_kb(5), peak_kb(50));
    println!("peak of 5 MB: {small} kB; of 50 MB: {large} kB");
    assert!(large < small + GROWTH_KB, "{small} kB, {large} kB");
}

#[test]
fn real_cities_have_their_objects() {
    for (name, count) in [
        ("chiyoda-11581", 11_581),
        ("minato-28106", 28_106),
        ("katsushika-106807", 106_807),
    ] {
        let Some(path) = real(&format!("geojson/tokyo-{name}.geojson.gz")) else {
            return;
        };
        let imported = import_one(&path, &Options::default()).unwrap();
        assert_eq!(imported.scene.objects.len(), count, "{name}");
        assert_eq!(imported.scene.crs.as_deref(), Some("EPSG:32654"));
        assert_warnings(&imported, &[]);
    }
}

/// The same buildings in the national grid. The two grids are turned against each other by the
/// convergence of UTM (0.73° here) and differ in scale by 0.9999 / 0.9996.
#[test]
fn real_buildings_are_as_large_as_in_the_national_grid() {
    const TURN: f64 = 0.0135;
    const SCALE: f64 = 0.0004;
    const TOLERANCE_M: f64 = 0.05;
    const HEIGHT_TOLERANCE_M: f64 = 0.002;
    let Some(obj) = real("obj/tokyo-chiyoda-11581.obj") else {
        return;
    };
    let obj = std::fs::read_to_string(obj).unwrap();
    let expected = obj_sizes(&obj);
    let path = real("geojson/tokyo-chiyoda-11581.geojson.gz").unwrap();
    let imported = import_one(&path, &Options::default()).unwrap();
    assert_eq!(expected.len(), imported.scene.objects.len());
    for object in &imported.scene.objects {
        let [x, y, z] = expected[object.id.as_str()];
        let size = object.bounds.size();
        let allowed = |a: f64, b: f64| TOLERANCE_M + SCALE * a + TURN * b;
        assert!(
            (size.x - x).abs() < allowed(x, y)
                && (size.y - y).abs() < allowed(y, x)
                && (size.z - z).abs() < HEIGHT_TOLERANCE_M,
            "{}: {size}, expected {x} {y} {z}",
            object.id
        );
    }
}

/// Extents by group name.
fn obj_sizes(text: &str) -> HashMap<&str, [f64; 3]> {
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    let mut boxes: HashMap<&str, ([f64; 3], [f64; 3])> = HashMap::new();
    let mut group = "";
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut number = || words.next().unwrap().parse().unwrap();
                vertices.push([number(), number(), number()]);
            }
            Some("o") => group = line[2..].trim(),
            Some("f") => {
                let nothing = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
                let (low, high) = boxes.entry(group).or_insert(nothing);
                for word in words {
                    let index: usize = word.split('/').next().unwrap().parse().unwrap();
                    for axis in 0..3 {
                        low[axis] = low[axis].min(vertices[index - 1][axis]);
                        high[axis] = high[axis].max(vertices[index - 1][axis]);
                    }
                }
            }
            _ => {}
        }
    }
    let sizes = boxes.into_iter();
    sizes
        .map(|(id, (low, high))| (id, std::array::from_fn(|i| high[i] - low[i])))
        .collect()
}
