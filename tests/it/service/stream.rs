use std::collections::BTreeSet;

use citylod::service::{Config, Scenes};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};

use super::effects;
use super::server::{Running, demo};
use super::stream_client::{Client, Full, camera, other_city, over_the_city, scenes};
use crate::support::{between, rng};

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
fn the_first_answer_is_whole_and_others_leave_out_what_is_as_before() {
    let service = Running::new();
    let mut client = Client::open(&service, "demo");
    let mut said = |message: Value| -> (Vec<String>, Vec<String>) {
        client.ask(&message);
        let answer: Value = serde_json::from_str(client.last()).unwrap();
        let names = |value: &Value| value.as_object().unwrap().keys().cloned().collect();
        (names(&answer), names(&answer["lod"]))
    };
    let always = ["add", "count", "lod", "remove", "seq"];
    let of_range = ["dist_factor", "error_px", "far_dist_m", "levels", "mode"];
    let moved = json!({"camera": camera([10.0, -800.0, 300.0], [0.0, 0.0, 0.0])});
    let whole = [
        "add", "count", "effects", "lod", "remove", "revision", "seq", "stats",
    ];
    for (message, members, lod) in [
        (over_the_city(), &whole[..], &of_range[..]),
        (json!({}), &always, &["error_px"]),
        (moved, &always, &["error_px"]),
        (
            json!({"lod": {"far_dist_m": 300}}),
            &always,
            &["error_px", "far_dist_m"],
        ),
        (
            json!({"lod": {"mode": "error", "max_error_px": 9}, "stats": true}),
            &["add", "count", "lod", "remove", "seq", "stats"],
            &["error_px", "max_error_px", "mode"],
        ),
        (
            json!({"lod": {"mode": "error", "max_error_px": 8}}),
            &["add", "count", "lod", "remove", "seq", "stats"],
            &["error_px", "max_error_px"],
        ),
        (json!({"lod": {}, "stats": false}), &always, &of_range[..]),
    ] {
        let said = said(message.clone());
        assert_eq!(said.0, members, "{message}");
        assert_eq!(said.1, lod, "{message}");
    }
}

#[test]
fn effects_that_did_the_same_are_as_before_whatever_they_took() {
    let scenes = scenes(effects::city(effects::DECLARED));
    let service = Running::of(scenes, Config::default(), |app| app);
    let mut client = Client::open(&service, "demo");
    let mut told = |message: &Value| {
        let answer = client.ask(message);
        let sent: Value = serde_json::from_str(client.last()).unwrap();
        let held = answer["effects"]["haze"]["removed"].as_u64();
        (sent.get("effects").cloned(), held)
    };
    let hazy = json!({"haze": true, "motion": false, "occlusion": false});
    let mut request = over_the_city();
    request["lod"] = json!({"far_dist_m": null});
    request["effects"] = hazy.clone();
    let (first, removed) = told(&request);
    let first = first.expect("the first answer is whole");
    assert!(first["haze"]["took_us"].is_f64(), "{first}");
    assert!(removed > Some(0), "{first}");
    for _ in 0..5 {
        assert_eq!(told(&json!({})), (None, removed));
    }
    let elsewhere = json!({"camera": camera([0.0, -1500.0, 300.0], [0.0, 0.0, 0.0])});
    let (anew, more) = told(&elsewhere);
    assert_eq!(
        anew.expect("what is in the haze is another")["haze"]["removed"],
        more.unwrap()
    );
    assert_ne!(more, removed);
    let also = json!({"effects": {"haze": true, "motion": true, "occlusion": false}});
    let with_motion = told(&also).0.expect("one effect more");
    assert!(with_motion["motion"].is_object(), "{with_motion}");
    let without = told(&json!({"effects": hazy})).0.expect("one effect less");
    assert!(without.get("motion").is_none(), "{without}");
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
    // The message that asked for too much is forgotten, its number too.
    service.shared.replace(scenes(other_city(5)));
    let answer = client.receive();
    assert_eq!(answer["seq"], 1, "{answer}");
    assert_eq!(answer["count"], 10);
    service.shared.replace(scenes(demo()));
    client.receive();
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

#[test]
fn a_smooth_flight_takes_less_than_a_tenth_of_the_bytes_of_full_answers() {
    // The city that is served where none is given.
    let city = citylod::scene::generate(&citylod::scene::CityParams {
        objects: 23_951,
        seed: 1,
    });
    let tree = citylod::index::build(&city, citylod::index::Promotion::Tallest).unwrap();
    let service = Running::of(scenes(tree), Config::default(), |app| app);
    for far_dist in [500, 1000, 2000] {
        smooth_flight(&service, far_dist);
    }
}

fn smooth_flight(service: &Running, far_dist: u32) {
    let mut client = Client::open(service, "demo");
    let (mut streamed, mut objects, mut full) = (0, 0, [0; 3]);
    for frame in 0..600 {
        // 15 m/s at 60 frames a second, around the centre and looking at it.
        let angle = f64::from(frame) * 0.25 / 500.0;
        let eye = [-500.0 * angle.sin(), -500.0 * angle.cos(), 120.0];
        let mut request = json!({"camera": camera(eye, [0.0, 0.0, 20.0]),
            "lod": {"far_dist_m": far_dist}});
        client.ask(&request);
        streamed += client.last().len();
        if frame % 20 == 0 {
            for (bytes, form) in full.iter_mut().zip(["ids", "ranges"]) {
                request["output"] = json!({"form": form});
                *bytes += 20 * service.visible("demo", &request.to_string()).body.len();
            }
        }
        full[2] += 4 * client.held().len();
        objects += client.held().len();
    }
    let percent = full.map(|bytes| 100.0 * streamed as f64 / bytes as f64);
    println!(
        "far_dist {far_dist} m: {} objects, {} bytes an answer: {percent:.1?} % of ids, ranges, \
         binary numbers",
        objects / 600,
        streamed / 600
    );
    for (percent, form) in percent.iter().zip(["ids", "ranges", "binary numbers"]) {
        assert!(*percent < 10.0, "{percent} % of answers as {form}");
    }
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
