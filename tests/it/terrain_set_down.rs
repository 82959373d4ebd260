use std::fmt::Write as _;

use citylod::index::LodTree;

use crate::desk::Desk;

/// Farthest that a height may be off after it was moved up and down, m.
const HEIGHT_TOLERANCE_M: f64 = 1e-9;

/// A footprint 8 m × 8 m from (x, 5) on, with `z` behind each position.
fn footprint(name: &str, x: f64, z: &str) -> String {
    let corners = [
        (x, 5.0),
        (x + 8.0, 5.0),
        (x + 8.0, 13.0),
        (x, 13.0),
        (x, 5.0),
    ];
    let corners: Vec<String> = corners
        .iter()
        .map(|(x, y)| format!("[{x},{y}{z}]"))
        .collect();
    format!(
        r#"{{"type":"Feature","id":"{name}","properties":{{"height":12.3,"class":"House"}},"geometry":{{"type":"Polygon","coordinates":[[{}]]}}}}"#,
        corners.join(",")
    )
}

/// Posts 10 m apart from (1000, 0) on: the height falls by 3 m a column from `top` on, and rises by
/// 0.5 m a row.
fn slope(top: f64) -> String {
    let mut text = "ncols 12 nrows 4 xllcenter 1000 yllcenter 0 cellsize 10\n".to_owned();
    for row in (0..4).rev() {
        for column in 0..12 {
            let _ = write!(
                text,
                "{} ",
                top - 3.0 * f64::from(column) + 0.5 * f64::from(row)
            );
        }
        text.push('\n');
    }
    text
}

/// The same on any point of its area: bilinear, as it is a plane.
fn height(top: f64, x: f64, y: f64) -> f64 {
    top - 3.0 * (x - 1000.0) / 10.0 + 0.5 * y / 10.0
}

/// A desk with a city of two houses without a base, one beyond the elevation, and one with a base.
fn desk() -> Desk {
    let desk = Desk::new();
    let features = [
        footprint("a", 1003.0, ""),
        footprint("b", 1047.0, ""),
        footprint("beyond", 2000.0, ""),
        footprint("known", 1080.0, ",700"),
    ];
    desk.write("city.geojsonl", features.join("\n").as_bytes());
    desk.out("import city.geojsonl -o city.citylod");
    for (name, top) in [("high.asc", 1600.0), ("low.asc", 40.0)] {
        desk.write(name, slope(top).as_bytes());
    }
    desk
}

/// Base and height of each object, by id.
fn stands(desk: &Desk) -> Vec<(String, f64, f64)> {
    let tree = LodTree::open_verified(&desk.path("city.citylod")).unwrap();
    assert_eq!(tree.validate(), []);
    let ids = ["a", "b", "beyond", "known"];
    let of = |id: &str| {
        let object = tree.object(tree.find(id).unwrap()).unwrap();
        assert_eq!(object.base_known, id == "known");
        assert!(object.attributes.unwrap().contains("House"));
        let (low, high) = (object.bounds.min().z, object.bounds.max().z);
        (id.to_owned(), low, high - low)
    };
    ids.map(of).to_vec()
}

fn assert_stands(desk: &Desk, bases: [f64; 4]) {
    for ((id, base, height), expected) in stands(desk).into_iter().zip(bases) {
        assert!(
            (base - expected).abs() < 1e-3,
            "{id}: {base}, not {expected}"
        );
        assert!((height - 12.3).abs() < HEIGHT_TOLERANCE_M, "{id}: {height}");
    }
}

/// The lowest ground is under the south-east corner of a box. Posts are kept as f32. What lies beyond
/// stands as high as the nearest post does, the last one of the row that it is beside.
fn expected(top: f64) -> [f64; 3] {
    let lowest = |x| height(top, x, 5.0);
    [lowest(1011.0), lowest(1055.0), height(top, 1110.0, 10.0)]
}

#[test]
fn footprints_without_a_base_are_set_on_the_ground_and_set_anew() {
    let desk = desk();
    assert_stands(&desk, [0.0, 0.0, 0.0, 700.0]);
    let told = desk.out("info city.citylod");
    assert!(
        told.contains("bases      not known of 3 objects; at 0"),
        "{told}"
    );
    assert!(
        told.contains("import ELEVATION --into city.citylod"),
        "{told}"
    );
    assert_eq!(desk.json("info city.citylod --json")["base_unknown"], 3);
    let files = || ["city.citylod", "city.terrain"].map(|f| std::fs::read(desk.path(f)).unwrap());
    let lay = |elevation: &str| {
        let run = desk.run(&format!("import {elevation} --into city.citylod"));
        assert_eq!(run.code, Some(0), "{}", run.err);
        assert!(
            run.err
                .contains("city.citylod: 2 objects set on the lowest ground"),
            "{}",
            run.err
        );
        assert!(run.err.contains("known: its base is"), "{}", run.err);
        assert!(run.err.contains("--drape"), "{}", run.err);
        assert!(
            run.err.contains("1 have no ground under them"),
            "{}",
            run.err
        );
        assert!(!run.err.contains("a: its base is"), "{}", run.err);
        files()
    };
    let high = lay("high.asc");
    let [a, b, beyond] = expected(1600.0);
    assert_stands(&desk, [a, b, beyond, 700.0]);
    assert_eq!(lay("high.asc"), high, "a second time changes nothing");
    let told = desk.out("info city.citylod --check");
    assert!(
        told.contains(
            "bases      not known of 3 objects; set on the ground; as high as the nearest where there is none"
        ),
        "{told}"
    );
    lay("low.asc");
    let [a, b, beyond] = expected(40.0);
    assert_stands(&desk, [a, b, beyond, 700.0]);
    lay("high.asc");
    let [a, b, beyond] = expected(1600.0);
    assert_stands(&desk, [a, b, beyond, 700.0]);
}

/// What ground was laid before does not matter to where a footprint without a base stands.
#[test]
fn footprints_that_other_ground_does_not_reach_stand_as_high_as_the_nearest() {
    let desk = desk();
    desk.out("import high.asc --into city.citylod");
    let [a, b, beyond] = expected(1600.0);
    assert_stands(&desk, [a, b, beyond, 700.0]);
    // As many columns, of which the first four end west of b.
    let rows = slope(40.0);
    let (head, heights) = rows.split_once('\n').unwrap();
    let cut: String = heights
        .lines()
        .map(|row| row.split(' ').take(4).collect::<Vec<_>>().join(" ") + "\n")
        .collect();
    let narrow = head.replace("ncols 12", "ncols 4") + "\n" + &cut;
    desk.write("narrow.asc", narrow.as_bytes());
    let run = desk.run("import narrow.asc --into city.citylod");
    assert_eq!(run.code, Some(0), "{}", run.err);
    for words in [
        "of 4 objects, 1 have no ground under them and stay where they are; the ground reaches from 1000 0 to 1030 30: known",
        "of 4 objects, 2 have no ground under them and stand as high as the nearest ground that is known; the ground reaches from 1000 0 to 1030 30: ",
        "city.citylod: 1 object set on the lowest ground",
    ] {
        assert!(run.err.contains(words), "{words:?} is not in {}", run.err);
    }
    let [a, ..] = expected(40.0);
    let east = height(40.0, 1030.0, 10.0);
    assert_stands(&desk, [a, east, east, 700.0]);
}

/// A roof 4 m above its ground stays so, whatever ground is laid and taken away.
#[test]
fn parts_that_begin_above_the_ground_are_kept_so() {
    let desk = Desk::new();
    let roof = |name: &str, x: f64| {
        let part = r#""min_height":4,"height":12.3"#;
        footprint(name, x, "").replace(r#""height":12.3"#, part)
    };
    let features = [roof("a", 1003.0), roof("b", 1047.0)];
    desk.write("city.geojsonl", features.join("\n").as_bytes());
    desk.out("import city.geojsonl -o city.citylod");
    for (name, top) in [("high.asc", 1600.0), ("low.asc", 40.0)] {
        desk.write(name, slope(top).as_bytes());
    }
    let west = slope(40.0).replace("xllcenter 1000", "xllcenter 920");
    desk.write("west.asc", west.as_bytes());
    let heights = || {
        let tree = LodTree::open_verified(&desk.path("city.citylod")).unwrap();
        ["a", "b"].map(|id| {
            let bounds = tree.object(tree.find(id).unwrap()).unwrap().bounds;
            assert!((bounds.size().z - 8.3).abs() < HEIGHT_TOLERANCE_M);
            bounds.min().z
        })
    };
    assert_eq!(heights(), [4.0, 4.0]);
    let on = |top| [expected(top)[0], expected(top)[1]];
    for (name, [a, b]) in [
        ("high.asc", on(1600.0)),
        ("low.asc", on(40.0)),
        (
            "west.asc",
            [height(16.0, 1011.0, 5.0), height(16.0, 1030.0, 10.0)],
        ),
    ] {
        let run = desk.run(&format!("import {name} --into city.citylod"));
        assert_eq!(run.code, Some(0), "{}", run.err);
        assert!(!run.err.contains("its base is"), "{}", run.err);
        let [on_a, on_b] = heights();
        assert!((on_a - a - 4.0).abs() < 1e-3, "{name}: {on_a}, not {a} + 4");
        assert!((on_b - b - 4.0).abs() < 1e-3, "{name}: {on_b}, not {b} + 4");
    }
}

/// One that says how high its ground is begins above that, and draped so far above the other; what
/// an attribute of other formats says of a lowest height is none of where a thing begins.
#[test]
fn draped_parts_are_kept_above_their_ground() {
    let desk = Desk::new();
    let part = r#""min_height":4,"height":12.3"#;
    let roof = footprint("roof", 1003.0, ",36").replace(r#""height":12.3"#, part);
    desk.write("roof.geojsonl", roof.as_bytes());
    let house = r#"{"asset":{"version":"2.0"},"nodes":[{"name":"house","mesh":0,"translation":[1047,36,-5],
        "extras":{"min_height":4}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{}}}}]}],
        "extensionsUsed":["KHR_draco_mesh_compression"],
        "accessors":[{"componentType":5126,"type":"VEC3","count":8,"min":[0,0,-8],"max":[8,9,0]}]}"#;
    desk.write("house.gltf", house.as_bytes());
    desk.out("import roof.geojsonl house.gltf -o city.citylod");
    let bases = || {
        let tree = LodTree::open_verified(&desk.path("city.citylod")).unwrap();
        ["roof", "house"].map(|id| tree.object(tree.find(id).unwrap()).unwrap().bounds.min().z)
    };
    assert_eq!(bases(), [40.0, 36.0]);
    for (name, top) in [("low.asc", 40.0), ("high.asc", 1600.0)] {
        desk.write(name, slope(top).as_bytes());
    }
    // Its ground is 36 m high, so the one that is laid is the right one for it.
    let run = desk.run("import low.asc --into city.citylod");
    assert!(!run.err.contains("roof: its base is"), "{}", run.err);
    for (name, top) in [("high.asc", 1600.0), ("low.asc", 40.0)] {
        let run = desk.run(&format!("import {name} --into city.citylod --drape"));
        assert_eq!(run.code, Some(0), "{}", run.err);
        assert!(!run.err.contains("its base is"), "{}", run.err);
        let [a, b, _] = expected(top);
        for (found, expected) in bases().into_iter().zip([a + 4.0, b]) {
            assert!(
                (found - expected).abs() < 1e-3,
                "{name}: {found}, not {expected}"
            );
        }
    }
}

/// Where it stood before it was draped is not kept.
#[test]
fn draped_objects_that_other_ground_does_not_reach_stay_and_are_named() {
    let desk = desk();
    desk.out("import high.asc --into city.citylod --drape");
    let draped = stands(&desk)[3].1;
    let west = slope(40.0).replace("xllcenter 1000", "xllcenter 950");
    desk.write("west.asc", west.as_bytes());
    let run = desk.run("import west.asc --into city.citylod --drape");
    assert_eq!(run.code, Some(0), "{}", run.err);
    let told = "1 have no ground under them and stay where they are; the ground reaches from 950 0 to 1060 30: known";
    assert!(run.err.contains(told), "{}", run.err);
    assert_eq!(stands(&desk)[3].1, draped);
}

#[test]
fn drape_sets_all_objects_on_the_ground() {
    let desk = desk();
    let run = desk.run("import high.asc --into city.citylod --drape");
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(run.err.contains("3 objects set on"), "{}", run.err);
    assert!(!run.err.contains("its base is"), "{}", run.err);
    let [a, b, beyond] = expected(1600.0);
    assert_stands(&desk, [a, b, beyond, height(1600.0, 1088.0, 5.0)]);
    desk.refuses("import city.geojsonl -o a.citylod --drape", 2, &["--drape"]);
    desk.refuses(
        "import high.asc --into city.citylod --promote largest",
        2,
        &["--promote"],
    );
}

/// What stands on the ground is found there: a view along it sees the houses.
#[test]
fn a_view_of_the_ground_sees_what_was_set_on_it() {
    let desk = desk();
    let seen = || {
        let look = "query city.citylod --eye 1050,-200,1595 --target 1050,0,1590 --fov 30";
        desk.out(look)
            .lines()
            .map(ToOwned::to_owned)
            .collect::<Vec<_>>()
    };
    assert!(seen().is_empty());
    desk.out("import high.asc --into city.citylod");
    let mut houses = seen();
    houses.sort();
    assert_eq!(houses, ["a", "b"]);
}

#[test]
fn a_city_that_is_refused_ground_is_left_as_it_was() {
    let desk = desk();
    let before = std::fs::read(desk.path("city.citylod")).unwrap();
    let far = slope(9.0).replace("xllcenter 1000", "xllcenter 90000");
    desk.write("far.asc", far.as_bytes());
    desk.refuses(
        "import far.asc --into city.citylod --drape",
        1,
        &["far.asc", "under nothing"],
    );
    std::fs::create_dir(desk.path("city.terrain")).unwrap();
    desk.refuses(
        "import high.asc --into city.citylod",
        1,
        &["city.terrain", "name a file"],
    );
    assert_eq!(std::fs::read(desk.path("city.citylod")).unwrap(), before);
}
