use std::collections::BTreeMap;

use citylod::service::Scenes;
use serde_json::json;

use super::server::{Running, demo};
use super::stream_client::Client;

/// Values by name and labels, read as strictly as the format is written down.
fn values(text: &str) -> BTreeMap<String, f64> {
    let mut values = BTreeMap::new();
    let mut kinds: BTreeMap<&str, &str> = BTreeMap::new();
    let mut current = "";
    assert!(text.ends_with('\n'));
    for line in text.lines() {
        if let Some(help) = line.strip_prefix("# HELP ") {
            let (name, help) = help.split_once(' ').unwrap();
            assert!(help.ends_with('.'), "{line}");
            current = name;
        } else if let Some(kind) = line.strip_prefix("# TYPE ") {
            let (name, kind) = kind.split_once(' ').unwrap();
            assert_eq!(name, current, "the type follows the help");
            assert!(kinds.insert(name, kind).is_none(), "{name} comes twice");
        } else {
            let (name, value) = line.rsplit_once(' ').unwrap();
            let bare = name.split('{').next().unwrap();
            let of = match kinds[current] {
                "histogram" => ["_bucket", "_sum", "_count"]
                    .iter()
                    .find_map(|suffix| bare.strip_suffix(suffix))
                    .unwrap(),
                "counter" | "gauge" => bare,
                kind => panic!("{kind}"),
            };
            assert_eq!(of, current, "{line}");
            assert_eq!(
                kinds[current] == "counter",
                bare.ends_with("_total"),
                "{line}"
            );
            let value: f64 = value.parse().unwrap();
            assert!(value >= 0.0, "{line}");
            assert!(values.insert(name.to_owned(), value).is_none(), "{line}");
        }
    }
    values
}

fn read(service: &Running) -> BTreeMap<String, f64> {
    let reply = service.get("/metrics");
    assert_eq!(reply.status, 200);
    let text = "text/plain; version=0.0.4; charset=utf-8";
    assert_eq!(reply.header("content-type"), Some(text));
    values(std::str::from_utf8(&reply.body).unwrap())
}

const CAMERA: &str = r#"{"camera":{"eye":[0,-800,300],"target":[0,0,0]}}"#;

#[test]
fn requests_are_counted_by_path_and_status_and_each_lies_in_a_bucket() {
    let service = Running::new();
    for _ in 0..3 {
        assert_eq!(service.visible("demo", CAMERA).status, 200);
    }
    service.visible("odd%20%C3%B6", CAMERA);
    service.visible("demo", "{").problem(400);
    service.get("/nowhere/at/all").problem(404);
    service.get("/collections/none").problem(404);
    let values = read(&service);
    let visible = "path=\"/collections/{scene}/visible\"";
    let requests = |labels: &str| values[&format!("citylod_http_requests_total{{{labels}}}")];
    assert_eq!(requests(&format!("{visible},status=\"200\"")), 4.0);
    assert_eq!(requests(&format!("{visible},status=\"400\"")), 1.0);
    assert_eq!(requests("path=\"other\",status=\"404\""), 1.0);
    assert_eq!(
        requests("path=\"/collections/{scene}\",status=\"404\""),
        1.0
    );
    let name = "citylod_http_request_duration_seconds";
    assert_eq!(values[&format!("{name}_count{{{visible}}}")], 5.0);
    assert_eq!(
        values[&format!("{name}_bucket{{{visible},le=\"+Inf\"}}")],
        5.0
    );
    assert!(values[&format!("{name}_sum{{{visible}}}")] > 0.0);
    let bounds: Vec<f64> = values
        .iter()
        .filter(|(label, _)| label.starts_with(&format!("{name}_bucket{{{visible},")))
        .map(|(_, count)| *count)
        .collect();
    assert_eq!(bounds.len(), 13);
    assert_eq!(values["citylod_scene_objects{scene=\"demo\"}"], 3000.0);
    assert!(values["process_start_time_seconds"] > 1e9);
    assert!(values["citylod_http_connections"] >= 1.0);
    // The one before is in.
    let again = read(&service);
    let metrics = "citylod_http_requests_total{path=\"/metrics\",status=\"200\"}";
    assert_eq!(again[metrics], values.get(metrics).unwrap_or(&0.0) + 1.0);
}

#[test]
fn streams_are_counted() {
    let service = Running::new();
    let mut client = Client::open(&service, "demo");
    let far = client.ask(&serde_json::from_str(CAMERA).unwrap());
    client.ask(&json!({"lod": {"far_dist_m": 0}}));
    client.ask(&json!({"lod": {"far_dist_m": -1}}));
    let values = read(&service);
    assert_eq!(values["citylod_streams"], 1.0);
    assert_eq!(values["citylod_stream_messages_total"], 3.0);
    assert_eq!(values["citylod_stream_messages_refused_total"], 1.0);
    assert_eq!(values["citylod_stream_messages_skipped_total"], 0.0);
    assert_eq!(values["citylod_stream_answer_duration_seconds_count"], 2.0);
    let (added, removed) = (
        values["citylod_stream_objects_total{change=\"add\"}"],
        values["citylod_stream_objects_total{change=\"remove\"}"],
    );
    assert!(added >= far["count"].as_f64().unwrap(), "{added}");
    assert_eq!(added - removed, client.held().len() as f64);
    drop(client);
    let ended = (0..200).any(|_| {
        std::thread::sleep(std::time::Duration::from_millis(20));
        read(&service)["citylod_streams"] == 0.0
    });
    assert!(ended);
}

#[test]
fn names_of_scenes_are_escaped() {
    let mut scenes = Scenes::new();
    scenes.insert("a \"b\" \\c\nd", demo()).unwrap();
    let service = Running::of(scenes, citylod::service::Config::default(), |app| app);
    let values = read(&service);
    assert_eq!(
        values["citylod_scene_objects{scene=\"a \\\"b\\\" \\\\c\\nd\"}"],
        3000.0
    );
}

#[test]
fn requests_have_the_names_they_came_with_and_refused_ones_a_new_one() {
    let service = Running::new();
    let named = |id: &str, path: &str| service.send("GET", path, &[("X-Request-Id", id)], b"");
    let reply = named("a-1", "/health");
    assert_eq!(reply.header("x-request-id"), Some("a-1"));
    let reply = named("a-2", "/nowhere");
    assert_eq!(reply.header("x-request-id"), Some("a-2"));
    // An answer that nobody asked the name of, and that is not logged, needs none.
    assert_eq!(service.get("/health").header("x-request-id"), None);
    let names: Vec<String> = ["/a", "/b"]
        .map(|path| service.get(path).header("x-request-id").unwrap().to_owned())
        .to_vec();
    assert_ne!(names[0], names[1]);
    for unusable in ["", "two words", "ümlaut", &"x".repeat(129)] {
        let reply = named(unusable, "/nowhere");
        let name = reply.header("x-request-id").unwrap();
        assert_ne!(name, unusable);
        assert!(name.len() < 40, "{name}");
    }
}
