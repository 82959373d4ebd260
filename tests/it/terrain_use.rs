use std::fmt::Write as _;

use citylod::scene::Effects;
use citylod::terrain::HeightField;

use crate::desk::Desk;
use crate::land::{city, ridge};

/// A field as an ESRI ASCII grid, moved by so many metres.
fn ascii(field: &HeightField, moved: f64) -> String {
    let grid = field.grid();
    let at = grid.origin() + moved;
    let mut text = format!(
        "ncols {}\nnrows {}\nxllcenter {}\nyllcenter {}\ncellsize {}\n",
        grid.columns(),
        grid.rows(),
        at.x,
        at.y,
        grid.spacing().x
    );
    for row in (0..grid.rows()).rev() {
        for column in 0..grid.columns() {
            let _ = write!(text, "{} ", field.height(column, row));
        }
        text.push('\n');
    }
    text
}

/// A desk with houses and the elevation of a ridge.
fn desk() -> Desk {
    let desk = Desk::new();
    city(Effects::default())
        .save(&desk.path("city.citylod"))
        .unwrap();
    desk.write("ridge.asc", ascii(&ridge(), 0.0).as_bytes());
    desk
}

const LOOK: &str = "city.citylod --eye 0,-400,20 --target 0,0,30 --size 320x180 --far-dist inf";

#[test]
fn ground_that_was_laid_is_drawn_and_can_be_left_out() {
    let desk = desk();
    let bare = desk.json(&format!("query {LOOK} --json"));
    assert_eq!(bare["effects"], serde_json::json!({}));
    desk.out(&format!("render {LOOK} -o bare.png"));
    let run = desk.run("import ridge.asc --into city.citylod");
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(
        run.err.contains("city.citylod: declares terrain"),
        "{}",
        run.err
    );
    let laid = desk.json(&format!("query {LOOK} --json"));
    assert_eq!(
        laid["ids"], bare["ids"],
        "the ground hides nothing without occlusion"
    );
    assert_ne!(laid["revision"], bare["revision"]);
    let terrain = &laid["effects"]["terrain"];
    assert!(terrain["triangles"].as_u64() > Some(50), "{terrain}");
    assert!(terrain["error_px"].as_f64() <= Some(1.5), "{terrain}");
    assert!(terrain["list"].is_null());
    let listed = desk.json(&format!("query {LOOK} --json --patches"));
    let list = listed["effects"]["terrain"]["list"]
        .as_array()
        .unwrap()
        .len();
    assert_eq!(listed["effects"]["terrain"]["patches"], list);
    let said = desk.run(&format!("query {LOOK}")).err;
    assert!(
        said.contains("terrain draws") && said.contains("triangles"),
        "{said}"
    );
    desk.refuses(
        &format!("query {LOOK} --json --patches --without terrain"),
        2,
        &["--patches", "--without"],
    );
    desk.out(&format!("render {LOOK} -o laid.png"));
    desk.out(&format!("render {LOOK} -o left.png --without terrain"));
    let picture = |name: &str| std::fs::read(desk.path(name)).unwrap();
    assert_ne!(picture("laid.png"), picture("bare.png"));
    assert_eq!(picture("left.png"), picture("bare.png"));
    desk.write("house.obj", b"o a\nv 0 0 0\nv 4 0 0\nv 4 4 4\nf 1 2 3\n");
    desk.out("import house.obj -o plain.citylod");
    desk.refuses(
        "query plain.citylod --eye 0,-9,9 --target 0,0,0 --json --patches",
        1,
        &[
            "terrain",
            "--patches",
            "import ELEVATION --into plain.citylod",
        ],
    );
}

/// Where the ridge stands before the sky, the picture shows it.
#[test]
fn a_picture_shows_the_ridge() {
    let desk = desk();
    let pixel = |name: &str, row: usize| -> [u8; 3] {
        desk.out(&format!("render {LOOK} -o {name}"));
        let file = std::fs::File::open(desk.path(name)).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(file))
            .read_info()
            .unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        let at = (row * 320 + 40) * 3;
        bytes[at..at + 3].try_into().unwrap()
    };
    // The crest, 60 m high at 400 m, is 40 m above the eye: row 90 − 155.9 · tan of 4.3° is 78.
    // Beyond it, and above it, there is sky; the plane without ground ends at the horizon.
    let (before, above) = (pixel("bare.png", 82), pixel("bare.png", 60));
    desk.out("import ridge.asc --into city.citylod");
    assert_ne!(pixel("laid.png", 82), before, "the ridge is there");
    let [r, _, b] = pixel("laid.png", 60);
    assert!(b > r, "sky above it: {r} {b}");
    assert!(above[2] > above[0], "as before: {above:?}");
}

#[test]
fn ground_under_nothing_of_the_city_is_refused_and_replaces_nothing() {
    let desk = desk();
    desk.write("far.asc", ascii(&ridge(), 5_000.0).as_bytes());
    let refused = |expected: &[&str]| {
        desk.refuses("import far.asc --into city.citylod", 1, expected);
    };
    let city = std::fs::read(desk.path("city.citylod")).unwrap();
    refused(&["far.asc", "lies under nothing of the city", "4500 4500"]);
    assert!(!desk.path("city.terrain").exists());
    assert_eq!(std::fs::read(desk.path("city.citylod")).unwrap(), city);
    desk.out("import ridge.asc --into city.citylod");
    let files = || ["city.citylod", "city.terrain"].map(|f| std::fs::read(desk.path(f)).unwrap());
    let before = files();
    refused(&["lies under nothing of the city"]);
    assert_eq!(files(), before);
}

#[test]
fn ground_that_is_missing_damaged_or_anothers_is_an_error() {
    let desk = desk();
    desk.out("import ridge.asc --into city.citylod");
    let laid = std::fs::read(desk.path("city.terrain")).unwrap();
    let refused = |expected: &[&str]| {
        desk.refuses(&format!("query {LOOK}"), 1, expected);
        desk.refuses(&format!("render {LOOK} -o a.png"), 1, expected);
        desk.refuses("serve city.citylod --listen 127.0.0.1:0", 1, expected);
        // What a city holds can be told without its ground.
        let told = desk.out("info city.citylod");
        assert!(
            told.contains("ground     cannot be used: city.terrain"),
            "{told}"
        );
        let checked = desk.run("info city.citylod --check --json");
        assert_eq!(checked.code, Some(1), "{}", checked.err);
        let json: serde_json::Value = serde_json::from_str(&checked.out).unwrap();
        let problem = json["terrain_problem"].as_str().unwrap();
        for words in expected {
            assert!(told.contains(words) && problem.contains(words), "{told}");
            assert!(checked.err.contains(words), "{}", checked.err);
        }
        assert!(json["terrain"].is_null());
        let objects = desk.lines("info city.citylod --objects").len();
        assert_eq!(json["objects"], objects);
    };
    std::fs::remove_file(desk.path("city.terrain")).unwrap();
    refused(&["city.terrain: there is no such file", "--into city.citylod"]);
    desk.out(&format!("query {LOOK} --without terrain"));
    desk.write("city.terrain", b"");
    refused(&["city.terrain: is empty"]);
    #[cfg(unix)]
    {
        std::fs::remove_file(desk.path("city.terrain")).unwrap();
        let made = std::process::Command::new("mkfifo")
            .arg(desk.path("city.terrain"))
            .status();
        assert!(made.unwrap().success());
        refused(&["city.terrain", "save it to a file first"]);
        std::fs::remove_file(desk.path("city.terrain")).unwrap();
    }
    let mut damaged = laid.clone();
    let at = damaged.len() - 100;
    damaged[at] ^= 4;
    desk.write("city.terrain", &damaged);
    refused(&["city.terrain: section tiles", "import the elevation again"]);
    // The ground of another city, or of this one at another time.
    city(Effects::default())
        .save(&desk.path("other.citylod"))
        .unwrap();
    let mut higher = ridge().heights().to_vec();
    for height in &mut higher {
        *height += 1.0;
    }
    let higher = HeightField::new(*ridge().grid(), higher).unwrap();
    desk.write("higher.asc", ascii(&higher, 0.0).as_bytes());
    desk.out("import higher.asc --into other.citylod");
    std::fs::copy(desk.path("other.terrain"), desk.path("city.terrain")).unwrap();
    refused(&[
        "city.terrain: is not the ground that was laid under city.citylod",
        "lay it again",
    ]);
    desk.write("city.terrain", &laid);
    desk.out(&format!("query {LOOK}"));
}

/// Laying ground writes new checksums: what is damaged must not become valid by it.
#[test]
fn no_ground_is_laid_under_a_damaged_city() {
    let desk = desk();
    let mut damaged = std::fs::read(desk.path("city.citylod")).unwrap();
    let at = damaged.len() / 2;
    damaged[at] ^= 4;
    desk.write("city.citylod", &damaged);
    desk.refuses(
        "import ridge.asc --into city.citylod",
        1,
        &["city.citylod: section", "is damaged"],
    );
    assert_eq!(std::fs::read(desk.path("city.citylod")).unwrap(), damaged);
    assert!(!desk.path("city.terrain").exists());
}

#[test]
fn another_city_does_not_stand_on_the_ground_of_the_one_before() {
    let desk = desk();
    desk.out("import ridge.asc --into city.citylod");
    for over in [
        "generate --objects 50 -o city.citylod",
        "import house.obj -o city.citylod",
    ] {
        desk.write("house.obj", b"o a\nv 0 0 0\nv 4 0 0\nv 4 4 4\nf 1 2 3\n");
        let run = desk.run(over);
        assert_eq!(run.code, Some(0), "{}", run.err);
        for words in [
            "warning: city.terrain: was laid under what city.citylod was before",
            "--into",
        ] {
            assert!(run.err.contains(words), "{}", run.err);
        }
        let answer = desk.json(&format!("query {LOOK} --json"));
        assert_eq!(answer["effects"], serde_json::json!({}));
        assert!(desk.json("info city.citylod --json")["terrain"].is_null());
    }
    assert!(
        !desk
            .run("generate --objects 50 -o fresh.citylod")
            .err
            .contains("warning")
    );
}

#[test]
fn settings_are_declared_when_the_ground_is_laid() {
    let desk = desk();
    desk.write(
        "e.json",
        br#"{"terrain":{"max_error_px":30,"max_triangles":60},"occlusion":{}}"#,
    );
    desk.write(
        "house.obj",
        b"o a\nv 0 100 0\nv 4 100 0\nv 4 104 4\nf 1 2 3\n",
    );
    for make in ["import house.obj", "generate --objects 9"] {
        desk.refuses(
            &format!("{make} -o new.citylod --effects e.json"),
            1,
            &["e.json: declares terrain", "--into CITY --effects e.json"],
        );
        assert!(!desk.path("new.citylod").exists());
    }
    desk.out("import house.obj -o city.citylod");
    desk.out("import ridge.asc --into city.citylod --effects e.json");
    let effects = desk.json("info city.citylod --json")["effects"].clone();
    assert_eq!(effects["terrain"]["max_error_px"], 30.0);
    assert!(effects["terrain"]["ground"].is_u64() && effects["occlusion"].is_object());
    let terrain = desk.json(&format!("query {LOOK} --json"))["effects"]["terrain"].clone();
    assert!(terrain["triangles"].as_u64() <= Some(60), "{terrain}");
    // Laying it again keeps what is declared.
    desk.out("import ridge.asc --into city.citylod");
    assert_eq!(desk.json("info city.citylod --json")["effects"], effects);
}

/// Speed makes the ground coarser, haze ends it.
#[test]
fn motion_and_haze_take_from_the_ground_too() {
    let desk = desk();
    desk.write(
        "e.json",
        br#"{"terrain":{"max_error_px":1},"motion":{"reference_speed_mps":1},"haze":{"visibility_m":150}}"#,
    );
    desk.write(
        "house.obj",
        b"o a\nv 0 -350 0\nv 4 -350 0\nv 4 -346 4\nf 1 2 3\n",
    );
    desk.out("import house.obj -o city.citylod");
    desk.out("import ridge.asc --into city.citylod --effects e.json");
    let triangles = |flags: &str| {
        let answer = desk.json(&format!("query {LOOK} --json{flags}"));
        answer["effects"]["terrain"]["triangles"].as_u64().unwrap()
    };
    let (slow, clear) = (triangles(""), triangles(" --without haze"));
    assert!(slow < clear, "{slow} {clear}");
    let fast = triangles(" --without haze --speed 20");
    assert!(fast < clear, "{fast} {clear}");
}

/// Ground that is coarser than asked for may stand before what is seen: it hides nothing.
#[test]
fn ground_of_too_few_triangles_hides_nothing() {
    let desk = desk();
    let drawn = |most: u32| {
        let effects = format!(r#"{{"terrain":{{"max_triangles":{most}}},"occlusion":{{}}}}"#);
        desk.write("e.json", effects.as_bytes());
        desk.out("import ridge.asc --into city.citylod --effects e.json");
        let ids = |flags: &str| {
            let answer = desk.json(&format!("query {LOOK} --json{flags}"));
            answer["ids"].clone()
        };
        (ids(""), ids(" --without terrain"))
    };
    let (on, without) = drawn(100_000);
    assert!(on.as_array().unwrap().len() < without.as_array().unwrap().len());
    let (on, without) = drawn(40);
    assert_eq!(on, without);
    // The whole is one box around the eye.
    drawn(2);
    let terrain = desk.json(&format!("query {LOOK} --json"))["effects"]["terrain"].clone();
    assert!(terrain["error_px"].is_null(), "{terrain}");
    let said = desk.run(&format!("query {LOOK}")).err;
    assert!(
        said.contains("without a bound around the eye") && !said.contains("inf"),
        "{said}"
    );
}
