use std::path::Path;
use std::time::Duration;

use citylod::index::{self, LodTree, Promotion};
use citylod::scene::{CityParams, generate};
use citylod::service::{Config, Scenes, serve};
use serde_json::Value;

use crate::desk::Desk;
use crate::served::Served;

fn city(seed: u64) -> LodTree {
    let scene = generate(&CityParams {
        objects: 1_000,
        seed,
    });
    index::build(&scene, Promotion::Tallest).unwrap()
}

fn revision(served: &Served) -> String {
    let answer = served.get("/collections/town");
    let (_, body) = answer.split_once("\r\n\r\n").unwrap();
    let document: Value = serde_json::from_str(body).unwrap();
    document["revision"].as_str().unwrap().to_owned()
}

fn words(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
#[cfg(unix)]
fn a_hangup_serves_the_files_as_they_are_now_and_keeps_the_old_where_they_cannot_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("town.citylod");
    city(1).save(&path).unwrap();
    let served = Served::start(&[words(&path)]);
    assert_eq!(revision(&served), city(1).revision());
    city(2).save(&path).unwrap();
    assert_eq!(revision(&served), city(1).revision(), "not by itself");
    served.signal("-HUP");
    let line = served.line_with("scenes were read again");
    assert!(line.contains("changed=1"), "{line}");
    assert_eq!(revision(&served), city(2).revision());
    // A new file takes the place of the old one, which is mapped: it must not be written into.
    let broken = folder.path().join("broken");
    std::fs::write(&broken, b"no city").unwrap();
    std::fs::rename(&broken, &path).unwrap();
    served.signal("-HUP");
    let line = served.line_with("could not be read again");
    assert!(line.contains("town.citylod"), "{line}");
    assert_eq!(revision(&served), city(2).revision());
    std::fs::rename(&path, &broken).unwrap();
    served.signal("-HUP");
    let line = served.line_with("could not be read again");
    assert!(line.contains("there is no such file"), "{line}");
    assert!(!line.contains("os error"), "{line}");
    let metrics = served.get("/metrics");
    for line in [
        "citylod_scene_reloads_total{result=\"ok\"} 1\n",
        "citylod_scene_reloads_total{result=\"failed\"} 2\n",
    ] {
        assert!(metrics.contains(line), "{metrics}");
    }
}

#[test]
#[cfg(unix)]
fn a_service_killed_under_load_starts_again_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("town.citylod");
    city(3).save(&path).unwrap();
    let mut served = Served::start(&[words(&path)]);
    for _ in 0..3 {
        let address = served.address;
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(move || {
                    use std::io::{Read, Write};
                    let request = "GET /collections/town/visible?eye=0,-500,100&target=0,0,0 \
                                   HTTP/1.1\r\nhost: x\r\n\r\n";
                    let mut stream = std::net::TcpStream::connect(address).unwrap();
                    let mut buffer = [0; 4096];
                    while stream.write_all(request.as_bytes()).is_ok()
                        && matches!(stream.read(&mut buffer), Ok(1..))
                    {}
                });
            }
            std::thread::sleep(Duration::from_millis(100));
            served.signal("-KILL");
        });
        served.wait();
        served = Served::start_at(&address.to_string(), &[words(&path)]);
        assert_eq!(served.address, address);
        assert_eq!(revision(&served), city(3).revision());
    }
    served.signal("-TERM");
    assert_eq!(served.wait(), Some(0));
}

#[test]
fn the_log_is_one_json_object_a_line_with_the_name_of_the_request() {
    let served = Served::start(&["--log-format", "json"]);
    served.send(
        "GET /nowhere HTTP/1.1\r\nhost: x\r\nx-request-id: who-42\r\nconnection: close\r\n\r\n",
    );
    let line: Value = serde_json::from_str(&served.line_with("who-42")).unwrap();
    for (member, value) in [
        ("level", "INFO".into()),
        ("message", "request refused".into()),
        ("request_id", "who-42".into()),
        ("method", "GET".into()),
        ("path", "/nowhere".into()),
        ("status", Value::from(404)),
        (
            "reason",
            r#"there is nothing at "/nowhere": GET / lists what there is"#.into(),
        ),
    ] {
        assert_eq!(line[member], value, "{line}");
    }
    assert!(
        line["took_us"].is_u64() && line["timestamp"].is_string(),
        "{line}"
    );
}

/// Where it is set, the test below is the service that it tests, in a process of its own.
#[cfg(unix)]
const SERVES: &str = "CITYLOD_TEST_SERVES";

#[test]
#[cfg(unix)]
fn told_to_stop_it_does_not_wait_for_files_that_are_being_read_again() {
    if std::env::var_os(SERVES).is_some() {
        return serve_and_read_again_for_ever();
    }
    let this = "serve_again::told_to_stop_it_does_not_wait_for_files_that_are_being_read_again";
    let mut service = std::process::Command::new(std::env::current_exe().unwrap());
    service.args(["--exact", this, "--nocapture"]);
    let mut served = Served::run(service.env(SERVES, "1"));
    served.signal("-HUP");
    served.line_with("reading for ever");
    served.signal("-TERM");
    assert_eq!(served.wait_for(Duration::from_secs(20)), Some(0));
}

/// As a program of someone who uses the library has it.
#[cfg(unix)]
fn serve_and_read_again_for_ever() {
    let config = Config {
        listen: ([127, 0, 0, 1], 0).into(),
        ..Config::default()
    };
    let mut scenes = Scenes::new();
    scenes.insert("town", city(1)).unwrap();
    let reread = || {
        eprintln!("reading for ever");
        loop {
            std::thread::park();
        }
    };
    tokio::runtime::Runtime::new()
        .unwrap()
        .block_on(serve(config, scenes, reread, |text| eprint!("{text}")))
        .unwrap();
}

#[test]
#[cfg(unix)]
fn a_file_that_is_written_into_while_it_is_served_is_named_in_the_log() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("town.citylod");
    city(1).save(&path).unwrap();
    let served = Served::start(&[words(&path)]);
    // Saved anew is as it should be.
    city(2).save(&path).unwrap();
    served.signal("-HUP");
    served.line_with("changed=1");
    let bytes = std::fs::read(&path).unwrap();
    let mut file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    file.write_all(&bytes).unwrap();
    drop(file);
    let line = served.line_with("ERROR");
    assert!(line.contains("written into"), "{line}");
    assert!(line.contains("scene=\"town\""), "{line}");
    // What is mapped now is not kept, although the bytes are the same.
    served.signal("-HUP");
    served.line_with("changed=1");
}

/// Heights whose bytes are ASCII, as answers are read as text here.
#[cfg(unix)]
const LOW_M: u32 = 2;
#[cfg(unix)]
const HIGH_M: u32 = 32;

/// Lays level ground of this height under `town.citylod`.
#[cfg(unix)]
fn lay(desk: &Desk, height: u32) {
    let head = "ncols 40 nrows 40 xllcenter -1950 yllcenter -1950 cellsize 100";
    let heights = format!("{height} ").repeat(40 * 40);
    desk.write("level.asc", format!("{head}\n{heights}\n").as_bytes());
    desk.out("import level.asc --into town.citylod");
}

/// As a client that keeps tiles asks for one.
#[test]
#[cfg(unix)]
fn a_tile_of_the_ground_that_a_client_keeps_is_good_until_the_ground_is_another() {
    let desk = Desk::new();
    desk.out("generate --objects 500 -o town.citylod");
    lay(&desk, LOW_M);
    let served = Served::start(&[words(&desk.path("town.citylod"))]);
    let tile = |query: &str, tag: &str| {
        served.send(&format!(
            "GET /collections/town/ground/0/0/0{query} HTTP/1.1\r\nhost: x\r\n\
             if-none-match: {tag}\r\nconnection: close\r\n\r\n"
        ))
    };
    let tag = |answer: &str| {
        let line = answer.lines().find(|line| line.starts_with("etag: "));
        line.unwrap()["etag: ".len()..].to_owned()
    };
    let status = |answer: &str| answer.split(' ').nth(1).unwrap().to_owned();
    let reread = |changed: u32| {
        served.signal("-HUP");
        let line = served.line_with("scenes were read again");
        assert!(line.contains(&format!("changed={changed}")), "{line}");
    };
    let first = tile("", "\"none\"");
    assert_eq!(status(&first), "200");
    let (old_tag, old_revision) = (tag(&first), revision(&served));
    assert_eq!(status(&tile("", &old_tag)), "304");
    // Laid again as it was.
    lay(&desk, LOW_M);
    reread(0);
    assert_eq!(status(&tile("", &old_tag)), "304");
    lay(&desk, HIGH_M);
    assert_eq!(status(&tile("", &old_tag)), "304", "not by itself");
    reread(1);
    let second = tile("", &old_tag);
    assert_eq!(status(&second), "200");
    assert_ne!(tag(&second), old_tag);
    assert_eq!(status(&tile("", &tag(&second))), "304");
    // An address that names the old revision is not answered with the new ground.
    let stale = tile(&format!("?revision={old_revision}"), &old_tag);
    assert_eq!(status(&stale), "409", "{stale}");
    assert_eq!(
        status(&tile(
            &format!("?revision={}", revision(&served)),
            "\"none\""
        )),
        "200"
    );
}
