use std::collections::BTreeSet;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use citylod::index::LodTree;
use citylod::service::{Config, Scenes};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::{self, Message, WebSocket};

use super::server::{Running, demo};
use super::stream_client::{Client, Full};
use crate::support::{between, rng};

fn camera(eye: [f64; 3], target: [f64; 3]) -> Value {
    json!({"eye": eye, "target": target})
}

fn over_the_city() -> Value {
    json!({"camera": camera([0.0, -800.0, 300.0], [0.0, 0.0, 0.0])})
}

/// Something that is done to a connection.
type Step = fn(&mut WebSocket<TcpStream>);

/// A flight about the demo city: it wanders, looks about, changes knobs and modes now and then.
struct Flight {
    rng: Pcg64Mcg,
    eye: [f64; 3],
    heading: f64,
    lod: Value,
}

impl Flight {
    fn new(seed: u64) -> Self {
        Self {
            rng: rng(seed),
            eye: [0.0, -500.0, 120.0],
            heading: 0.0,
            lod: json!({}),
        }
    }

    /// The next message, which leaves out what it does not change; and the whole request.
    fn next(&mut self) -> (Value, Value) {
        let rng = &mut self.rng;
        self.heading += between(rng, -0.15, 0.15);
        let (sin, cos) = self.heading.sin_cos();
        let pull = |x: f64| -x * 0.01;
        self.eye[0] += 12.0 * sin + pull(self.eye[0]);
        self.eye[1] += 12.0 * cos + pull(self.eye[1]);
        self.eye[2] = (self.eye[2] + between(rng, -8.0, 8.0)).clamp(2.0, 400.0);
        if rng.random_bool(0.01) {
            self.eye = [
                between(rng, -900.0, 900.0),
                between(rng, -900.0, 900.0),
                50.0,
            ];
        }
        let [x, y, z] = self.eye;
        let camera = camera(self.eye, [x + 50.0 * sin, y + 50.0 * cos, z - 10.0]);
        let mut message = json!({"camera": camera});
        if rng.random_bool(0.03) {
            self.lod = match rng.random_range(0..4) {
                0 => json!({"mode": "error", "max_error_px": between(rng, 2.0, 60.0)}),
                1 => json!({"mode": "budget", "max_objects": rng.random_range(0..900)}),
                2 => json!({"far_dist_m": null}),
                _ => json!({"far_dist_m": between(rng, 0.0, 900.0), "culling": "exact"}),
            };
            message["lod"] = self.lod.clone();
        }
        (message, json!({"camera": camera, "lod": self.lod}))
    }
}

#[test]
fn adds_and_removes_make_the_full_answer_at_every_frame_and_over_reconnects() {
    let service = Running::new();
    let tree = demo();
    let mut full = Full::new(&tree);
    let mut flight = Flight::new(1);
    let mut client = Client::open(&service, "demo");
    let mut objects = 0;
    for frame in 0..10_000 {
        let (mut message, request) = flight.next();
        if frame % 997 == 996 {
            client = Client::open(&service, "demo");
            message = request.clone();
        }
        let answer = client.ask(&message);
        assert_eq!(answer["revision"], tree.revision(), "{frame}");
        assert_eq!(
            client.held(),
            full.objects(&request),
            "frame {frame}: {request}"
        );
        assert_eq!(answer["count"], client.held().len());
        objects += client.held().len();
        if frame % 500 == 0 {
            let mut body = request;
            body["output"] = json!({"form": "ranges"});
            let posted = service.visible("demo", &body.to_string()).json();
            let ranges: Vec<[u32; 2]> = serde_json::from_value(posted["ranges"].clone()).unwrap();
            let posted_set: BTreeSet<u32> = ranges.iter().flat_map(|r| r[0]..r[1]).collect();
            assert_eq!(*client.held(), posted_set);
            assert_eq!(answer["lod"], posted["lod"]);
        }
    }
    assert!(objects > 1_000_000, "{objects}: views worth testing");
}

#[test]
fn a_client_that_stalls_gets_the_newest_frame_not_a_queue() {
    let service = Running::new();
    let tree = demo();
    let mut full = Full::new(&tree);
    let mut flight = Flight::new(2);
    let mut client = Client::open(&service, "demo");
    for stall in 0..5 {
        // What each message stands for, whole: some say a part only.
        let requests: Vec<Value> = (0..400)
            .map(|_| {
                let (message, request) = flight.next();
                client.send(&message);
                request
            })
            .collect();
        let first = client.seq() + 1 - 400;
        let mut answers = 0;
        loop {
            let answer = client.receive();
            let seq = answer["seq"].as_u64().unwrap();
            let request = &requests[(seq - first) as usize];
            assert_eq!(client.held(), full.objects(request), "stall {stall}, {seq}");
            answers += 1;
            if seq == client.seq() {
                break;
            }
        }
        assert!(answers <= 40, "{answers} answers to 400 messages");
    }
}

#[test]
fn a_member_left_out_keeps_what_was_said_and_a_refused_message_changes_nothing() {
    let service = Running::new();
    let tree = demo();
    let mut full = Full::new(&tree);
    let mut client = Client::open(&service, "demo");
    let problem = client.ask(&json!({"lod": {"far_dist_m": 100}}))["problem"].clone();
    assert_eq!(problem["status"], 400);
    assert_eq!(problem["pointer"], "/camera");
    let mut request = over_the_city();
    request["lod"] = json!({"mode": "budget", "max_objects": 77});
    assert_eq!(client.ask(&request)["count"], 77);
    request["camera"] = camera([100.0, -300.0, 50.0], [0.0, 0.0, 0.0]);
    let answer = client.ask(&json!({"camera": request["camera"]}));
    assert_eq!(answer["lod"]["max_objects"], 77);
    assert_eq!(client.held(), full.objects(&request));
    for (message, status, pointer) in [
        (json!({"lod": {"mode": "error"}}), 422, "/lod/max_error_px"),
        (json!({"camera": {"eye": [0, 0]}}), 400, "/camera/eye"),
        (json!({"camera": {"eye": [0, 0, 9]}}), 422, "/camera/target"),
        (json!({"camera": null}), 400, "/camera"),
        (json!({"effects": {"haze": true}}), 422, "/effects/haze"),
        (json!({"output": {"form": "ids"}}), 400, "/output"),
        (json!({"lod": 7}), 400, "/lod"),
    ] {
        let answer = client.ask(&message);
        assert_eq!(answer["problem"]["status"], status, "{message} {answer}");
        assert_eq!(answer["problem"]["pointer"], pointer, "{message} {answer}");
        assert_eq!(client.held(), full.objects(&request), "{message}");
    }
    // Nothing said at all: the same again, so nothing comes and nothing goes.
    let answer = client.ask(&json!({}));
    assert_eq!(answer["count"], 77);
    assert_eq!(
        (&answer["add"], &answer["remove"]),
        (&json!([]), &json!([]))
    );
}

#[test]
fn what_is_no_message_gets_a_problem_and_the_stream_goes_on() {
    let service = Running::new();
    let mut client = Client::open(&service, "demo");
    for (text, seq, status) in [
        ("", Value::Null, 400),
        ("{", Value::Null, 400),
        ("[]", Value::Null, 400),
        ("[1,2]", Value::Null, 400),
        ("null", Value::Null, 400),
        (
            r#"{"camera":{"eye":[0,0,9],"target":[0,0,0]}}"#,
            Value::Null,
            400,
        ),
        (r#"{"seq":-1}"#, Value::Null, 400),
        (r#"{"seq":1.5}"#, Value::Null, 400),
        (r#"{"seq":"1"}"#, Value::Null, 400),
        (r#"{"seq":7,"seq":8}"#, Value::Null, 400),
        (r#"{"seq":9,"sequel":8}"#, json!(9), 400),
        (
            r#"{"seq":10,"camera":{"eye":[1e999,0,9],"target":[0,0,0]}}"#,
            json!(10),
            400,
        ),
        (r#"{"seq":11,"camera":[[0,0,9]]}"#, json!(11), 400),
    ] {
        client.send_text(text);
        let answer = client.receive();
        assert_eq!(answer["seq"], seq, "{text} {answer}");
        assert_eq!(answer["problem"]["status"], status, "{text} {answer}");
    }
    assert!(client.ask(&over_the_city())["count"].as_u64() > Some(100));
}

#[test]
fn an_answer_beyond_the_limit_is_refused_and_the_client_keeps_what_it_holds() {
    let config = Config {
        max_answer_objects: 40,
        ..Config::default()
    };
    let service = Running::with(config, |app| app);
    let tree = demo();
    let mut full = Full::new(&tree);
    let mut client = Client::open(&service, "demo");
    let mut small = over_the_city();
    small["lod"] = json!({"mode": "budget", "max_objects": 10});
    client.ask(&small);
    let large = json!({"lod": {"mode": "budget", "max_objects": 900}});
    let answer = client.ask(&large);
    assert_eq!(answer["problem"]["status"], 413, "{answer}");
    assert_eq!(answer["problem"]["type"], "/#answer-too-large");
    // The knobs that asked for too much are forgotten.
    let answer = client.ask(&json!({}));
    assert_eq!(answer["lod"]["max_objects"], 10);
    assert_eq!(client.held(), full.objects(&small));
}

#[test]
fn effects_are_answered_as_by_post() {
    let mut scene = citylod::scene::generate(&citylod::scene::CityParams {
        objects: 2_000,
        seed: 3,
    });
    scene.effects = serde_json::from_value(json!({
        "motion": {"reference_speed_mps": 1.5}, "haze": {"visibility_m": 600},
        "occlusion": {"width_px": 256, "min_pixels": 1}
    }))
    .unwrap();
    let tree = citylod::index::build(&scene, citylod::index::Promotion::Tallest).unwrap();
    let mut scenes = Scenes::new();
    scenes.insert("misty", tree).unwrap();
    let service = Running::of(scenes, Config::default(), |app| app);
    let mut client = Client::open(&service, "misty");
    let mut request = over_the_city();
    for effects in [
        json!({}),
        json!({"motion": {"speed_mps": 9}}),
        json!({"haze": false}),
        json!({"occlusion": {"width_px": 64}, "motion": false}),
        json!({"occlusion": false, "haze": false, "motion": false}),
    ] {
        request["effects"] = effects;
        let answer = client.ask(&request);
        let mut body = request.clone();
        body["output"] = json!({"form": "ranges"});
        let posted = service.visible("misty", &body.to_string()).json();
        let ranges: Vec<[u32; 2]> = serde_json::from_value(posted["ranges"].clone()).unwrap();
        let posted_set: BTreeSet<u32> = ranges.iter().flat_map(|r| r[0]..r[1]).collect();
        assert_eq!(*client.held(), posted_set, "{request}");
        assert_eq!(answer["lod"], posted["lod"]);
        let ran = |document: &Value| -> Vec<String> {
            document["effects"]
                .as_object()
                .unwrap()
                .keys()
                .cloned()
                .collect()
        };
        assert_eq!(ran(&answer), ran(&posted));
    }
    let pixels = client.ask(&json!({"effects": {"occlusion": {"visible_pixels": true}}}));
    assert_eq!(
        pixels["problem"]["pointer"], "/effects/occlusion/visible_pixels",
        "{pixels}"
    );
}

fn other_city(seed: u64) -> LodTree {
    let params = citylod::scene::CityParams {
        objects: 2_500,
        seed,
    };
    let scene = citylod::scene::generate(&params);
    citylod::index::build(&scene, citylod::index::Promotion::Tallest).unwrap()
}

fn scenes(tree: LodTree) -> Scenes {
    let mut scenes = Scenes::new();
    scenes.insert("demo", tree).unwrap();
    scenes
}

#[test]
fn a_replaced_scene_is_sent_whole_without_being_asked_for() {
    let service = Running::new();
    let mut client = Client::open(&service, "demo");
    let request = over_the_city();
    let before = client.ask(&request);
    for seed in [5, 6] {
        let tree = other_city(seed);
        assert_eq!(service.shared.replace(scenes(other_city(seed))), 1);
        let answer = client.receive();
        assert_eq!(
            answer["seq"], before["seq"],
            "the last message is answered again"
        );
        assert_eq!(answer["revision"], tree.revision());
        assert_eq!(answer["remove"], json!([]));
        assert_eq!(client.held(), Full::new(&tree).objects(&request));
        // The same contents are no news.
        assert_eq!(service.shared.replace(scenes(other_city(seed))), 0);
    }
    let tree = other_city(6);
    client.ask(&json!({"lod": {"far_dist_m": 100}}));
    let request = json!({"camera": request["camera"], "lod": {"far_dist_m": 100}});
    assert_eq!(client.held(), Full::new(&tree).objects(&request));
    service.shared.replace(Scenes::new());
    let (code, reason) = client.closed();
    assert_eq!(
        (code, reason.as_str()),
        (CloseCode::Away, "the scene is no longer served")
    );
    service.get("/collections/demo").problem(404);
}

#[test]
fn requests_are_answered_while_scenes_are_replaced() {
    let service = Running::new();
    let stop = std::sync::atomic::AtomicBool::new(false);
    let trees = [other_city(7), other_city(8)];
    let mut full = trees.each_ref().map(Full::new);
    let request = over_the_city();
    let expected = full.each_mut().map(|full| full.objects(&request).clone());
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !stop.load(std::sync::atomic::Ordering::Relaxed) {
                for seed in [7, 8] {
                    service.shared.replace(scenes(other_city(seed)));
                }
            }
        });
        let mut client = Client::open(&service, "demo");
        let mut seen = BTreeSet::new();
        let start = Instant::now();
        while seen.len() < 2 || client.seq() < 300 {
            assert!(start.elapsed() < Duration::from_secs(60), "{seen:?}");
            client.send(&request);
            loop {
                let answer = client.receive();
                let revision = answer["revision"].as_str().unwrap().to_owned();
                if let Some(at) = trees.iter().position(|tree| tree.revision() == revision) {
                    assert_eq!(*client.held(), expected[at]);
                    seen.insert(revision);
                }
                if answer["seq"] == client.seq() {
                    break;
                }
            }
            let posted = service.visible("demo", &request.to_string());
            assert_eq!(posted.status, 200);
        }
        stop.store(true, std::sync::atomic::Ordering::Relaxed);
    });
}

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

#[test]
fn a_smooth_flight_takes_less_than_a_tenth_of_the_bytes_of_full_answers() {
    let service = Running::new();
    let mut client = Client::open(&service, "demo");
    let (mut streamed, mut full) = (0, [0_usize; 3]);
    for frame in 0..600 {
        // 15 m/s at 60 frames a second, around the centre and looking at it.
        let angle = f64::from(frame) * 0.25 / 500.0;
        let eye = [-500.0 * angle.sin(), -500.0 * angle.cos(), 120.0];
        let mut request = json!({"camera": camera(eye, [0.0, 0.0, 20.0])});
        client.ask(&request);
        streamed += client.last_length();
        if frame % 20 == 0 {
            for (bytes, form) in full.iter_mut().zip(["ids", "ranges"]) {
                request["output"] = json!({"form": form});
                *bytes += 20 * service.visible("demo", &request.to_string()).body.len();
            }
        }
        full[2] += 4 * client.held().len();
    }
    let percent = full.map(|bytes| 100.0 * streamed as f64 / bytes as f64);
    println!("{streamed} bytes: {percent:.1?} % of ids, ranges, binary numbers");
    assert!(percent[0] < 10.0, "{percent:?} % of answers with ids");
}

#[test]
fn feedback_draws_with_the_far_dist_of_the_controller_which_remembers() {
    use citylod::control::{Params, Sample, State, step};
    let service = Running::new();
    let tree = demo();
    let mut full = Full::new(&tree);
    let mut client = Client::open(&service, "demo");
    let mut request = over_the_city();
    request["lod"] = json!({"far_dist_m": 300});
    let mut first = request.clone();
    first["feedback"] = json!({"target_ms": 10});
    let [least, most] = Params::USUAL_FAR_DIST_M;
    let params = Params::new(10.0, least, most).unwrap();
    let mut state = State::starting_at(300.0);
    let mut answer = client.ask(&first);
    let mut chosen = Vec::new();
    for frame in 0..60 {
        // Without a sample it only says where it stands.
        let sample = (frame > 0).then(|| {
            let far_dist_m = chosen[frame - 1];
            let frame_ms = 2.0 + f64::powi(far_dist_m / 250.0, 2);
            Sample {
                frame_ms,
                far_dist_m,
            }
        });
        if let Some(Sample {
            frame_ms,
            far_dist_m,
        }) = sample
        {
            answer = client.ask(&json!({"feedback":
                {"target_ms": 10, "frame_ms": frame_ms, "far_dist_m": far_dist_m}}));
        }
        let (next, far_dist) = step(&params, state, sample);
        state = next;
        assert_eq!(
            answer["feedback"]["far_dist_m"].as_f64(),
            Some(far_dist),
            "{frame}"
        );
        assert_eq!(answer["lod"]["far_dist_m"].as_f64(), Some(far_dist));
        request["lod"]["far_dist_m"] = far_dist.into();
        assert_eq!(client.held(), full.objects(&request));
        chosen.push(far_dist);
    }
    let last = chosen[59];
    assert!(
        (last - 250.0 * 8_f64.sqrt()).abs() < 0.1 * last,
        "{chosen:?}"
    );
    // Without feedback the knobs hold as they were given; after that it goes on where it was.
    request["lod"]["far_dist_m"] = json!(300);
    let answer = client.ask(&json!({}));
    assert!(answer.get("feedback").is_none(), "{answer}");
    assert_eq!(client.held(), full.objects(&request));
    let answer = client.ask(&json!({"feedback": {"target_ms": 10}}));
    assert_eq!(answer["feedback"]["far_dist_m"], last);
    for (feedback, lod, status, pointer) in [
        (
            json!({"target_ms": 0}),
            json!({}),
            422,
            "/feedback/target_ms",
        ),
        (json!({}), json!({}), 400, "/feedback/target_ms"),
        (
            json!({"target_ms": 9, "frame_ms": 7}),
            json!({}),
            422,
            "/feedback/far_dist_m",
        ),
        (
            json!({"target_ms": 9, "far_dist_m": 7}),
            json!({}),
            422,
            "/feedback/frame_ms",
        ),
        (
            json!({"target_ms": 9, "state": null}),
            json!({}),
            400,
            "/feedback/state",
        ),
        (
            json!({"target_ms": 9}),
            json!({"mode": "budget", "max_objects": 9}),
            422,
            "/feedback/target_ms",
        ),
    ] {
        let answer = client.ask(&json!({"feedback": feedback, "lod": lod}));
        assert_eq!(answer["problem"]["status"], status, "{feedback} {answer}");
        assert_eq!(answer["problem"]["pointer"], pointer, "{feedback} {answer}");
    }
    let answer = client.ask(&json!({"feedback": {"target_ms": 10}}));
    assert_eq!(
        answer["feedback"]["far_dist_m"], last,
        "refused messages changed nothing"
    );
}
