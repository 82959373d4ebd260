use citylod::geom::{DVec3, View};
use citylod::lod::{BudgetLod, ErrorLod, Lod, Selection, select};
use serde_json::{Value, json};

use crate::support::look;

use super::server::{ODD_IDS, Reply, Running, demo};

const CAMERA: &str = r#"{"camera":{"eye":[0,-800,300],"target":[0,0,0]}}"#;
const CAMERA_QUERY: &str = "/collections/demo/visible?eye=0,-800,300&target=0,0,0";

/// What `CAMERA` sees.
fn view() -> View {
    look(DVec3::new(0.0, -800.0, 300.0), DVec3::ZERO)
}

/// What the library says to `CAMERA`.
fn expected() -> Selection {
    let mut selection = Selection::default();
    select(&demo(), &view(), &Lod::default(), &mut selection);
    selection
}

fn ids(reply: &Reply) -> Vec<String> {
    serde_json::from_value(reply.json()["ids"].clone()).unwrap()
}

#[test]
fn the_answer_is_what_the_library_says() {
    let service = Running::new();
    let reply = service.visible("demo", CAMERA);
    assert_eq!(reply.status, 200);
    assert_eq!(reply.header("content-type"), Some("application/json"));
    let (tree, selection) = (demo(), expected());
    let wanted: Vec<String> = selection
        .objects()
        .map(|o| tree.id(o).unwrap().into_owned())
        .collect();
    assert!(wanted.len() > 100, "a view worth testing");
    assert_eq!(ids(&reply), wanted);
    let document = reply.json();
    assert_eq!(document["scene"], "demo");
    assert_eq!(document["revision"], tree.revision());
    assert_eq!(document["count"], wanted.len());
    assert_eq!(document["effects"], json!({}));
    let lod = &document["lod"];
    assert_eq!(lod["mode"], "range");
    assert_eq!(lod["far_dist_m"], 500.0);
    assert_eq!(lod["dist_factor"], 2.5);
    assert_eq!(lod["levels"], 4);
    assert_eq!(lod["error_px"].as_f64(), Some(selection.error_px()));
    let stats = selection.stats();
    assert_eq!(document["stats"]["nodes_visited"], stats.nodes_visited);
    assert_eq!(document["stats"]["objects_tested"], stats.objects_tested);
    assert!(document["stats"]["retrieve_us"].as_f64().unwrap() >= 0.0);
}

#[test]
fn every_mode_is_answered_as_the_library_does() {
    let service = Running::new();
    let tree = demo();
    let view = view();
    let mut selection = Selection::default();
    for (knobs, query, lod) in [
        (
            json!({"mode":"error","max_error_px":12.5}),
            "&mode=error&max_error_px=12.5",
            Lod::Error(ErrorLod::new(12.5).unwrap()),
        ),
        (
            json!({"mode":"budget","max_objects":321}),
            "&mode=budget&max_objects=321",
            Lod::Budget(BudgetLod::new(321)),
        ),
    ] {
        let mut body: Value = serde_json::from_str(CAMERA).unwrap();
        body["lod"] = knobs.clone();
        let posted = service.visible("demo", &body.to_string());
        let got = service.get(&format!("{CAMERA_QUERY}{query}"));
        select(&tree, &view, &lod, &mut selection);
        let wanted: Vec<String> = selection
            .objects()
            .map(|o| tree.id(o).unwrap().into_owned())
            .collect();
        assert!(wanted.len() > 100, "a view worth testing");
        let mut answer = knobs;
        answer["error_px"] = json!(selection.error_px());
        for reply in [posted, got] {
            assert_eq!(ids(&reply), wanted, "{query}");
            assert_eq!(reply.json()["lod"], answer, "{query}");
        }
    }
}

#[test]
fn the_members_come_in_the_order_of_the_description() {
    let reply = Running::new().visible("demo", CAMERA);
    let text = String::from_utf8(reply.body).unwrap();
    let places: Vec<_> = [
        "scene", "revision", "count", "ids", "lod", "effects", "stats",
    ]
    .iter()
    .map(|name| text.find(&format!("\"{name}\":")).unwrap())
    .collect();
    assert!(places.is_sorted(), "{places:?}");
}

#[test]
fn the_query_means_the_same_as_the_body() {
    let service = Running::new();
    for (query, body) in [
        ("", json!({})),
        (
            "&up=0,1,0&fov_y_deg=30&viewport=800x600",
            json!({"up":[0,1,0],"fov_y_deg":30,"viewport":[800,600]}),
        ),
        (
            "&viewport=800,600&near=10&far=900",
            json!({"viewport":[800,600],"near":10,"far":900}),
        ),
        (
            "&orthographic_height_m=400&far=null",
            json!({"orthographic_height_m":400,"far":null}),
        ),
        (
            "&off_axis=-1,0,-0.5,0.5",
            json!({"off_axis":[-1,0,-0.5,0.5]}),
        ),
    ] {
        let mut camera = json!({"eye":[0,-800,300],"target":[0,0,0]});
        for (name, value) in body.as_object().unwrap() {
            camera[name] = value.clone();
        }
        let posted = service.visible("demo", &json!({"camera":camera}).to_string());
        let got = service.get(&format!("{CAMERA_QUERY}{query}"));
        assert_eq!(got.status, 200, "{query}");
        assert_eq!(ids(&got), ids(&posted), "{query}");
    }
    let knobs = "&mode=range&far_dist_m=100&dist_factor=2&levels=2&beyond=hide&form=ranges";
    let got = service.get(&format!("{CAMERA_QUERY}{knobs}")).json();
    let mut body: Value = serde_json::from_str(CAMERA).unwrap();
    body["lod"] =
        json!({"mode":"range","far_dist_m":100,"dist_factor":2,"levels":2,"beyond":"hide"});
    body["output"] = json!({"form":"ranges"});
    let posted = service.visible("demo", &body.to_string()).json();
    assert_eq!(got["ranges"], posted["ranges"]);
    assert_eq!(got["lod"], posted["lod"]);
}

#[test]
fn straight_down_has_north_upright() {
    let service = Running::new();
    for sight in [
        r#""eye":[0,0,500],"target":[0,0,0]"#,
        r#""eye":[0,0,-50],"target":[0,0,900]"#,
        r#""eye":[0,0,500],"target":[1e-12,0,0]"#,
    ] {
        let short = service.visible("demo", &format!(r#"{{"camera":{{{sight}}}}}"#));
        let long = service.visible("demo", &format!(r#"{{"camera":{{{sight},"up":[0,1,0]}}}}"#));
        assert_eq!(short.status, 200, "{sight}");
        assert_eq!(ids(&short), ids(&long), "{sight}");
    }
    let wrong = r#"{"camera":{"eye":[0,0,500],"target":[0,0,0],"up":[0,0,1]}}"#;
    let document = service.visible("demo", wrong).problem(422);
    assert!(document["detail"].to_string().contains("such as [0,1,0]"));
}

#[test]
fn a_matrix_sees_what_its_camera_sees() {
    let service = Running::new();
    // Square, 90 degrees, straight down from 1,000 m, near 0.1.
    let matrix = "1,0,0,0,0,1,0,0,0,0,-1,-1,0,0,999.8,1000";
    let by_matrix = service.get(&format!(
        "/collections/demo/visible?eye=0,0,1000&view_projection={matrix}&viewport=500x500"
    ));
    let by_camera = service.get(
        "/collections/demo/visible?eye=0,0,1000&target=0,0,0&up=0,1,0&fov_y_deg=90&viewport=500x500",
    );
    let by_quaternion = service.get(
        "/collections/demo/visible?eye=0,0,1000&quaternion=0,0,0,1&fov_y_deg=90&viewport=500x500",
    );
    assert_eq!(ids(&by_matrix), ids(&by_camera));
    assert_eq!(ids(&by_quaternion), ids(&by_camera));
    assert!(!ids(&by_camera).is_empty());
}

#[test]
fn every_form_lists_the_same_objects() {
    let service = Running::new();
    let wanted: Vec<u32> = expected().objects().collect();
    let with_form = |form: &str| {
        let mut body: Value = serde_json::from_str(CAMERA).unwrap();
        body["output"] = json!({"form":form});
        service.visible("demo", &body.to_string()).json()
    };
    let tree = demo();
    let objects = with_form("objects");
    let listed = objects["objects"].as_array().unwrap();
    assert_eq!(listed.len(), wanted.len());
    for (item, &object) in listed.iter().zip(&wanted) {
        let known = tree.object(object).unwrap();
        assert_eq!(item["index"], object);
        assert_eq!(item["id"], *known.id);
        assert_eq!(item["class"], known.class);
        assert_eq!(item["level"], known.level);
        assert_eq!(item["bounds"], json!(known.bounds.to_array()));
    }
    let ranges: Vec<(u32, u32)> =
        serde_json::from_value(with_form("ranges")["ranges"].clone()).unwrap();
    let from_ranges: Vec<u32> = ranges.into_iter().flat_map(|(a, b)| a..b).collect();
    assert_eq!(from_ranges, wanted);

    let headers = [
        ("Content-Type", "application/json"),
        ("Accept", "application/octet-stream"),
    ];
    let path = "/collections/demo/visible";
    let binary = service.send("POST", path, &headers, CAMERA.as_bytes());
    assert_eq!(
        binary.header("content-type"),
        Some("application/octet-stream")
    );
    let count = wanted.len().to_string();
    assert_eq!(binary.header("x-citylod-count"), Some(count.as_str()));
    let revision = tree.revision();
    assert_eq!(binary.header("x-citylod-revision"), Some(revision.as_str()));
    let numbers: Vec<u32> = binary
        .body
        .chunks_exact(4)
        .map(|four| u32::from_le_bytes(four.try_into().unwrap()))
        .collect();
    assert_eq!(numbers, wanted);
}

#[test]
fn an_infinite_bound_or_range_is_null() {
    let service = Running::new();
    let body = r#"{"camera":{"eye":[0,0,1],"target":[1,0,1]},"lod":{"far_dist_m":0}}"#;
    assert_eq!(
        service.visible("demo", body).json()["lod"]["error_px"],
        Value::Null
    );
    let body = r#"{"camera":{"eye":[0,0,1],"target":[1,0,1]},"lod":{"far_dist_m":null}}"#;
    let lod = &service.visible("demo", body).json()["lod"];
    assert_eq!(lod["far_dist_m"], Value::Null);
    assert_eq!(lod["error_px"], 0.0);
}

#[test]
fn a_scene_without_objects_answers_too() {
    let service = Running::new();
    let document = service.visible("empty", CAMERA).json();
    assert_eq!(document["count"], 0);
    assert_eq!(document["ids"], json!([]));
    assert_eq!(
        service.get("/collections/empty").json()["bounds"],
        Value::Null
    );
    assert_eq!(service.get("/collections/empty/boxes").body, b"");
    assert_eq!(service.get("/collections/empty/plan.svg").status, 200);
}

#[test]
fn any_id_can_be_asked_for() {
    let service = Running::new();
    let encode = |text: &str| {
        percent_encoding::percent_encode(text.as_bytes(), percent_encoding::NON_ALPHANUMERIC)
            .to_string()
    };
    for id in ODD_IDS {
        let path = format!("/collections/odd%20%C3%B6/items/{}", encode(id));
        let reply = service.get(&path);
        assert_eq!(reply.status, 200, "{id}");
        let item = reply.json();
        assert_eq!(item["id"], id);
        assert_eq!(item["height_m"], 5.0);
        assert_eq!(item["footprint_area_m2"], 100.0);
        let link = item["links"][0]["href"].as_str().unwrap();
        assert_eq!(service.get(link).json()["id"], id, "{link}");
    }
    let tower = service.get(&format!(
        "/collections/odd%20%C3%B6/items/{}",
        encode(ODD_IDS[0])
    ));
    assert_eq!(tower.json()["attributes"], json!({"height":333,"名":"塔"}));
    let all = service.visible(
        "odd%20%C3%B6",
        r#"{"camera":{"eye":[50,-100,50],"target":[50,0,0]}}"#,
    );
    let mut listed = ids(&all);
    listed.sort_unstable();
    let mut wanted = ODD_IDS.map(str::to_owned).to_vec();
    wanted.sort_unstable();
    assert_eq!(listed, wanted);
    assert_eq!(all.json()["scene"], "odd ö");
}

#[test]
fn boxes_hold_their_objects_and_no_more_than_rounding() {
    let service = Running::new();
    let tree = demo();
    let floats = |reply: &Reply| -> Vec<f32> {
        let four = reply.body.chunks_exact(4);
        four.map(|b| f32::from_le_bytes(b.try_into().unwrap()))
            .collect()
    };
    let all = service.get("/collections/demo/boxes");
    assert_eq!(all.header("cache-control"), Some("no-cache"));
    let all = floats(&all);
    assert_eq!(all.len(), tree.object_count() as usize * 6);
    let origin = tree.origin().to_array();
    for (object, corner) in all.chunks_exact(6).enumerate() {
        let exact = tree.bounds_of(object as u32).unwrap().to_array();
        for axis in 0..3 {
            let (low, high) = (f64::from(corner[axis]), f64::from(corner[axis + 3]));
            let (min, max) = (exact[axis] - origin[axis], exact[axis + 3] - origin[axis]);
            assert!(low <= min && high >= max, "{object}");
            assert!(min - low < 1e-3 && high - max < 1e-3, "{object}");
        }
    }
    for (start, end) in [(0, 1), (3, 29), (8, 16), (2_999, 3_000), (7, 7)] {
        let path = format!("/collections/demo/boxes?start={start}&end={end}");
        assert_eq!(
            floats(&service.get(&path)),
            all[start * 6..end * 6],
            "{path}"
        );
    }
}

#[test]
fn what_does_not_change_is_not_sent_twice() {
    let service = Running::new();
    let revision = demo().revision();
    let strong = format!("\"{}-{revision}\"", env!("CARGO_PKG_VERSION"));
    let tag = format!("W/{strong}");
    for path in [
        "/collections/demo",
        "/collections/demo/boxes",
        "/collections/demo/items",
        "/collections/demo/plan.svg",
    ] {
        let first = service.get(path);
        assert_eq!(first.header("etag"), Some(tag.as_str()), "{path}");
        for known in [&tag, &strong, &format!("\"else\", {tag}")] {
            let again = service.send("GET", path, &[("If-None-Match", known)], b"");
            assert_eq!((again.status, again.body.len()), (304, 0), "{path}");
            assert_eq!(again.header("etag"), Some(tag.as_str()), "{path}");
        }
        let other = service.send("GET", path, &[("If-None-Match", "\"else\"")], b"");
        assert_eq!(other.status, 200, "{path}");
    }
    let pinned = service.get(&format!("/collections/demo/boxes?revision={revision}"));
    assert!(
        pinned
            .header("cache-control")
            .unwrap()
            .contains("immutable")
    );
    let stale = service.get("/collections/demo/boxes?revision=1-0-0");
    assert_eq!(stale.problem(409)["pointer"], "revision");
}

#[test]
fn the_form_follows_what_is_accepted() {
    let service = Running::new();
    let json = "application/json";
    for (path, accept, status, media_type) in [
        (
            "/",
            "text/html,application/xhtml+xml,*/*;q=0.8",
            200,
            "text/html; charset=utf-8",
        ),
        ("/", "*/*", 200, json),
        ("/", json, 200, json),
        ("/", "application/json, text/html;q=0.9", 200, json),
        ("/", "text/*", 200, "text/html; charset=utf-8"),
        ("/", "image/png", 406, ""),
        ("/api", "*/*", 200, "application/vnd.oai.openapi"),
        ("/api", "application/yaml", 200, "application/yaml"),
        (
            "/api",
            "text/html,*/*;q=0.8",
            200,
            "application/vnd.oai.openapi",
        ),
        ("/collections", "text/html,*/*;q=0.8", 200, json),
        ("/collections", "application/json;q=0", 406, ""),
        ("/collections/demo", "application/*", 200, json),
        (
            "/collections/demo/plan.svg",
            "image/*",
            200,
            "image/svg+xml",
        ),
        ("/collections/demo/plan.svg", json, 406, ""),
        ("/collections/demo/boxes", "text/plain", 406, ""),
        (
            CAMERA_QUERY,
            "application/octet-stream",
            200,
            "application/octet-stream",
        ),
        (
            CAMERA_QUERY,
            "application/octet-stream;q=0.5, application/json",
            200,
            json,
        ),
        (CAMERA_QUERY, "text/xml", 406, ""),
        ("/health", "*/*", 200, json),
        ("/conformance", "*/*", 200, json),
    ] {
        let reply = service.send("GET", path, &[("Accept", accept)], b"");
        if status == 406 {
            assert_eq!(reply.problem(406)["pointer"], "Accept", "{path} {accept}");
        } else {
            assert_eq!(reply.status, status, "{path} {accept}");
            assert_eq!(
                reply.header("content-type"),
                Some(media_type),
                "{path} {accept}"
            );
            assert!(reply.header("vary").unwrap().contains("accept"), "{path}");
        }
    }
}

#[test]
fn a_binary_answer_has_one_form() {
    let service = Running::new();
    let binary = [("Accept", "application/octet-stream")];
    for (form, status) in [("ids", 200), ("objects", 422), ("ranges", 422)] {
        let mut body: Value = serde_json::from_str(CAMERA).unwrap();
        body["output"] = json!({"form":form});
        let body = body.to_string();
        let path = "/collections/demo/visible";
        let posted = service.send("POST", path, &binary, body.as_bytes());
        let got = service.send("GET", &format!("{CAMERA_QUERY}&form={form}"), &binary, b"");
        if status == 200 {
            assert_eq!((posted.status, got.status), (200, 200));
        } else {
            assert_eq!(posted.problem(status)["pointer"], "/output/form");
            assert_eq!(got.problem(status)["pointer"], "form");
        }
    }
}

#[test]
fn every_link_leads_somewhere() {
    let service = Running::new();
    let mut to_do = vec!["/".to_owned()];
    let mut seen = Vec::new();
    while let Some(path) = to_do.pop() {
        if seen.contains(&path) {
            continue;
        }
        let reply = service.get(&path);
        if path.ends_with("/visible") {
            reply.problem(400); // it needs a camera
        } else if path.ends_with("/stream") {
            reply.problem(426); // it needs a WebSocket
        } else {
            assert_eq!(reply.status, 200, "{path}");
        }
        if reply.header("content-type") == Some("application/json") {
            links(&reply.json(), &mut to_do);
        }
        seen.push(path);
    }
    assert!(seen.len() > 15, "{seen:?}");
}

fn links(document: &Value, found: &mut Vec<String>) {
    match document {
        Value::Object(members) => {
            if let Some(href) = members.get("href") {
                found.push(href.as_str().unwrap().to_owned());
            }
            members.values().for_each(|value| links(value, found));
        }
        Value::Array(items) => items.iter().for_each(|item| links(item, found)),
        _ => {}
    }
}

#[test]
fn the_page_shows_every_scene_and_links_only_to_what_there_is() {
    let service = Running::new();
    let page = String::from_utf8(service.get("/about").body).unwrap();
    assert!(page.contains("3,000"), "objects of demo");
    assert!(page.contains("odd ö"));
    assert!(page.contains("curl -s http://localhost/collections/demo/visible"));
    assert!(!page.contains("{{"), "a place left unfilled");
    for attribute in ["href=\"", "src=\""] {
        for rest in page.split(attribute).skip(1) {
            let target = rest.split('"').next().unwrap();
            match target.strip_prefix('#') {
                Some(id) => assert!(page.contains(&format!("id=\"{id}\"")), "{target}"),
                None => assert_eq!(service.get(target).status, 200, "{target}"),
            }
        }
    }
}

#[test]
fn compressed_answers_say_the_same() {
    let service = Running::new();
    let plain = service.get("/collections/demo/plan.svg");
    let gzip = [("Accept-Encoding", "gzip")];
    let packed = service.send("GET", "/collections/demo/plan.svg", &gzip, b"");
    assert_eq!(plain.header("content-encoding"), None);
    assert_eq!(packed.header("content-encoding"), Some("gzip"));
    assert!(packed.body.len() < plain.body.len());
    let mut text = Vec::new();
    let mut reader = flate2::read::GzDecoder::new(&packed.body[..]);
    std::io::Read::read_to_end(&mut reader, &mut text).unwrap();
    assert_eq!(text, plain.body);
    let refused = [("Accept-Encoding", "gzip;q=0")];
    let reply = service.send("GET", "/collections/demo/plan.svg", &refused, b"");
    assert_eq!(reply.header("content-encoding"), None);
    let tiny = service.send("GET", "/nowhere", &gzip, b"");
    tiny.problem(404);
    assert_eq!(tiny.header("content-encoding"), None);
}

#[test]
fn pages_of_other_origins_may_ask() {
    let service = Running::new();
    let preflight = service.send(
        "OPTIONS",
        "/collections/demo/visible",
        &[
            ("Origin", "https://viewer.example"),
            ("Access-Control-Request-Method", "POST"),
            ("Access-Control-Request-Headers", "content-type"),
        ],
        b"",
    );
    assert_eq!(preflight.status, 204);
    assert_eq!(preflight.header("access-control-allow-origin"), Some("*"));
    assert!(
        preflight
            .header("access-control-allow-methods")
            .unwrap()
            .contains("POST")
    );
    assert!(
        preflight
            .header("access-control-allow-headers")
            .unwrap()
            .contains("content-type")
    );
    let origin = [("Origin", "https://viewer.example")];
    for path in ["/collections", "/nowhere"] {
        let reply = service.send("GET", path, &origin, b"");
        assert_eq!(
            reply.header("access-control-allow-origin"),
            Some("*"),
            "{path}"
        );
    }
}

#[test]
fn head_is_get_without_the_body() {
    let service = Running::new();
    let get = service.get("/collections/demo");
    let head = service.send("HEAD", "/collections/demo", &[], b"");
    assert_eq!((head.status, head.body.len()), (200, 0));
    assert_eq!(head.header("content-length"), get.header("content-length"));
}
