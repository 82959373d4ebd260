use std::path::Path;
use std::process::{Command, Stdio};

use citylod::index::LodTree;

use crate::desk::Desk;
use crate::written::fixture;

const POSE: &str = "--eye 0,-900,260 --target 0,200,20";

fn city(desk: &Desk) {
    desk.out("generate --objects 3000 -o city.citylod");
}

#[test]
fn numbers_out_of_bounds_are_refused_by_name() {
    let desk = Desk::new();
    city(&desk);
    for (option, values) in [
        ("--fov", "nan inf 0 -1 180 1e-300 x"),
        ("--size", "0x0 5 1x99999999999"),
        ("--far-dist", "nan -1 x"),
        ("--dist-factor", "nan inf 0 -1 0.99"),
        ("--levels", "nan 0 -1 99999999999"),
        ("--max-error-px", "nan inf -1"),
        ("--max-objects", "nan -1 1.5 4294967296"),
        ("--speed", "nan inf -1"),
        ("--repeat", "nan 0 -1 99999999999"),
    ] {
        for value in values.split(' ') {
            let words = format!("query city.citylod {POSE} {option} {value}");
            desk.refuses(&words, 2, &[option]);
        }
    }
    for (option, values) in [
        ("--eye", "nan,0,0 0,inf,0 0,0,-inf 1e308,0,0 1e12,0,0 1,2"),
        ("--target", "nan,0,0 1e308,0,0"),
    ] {
        for value in values.split(' ') {
            let pose = match option {
                "--eye" => format!("--eye {value} --target 0,0,0"),
                _ => format!("--eye 0,0,9 --target {value}"),
            };
            desk.refuses(&format!("query city.citylod {pose}"), 2, &[option]);
        }
    }
    for (words, option, values) in [
        (
            "generate -o a.citylod",
            "--objects",
            "nan -1 1.5 4294967295",
        ),
        ("generate -o a.citylod", "--seed", "nan -1 1.5 1e99"),
        ("import a.obj -o a.citylod", "--warnings", "nan -1 1.5"),
        (
            "import a.asc --into a.citylod",
            "--crs",
            "foo EPSG: :1 EPSG:25832:1",
        ),
        (
            "import a.asc --into a.citylod",
            "--bounds",
            "nan 1,2,3 1,2,3,x",
        ),
        ("experiment far-dist", "--largest", "nan 0 -1 999 1e9"),
        ("serve", "--max-body-bytes", "nan 0 -1 18446744073709551615"),
        ("serve", "--timeout-ms", "nan 0 -1 18446744073709551615"),
        (
            "serve",
            "--max-concurrency",
            "nan 0 -1 18446744073709551615",
        ),
        (
            "serve",
            "--max-connections",
            "nan 0 -1 18446744073709551615",
        ),
        ("serve", "--max-streams", "nan 0 -1 18446744073709551615"),
        ("serve", "--max-answer-objects", "nan 0 -1 4294967296"),
        (
            "serve",
            "--max-occlusion-ms",
            "nan 0 -1 18446744073709551615",
        ),
        ("serve", "--stream-idle-ms", "nan 0 -1 18446744073709551615"),
        ("serve", "--listen", "nan 127.0.0.1:99999 -1"),
    ] {
        for value in values.split(' ') {
            desk.refuses(&format!("{words} {option} {value}"), 2, &[option]);
        }
    }
}

#[test]
fn extreme_numbers_are_told_in_few_digits() {
    let desk = Desk::new();
    city(&desk);
    for options in [
        "--fov 0.001",
        "--max-error-px 1e308",
        "--far-dist 1e308",
        "--dist-factor 1e308",
        "--levels 4294967295",
        "--max-objects 4294967295",
    ] {
        let run = desk.run(&format!("query city.citylod {POSE} {options}"));
        assert_eq!(run.code, Some(0), "{options}: {}", run.err);
        assert!(run.err.len() < 200, "{options}: {}", run.err);
    }
    // Stands in a building, and is to draw nothing.
    let tree = LodTree::open(&desk.path("city.citylod")).unwrap();
    let middle = tree.bounds_of(0).unwrap().center();
    let inside = format!(
        "--eye {},{},{} --target 0,0,999",
        middle.x, middle.y, middle.z
    );
    let run = desk.run(&format!("query city.citylod {inside} --max-objects 0"));
    assert!(run.err.contains("around the eye"), "{}", run.err);
}

#[test]
fn files_that_cannot_be_used_are_named_with_the_way_out() {
    let desk = Desk::new();
    city(&desk);
    desk.write("ok.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    desk.write("empty.json", b" ");
    desk.write("empty.citylod", b"");
    for folder in ["dir.citylod", "dir.obj", "dir.json", "dir.png", "dir.glb"] {
        std::fs::create_dir(desk.path(folder)).unwrap();
    }
    for (words, said) in [
        (
            "import none.obj -o a.citylod",
            ["none.obj: cannot read", "no such file"],
        ),
        (
            "import dir.obj -o a.citylod",
            ["dir.obj: cannot read", "name a file"],
        ),
        (
            "import ok.obj -o no/a.citylod",
            ["no/a.citylod: cannot write", "no such folder"],
        ),
        (
            "import ok.obj -o ok.obj/a.citylod",
            ["ok.obj/a.citylod: cannot write", "not a folder"],
        ),
        (
            "import ok.obj -o dir.citylod",
            ["dir.citylod: cannot write", "name a file"],
        ),
        (
            "import ok.obj -o a.citylod --effects none.json",
            ["none.json: cannot read", "no such"],
        ),
        (
            "import ok.obj -o a.citylod --effects dir.json",
            ["dir.json: cannot read", "name a file"],
        ),
        (
            "import ok.obj -o a.citylod --effects empty.json",
            ["empty.json: is empty", "haze"],
        ),
        (
            "import city.citylod -o a.citylod",
            ["city.citylod: is a city already", "citylod info"],
        ),
        (
            "generate --objects 9 -o no/a.glb",
            ["no/a.glb: cannot write", "no such folder"],
        ),
        (
            "generate --objects 9 -o dir.glb",
            ["dir.glb: cannot write", "name a file"],
        ),
        (
            "info dir.citylod",
            ["dir.citylod: cannot open", "name a file"],
        ),
        (
            "info none.citylod",
            ["none.citylod: cannot open", "no such file"],
        ),
        ("info empty.citylod", ["empty.citylod: header", "is empty"]),
        ("info ok.obj", ["ok.obj: header", "citylod import"]),
        (
            "serve dir.citylod",
            ["dir.citylod: cannot open", "name a file"],
        ),
        (
            "experiment far-dist --largest 1000 --city dir.obj",
            ["dir.obj: cannot read", "name a"],
        ),
        (
            "experiment far-dist --largest 1000 --out ok.obj/a",
            ["ok.obj/a: cannot write", "not a"],
        ),
    ] {
        desk.refuses(words, 1, &said);
        assert!(!desk.path("a.citylod").exists(), "{words}");
    }
    let picture = format!("render city.citylod {POSE} --size 64x36 -o");
    desk.refuses(
        &format!("{picture} no/a.png"),
        1,
        &["no/a.png: cannot write", "no such folder"],
    );
    desk.refuses(
        &format!("{picture} dir.png"),
        1,
        &["dir.png: cannot write", "name a file"],
    );
}

#[test]
fn what_goes_elsewhere_is_told_where() {
    let desk = Desk::new();
    city(&desk);
    desk.write("a.asc", b"ncols 2");
    desk.refuses(
        "import a.asc -o a.citylod",
        1,
        &["a.asc", "elevation", "--into"],
    );
    desk.refuses(
        "import a.obj --into city.citylod",
        1,
        &["a.obj", "elevation", "-o"],
    );
    desk.refuses(
        "experiment scaling --city city.citylod",
        2,
        &["--city", "scaling", "far-dist, views, accuracy, culling"],
    );
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    desk.refuses(
        &format!("serve city.citylod --listen {port}"),
        1,
        &[
            &format!("127.0.0.1:{port}"),
            "another program",
            "--listen 0",
        ],
    );
    // TEST-NET-1 of RFC 5737, which no machine has.
    desk.refuses(
        "serve city.citylod --listen 192.0.2.1:8080",
        1,
        &["192.0.2.1:8080", "no address of this machine"],
    );
}

/// They cannot be read twice, nor mapped.
#[cfg(unix)]
#[test]
fn pipes_are_refused_and_not_waited_for() {
    let desk = Desk::new();
    for name in ["pipe.geojson", "pipe.citylod"] {
        let made = Command::new("mkfifo").arg(desk.path(name)).status();
        assert!(made.unwrap().success());
    }
    let way_out = "save it to a file first";
    desk.refuses(
        "import pipe.geojson -o a.citylod",
        1,
        &["pipe.geojson", way_out],
    );
    desk.refuses("info pipe.citylod", 1, &["pipe.citylod", way_out]);
    let mut fed = desk.command();
    fed.args(["import", "/dev/stdin", "-o", "a.citylod"]);
    let mut fed = fed
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(fed.stdin.take());
    let output = fed.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("/dev/stdin") && said.contains(way_out),
        "{said}"
    );
}

/// As `citylod … 2>&1 | head -1` does, or a log that is closed.
#[test]
fn nobody_has_to_listen() {
    let desk = Desk::new();
    city(&desk);
    let solid = fixture("cityjson/levels.city.json");
    let deaf = |words: &str, code: i32| {
        let mut child = desk
            .command()
            .args(words.split(' ').map(|word| match word {
                "SOLID" => solid.as_path(),
                word => Path::new(word),
            }))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        drop(child.stderr.take());
        assert_eq!(child.wait().unwrap().code(), Some(code), "{words}");
    };
    deaf("import SOLID SOLID -o two.citylod --lod 1.2", 0);
    deaf("generate --objects 100 -o made.citylod", 0);
    deaf(
        &format!("render city.citylod {POSE} --size 64x36 --tint level -o view.png"),
        0,
    );
    for made in ["two.citylod", "made.citylod", "view.png"] {
        assert!(desk.path(made).exists(), "{made}");
    }
    deaf(&format!("query city.citylod {POSE}"), 0);
    deaf(&format!("query city.citylod {POSE} --json"), 0);
    deaf("info city.citylod", 0);
    deaf("info city.citylod --check --nodes", 0);
    deaf("experiment far-dist --largest 1000 --out out", 0);
    assert!(desk.path("out/far-dist.json").exists());
    deaf("info none.citylod", 1);
    deaf("import none.obj -o two.citylod", 1);
    deaf("query --help", 0);
    deaf("query", 2);
}

/// As over HTTP: see `service::effects`.
#[test]
fn effects_that_are_not_declared_may_be_switched_off_and_not_asked_for() {
    let desk = Desk::new();
    city(&desk);
    let plain = desk.out(&format!("query city.citylod {POSE}"));
    let off = "--without haze --without motion --without occlusion";
    assert_eq!(desk.out(&format!("query city.citylod {POSE} {off}")), plain);
    let query = format!("query city.citylod {POSE}");
    desk.refuses(
        &format!("{query} --speed 3"),
        1,
        &["city.citylod", "motion", "--speed"],
    );
    desk.refuses(
        &format!("{query} --json --visible-pixels"),
        1,
        &["city.citylod", "occlusion", "--visible-pixels"],
    );
    desk.write(
        "all.json",
        br#"{"motion":{},"occlusion":{},"haze":{"visibility_m":600}}"#,
    );
    desk.out("generate --objects 3000 --effects all.json -o weather.citylod");
    let query = format!("query weather.citylod {POSE}");
    assert_eq!(desk.out(&format!("{query} {off}")), plain);
    assert_ne!(desk.out(&query), plain);
    desk.refuses(
        &format!("{query} --speed 3 --without motion"),
        2,
        &["--speed", "--without"],
    );
    desk.refuses(
        &format!("{query} --json --visible-pixels --without occlusion"),
        2,
        &["--visible-pixels", "--without"],
    );
}
