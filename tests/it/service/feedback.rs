use serde_json::{Value, json};

use super::server::{Reply, Running};

fn ask(service: &Running, feedback: &Value) -> Reply {
    let body = json!({
        "camera": { "eye": [0, -800, 60], "target": [0, 0, 0] },
        "lod": { "far_dist_m": 500 },
        "feedback": feedback,
    });
    service.visible("demo", &body.to_string())
}

/// The time of a frame that draws so many objects, ms.
fn frame_ms(answer: &Value) -> f64 {
    4.0 + answer["count"].as_f64().unwrap() / 100.0
}

#[test]
fn the_loop_settles_on_the_target_with_the_state_at_the_client() {
    // Each answer by another replica: nothing is remembered but what the client sends.
    let replicas = [Running::new(), Running::new()];
    let (mut feedback, mut times) = (json!({ "target_ms": 10 }), Vec::new());
    for frame in 0..40 {
        let reply = ask(&replicas[frame % 2], &feedback);
        assert_eq!(reply.status, 200, "{:?}", reply.json());
        let answer = reply.json();
        let chosen = &answer["feedback"];
        assert_eq!(
            chosen["far_dist_m"], answer["lod"]["far_dist_m"],
            "drawn with what was chosen"
        );
        if frame == 0 {
            assert_eq!(chosen["far_dist_m"], 500.0, "starts where the knobs say");
        }
        times.push(frame_ms(&answer));
        feedback = json!({
            "target_ms": 10, "frame_ms": frame_ms(&answer),
            "far_dist_m": chosen["far_dist_m"], "state": chosen["state"],
        });
    }
    let late = &times[20..];
    assert!(late.iter().all(|ms| (ms - 10.0).abs() < 1.0), "{times:?}");
}

#[test]
fn a_query_asks_the_same_and_a_binary_answer_tells_it_in_a_header() {
    let service = Running::new();
    let first = ask(
        &service,
        &json!({ "target_ms": 10, "frame_ms": 20, "far_dist_m": 500 }),
    );
    let state = first.json()["feedback"]["state"].clone();
    let second = json!({
        "target_ms": 10, "frame_ms": 18, "far_dist_m": 480, "state": state,
        "min_far_dist_m": 300, "max_far_dist_m": 400,
    });
    let second = ask(&service, &second).json();
    let text: String = form_urlencode(&state.to_string());
    let query = format!(
        "/collections/demo/visible?eye=0,-800,60&target=0,0,0&far_dist_m=500&target_ms=10\
         &frame_ms=18&frame_far_dist_m=480&min_far_dist_m=300&max_far_dist_m=400&state={text}"
    );
    let by_query = service.get(&query).json();
    assert_eq!(by_query["feedback"], second["feedback"]);
    assert_eq!(by_query["ids"], second["ids"]);
    assert!((300.0..=400.0).contains(&second["feedback"]["far_dist_m"].as_f64().unwrap()));
    let binary = service.send(
        "GET",
        &query,
        &[("accept", "application/octet-stream")],
        b"",
    );
    let header = binary.header("x-citylod-feedback").unwrap();
    let header: Value = serde_json::from_str(header).unwrap();
    assert_eq!(header, second["feedback"]);
}

#[test]
fn a_frame_time_that_cannot_be_is_counted() {
    let service = Running::new();
    let reply = ask(
        &service,
        &json!({ "target_ms": 10, "frame_ms": 0, "far_dist_m": 500 }),
    );
    assert_eq!(reply.json()["feedback"]["state"]["ignored"], 1);
    assert_eq!(reply.json()["feedback"]["far_dist_m"], 500.0);
}

#[test]
fn what_is_wrong_with_feedback_is_named() {
    let service = Running::new();
    let state = ask(&service, &json!({ "target_ms": 10 })).json()["feedback"]["state"].clone();
    let with = |member: &str, value: Value| {
        let mut state = state.clone();
        state[member] = value;
        json!({ "target_ms": 10, "state": state })
    };
    for (feedback, status, pointer) in [
        (json!(null), 400, "/feedback"),
        (json!([10]), 400, "/feedback"),
        (json!({}), 400, "/feedback/target_ms"),
        (json!({ "target_ms": "10" }), 400, "/feedback/target_ms"),
        (json!({ "target_ms": 10, "more": 1 }), 400, "/feedback/more"),
        (json!({ "target_ms": 0 }), 422, "/feedback/target_ms"),
        (json!({ "target_ms": 4e6 }), 422, "/feedback/target_ms"),
        (
            json!({ "target_ms": 10, "frame_ms": 9 }),
            422,
            "/feedback/far_dist_m",
        ),
        (
            json!({ "target_ms": 10, "far_dist_m": 9 }),
            422,
            "/feedback/frame_ms",
        ),
        (
            json!({ "target_ms": 10, "min_far_dist_m": 0 }),
            422,
            "/feedback/min_far_dist_m",
        ),
        (
            json!({ "target_ms": 10, "max_far_dist_m": 3 }),
            422,
            "/feedback/max_far_dist_m",
        ),
        (
            json!({ "target_ms": 10, "state": [] }),
            400,
            "/feedback/state",
        ),
        (
            json!({ "target_ms": 10, "state": "x" }),
            400,
            "/feedback/state",
        ),
        (
            json!({ "target_ms": 10, "state": {} }),
            400,
            "/feedback/state/far_dist_m",
        ),
        (
            with("far_dist_m", json!("x")),
            400,
            "/feedback/state/far_dist_m",
        ),
        (
            with("recent", json!(vec![[1, 2]; 17])),
            400,
            "/feedback/state/recent",
        ),
        (with("suspect", json!({})), 400, "/feedback/state/suspect"),
        (with("ignored", json!(-1)), 400, "/feedback/state/ignored"),
        (with("more", json!(1)), 400, "/feedback/state/more"),
    ] {
        let reply = ask(&service, &feedback);
        assert_eq!(reply.status, status, "{feedback} {:?}", reply.json());
        assert_eq!(reply.json()["pointer"], pointer, "{feedback}");
    }
    let modes = r#"{"camera":{"eye":[0,-800,60],"target":[0,0,0]},
        "lod":{"mode":"error","max_error_px":4},"feedback":{"target_ms":10}}"#;
    let reply = service.visible("demo", modes);
    assert_eq!(reply.status, 422);
    assert_eq!(reply.json()["pointer"], "/feedback/target_ms");
    for (query, status, parameter) in [
        ("frame_ms=9&frame_far_dist_m=500", 422, "target_ms"),
        ("target_ms=9&frame_ms=9", 422, "frame_far_dist_m"),
        ("target_ms=9&state=%7B%7D", 400, "state"),
        ("target_ms=9&target_ms=9", 400, "target_ms"),
        ("target_ms=0", 422, "target_ms"),
    ] {
        let reply = service.get(&format!(
            "/collections/demo/visible?eye=0,-800,60&target=0,0,0&{query}"
        ));
        assert_eq!(reply.status, status, "{query}");
        assert_eq!(
            reply.json()["pointer"],
            parameter,
            "{query} {:?}",
            reply.json()
        );
    }
}

fn form_urlencode(text: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric();
    text.bytes()
        .map(|byte| {
            if plain(byte) {
                char::from(byte).to_string()
            } else {
                format!("%{byte:02X}")
            }
        })
        .collect()
}
