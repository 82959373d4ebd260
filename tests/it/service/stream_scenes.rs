use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use citylod::index::{Promotion, build};
use citylod::scene::{CityParams, generate};
use citylod::service::{Config, Scenes};
use serde_json::json;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;

use super::server::Running;
use super::stream_client::{Client, Full, other_city, over_the_city, scenes};

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
fn a_refusal_after_a_scene_was_replaced_names_the_revision_and_is_counted() {
    let mut misty = generate(&CityParams {
        objects: 2_000,
        seed: 3,
    });
    misty.effects = serde_json::from_value(json!({"haze": {"visibility_m": 900}})).unwrap();
    let misty = build(&misty, Promotion::Tallest).unwrap();
    let service = Running::of(scenes(misty), Config::default(), |app| app);
    let mut client = Client::open(&service, "demo");
    let mut request = over_the_city();
    request["effects"] = json!({"haze": true});
    assert!(client.ask(&request)["count"].as_u64() > Some(50));
    // The new city has no haze.
    let tree = other_city(5);
    service.shared.replace(scenes(other_city(5)));
    let answer = client.receive();
    assert_eq!(answer["seq"], 1);
    assert_eq!(answer["problem"]["pointer"], "/effects/haze", "{answer}");
    assert_eq!(answer["revision"], tree.revision(), "{answer}");
    assert!(client.held().is_empty(), "what it held is void");
    let metrics = String::from_utf8(service.get("/metrics").body).unwrap();
    let line = "citylod_stream_messages_refused_total 1\n";
    assert!(metrics.contains(line), "{metrics}");
    let answer = client.ask(&json!({"effects": {}}));
    assert_eq!(answer["revision"], tree.revision());
    assert_eq!(client.held(), Full::new(&tree).objects(&request));
}
