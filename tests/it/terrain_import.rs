use std::fmt::Write as _;

use crate::desk::Desk;

/// A cube from (x, 0, z) to (x + 4, 4, z + 4).
fn cube(name: &str, x: i32, z: i32) -> String {
    let mut text = format!("o {name}\n");
    for (dx, dy, dz) in [(0, 0, 0), (4, 0, 0), (4, 4, 4), (0, 4, 4)] {
        let _ = writeln!(text, "v {} {dy} {}", x + dx, z + dz);
    }
    text + "f -4 -3 -2\nf -4 -2 -1\n"
}

/// Posts 10 m apart from (−45, −45) on, rising 1 m a column.
fn slope() -> String {
    let row: Vec<String> = (0..12).map(|column| column.to_string()).collect();
    let head = "ncols 12\nnrows 10\nxllcenter -45\nyllcenter -45\ncellsize 10\n";
    head.to_owned() + &format!("{}\n", row.join(" ")).repeat(10)
}

fn city(desk: &Desk) {
    // The ground under x = 0 … 4 is 4.5 to 4.9 m high, under x = 20 … 24 6.5 to 6.9 m.
    let cubes = [
        ("stands", 0, 4),
        ("hovers", 0, 20),
        ("buried", 20, -9),
        ("far", 900, 0),
    ];
    let cubes: String = cubes.iter().map(|&(name, x, z)| cube(name, x, z)).collect();
    desk.write("c.obj", cubes.as_bytes());
    desk.out("import c.obj -o city.citylod");
}

#[test]
fn ground_lies_beside_its_city_and_is_told_of() {
    let desk = Desk::new();
    city(&desk);
    let before = desk.lines("info city.citylod --objects");
    assert!(desk.json("info city.citylod --json")["terrain"].is_null());
    assert!(!desk.out("info city.citylod").contains("ground"));
    desk.write("slope.asc", slope().as_bytes());
    let run = desk.run("import slope.asc --into city.citylod");
    assert_eq!(run.code, Some(0), "{}", run.err);
    for words in [
        "hovers: its base is 15.1 m above the ground",
        "buried: its base is 15.5 m below the ground",
        "of 4 objects, 1 stand more than 2 m above the ground under them and 1 more than that below",
        "1 have no ground under them and stay where they are; the ground reaches from -45 -45 to 65 45",
        "city.terrain: 12 x 10 posts 10 x 10 m apart, 0 to 11 m high",
    ] {
        assert!(run.err.contains(words), "{words:?} is not in {}", run.err);
    }
    assert!(!run.err.contains("stands:"), "{}", run.err);
    assert_eq!(desk.lines("info city.citylod --objects"), before);
    let told = desk.json("info city.citylod --check --json");
    assert_eq!(told["terrain"]["posts"], serde_json::json!([12, 10]));
    assert_eq!(told["terrain"]["heights_m"], serde_json::json!([0.0, 11.0]));
    assert!(
        desk.out("info city.citylod")
            .contains("ground     12 x 10 posts")
    );
    let run = desk.run("import slope.asc --into city.citylod --warnings 1");
    assert_eq!(run.err.matches(": its base is").count(), 1, "{}", run.err);
    assert!(run.err.contains("1 more object"), "{}", run.err);
}

#[test]
fn what_is_typed_of_elevation_changes_it() {
    let desk = Desk::new();
    city(&desk);
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 2, 2);
    encoder.set_color(png::ColorType::Rgb);
    // As terrain-rgb 206 km, as terrarium 24 km under the sea: neither is told by its reds.
    let pixels = [33, 0, 0].repeat(4);
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&pixels)
        .unwrap();
    desk.write("sea.png", &png);
    let heights = |options: &str| {
        desk.out(&format!(
            "import sea.png --into city.citylod --bounds -50,-50,50,50{options}"
        ));
        desk.json("info city.citylod --json")["terrain"].clone()
    };
    let rgb = " --encoding terrain-rgb";
    let origin = heights(rgb)["origin_m"].clone();
    assert_eq!(origin, serde_json::json!([-25.0, -25.0]));
    for (encoding, expected) in [("terrain-rgb", 206_268.8), ("terrarium", -24_320.0)] {
        let low = heights(&format!(" --encoding {encoding}"))["heights_m"][0].as_f64();
        assert!(
            (low.unwrap() - expected).abs() < 0.02,
            "{encoding}: {low:?}"
        );
    }
    assert!(heights(rgb)["crs"].is_null());
    assert_eq!(
        heights(&format!("{rgb} --crs EPSG:6677"))["crs"],
        "EPSG:6677"
    );
    desk.refuses(
        "import sea.png --into city.citylod --bounds -50,-50,50,50",
        1,
        &["sea.png", "--encoding"],
    );
    desk.refuses(
        "import sea.png --into city.citylod --encoding terrain-rgb",
        1,
        &["sea.png", "--bounds"],
    );
}

#[test]
fn ground_that_cannot_be_is_refused_and_the_old_kept() {
    let desk = Desk::new();
    city(&desk);
    desk.write("slope.asc", slope().as_bytes());
    desk.out("import slope.asc --into city.citylod");
    let before = std::fs::read(desk.path("city.terrain")).unwrap();
    desk.write("cut.asc", &slope().as_bytes()[..300]);
    desk.write(
        "line.asc",
        b"ncols 2 nrows 1 xllcorner -3 yllcorner -4 cellsize 10 1 2",
    );
    for (words, code, expected) in [
        (
            "import cut.asc --into city.citylod",
            1,
            &["cut.asc", "line", "heights"][..],
        ),
        ("import line.asc --into city.citylod", 1, &["2 x 1 posts"]),
        (
            "import c.obj --into city.citylod",
            1,
            &["c.obj", "not an elevation format"],
        ),
        (
            "import none.asc --into city.citylod",
            1,
            &["none.asc", "cannot read"],
        ),
        ("import slope.asc --into none.citylod", 1, &["none.citylod"]),
        (
            "import slope.asc slope.asc --into city.citylod",
            1,
            &["one elevation file"],
        ),
        ("import slope.asc", 2, &["--output"]),
        (
            "import slope.asc --into city.citylod -o a.citylod",
            2,
            &["cannot be used with"],
        ),
        (
            "import c.obj -o a.citylod --bounds 1,2,3,4",
            2,
            &["cannot be used with"],
        ),
        (
            "import slope.asc --into city.citylod --bounds 1,2,3",
            2,
            &["west,south,east,north"],
        ),
    ] {
        desk.refuses(words, code, expected);
    }
    assert_eq!(std::fs::read(desk.path("city.terrain")).unwrap(), before);
    let mut damaged = before;
    let last = damaged.len() - 70;
    damaged[last] ^= 1;
    desk.write("city.terrain", &damaged);
    let run = desk.run("info city.citylod --check");
    assert_eq!(run.code, Some(1));
    assert!(run.err.contains("section tiles"), "{}", run.err);
    assert!(run.err.contains("the city itself is sound"), "{}", run.err);
    assert!(!run.err.contains("checked"), "{}", run.err);
}

/// Whatever is said of their system: degrees are no metres.
#[test]
fn degrees_that_are_said_to_be_metres_are_refused_with_the_way_out() {
    let desk = Desk::new();
    city(&desk);
    let degrees = slope()
        .replace("-45", "11.5")
        .replace("cellsize 10", "cellsize 0.0008");
    desk.write("d.asc", degrees.as_bytes());
    desk.refuses(
        "import d.asc --into city.citylod --crs EPSG:25832",
        1,
        &[
            "d.asc: has coordinates that are degrees or look like it (11.5000 11.5000 to 11.5088 11.5072)",
            "EPSG:25832, which is in metres",
            "EPSG:4326",
        ],
    );
    assert!(!desk.path("city.terrain").exists());
}

/// A file of a few kilobytes that declares hundreds of megabytes, or unpacks to them, is refused
/// within 300 MB of address space, the program's own included; what goes on after the last height
/// is not unpacked.
#[cfg(target_os = "linux")]
#[test]
fn hostile_rasters_are_refused_within_bounded_memory() {
    let desk = Desk::new();
    // Where the small raster lies that is no bomb.
    desk.write(
        "h.obj",
        b"o a\nv 508 887 0\nv 520 887 0\nv 520 893 4\nf 1 2 3\n",
    );
    desk.out("import h.obj -o city.citylod");
    let asc = slope()
        .replace("ncols 12", "ncols 16000")
        .replace("nrows 10", "nrows 16000");
    desk.write("bomb.asc", asc.as_bytes());
    // A small picture that says it is a large one.
    let mut png = crate::elevation_files::picture(2, 1, &[1; 6]);
    for side in [16, 20] {
        png[side..side + 4].copy_from_slice(&16_000_u32.to_be_bytes());
    }
    let sum = crc32fast::hash(&png[12..29]);
    png[29..33].copy_from_slice(&sum.to_be_bytes());
    desk.write("bomb.png", &png);
    desk.write("bomb.tif", &crate::elevation_files::empty_tiff(16_000));
    desk.write("deflate.tif", &crate::elevation_files::deflate_bomb());
    desk.write("endless.tif", &crate::elevation_files::endless_strip());
    for (name, code, says) in [
        ("bomb.asc", 1, "room for"),
        ("bomb.png", 1, "do not fit"),
        ("bomb.tif", 1, "do not fit"),
        ("deflate.tif", 1, "bytes of memory"),
        ("endless.tif", 0, "city.terrain"),
    ] {
        let script = format!(
            "ulimit -v 300000; exec {} import {name} --into city.citylod --bounds 0,0,1,1",
            env!("CARGO_BIN_EXE_citylod")
        );
        let output = std::process::Command::new("sh")
            .args(["-c", &script])
            .current_dir(desk.path(""))
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{name}: {said}");
        assert!(
            (code == 0 || said.contains(name)) && said.contains(says),
            "{name}: {said}"
        );
    }
}
