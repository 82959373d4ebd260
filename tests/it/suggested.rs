use crate::desk::Desk;
use crate::written;

/// What `info` says to try.
fn suggested(desk: &Desk, name: &str) -> String {
    let info = desk.out(&format!("info {name}"));
    let line = info.lines().find_map(|line| line.strip_prefix("try "));
    let words = line.unwrap().trim().strip_prefix("citylod ");
    words.unwrap().to_owned()
}

/// How many objects that shows.
fn tried(desk: &Desk, name: &str) -> usize {
    desk.out(&suggested(desk, name)).lines().count()
}

#[test]
fn the_query_that_info_suggests_shows_a_good_part_of_the_city() {
    let desk = Desk::new();
    for objects in [5_000, 23_951, 300_000] {
        desk.out(&format!("generate --objects {objects} -o city.citylod"));
        let count = tried(&desk, "city.citylod");
        assert!((500..=2_000).contains(&count), "{count} of {objects}");
    }
    for visibility_m in [40, 400, 3_000] {
        let haze = format!(r#"{{"haze":{{"visibility_m":{visibility_m}}}}}"#);
        desk.write("haze.json", haze.as_bytes());
        desk.out("generate --objects 23951 --effects haze.json -o hazy.citylod");
        let count = tried(&desk, "hazy.citylod");
        assert!(
            (1..=2_000).contains(&count),
            "{count} within {visibility_m} m"
        );
    }
    desk.out("generate --objects 60 -o small.citylod");
    assert!(tried(&desk, "small.citylod") >= 30);
    desk.out("generate --objects 1 -o one.citylod");
    assert_eq!(tried(&desk, "one.citylod"), 1);
    desk.out("generate --objects 0 -o none.citylod");
    assert!(!desk.out("info none.citylod").contains("try"));
}

/// Houses of so many metres about these places, as OBJ.
fn houses(places: impl Iterator<Item = [f64; 2]>, side: f64) -> String {
    let house = |(at, [x, y]): (usize, [f64; 2])| {
        let [far_x, far_y] = [x + side, y + side];
        let corners = format!("v {x} {y} 0\nv {far_x} {y} 0\nv {far_x} {far_y} {side}\n");
        format!("o o{at}\n{corners}f -3 -2 -1\n")
    };
    places.enumerate().map(house).collect()
}

#[test]
fn the_query_that_info_suggests_shows_something_of_tiny_and_sparse_cities() {
    let desk = Desk::new();
    let grid = |side: u32, apart: f64| {
        let at = (0..side * side).map(move |n| [n % side, n / side]);
        at.map(move |at| at.map(|n| f64::from(n) * apart))
    };
    let towns = |count: usize| {
        let towns = [[0.0, 0.0], [50e3, 100e3], [100e3, 50e3]]
            .into_iter()
            .cycle();
        let spread = grid(100, 20.0).zip(towns).take(count);
        spread.map(|([x, y], town)| [town[0] + x, town[1] + y])
    };
    let models = [
        (
            "a single cube of a decimetre",
            houses(grid(1, 1.0), 0.1),
            1,
            1,
        ),
        ("a table of models", houses(grid(5, 0.2), 0.1), 25, 25),
        ("a farm here and there", houses(grid(4, 30e3), 10.0), 2, 16),
        (
            "a house a hundred kilometres",
            houses(grid(7, 100e3), 10.0),
            5,
            49,
        ),
        (
            "many, a kilometre apart",
            houses(grid(60, 1e3), 10.0),
            500,
            2_000,
        ),
        (
            "many, a hundred kilometres apart",
            houses(grid(60, 100e3), 10.0),
            500,
            2_000,
        ),
        ("three towns of 500", houses(towns(1_500), 10.0), 500, 1_500),
        (
            "three towns of 2,000",
            houses(towns(6_000), 10.0),
            500,
            2_000,
        ),
    ];
    for (what, model, least, most) in models {
        desk.write("model.obj", model.as_bytes());
        desk.out("import model.obj -o model.citylod");
        let count = tried(&desk, "model.citylod");
        assert!((least..=most).contains(&count), "{what}: {count}");
    }
    // Small ones are seen from near by.
    for (side, apart) in [(1, 1.0), (5, 0.2)] {
        desk.write("model.obj", houses(grid(side, apart), 0.1).as_bytes());
        desk.out("import model.obj -o model.citylod");
        let large = format!("{} --max-error-px 50", suggested(&desk, "model.citylod"));
        assert_eq!(desk.out(&large).lines().count() as u32, side * side);
    }
}

#[test]
fn the_query_that_info_suggests_shows_a_good_part_of_real_cities() {
    let desk = Desk::new();
    for (file, least) in [
        ("geojson/tokyo-chiyoda-11581.geojson.gz", 500),
        ("cityjson/tokyo-minato-23951.city.json.gz", 500),
        ("cityjson/delft.json", 280),
        ("cityjson/vienna.city.jsonl", 70),
        ("cityjson/multi_lod.json", 5),
    ] {
        let Some(path) = written::real(file) else {
            return;
        };
        desk.out(&format!("import {} -o city.citylod", path.display()));
        let count = tried(&desk, "city.citylod");
        assert!((least..=2_000).contains(&count), "{file}: {count}");
    }
}

/// How many of the objects that it shows are at least so large on the screen.
fn large(desk: &Desk, name: &str, px: u32) -> usize {
    let words = suggested(desk, name);
    let camera = words.split(" --far-dist").next().unwrap();
    let query = format!("{camera} --max-error-px {px}");
    desk.out(&query).lines().count()
}

#[test]
fn the_query_that_info_suggests_looks_at_something_in_awkward_cities() {
    let desk = Desk::new();
    let row = |count: u32, apart: f64| (0..count).map(move |at| [f64::from(at) * apart, 0.0]);
    let town =
        |x: f64| (0..100).map(move |at| [x + 20.0 * f64::from(at % 10), 20.0 * f64::from(at / 10)]);
    let far_off = |x: f64| std::iter::once([x, x]);
    let flat = houses(town(0.0), 10.0).replace(" 10\nf", " 0\nf");
    let models = [
        ("one object", houses(row(1, 1.0), 10.0), 1),
        ("a short line", houses(row(30, 20.0), 10.0), 20),
        ("a long line", houses(row(300, 1e3), 10.0), 1),
        (
            "two towns 50 km apart",
            houses(town(0.0).chain(town(50e3)), 10.0),
            50,
        ),
        ("all flat", flat, 50),
        (
            "one 1,000 km off",
            houses(town(0.0).chain(far_off(1e6)), 10.0),
            50,
        ),
        (
            "two houses, one of them 1,000 km off",
            houses(row(1, 1.0).chain(far_off(1e6)), 10.0),
            1,
        ),
        (
            "one far off before three",
            houses(far_off(-1e6).chain(row(3, 20.0)), 10.0),
            1,
        ),
    ];
    for (what, model, least) in models {
        desk.write("model.obj", model.as_bytes());
        desk.out("import model.obj -o model.citylod");
        let (drawn, seen) = (
            tried(&desk, "model.citylod"),
            large(&desk, "model.citylod", 10),
        );
        let told = suggested(&desk, "model.citylod");
        assert!(drawn >= least, "{what}: {drawn} drawn by {told}");
        assert!(seen >= least, "{what}: {seen} seen by {told}");
    }
}

/// A park with three houses in it, and another, larger one beside it.
#[test]
fn the_query_that_info_suggests_looks_at_buildings_rather_than_at_land() {
    let desk = Desk::new();
    let square = |class: &str, [x, y]: [f64; 2], side: f64, height: f64| {
        // Far from 0, so that they cannot be degrees.
        let [x, y] = [x + 1_000.0, y + 1_000.0];
        let [east, north] = [x + side, y + side];
        format!(
            r#"{{"type":"Feature","properties":{{"height":{height},"class":"{class}"}},"geometry":{{"type":"Polygon","coordinates":[[[{x},{y},0],[{east},{y},0],[{east},{north},0],[{x},{north},0],[{x},{y},0]]]}}}}"#
        )
    };
    let house = |x: f64| square("Building", [x, 50.0], 10.0, 6.0);
    let land = |x| square("PlantCover", [x, 0.0], 3_000.0, 25.0);
    let features = [
        land(0.0),
        land(3_000.0),
        land(6_000.0),
        house(20.0),
        house(40.0),
        house(60.0),
    ];
    desk.write("city.geojsonl", features.join("\n").as_bytes());
    desk.out("import city.geojsonl -o city.citylod");
    let words = suggested(&desk, "city.citylod");
    let camera = words.split_once(" --eye ").unwrap().1;
    let target = camera.split_once(" --target ").unwrap().1;
    let target = target.split([',', ' ']).map(str::parse::<f64>).take(2);
    let target: Vec<f64> = target.map(Result::unwrap).collect();
    assert!((1_000.0..=1_100.0).contains(&target[0]), "{words}");
    assert!((1_000.0..=1_150.0).contains(&target[1]), "{words}");
    let pixels = format!("query city.citylod --eye {camera} --json");
    assert!(
        desk.json(&pixels)["count"].as_u64().unwrap() >= 3,
        "{words}"
    );
}

/// The eye is above ground that rises between it and the houses.
#[test]
fn the_query_that_info_suggests_stands_above_the_ground() {
    let desk = Desk::new();
    let houses = houses(
        (0..30).map(|at| [500.0 + 20.0 * f64::from(at), 900.0]),
        10.0,
    );
    desk.write("model.obj", houses.as_bytes());
    desk.out("import model.obj -o model.citylod");
    let eye = || {
        let words = suggested(&desk, "model.citylod");
        let eye = words
            .split_once("--eye ")
            .unwrap()
            .1
            .split(' ')
            .next()
            .unwrap();
        let eye: Vec<f64> = eye.split(',').map(|n| n.parse().unwrap()).collect();
        eye
    };
    let before = eye();
    // A ridge 500 m high along y = 400 to 500, and nothing known in the east.
    let mut ground =
        "ncols 21 nrows 21 xllcenter 0 yllcenter -500 cellsize 100 nodata_value -1\n".to_owned();
    for row in (0..21).rev() {
        let height = if (5..11).contains(&row) { 500 } else { 0 };
        let row = (0..21).map(|column| {
            if column > 15 {
                "-1".to_owned()
            } else {
                height.to_string()
            }
        });
        ground += &(row.collect::<Vec<_>>().join(" ") + "\n");
    }
    desk.write("ridge.asc", ground.as_bytes());
    desk.out("import ridge.asc --into model.citylod");
    let after = eye();
    assert_eq!(before[..2], after[..2]);
    assert!(
        before[2] < 500.0 && after[2] > 500.0,
        "{before:?}, {after:?}"
    );
    assert!(large(&desk, "model.citylod", 5) >= 20);
}

/// Footprints over a hole in the ground stand beside those over the ground, and are seen with them.
#[test]
fn the_query_that_info_suggests_shows_a_city_on_ground_with_holes() {
    let desk = Desk::new();
    let house = |at: u32| {
        let [x, y] = [at % 10, at / 10].map(|n| 1_000.0 + 20.0 * f64::from(n));
        let [east, north] = [x + 10.0, y + 10.0];
        format!(
            r#"{{"type":"Feature","properties":{{"height":9}},"geometry":{{"type":"Polygon","coordinates":[[[{x},{y}],[{east},{y}],[{east},{north}],[{x},{north}],[{x},{y}]]]}}}}"#
        )
    };
    let features: Vec<String> = (0..100).map(house).collect();
    desk.write("city.geojsonl", features.join("\n").as_bytes());
    desk.out("import city.geojsonl -o city.citylod");
    // Two in three houses stand where none is known.
    let mut ground =
        "ncols 41 nrows 41 xllcenter 900 yllcenter 900 cellsize 10 nodata_value -1\n".to_owned();
    for row in 0..41 {
        let row = (0..41).map(|column| {
            if column > 16 || row > 39 {
                "-1"
            } else {
                "2500"
            }
        });
        ground += &(row.collect::<Vec<_>>().join(" ") + "\n");
    }
    desk.write("holes.asc", ground.as_bytes());
    let run = desk.run("import holes.asc --into city.citylod");
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(
        run.err
            .contains("stand as high as the nearest ground that is known"),
        "{}",
        run.err
    );
    let bounds = desk.json("info city.citylod --json")["bounds"].clone();
    assert_eq!(
        [bounds[2].as_f64(), bounds[5].as_f64()],
        [Some(2500.0), Some(2509.0)]
    );
    assert!(large(&desk, "city.citylod", 10) >= 80);
}
