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
    let served = Served::start(&["--max-streams", "1", "--stream-idle-ms", "700"]);
    // Nothing is said, so the service ends it: a close frame (0x88) with 1008 (0x03f0).
    let first = std::thread::scope(|scope| {
        let first = scope.spawn(|| {
            use std::io::{Read, Write};
            let mut stream = std::net::TcpStream::connect(served.address).unwrap();
            stream.write_all(UPGRADE.as_bytes()).unwrap();
            let mut bytes = Vec::new();
            let _ = stream.read_to_end(&mut bytes);
            bytes
        });
        let full = (0..200).any(|_| {
            std::thread::sleep(std::time::Duration::from_millis(2));
            served.send(UPGRADE).starts_with("HTTP/1.1 503 ")
        });
        assert!(full, "the only place is taken");
        first.join().unwrap()
    });
    assert!(first.starts_with(b"HTTP/1.1 101 "));
    let end = memchr::memmem::find(&first, b"\r\n\r\n").unwrap() + 4;
    assert_eq!(first[end], 0x88);
    assert_eq!(first[end + 2..end + 4], [0x03, 0xf0]);
    assert!(String::from_utf8_lossy(&first[end + 4..]).contains("no message for 0.7 s"));
}
