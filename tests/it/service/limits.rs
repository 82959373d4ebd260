use std::io::{Read, Write};
use std::time::{Duration, Instant};

use axum::routing::get;
use citylod::service::Config;

use super::server::{Reply, Running};

const CAMERA: &str = r#"{"camera":{"eye":[0,-800,300],"target":[0,0,0]}}"#;

#[test]
fn long_bodies_are_refused_announced_or_not() {
    let config = Config {
        max_body_bytes: 1_000,
        ..Config::default()
    };
    let service = Running::with(config, |app| app);
    let padded = |length: usize| format!("{CAMERA}{}", " ".repeat(length - CAMERA.len()));
    assert_eq!(service.visible("demo", &padded(1_000)).status, 200);
    service.visible("demo", &padded(1_001)).problem(413);
    let chunked = format!(
        "POST /collections/demo/visible HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n\
         Transfer-Encoding: chunked\r\nConnection: close\r\n\r\n{:x}\r\n{}\r\n0\r\n\r\n",
        2_000,
        padded(2_000)
    );
    service.raw(chunked.as_bytes()).problem(413);
    // Announced only: it is refused without waiting for the body.
    let announced = "POST /collections/demo/visible HTTP/1.1\r\nHost: x\r\n\
         Content-Type: application/json\r\nContent-Length: 9999999999\r\n\r\n";
    let start = Instant::now();
    service.raw(announced.as_bytes()).problem(413);
    assert!(start.elapsed() < Duration::from_secs(5));
    assert_eq!(service.visible("demo", CAMERA).status, 200);
}

#[test]
fn answers_beyond_the_limit_are_refused_with_a_way_out() {
    let config = Config {
        max_answer_objects: 40,
        ..Config::default()
    };
    let service = Running::with(config, |app| app);
    let everything = |form: &str| {
        format!(
            r#"{{"camera":{{"eye":[0,0,9000],"target":[0,0,0],"up":[0,1,0]}},
            "lod":{{"far_dist_m":null}},"output":{{"form":"{form}"}}}}"#
        )
    };
    for form in ["ids", "objects"] {
        let reply = service.visible("demo", &everything(form));
        let document = reply.problem(413);
        assert_eq!(document["type"], "/#answer-too-large");
        let detail = document["detail"].as_str().unwrap();
        assert!(detail.contains("3000 objects are visible"), "{detail}");
        assert!(detail.contains("far_dist_m") && detail.contains("ranges"));
        let most = if form == "ids" { "40 ids" } else { "4 objects" };
        assert!(detail.contains(most), "{detail}");
    }
    // They take no more room than the limit allows.
    assert_eq!(service.visible("demo", &everything("ranges")).status, 200);
    let binary = [("Accept", "application/octet-stream")];
    let path = "/collections/demo/visible";
    let reply = service.send("POST", path, &binary, everything("ids").as_bytes());
    assert!(
        reply.problem(413)["detail"]
            .to_string()
            .contains("160 numbers")
    );
}

#[test]
fn large_answers_are_whole() {
    let service = Running::new();
    let body = r#"{"camera":{"eye":[0,0,9000],"target":[0,0,0],"up":[0,1,0]},
        "lod":{"far_dist_m":null},"output":{"form":"objects"}}"#;
    let reply = service.visible("demo", body);
    assert!(reply.body.len() > 400_000, "{}", reply.body.len());
    assert_eq!(reply.json()["objects"].as_array().unwrap().len(), 3_000);
}

#[test]
fn slow_senders_are_cut_off() {
    let config = Config {
        timeout: Duration::from_millis(300),
        ..Config::default()
    };
    let service = Running::with(config, |app| app);
    let start = Instant::now();
    let half = "POST /collections/demo/visible HTTP/1.1\r\nHost: x\r\n\
         Content-Type: application/json\r\nContent-Length: 500\r\n\r\n{\"camera\":";
    service.raw(half.as_bytes()).problem(408);
    // A head that never ends: the connection is closed.
    let mut stream = service.connect();
    stream
        .write_all(b"GET /health HTTP/1.1\r\nHost: x\r\nX-Slow: ")
        .unwrap();
    let mut rest = Vec::new();
    let _ = std::io::Read::read_to_end(&mut stream, &mut rest);
    // So is one that says nothing, and one that fell silent after a request.
    for first in ["", "GET /health HTTP/1.1\r\nHost: x\r\n\r\n"] {
        let mut stream = service.connect();
        stream.write_all(first.as_bytes()).unwrap();
        let _ = std::io::Read::read_to_end(&mut stream, &mut rest);
    }
    assert!(start.elapsed() < Duration::from_secs(8));
    assert_eq!(service.get("/health").status, 200);
}

#[test]
fn readers_that_stop_reading_are_cut_off() {
    async fn large() -> Vec<u8> {
        vec![b'x'; 64 << 20]
    }
    let config = Config {
        timeout: Duration::from_millis(300),
        max_connections: 1,
        ..Config::default()
    };
    let service = Running::with(config, |app| app.route("/large", get(large)));
    let mut lazy = service.connect();
    lazy.write_all(b"GET /large HTTP/1.1\r\nHost: x\r\n\r\n")
        .unwrap();
    let start = Instant::now();
    // The only connection there may be has to end first.
    assert_eq!(service.get("/health").status, 200);
    assert!(start.elapsed() < Duration::from_secs(8));
    drop(lazy);
    // One that reads in bursts, each wait shorter than the limit, gets everything.
    let mut slow = service.connect();
    slow.write_all(b"GET /large HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
        .unwrap();
    let mut buffer = vec![0; 8 << 20];
    let mut total = 0;
    while let Ok(read @ 1..) = slow.read(&mut buffer) {
        if total / buffer.len() != (total + read) / buffer.len() {
            std::thread::sleep(Duration::from_millis(100));
        }
        total += read;
    }
    assert!(total > 64 << 20, "{total}");
}

#[test]
fn requests_beyond_the_limit_are_turned_away_at_once() {
    let config = Config {
        max_concurrency: 2,
        timeout: Duration::from_secs(5),
        ..Config::default()
    };
    let service = Running::with(config, |app| app);
    let unfinished = "POST /collections/demo/visible HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\
         Content-Type: application/json\r\nContent-Length: 48\r\n\r\n";
    assert_eq!(CAMERA.len(), 48);
    let mut waiting: Vec<_> = (0..2)
        .map(|_| {
            let mut stream = service.connect();
            stream.write_all(unfinished.as_bytes()).unwrap();
            stream
        })
        .collect();
    let turned_away = (0..100).find_map(|_| {
        std::thread::sleep(Duration::from_millis(10));
        let reply = service.get("/health");
        (reply.status != 200).then_some(reply)
    });
    let turned_away = turned_away.expect("two requests are in work");
    turned_away.problem(503);
    assert_eq!(turned_away.header("retry-after"), Some("1"));
    for stream in &mut waiting {
        stream.write_all(CAMERA.as_bytes()).unwrap();
        assert_eq!(Reply::read(stream).status, 200);
    }
    assert_eq!(service.get("/health").status, 200);
}

#[test]
fn a_panic_is_a_problem_document_and_the_service_stays_up() {
    async fn defect() -> &'static str {
        panic!("on purpose")
    }
    let service = Running::with(Config::default(), |app| app.route("/defect", get(defect)));
    for _ in 0..3 {
        let document = service.get("/defect").problem(500);
        assert!(!document.to_string().contains("on purpose"));
    }
    assert_eq!(service.visible("demo", CAMERA).status, 200);
}

#[test]
fn requests_in_work_are_finished_when_the_service_stops() {
    async fn slow() -> &'static str {
        tokio::time::sleep(Duration::from_millis(600)).await;
        "done"
    }
    let mut service = Running::with(Config::default(), |app| app.route("/slow", get(slow)));
    let mut idle = service.connect();
    idle.write_all(b"GET /health HTTP/1.1\r\nHost: x\r\n\r\n")
        .unwrap();
    let mut stream = service.connect();
    stream
        .write_all(b"GET /slow HTTP/1.1\r\nHost: x\r\n\r\n")
        .unwrap();
    std::thread::sleep(Duration::from_millis(200));
    let start = Instant::now();
    service.stop();
    let reply = Reply::read(&mut stream);
    assert_eq!((reply.status, reply.body.as_slice()), (200, &b"done"[..]));
    service.wait();
    assert!(
        start.elapsed() < Duration::from_secs(5),
        "idle connections do not hold it up"
    );
    assert!(std::net::TcpStream::connect(service.address).is_err());
}

#[test]
fn stopping_does_not_wait_for_ever() {
    async fn stuck() -> &'static str {
        tokio::time::sleep(Duration::from_secs(60)).await;
        "never"
    }
    let config = Config {
        timeout: Duration::from_secs(60),
        drain: Duration::from_millis(300),
        ..Config::default()
    };
    let mut service = Running::with(config, |app| app.route("/stuck", get(stuck)));
    let mut stream = service.connect();
    stream
        .write_all(b"GET /stuck HTTP/1.1\r\nHost: x\r\n\r\n")
        .unwrap();
    std::thread::sleep(Duration::from_millis(100));
    let start = Instant::now();
    service.stop();
    service.wait();
    assert!(start.elapsed() < Duration::from_secs(5));
}

#[test]
fn an_address_that_is_taken_is_named() {
    let service = Running::new();
    let config = Config {
        listen: service.address,
        ..Config::default()
    };
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let scenes = citylod::service::Scenes::new();
    let refused = runtime.block_on(citylod::service::serve(
        config,
        scenes,
        || Ok(citylod::service::Scenes::new()),
        |_| (),
    ));
    let text = refused.unwrap_err().to_string();
    assert!(text.contains(&service.address.to_string()), "{text}");
}

#[test]
fn two_scenes_cannot_have_one_name() {
    use citylod::service::Scenes;
    let name = Scenes::name_of("/data/north/city.citylod".as_ref()).unwrap();
    assert_eq!(name, "city");
    let mut scenes = Scenes::new();
    scenes.insert(name.clone(), super::server::demo()).unwrap();
    let error = scenes.insert(name, super::server::demo()).unwrap_err();
    assert!(error.to_string().contains("\"city\""));
    assert!(Scenes::name_of("/".as_ref()).is_err());
}
