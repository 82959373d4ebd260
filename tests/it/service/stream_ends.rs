use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use citylod::service::Config;
use rand::RngExt;
use serde_json::json;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::{self, Message, WebSocket};

use super::server::Running;
use super::stream_client::{Client, over_the_city};
use crate::support::rng;

/// Something that is done to a connection.
type Step = fn(&mut WebSocket<TcpStream>);

#[test]
fn frames_that_no_client_should_send_end_the_stream_with_the_reason() {
    let config = Config {
        max_body_bytes: 2_000,
        ..Config::default()
    };
    let service = Running::with(config, |app| app);
    let cases: [(&str, Step, CloseCode); 8] = [
        (
            "a long message",
            |s| s.send(Message::text(" ".repeat(2_001))).unwrap(),
            CloseCode::Size,
        ),
        (
            // Announced only: it is refused without waiting for the rest.
            "a frame of 2^62 bytes",
            |s| {
                let head = [0x81, 0xff, 0x40, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4];
                s.get_mut().write_all(&head).unwrap();
            },
            CloseCode::Size,
        ),
        (
            "fragments that add up",
            |s| {
                let fragment = [&[0x01, 0xfe, 0x05, 0xdc, 0, 0, 0, 0], &[b' '; 1500][..]].concat();
                s.get_mut().write_all(&fragment).unwrap();
                let rest = [&[0x00, 0xfe, 0x05, 0xdc, 0, 0, 0, 0], &[b' '; 1500][..]].concat();
                s.get_mut().write_all(&rest).unwrap();
            },
            CloseCode::Size,
        ),
        (
            "a binary message",
            |s| s.send(Message::binary(vec![1, 2, 3])).unwrap(),
            CloseCode::Unsupported,
        ),
        (
            "text that is not UTF-8",
            |s| {
                s.get_mut()
                    .write_all(&[0x81, 0x82, 0, 0, 0, 0, 0xc3, 0x28])
                    .unwrap();
            },
            CloseCode::Invalid,
        ),
        (
            "a frame without a mask",
            |s| s.get_mut().write_all(&[0x81, 0x02, b'{', b'}']).unwrap(),
            CloseCode::Protocol,
        ),
        (
            "a frame with reserved bits",
            |s| {
                s.get_mut()
                    .write_all(&[0xf1, 0x82, 0, 0, 0, 0, b'{', b'}'])
                    .unwrap();
            },
            CloseCode::Protocol,
        ),
        (
            "an HTTP request",
            |s| {
                s.get_mut()
                    .write_all(b"GET /health HTTP/1.1\r\nHost: x\r\n\r\n")
                    .unwrap();
            },
            CloseCode::Protocol,
        ),
    ];
    for (what, step, code) in cases {
        let mut client = Client::open(&service, "demo");
        client.ask(&over_the_city());
        step(client.socket());
        assert_eq!(client.closed().0, code, "{what}");
    }
    // A message of just the limit is fine.
    let mut client = Client::open(&service, "demo");
    let text = json!({"seq": 1, "camera": over_the_city()["camera"]}).to_string();
    client.send_text(&format!("{text}{}", " ".repeat(2_000 - text.len())));
    assert_eq!(client.receive()["seq"], 1);
    assert_eq!(service.get("/health").status, 200);
}

#[test]
fn random_bytes_never_take_the_service_down() {
    let service = Running::new();
    let mut rng = rng(11);
    for _ in 0..200 {
        let mut client = Client::open(&service, "demo");
        let bytes: Vec<u8> = (0..rng.random_range(1..300))
            .map(|_| rng.random())
            .collect();
        let _ = client.socket().get_mut().write_all(&bytes);
        if rng.random_bool(0.5) {
            // Half of them are half a frame: the client goes away in the middle.
            drop(client);
        } else {
            let _ = client
                .socket()
                .get_mut()
                .shutdown(std::net::Shutdown::Write);
            let _ = client.socket().get_mut().read_to_end(&mut Vec::new());
        }
    }
    let mut client = Client::open(&service, "demo");
    assert!(client.ask(&over_the_city())["count"].as_u64() > Some(100));
}

#[test]
fn idle_and_half_open_streams_are_closed() {
    let config = Config {
        timeout: Duration::from_millis(400),
        stream_idle: Duration::from_millis(1500),
        max_streams: 2,
        ..Config::default()
    };
    let service = Running::with(config, |app| app);
    // This one reads, and so answers pings, but says nothing.
    let mut idle = Client::open(&service, "demo");
    idle.ask(&over_the_city());
    // This one is gone without a word: no pong comes.
    let mut gone = Client::open(&service, "demo");
    gone.ask(&over_the_city());
    let start = Instant::now();
    let (code, reason) = idle.closed();
    assert_eq!(code, CloseCode::Policy);
    assert!(reason.contains("--stream-idle-ms"), "{reason}");
    // The other was told earlier, though it is only now that it looks.
    let (code, reason) = gone.closed();
    assert_eq!(code, CloseCode::Policy);
    assert!(reason.contains("--timeout-ms"), "{reason}");
    assert!(start.elapsed() < Duration::from_secs(8));
    // Their places are free again.
    let text = (0..100).find_map(|_| {
        let text = String::from_utf8(service.get("/metrics").body).unwrap();
        std::thread::sleep(Duration::from_millis(50));
        text.contains("citylod_streams 0\n").then_some(text)
    });
    let text = text.expect("both have ended");
    for end in ["idle", "unread"] {
        let line = format!("citylod_streams_ended_total{{reason=\"{end}\"}} 1\n");
        assert!(text.contains(&line), "{line} in {text}");
    }
}

#[test]
fn streams_take_no_place_of_requests_or_connections_and_have_a_limit_of_their_own() {
    let config = Config {
        max_concurrency: 1,
        max_connections: 1,
        max_streams: 3,
        ..Config::default()
    };
    let service = Running::with(config, |app| app);
    let mut clients: Vec<_> = (0..3).map(|_| Client::open(&service, "demo")).collect();
    let refused = Client::refused(&service, "demo");
    assert_eq!(refused.status, 503);
    assert_eq!(refused.header("retry-after"), Some("1"));
    for client in &mut clients {
        client.ask(&over_the_city());
        assert_eq!(service.get("/health").status, 200);
    }
    drop(clients.pop());
    let opened = (0..100).any(|_| {
        std::thread::sleep(Duration::from_millis(20));
        Client::try_open(&service, "demo").is_some()
    });
    assert!(opened, "a place was given back");
}

#[test]
fn what_is_no_websocket_request_is_refused() {
    let service = Running::new();
    let path = "/collections/demo/stream";
    let reply = service.get(path);
    let problem = reply.problem(426);
    assert_eq!(problem["type"], "/#upgrade-required");
    assert_eq!(reply.header("upgrade"), Some("websocket"));
    assert_eq!(reply.header("sec-websocket-version"), Some("13"));
    let right = [
        ("Connection", "keep-alive, Upgrade"),
        ("Upgrade", "websocket"),
        ("Sec-WebSocket-Version", "13"),
        ("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="),
    ];
    for (at, wrong) in [(0, "close"), (1, "h2c"), (2, "12"), (3, "short")] {
        let mut headers = right;
        headers[at].1 = wrong;
        service.send("GET", path, &headers, b"").problem(426);
    }
    assert_eq!(service.send("HEAD", path, &right, b"").status, 426);
    service.send("POST", path, &right, b"").problem(405);
    service
        .send("GET", "/collections/none/stream", &right, b"")
        .problem(404);
    assert_eq!(Client::refused(&service, "none").status, 404);
}

#[test]
fn streams_are_told_when_the_service_stops() {
    let mut service = Running::new();
    let mut quiet = Client::open(&service, "demo");
    let mut busy = Client::open(&service, "demo");
    busy.ask(&over_the_city());
    let start = Instant::now();
    service.stop();
    for client in [&mut quiet, &mut busy] {
        assert_eq!(
            client.closed(),
            (CloseCode::Away, "the service stops".to_owned())
        );
    }
    service.wait();
    assert!(start.elapsed() < Duration::from_secs(5));
    assert!(matches!(
        quiet.socket().read(),
        Err(tungstenite::Error::ConnectionClosed | tungstenite::Error::AlreadyClosed)
    ));
}
