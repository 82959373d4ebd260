use std::io::{Read, Write};
use std::net::TcpStream;

use citylod::index::{self, Promotion};
use citylod::scene::{CityParams, generate};
use serde_json::json;
use tokio_tungstenite::tungstenite::{Message, client};

use crate::desk::Desk;
use crate::served::Served;

const BODY: &str = r#"{"camera":{"eye":[0,-800,250],"target":[0,0,30]}}"#;

/// Status of one answer of a demo city served with these flags.
fn status(flags: &[&str]) -> String {
    let answer = Served::start(flags).send(&format!(
        "POST /collections/demo/visible HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\
         content-type: application/json\r\ncontent-length: {}\r\n\r\n{BODY}",
        BODY.len()
    ));
    answer.split(' ').nth(1).unwrap_or_default().to_owned()
}

const UPGRADE: &str = "GET /collections/demo/stream HTTP/1.1\r\nhost: x\r\n\
    connection: upgrade\r\nupgrade: websocket\r\nsec-websocket-version: 13\r\n\
    sec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";

#[test]
fn limits_on_the_command_line_hold() {
    assert_eq!(status(&[]), "200");
    assert_eq!(status(&["--max-answer-objects", "10"]), "413");
    assert_eq!(status(&["--max-body-bytes", "10"]), "413");
}

#[test]
fn limits_of_streams_on_the_command_line_hold() {
    let served = Served::start(&[
        "--max-streams",
        "1",
        "--stream-idle-ms",
        "1500",
        "--timeout-ms",
        "2000",
    ]);
    let mut stream = TcpStream::connect(served.address).unwrap();
    stream.write_all(UPGRADE.as_bytes()).unwrap();
    let mut first = vec![0; 1];
    stream.read_exact(&mut first).unwrap();
    // The only place is taken.
    let second = served.send(UPGRADE);
    assert!(second.starts_with("HTTP/1.1 503 "), "{second}");
    // Nothing is said, so the service ends it: a close frame (0x88) with 1008 (0x03f0).
    let _ = stream.read_to_end(&mut first);
    assert!(first.starts_with(b"HTTP/1.1 101 "));
    let end = memchr::memmem::find(&first, b"\r\n\r\n").unwrap() + 4;
    assert_eq!(first[end], 0x88);
    assert_eq!(first[end + 2..end + 4], [0x03, 0xf0]);
    assert!(String::from_utf8_lossy(&first[end + 4..]).contains("no message for 1.5 s"));
}

#[test]
fn a_port_alone_listens_on_this_machine_and_what_is_no_address_is_explained() {
    for listen in ["0", "localhost:0"] {
        let served = Served::start_at(listen, &[]);
        assert!(served.address.ip().is_loopback());
        assert!(served.get("/health").starts_with("HTTP/1.1 200 "));
    }
    for listen in ["here", "127.0.0.1", "65536"] {
        let words = format!("serve --listen {listen}");
        Desk::new().refuses(&words, 2, &["--listen", "127.0.0.1:8080", "or a port"]);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn frames_of_many_streams_that_take_long_take_few_threads() {
    const STREAMS: usize = 48;
    let desk = Desk::new();
    let path = desk.path("town.citylod");
    let mut scene = generate(&CityParams {
        objects: 4_000,
        seed: 1,
    });
    scene.effects = serde_json::from_value(json!({
        "occlusion": {"width_px": 1024, "min_pixels": 1}
    }))
    .unwrap();
    let tree = index::build(&scene, Promotion::Tallest).unwrap();
    tree.save(&path).unwrap();
    let served = Served::start(&[path.to_str().unwrap()]);
    let before = served.threads();
    let url = format!("ws://{}/collections/town/stream", served.address);
    let camera = json!({"eye": [0, -300, 60], "target": [0, 0, 0]});
    let message = json!({"seq": 1, "camera": camera, "lod": {"far_dist_m": null}}).to_string();
    let mut streams: Vec<_> = (0..STREAMS)
        .map(|_| {
            let stream = TcpStream::connect(served.address).unwrap();
            client(&url, stream).unwrap().0
        })
        .collect();
    for stream in &mut streams {
        stream.send(Message::text(&message)).unwrap();
    }
    let mut most = 0;
    for stream in &mut streams {
        most = most.max(served.threads());
        let answer = stream.read().unwrap().into_text().unwrap();
        assert!(answer.contains("\"occlusion\""), "{answer}");
        // Cheap things are done meanwhile.
        assert!(served.get("/health").starts_with("HTTP/1.1 200 "));
    }
    println!("{most} threads with {STREAMS} streams, {before} before");
    assert!(most <= before + 12, "{most} threads, {before} before");
}
