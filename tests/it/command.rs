use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::Stdio;

use citylod::geom::DVec3;
use citylod::index::LodTree;
use citylod::lod::{Beyond, BudgetLod, ErrorLod, Lod, RangeLod, Selection, select};
use serde_json::Value;

use crate::desk::Desk;
use crate::support::look;
use crate::written::fixture;

fn keys(value: &Value) -> Vec<&str> {
    value
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect()
}

fn ids(objects: &[Value]) -> Vec<&str> {
    let mut ids: Vec<&str> = objects.iter().map(|o| o["id"].as_str().unwrap()).collect();
    ids.sort_unstable();
    ids
}

#[test]
fn several_files_make_one_city_gzipped_or_not() {
    let desk = Desk::new();
    let one = desk.imported(&["cityjson/solid.city.json"], "");
    let text = std::fs::read(fixture("cityjson/solid.city.json")).unwrap();
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gz.write_all(&text).unwrap();
    desk.write("solid.city.json.gz", &gz.finish().unwrap());
    desk.out("import solid.city.json.gz -o gz.citylod");
    assert_eq!(desk.lines("info gz.citylod --objects"), one);

    let two = desk.imported(&["cityjson/solid.city.json", "obj/bare.obj"], "");
    assert_eq!(ids(&one), ["b1"]);
    assert_eq!(ids(&two), ["b1", "bare"]);
}

/// Importing the same file twice is a city with everything twice, and a warning for each.
#[test]
fn ids_that_repeat_are_made_unique_with_a_warning() {
    let desk = Desk::new();
    let twice = desk.imported(&["obj/bare.obj", "obj/bare.obj"], "");
    assert_eq!(ids(&twice), ["bare", "bare~2"]);
    let names = desk.imported(&["cityjson/names.city.json"], "");
    assert_eq!(ids(&names)[..3], ["", "twice", "twice~2"]);
    desk.write("b.obj", &std::fs::read(fixture("obj/bare.obj")).unwrap());
    let run = desk.run("import b.obj b.obj -o city.citylod");
    assert!(run.err.contains(r#"imported as "b~2""#), "{}", run.err);
    let run = desk.run("import b.obj b.obj -o city.citylod --warnings 0");
    assert!(!run.err.contains("imported as"), "{}", run.err);
    assert!(run.err.contains("and 1 more warning;"), "{}", run.err);
}

#[test]
fn flags_of_import_change_the_city() {
    let desk = Desk::new();
    let top = |objects: &[Value]| objects[0]["bounds"][5].as_f64().unwrap();

    desk.write("t.obj", b"v 1 2 3\nv 4 2 3\nv 4 6 3\nf 1 2 3\n");
    desk.out("import t.obj -o z.citylod --up z");
    desk.out("import t.obj -o y.citylod --up y");
    let bounds = |name: &str| desk.lines(&format!("info {name} --objects"))[0]["bounds"].clone();
    assert_eq!(
        bounds("z.citylod"),
        serde_json::json!([1., 2., 3., 4., 6., 3.])
    );
    assert_eq!(
        bounds("y.citylod"),
        serde_json::json!([1., -3., 2., 4., -3., 6.])
    );

    let levels = ["cityjson/levels.city.json"];
    assert_eq!(top(&desk.imported(&levels, "")), 8.0);
    assert_eq!(top(&desk.imported(&levels, "--lod 1.2")), 3.0);

    let feature = crate::written::feature(
        r#"{"height":3,"roof":8}"#,
        &format!("[{}]", crate::written::SQUARE),
    );
    desk.write("f.geojson", feature.as_bytes());
    desk.out("import f.geojson -o h.citylod");
    desk.out("import f.geojson -o r.citylod --height roof");
    assert_eq!(bounds("h.citylod")[5], 3.0);
    assert_eq!(bounds("r.citylod")[5], 8.0);
}

/// A tower, a hall and a bridge at the end of a row of huts: one of them stands for the others.
#[test]
fn promotion_decides_who_stands_for_the_neighbours() {
    let desk = Desk::new();
    let mut obj = String::new();
    let huts = (0..7).map(|i| (format!("hut{i}"), f64::from(i) * 20.0, [5.0, 5.0, 3.0]));
    let large = [
        ("tower".to_owned(), 2000.0, [1.0, 1.0, 50.0]),
        ("hall".to_owned(), 2100.0, [60.0, 60.0, 1.0]),
        ("bridge".to_owned(), 2200.0, [150.0, 2.0, 2.0]),
    ];
    for (id, x, [w, d, h]) in huts.chain(large) {
        let far = x + w;
        obj.extend([
            format!("o {id}\nv {x} 0 0\nv {far} 0 0\n"),
            format!("v {far} {d} {h}\nv {x} {d} {h}\nf -4 -3 -2 -1\n"),
        ]);
    }
    desk.write("row.obj", obj.as_bytes());
    for (options, expected, name) in [
        ("", "tower", "tallest"),
        ("--promote tallest", "tower", "tallest"),
        ("--promote footprint", "hall", "footprint"),
        ("--promote largest", "bridge", "largest"),
    ] {
        desk.out(format!("import row.obj -o city.citylod {options}").trim_end());
        assert_eq!(desk.json("info city.citylod --json")["promotion"], name);
        let promoted: Vec<Value> = desk
            .lines("info city.citylod --objects")
            .into_iter()
            .filter(|o| o["level"] == 1)
            .collect();
        assert!(ids(&promoted).contains(&expected), "{name}: {promoted:?}");
        assert_eq!(promoted.len(), 2, "{name}");
    }
}

#[test]
fn a_failed_import_leaves_the_output_as_it_was() {
    let desk = Desk::new();
    desk.write("city.citylod", b"precious");
    desk.write("bad.city.json", b"{\"type\":\"CityJSON\",");
    desk.refuses(
        "import bad.city.json -o city.citylod",
        1,
        &["bad.city.json", "line 1"],
    );
    desk.refuses(
        "import none.obj -o city.citylod",
        1,
        &["none.obj: cannot read"],
    );
    desk.write("a.xyz", b"1 2 3");
    desk.refuses(
        "import a.xyz -o city.citylod",
        1,
        &["a.xyz", "expected .gltf"],
    );
    assert_eq!(
        std::fs::read(desk.path("city.citylod")).unwrap(),
        b"precious"
    );
    assert_eq!(std::fs::read_dir(desk.path("")).unwrap().count(), 3);
    desk.write("ok.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    desk.refuses(
        "import ok.obj -o no/city.citylod",
        1,
        &["no/city.citylod: cannot write"],
    );
}

#[test]
fn an_import_without_objects_or_into_a_source_is_refused() {
    let desk = Desk::new();
    desk.write("city.citylod", b"precious");
    desk.write(
        "none.geojson",
        br#"{"type":"FeatureCollection","features":[]}"#,
    );
    let none = "import none.geojson -o city.citylod";
    desk.refuses(none, 1, &["no object", "city.citylod"]);
    let kept = std::fs::read(desk.path("city.citylod")).unwrap();
    assert_eq!(kept, b"precious");
    desk.refuses("import none.geojson -o none.geojson", 2, &[".citylod"]);
    desk.refuses(
        &format!("{none} --lod 2 --up y"),
        1,
        &["--lod is", "--up is"],
    );
    let run = desk.run("import no.obj -o city.citylod");
    assert_eq!(run.err.matches("no such file").count(), 1, "{}", run.err);
    desk.write("ok.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let run = desk.run("import ok.obj -o no/city.citylod");
    assert_eq!(run.err.matches("no such folder").count(), 1, "{}", run.err);
    assert!(!run.err.contains(".citylod-"), "{}", run.err);
}

#[test]
fn generate_makes_the_same_city_in_both_formats() {
    let desk = Desk::new();
    desk.out("generate --objects 300 -o a.citylod");
    desk.out("generate --objects 300 --seed 1 -o b.citylod");
    desk.out("generate --objects 300 --seed 2 -o c.citylod");
    desk.out("generate --objects 300 --promote footprint -o d.citylod");
    let read = |name: &str| std::fs::read(desk.path(name)).unwrap();
    assert!(
        read("a.citylod") == read("b.citylod"),
        "seed 1 is the default"
    );
    assert!(read("a.citylod") != read("c.citylod"));
    assert!(read("a.citylod") != read("d.citylod"));

    desk.out("generate --objects 300 -o a.glb");
    desk.out("import a.glb -o e.citylod");
    let (made, imported) = (
        desk.lines("info a.citylod --objects"),
        desk.lines("info e.citylod --objects"),
    );
    assert_eq!(ids(&made), ids(&imported));

    desk.out("generate --objects 0 -o none.citylod");
    assert_eq!(desk.json("info none.citylod --json")["objects"], 0);
    desk.refuses(
        "generate --objects 9 -o a.obj",
        2,
        &["a.obj", ".citylod or .glb"],
    );
    desk.refuses("generate -o b.glb --promote tallest", 2, &["--promote"]);
    assert!(!desk.path("a.obj").exists());
}

#[test]
fn info_states_what_the_library_holds() {
    let desk = Desk::new();
    desk.out("generate --objects 500 -o city.citylod");
    let tree = LodTree::open(&desk.path("city.citylod")).unwrap();

    let info = desk.json("info city.citylod --json");
    assert_eq!(info["objects"], 500);
    assert_eq!(info["nodes"], tree.node_count());
    assert_eq!(info["levels"], tree.level_count());
    assert_eq!(info["revision"], tree.revision());
    assert_eq!(info["bounds"], serde_json::json!(tree.bounds().to_array()));
    let classes = info["classes"].as_object().unwrap().values();
    assert_eq!(classes.filter_map(Value::as_u64).sum::<u64>(), 500);
    assert!(desk.out("info city.citylod").contains("objects    500"));
    let check = desk.run("info city.citylod --check");
    assert_eq!((check.code, check.err.contains("sound")), (Some(0), true));

    let objects = desk.lines("info city.citylod --objects");
    assert_eq!(objects.len(), 500);
    for (number, line) in (0..).zip(&objects) {
        assert_eq!(keys(line), ["bounds", "class", "id", "index", "level"]);
        let object = tree.object(number).unwrap();
        assert_eq!(line["index"], number);
        assert_eq!(line["id"], *object.id);
        assert_eq!(line["class"], object.class);
        assert_eq!(line["level"], object.level);
        assert_eq!(line["bounds"], serde_json::json!(object.bounds.to_array()));
    }

    let nodes = desk.lines("info city.citylod --nodes");
    assert_eq!(nodes.len(), tree.node_count() as usize);
    let (mut owned, mut children) = (Vec::new(), vec![0]);
    let numbers = |value: &Value| -> Vec<u64> {
        let array = value.as_array().unwrap();
        array.iter().map(|n| n.as_u64().unwrap()).collect()
    };
    for (number, line) in (0..).zip(&nodes) {
        assert_eq!(
            keys(line),
            ["bounds", "children", "level", "node", "objects"]
        );
        assert_eq!(line["node"], number);
        let exact = tree.arrays().node_boxes[number as usize];
        assert_eq!(line["bounds"], serde_json::json!(exact));
        for child in numbers(&line["children"]) {
            let below = line["level"].as_u64().unwrap() - 1;
            assert_eq!(nodes[child as usize]["level"], below);
            children.push(child);
        }
        for object in numbers(&line["objects"]) {
            assert_eq!(objects[object as usize]["level"], line["level"]);
            owned.push(object);
        }
    }
    owned.sort_unstable();
    children.sort_unstable();
    assert_eq!(owned, (0..500).collect::<Vec<u64>>());
    assert_eq!(
        children,
        (0..u64::from(tree.node_count())).collect::<Vec<_>>()
    );
}

fn library_ids(path: &Path, lod: &Lod) -> (Vec<String>, f64) {
    let tree = LodTree::open(path).unwrap();
    let view = look(DVec3::new(-350.5, -200.0, 80.0), DVec3::ZERO);
    let mut selection = Selection::default();
    select(&tree, &view, lod, &mut selection);
    let ids = selection
        .objects()
        .map(|o| tree.id(o).unwrap().into_owned());
    (ids.collect(), selection.error_px())
}

fn by_range(far_dist: f64, levels: u32) -> Lod {
    Lod::Range(RangeLod::new(far_dist, 2.5, levels, Beyond::Show).unwrap())
}

#[test]
fn query_by_size_gives_the_librarys_answer() {
    const POSE: &str = "query city.citylod --eye -350.5,-200,80 --target 0,0,0";
    let desk = Desk::new();
    desk.out("generate --objects 3000 -o city.citylod --promote largest");
    let path = desk.path("city.citylod");
    for (options, lod, members) in [
        (
            "--max-error-px 30",
            Lod::Error(ErrorLod::new(30.0).unwrap()),
            serde_json::json!({"mode":"error","max_error_px":30.0}),
        ),
        (
            "--max-objects 123",
            Lod::Budget(BudgetLod::new(123)),
            serde_json::json!({"mode":"budget","max_objects":123}),
        ),
    ] {
        let (expected, error_px) = library_ids(&path, &lod);
        assert!(expected.len() > 100, "a view worth testing");
        let out = desk.out(&format!("{POSE} {options}"));
        assert_eq!(out.lines().collect::<Vec<_>>(), expected, "{options}");
        let answer = desk.json(&format!("{POSE} {options} --json"));
        let mut wanted = members;
        wanted["error_px"] = serde_json::json!(error_px);
        assert_eq!(answer["lod"], wanted);
        assert_eq!(answer["ids"], serde_json::json!(expected));
    }
}

#[test]
fn query_gives_the_librarys_answer() {
    const POSE: &str = "query city.citylod --eye -350.5,-200,80 --target 0,0,0";
    let desk = Desk::new();
    desk.out("generate --objects 3000 -o city.citylod");
    let path = desk.path("city.citylod");
    for (options, far_dist, levels) in [
        ("", 500.0, 4),
        ("--far-dist 60", 60.0, 4),
        ("--far-dist 60 --levels 2", 60.0, 2),
        ("--far-dist inf", f64::INFINITY, 4),
    ] {
        let words = format!("{POSE} {options}");
        let (expected, error_px) = library_ids(&path, &by_range(far_dist, levels));
        assert!(!expected.is_empty());
        let out = desk.out(words.trim_end());
        assert_eq!(out.lines().collect::<Vec<_>>(), expected, "{options}");
        let answer = desk.json(&format!("{} --json", words.trim_end()));
        assert_eq!(answer["ids"], serde_json::json!(expected), "{options}");
        assert_eq!(answer["count"], expected.len());
        assert_eq!(answer["scene"], "city");
        assert_eq!(answer["lod"].get("beyond"), None);
        assert_eq!(answer["lod"]["error_px"], error_px);
        assert_eq!(answer["lod"]["levels"], levels);
        assert!(answer["stats"]["nodes_visited"].as_u64() > Some(0));
        assert!(answer["stats"]["retrieve_us"].as_f64() > Some(0.0));
    }
    let count = |options: &str| desk.out(&format!("{POSE} {options}")).lines().count();
    let usual = count("--far-dist 60 --levels 3");
    for different in [
        "--fov 20",
        "--size 600x1200",
        "--dist-factor 5",
        "--beyond hide",
    ] {
        let changed = count(&format!("--far-dist 60 --levels 3 {different}"));
        assert_ne!(changed, usual, "{different}");
    }
    let down = "query city.citylod --eye 0,0,500 --target 0,0,0";
    assert!(desk.out(down).lines().count() > 0, "straight down");
}

#[test]
fn exit_codes_and_places() {
    let desk = Desk::new();
    desk.out("generate --objects 100 -o city.citylod");
    for usage in [
        "fly",
        "import a.obj",
        "info",
        "info city.citylod --objects --nodes",
        "generate --objects -1 -o a.citylod",
        "generate --objects 9 -o a.citylod --promote widest",
        "query city.citylod --eye 1,2 --target 0,0,0",
        "query city.citylod --eye 1,2,3 --target 0,0,0 --size 800",
        "experiment none",
    ] {
        desk.refuses(usage, 2, &["--help"]);
    }
    let query = "query city.citylod --eye 1,2,3 --target";
    for (rest, words) in [
        ("1,2,3", "--target"),
        ("1,nan,3", "--target"),
        ("9,9,9 --fov 180", "--fov"),
        ("9,9,9 --fov 0", "--fov"),
        ("9,9,9 --size 0x10", "--size"),
        ("9,9,9 --levels 0", "--levels"),
        ("9,9,9 --dist-factor 0", "--dist-factor"),
        ("9,9,9 --far-dist -1", "--far-dist"),
        ("9,9,9 --far-dist nan", "a number of metres or inf"),
        ("9,9,9 --max-error-px -1", "--max-error-px"),
        ("9,9,9 --max-error-px inf", "--max-error-px"),
        ("9,9,9 --max-objects 1.5", "--max-objects"),
        (
            "9,9,9 --max-objects 5 --max-error-px 1",
            "cannot be used with",
        ),
        ("9,9,9 --max-error-px 1 --far-dist 9", "cannot be used with"),
        (
            "9,9,9 --max-error-px 1 --beyond show",
            "cannot be used with",
        ),
        ("9,9,9 --max-objects 5 --levels 2", "cannot be used with"),
        (
            "9,9,9 --max-objects 5 --dist-factor 2",
            "cannot be used with",
        ),
    ] {
        desk.refuses(&format!("{query} {rest}"), 2, &[words, "--help"]);
    }

    desk.refuses("info none.citylod", 1, &["none.citylod: cannot open"]);
    desk.write("empty.citylod", b"");
    desk.refuses("info empty.citylod", 1, &["empty.citylod: header"]);
    desk.write("foreign.citylod", b"{\"type\":\"CityJSON\"}");
    desk.refuses(
        "info foreign.citylod",
        1,
        &["foreign.citylod: header", "not a .citylod file"],
    );
    let mut bytes = std::fs::read(desk.path("city.citylod")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    desk.write("damaged.citylod", &bytes);
    for verb in [
        "info damaged.citylod",
        "query damaged.citylod --eye 0,0,9 --target 9,9,9",
    ] {
        desk.refuses(verb, 1, &["damaged.citylod: section `", "checksum"]);
    }
    desk.write("cut.citylod", &bytes[..middle]);
    desk.refuses("info cut.citylod", 1, &["cut.citylod", "beyond the end"]);
    assert_eq!(desk.run("--version").code, Some(0));
    assert_eq!(desk.run("query --help").code, Some(0));
}

/// As `citylod info … --objects | head -1` does.
#[test]
fn a_reader_that_has_seen_enough_is_no_failure() {
    let desk = Desk::new();
    desk.out("generate --objects 20000 -o city.citylod");
    let mut child = desk
        .command()
        .args(["info", "city.citylod", "--objects"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    let mut out = BufReader::new(child.stdout.take().unwrap());
    out.read_line(&mut line).unwrap();
    assert!(line.starts_with('{'), "{line}");
    drop(out);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
}

#[test]
fn a_camera_that_misses_the_city_is_told_where_the_city_is() {
    let desk = Desk::new();
    desk.out("generate --objects 500 -o city.citylod");
    for (words, hinted) in [
        ("--eye 0,-9000,100 --target 0,-9900,100", true),
        ("--eye 0,-9000,100 --target 0,0,0", false),
        // In view, but too small.
        ("--eye 0,-9000,100 --target 0,0,0 --max-error-px 900", false),
    ] {
        for verb in ["query city.citylod", "query city.citylod --json"] {
            let run = desk.run(&format!("{verb} {words}"));
            assert_eq!(run.code, Some(0), "{}", run.err);
            let hint = run
                .err
                .contains("nothing of the city is in view: it lies between -");
            assert_eq!(hint, hinted, "{words}: {}", run.err);
        }
    }
    let away = "--eye 0,-9000,100 --target 0,-9900,100 --size 64x48 -o view.png";
    let run = desk.run(&format!("render city.citylod {away}"));
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(
        run.err.contains("nothing of the city is in view"),
        "{}",
        run.err
    );
}
