use std::time::Duration;

use citylod::geom::DVec3;
use citylod::index::{self, LodTree, Promotion};
use citylod::scene::{CityParams, Effects, generate};
use citylod::service::{Config, Scenes};
use serde_json::{Value, json};

use super::server::{Reply, Running};
use crate::support::look;

pub const DECLARED: &str = r#"{"motion":{"reference_speed_mps":2},"haze":{"visibility_m":700},
    "occlusion":{"width_px":256}}"#;

pub fn city(declared: &str) -> LodTree {
    let mut scene = generate(&CityParams {
        objects: 3_000,
        seed: 1,
    });
    scene.effects = Effects::from_json(declared).unwrap();
    index::build(&scene, Promotion::Tallest).unwrap()
}

fn service() -> Running {
    let mut scenes = Scenes::new();
    scenes.insert("weather", city(DECLARED)).unwrap();
    scenes.insert("clear", city("{}")).unwrap();
    Running::of(scenes, Config::default(), |app| app)
}

fn ask(service: &Running, scene: &str, effects: &Value) -> Reply {
    let body = json!({
        "camera": { "eye": [0, -800, 60], "target": [0, 0, 0] },
        "lod": { "far_dist_m": null },
        "effects": effects,
    });
    service.visible(scene, &body.to_string())
}

const QUERY: &str = "visible?eye=0,-800,60&target=0,0,0&far_dist_m=null";

fn ids(reply: &Reply) -> Vec<String> {
    assert_eq!(reply.status, 200, "{:?}", reply.json());
    serde_json::from_value(reply.json()["ids"].clone()).unwrap()
}

#[test]
fn what_is_declared_runs_unless_it_is_switched_off() {
    let service = service();
    let on = ask(&service, "weather", &json!({}));
    let ran = on.json()["effects"].clone();
    assert_eq!(ran["motion"]["slowdown"], 1.0);
    assert!(ran["haze"]["removed"].is_u64());
    assert!(ran["occlusion"]["removed"].as_u64().unwrap() > 0);
    assert_eq!(ran["occlusion"]["width_px"], 256);
    assert_eq!(ran["occlusion"]["height_px"], 144);
    for effect in ["motion", "haze", "occlusion"] {
        assert!(ran[effect]["took_us"].as_f64().unwrap() >= 0.0);
    }
    let off = json!({"motion": false, "haze": false, "occlusion": false});
    let off = ask(&service, "weather", &off);
    assert_eq!(off.json()["effects"], json!({}));
    let clear = ask(&service, "clear", &json!({}));
    assert_eq!(clear.json()["effects"], json!({}));
    assert_eq!(ids(&off), ids(&clear));
    assert!(ids(&on).len() < ids(&off).len());
    // To switch off what is not there changes nothing.
    let same = ask(&service, "clear", &json!({"haze": false}));
    assert_eq!(ids(&same), ids(&clear));
    // A client can find out what there is.
    let known = service.get("/collections/weather").json()["effects"].clone();
    assert_eq!(known["haze"]["visibility_m"], 700.0);
    assert_eq!(
        service.get("/collections/clear").json()["effects"],
        json!({})
    );
    // By query too.
    let get = service.get(&format!(
        "/collections/weather/{QUERY}&without=motion,haze,occlusion"
    ));
    assert_eq!(ids(&get), ids(&off));
}

#[test]
fn haze_leaves_what_is_near() {
    let service = service();
    let only = json!({"motion": false, "haze": true, "occlusion": false});
    let hazy = ids(&ask(&service, "weather", &only));
    let tree = city(DECLARED);
    let eye = DVec3::new(0.0, -800.0, 60.0);
    let within = |id: &String| {
        let bounds = tree.bounds_of(tree.find(id).unwrap()).unwrap();
        bounds.distance(eye) <= 700.0
    };
    let mut wanted = ids(&ask(&service, "clear", &json!({})));
    wanted.retain(within);
    assert_eq!(hazy, wanted);
    assert!(!hazy.is_empty());
}

#[test]
fn motion_takes_detail_and_the_answer_says_what_is_left() {
    let service = service();
    let reply = service.visible(
        "weather",
        r#"{"camera":{"eye":[0,-800,60],"target":[0,0,0]},"lod":{"far_dist_m":400},
            "effects":{"motion":{"speed_mps":8},"haze":false,"occlusion":false}}"#,
    );
    assert_eq!(reply.json()["effects"]["motion"]["slowdown"], 4.0);
    assert_eq!(reply.json()["lod"]["far_dist_m"], 100.0);
    let get = service.get(
        "/collections/weather/visible?eye=0,-800,60&target=0,0,0&far_dist_m=400&speed_mps=8\
         &without=haze,occlusion",
    );
    assert_eq!(ids(&get), ids(&reply));
}

#[test]
fn pixels_are_those_of_the_listed_objects() {
    let service = service();
    let asked = json!({"haze": false, "occlusion": {
        "width_px": 128, "min_pixels": 3, "visible_pixels": true
    }});
    let reply = ask(&service, "weather", &asked);
    let occlusion = reply.json()["effects"]["occlusion"].clone();
    assert_eq!(
        (&occlusion["width_px"], &occlusion["height_px"]),
        (&json!(128), &json!(72))
    );
    let pixels: Vec<u32> = serde_json::from_value(occlusion["visible_pixels"].clone()).unwrap();
    assert_eq!(pixels.len(), ids(&reply).len());
    assert!(pixels.iter().all(|&p| p >= 3));
    // Of an object that nothing hides, as many as its outline has.
    let tree = city(DECLARED);
    let view = look(DVec3::new(0.0, -800.0, 60.0), DVec3::ZERO);
    let scale = 128.0 / 1920.0;
    for (id, pixels) in ids(&reply).iter().zip(&pixels) {
        let bounds = tree.bounds_of(tree.find(id).unwrap()).unwrap();
        // A disc about the box covers it; pixels that it cuts may count.
        let diameter = view.size_px(&bounds) * scale + 2.0;
        assert!(f64::from(*pixels) <= diameter * diameter, "{id}: {pixels}");
    }
}

#[test]
fn occlusion_that_takes_too_long_is_refused() {
    let hasty = || {
        let mut scenes = Scenes::new();
        scenes.insert("weather", city(DECLARED)).unwrap();
        let config = Config {
            max_occlusion: Duration::ZERO,
            ..Config::default()
        };
        Running::of(scenes, config, |app| app)
    };
    let service = hasty();
    let reply = ask(&service, "weather", &json!({}));
    assert_eq!(reply.status, 422, "{:?}", reply.json());
    let problem = reply.json();
    assert_eq!(problem["type"], "/#too-costly");
    let detail = problem["detail"].as_str().unwrap();
    assert!(detail.contains("--max-occlusion-ms"), "{detail}");
    let off = ask(&service, "weather", &json!({"occlusion": false}));
    assert_eq!(off.status, 200);
}

#[test]
fn what_cannot_be_asked_for_is_named() {
    let service = service();
    let undeclared = "does not declare";
    for (scene, effects, status, place, words) in [
        (
            "clear",
            json!({"haze": true}),
            422,
            "/effects/haze",
            undeclared,
        ),
        (
            "clear",
            json!({"motion": {"speed_mps": 3}}),
            422,
            "/effects/motion",
            undeclared,
        ),
        (
            "weather",
            json!({"rain": {}}),
            422,
            "/effects/rain",
            undeclared,
        ),
        (
            "weather",
            json!({"haze": 3}),
            400,
            "/effects/haze",
            "true, false or an object",
        ),
        (
            "weather",
            json!({"haze": {"fog": 1}}),
            400,
            "/effects/haze/fog",
            "effects.haze has no member fog",
        ),
        (
            "weather",
            json!({"motion": {"speed_mps": -1}}),
            422,
            "/effects/motion/speed_mps",
            "0 or more",
        ),
        (
            "weather",
            json!({"occlusion": {"width_px": 9}}),
            422,
            "/effects/occlusion/width_px",
            "16 to 4096",
        ),
        (
            "weather",
            json!({"occlusion": {"width_px": 257}}),
            422,
            "/effects/occlusion/width_px",
            "at most 256",
        ),
        (
            "weather",
            json!({"occlusion": {"min_pixels": 0}}),
            422,
            "/effects/occlusion/min_pixels",
            "at least 1",
        ),
    ] {
        let reply = ask(&service, scene, &effects);
        assert_eq!(reply.status, status, "{effects}: {:?}", reply.json());
        let problem = reply.json();
        assert_eq!(problem["pointer"], place, "{effects}");
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.contains(words), "{effects}: {detail}");
    }
    for (query, place) in [
        ("speed_mps=-1", "speed_mps"),
        ("speed_mps=fast", "speed_mps"),
        ("width_px=9", "width_px"),
        ("min_pixels=0", "min_pixels"),
        ("visible_pixels=yes", "visible_pixels"),
        ("without=rain", "without"),
        ("width_px=64&without=occlusion", "without"),
        ("without=occlusion&width_px=64", "width_px"),
        ("visible_pixels=true&form=ranges", "visible_pixels"),
    ] {
        let reply = service.get(&format!("/collections/weather/{QUERY}&{query}"));
        assert!((400..500).contains(&reply.status), "{query}");
        let problem = reply.json();
        let named = [&problem["pointer"], &problem["parameter"]];
        assert!(named.contains(&&json!(place)), "{query}: {problem}");
    }
}

/// As no other part of a query is at fault.
#[test]
fn what_is_not_declared_is_refused_by_the_parameter() {
    let service = service();
    for (query, place) in [
        ("speed_mps=3", "speed_mps"),
        ("width_px=64", "width_px"),
        ("min_pixels=2", "min_pixels"),
        ("visible_pixels=true", "visible_pixels"),
        ("visible_pixels=true&width_px=64", "width_px"),
    ] {
        let reply = service.get(&format!("/collections/clear/{QUERY}&{query}"));
        assert_eq!(reply.status, 422, "{query}");
        let problem = reply.json();
        assert_eq!(problem["pointer"], place, "{query}");
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.contains("does not declare"), "{query}: {detail}");
    }
    // Two declare nothing and something; one asks for what nobody declares.
    for (scene, effects, told) in [
        (
            "clear",
            json!({"haze": true}),
            "\"haze\", nor any other; leave haze out, or declare it with --effects",
        ),
        (
            "weather",
            json!({"terrain": true}),
            "\"terrain\", only motion, haze, occlusion; leave terrain out, or lay its ground",
        ),
        (
            "weather",
            json!({"rain": true}),
            "there is no such effect, only motion, haze, occlusion, terrain",
        ),
    ] {
        let problem = ask(&service, scene, &effects).json();
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.contains(told), "{detail}");
    }
    let same = service.get(&format!("/collections/clear/{QUERY}&without=haze"));
    assert_eq!(same.status, 200);
}
