use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};

const BODY: &str = r#"{"camera":{"eye":[0,-800,250],"target":[0,0,30]}}"#;

/// Status of one answer of a demo city served with these flags.
fn status(flags: &[&str]) -> String {
    let serve = Command::new(env!("CARGO_BIN_EXE_citylod"))
        .args(["serve", "--listen", "127.0.0.1:0"])
        .args(flags)
        .stderr(Stdio::piped())
        .spawn();
    let mut serve = serve.unwrap();
    let mut greeting = BufReader::new(serve.stderr.take().unwrap()).lines();
    let address = greeting.find_map(|line| {
        let line = line.unwrap();
        Some(line.split_once("http://")?.1.trim().to_owned())
    });
    let mut stream = TcpStream::connect(address.unwrap()).unwrap();
    write!(
        stream,
        "POST /collections/demo/visible HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\
         content-type: application/json\r\ncontent-length: {}\r\n\r\n{BODY}",
        BODY.len()
    )
    .unwrap();
    let mut answer = String::new();
    let _ = stream.read_to_string(&mut answer);
    serve.kill().unwrap();
    serve.wait().unwrap();
    answer.split(' ').nth(1).unwrap_or_default().to_owned()
}

#[test]
fn limits_on_the_command_line_hold() {
    assert_eq!(status(&[]), "200");
    assert_eq!(status(&["--max-answer-objects", "10"]), "413");
    assert_eq!(status(&["--max-body-bytes", "10"]), "413");
}
