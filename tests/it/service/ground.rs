use citylod::geom::{DVec3, DepthRange, Orientation, Projection, View};
use citylod::scene::{Effects, Occlusion, Terrain};
use citylod::service::{Config, SceneError, Scenes};
use citylod::terrain::{Criterion, Detail, Node, Patch, Workers, select_within};
use serde_json::{Value, json};

use super::server::{Reply, Running};
use super::stream_client::Client;
use crate::land::{city, land, ridge};
use crate::terrain::patches::{drawn, sorted};

/// Coarse enough that much is left out.
const DECLARED: Terrain = Terrain {
    criterion: citylod::scene::Criterion::Error,
    max_error_px: 2.0,
    max_triangles: 20_000,
    ground: None,
};

fn declared() -> Effects {
    Effects {
        terrain: Some(DECLARED),
        occlusion: Some(Occlusion {
            width_px: 256,
            min_pixels: 1,
        }),
        ..Effects::default()
    }
}

fn service(folder: &std::path::Path) -> Running {
    let mut scenes = Scenes::new();
    let land = land(&ridge(), folder);
    scenes
        .insert_on("hills", city(declared()), Some(land))
        .unwrap();
    scenes.insert("plain", city(Effects::default())).unwrap();
    Running::of(scenes, Config::default(), |app| app)
}

const EYE: [f64; 3] = [0.0, -400.0, 20.0];
const TARGET: [f64; 3] = [0.0, 0.0, 30.0];

fn ask(service: &Running, scene: &str, effects: &Value) -> Reply {
    let body = json!({
        "camera": { "eye": EYE, "target": TARGET, "viewport": [1280, 720] },
        "lod": { "far_dist_m": null },
        "effects": effects,
    });
    service.visible(scene, &body.to_string())
}

const QUERY: &str = "visible?eye=0,-400,20&target=0,0,30&viewport=1280x720&far_dist_m=null";

fn terrain(reply: &Reply) -> Value {
    assert_eq!(reply.status, 200, "{:?}", reply.json());
    reply.json()["effects"]["terrain"].clone()
}

fn patches(list: &Value) -> Vec<Patch> {
    let list: Vec<(u32, u32, u32, Vec<u32>)> = serde_json::from_value(list.clone()).unwrap();
    let patch = |(level, x, y, fans)| Patch {
        tile: Node { level, x, y },
        fans,
    };
    list.into_iter().map(patch).collect()
}

#[test]
fn the_ground_comes_with_the_objects_unless_it_is_switched_off() {
    let folder = tempfile::tempdir().unwrap();
    let service = service(folder.path());
    let on = terrain(&ask(&service, "hills", &json!({})));
    assert!(on["patches"].as_u64() > Some(0) && on["triangles"].as_u64() > Some(100));
    assert!(on["error_px"].as_f64().unwrap() <= 2.0 && on["took_us"].as_f64().unwrap() >= 0.0);
    assert!(on["list"].is_null());
    let by_query = service.get(&format!("/collections/hills/{QUERY}"));
    assert_eq!(terrain(&by_query)["triangles"], on["triangles"]);
    let off = ask(
        &service,
        "hills",
        &json!({ "terrain": false, "occlusion": false }),
    );
    assert_eq!(off.json()["effects"], json!({}));
    let without = format!("/collections/hills/{QUERY}&without=terrain,occlusion");
    assert_eq!(service.get(&without).json()["ids"], off.json()["ids"]);
    let plain = ask(&service, "plain", &json!({ "terrain": false }));
    assert_eq!(plain.json()["ids"], off.json()["ids"]);
}

/// The houses behind the ridge are hidden by it, the tower looks over.
#[test]
fn the_ground_hides_objects_where_occlusion_is_declared_too() {
    let folder = tempfile::tempdir().unwrap();
    let service = service(folder.path());
    let seen = |effects: Value| -> Vec<String> {
        let ids = ask(&service, "hills", &effects).json()["ids"].clone();
        let mut ids: Vec<String> = serde_json::from_value(ids).unwrap();
        ids.sort();
        ids
    };
    let hidden = seen(json!({}));
    assert!(hidden.iter().any(|id| id == "tower"), "{hidden:?}");
    assert!(
        hidden.iter().any(|id| id.starts_with("south")),
        "{hidden:?}"
    );
    assert!(
        !hidden.iter().any(|id| id.starts_with("north")),
        "{hidden:?}"
    );
    let level = seen(json!({ "terrain": false }));
    assert!(level.iter().any(|id| id.starts_with("north")), "{level:?}");
    let counted = ask(
        &service,
        "hills",
        &json!({ "occlusion": { "visible_pixels": true } }),
    );
    let pixels = counted.json()["effects"]["occlusion"]["visible_pixels"].clone();
    assert_eq!(pixels.as_array().unwrap().len(), hidden.len());
}

/// Patches and tiles, as they come over HTTP, are what the library selects for the same view.
#[test]
fn patches_with_their_tiles_are_the_ground_of_the_view() {
    let folder = tempfile::tempdir().unwrap();
    let service = service(folder.path());
    let field = ridge();
    let land = land(&field, folder.path());
    let told = service.get("/collections/hills").json();
    let ground = &told["ground"];
    let tiling = land.pyramid().tiling();
    assert_eq!(ground["posts"], json!([101, 101]));
    assert_eq!(ground["origin"], json!([-500.0, -500.0]));
    assert_eq!(ground["spacing"], json!([10.0, 10.0]));
    assert_eq!(ground["block_levels"], tiling.layout().levels());
    assert_eq!(ground["tile_levels"], tiling.tile_levels());
    assert_eq!(ground["finest"], tiling.finest());
    assert_eq!(ground["blocks"], json!([1, 1]));
    assert!(service.get("/collections/plain").json()["ground"].is_null());
    let mut counts = Vec::new();
    for (settings, px, most) in [
        (json!({ "patches": true }), 2.0, 20_000),
        (json!({ "patches": true, "max_error_px": 9 }), 9.0, 20_000),
        (json!({ "patches": true, "max_triangles": 200 }), 2.0, 200),
        (
            json!({ "patches": true, "criterion": "vertex" }),
            2.0,
            20_000,
        ),
    ] {
        let criterion = match settings["criterion"].as_str() {
            Some("vertex") => Criterion::Vertex,
            _ => Criterion::Error,
        };
        let answered = terrain(&ask(&service, "hills", &json!({ "terrain": settings })));
        let patches = patches(&answered["list"]);
        for Patch { tile, .. } in &patches {
            let Node { level, x, y } = tile;
            let bytes = service
                .get(&format!("/collections/hills/ground/{level}/{x}/{y}"))
                .body;
            let heights = bytes.as_chunks().0.iter().map(|&b| f32::from_le_bytes(b));
            let heights: Vec<f32> = heights.collect();
            assert_eq!(heights, land.pyramid().tile(*tile).unwrap().heights);
        }
        let made = drawn(land.pyramid(), &patches);
        assert_eq!(answered["triangles"], made.len());
        assert_eq!(answered["patches"], patches.len());
        assert!(made.len() <= most);
        let view = View::new(
            EYE.into(),
            Orientation::LookAt {
                target: TARGET.into(),
                up: DVec3::Z,
            },
            Projection::Perspective { fov_y_deg: 60.0 },
            DepthRange::default(),
            [1280, 720],
        )
        .unwrap();
        let per_radian = 720.0 / 2.0 / 30.0_f64.to_radians().tan();
        let usual = Detail::of(criterion);
        let detail = Detail {
            knobs: criterion.share(&usual.knobs, per_radian / px / 1024.0),
            max_triangles: Some(most),
            ..usual
        };
        let wanted = select_within(land.ground(), &view, &detail, px, Workers::One).unwrap();
        let wanted = wanted.patches(land.ground(), tiling.tile_levels());
        assert_eq!(sorted(made.clone()), sorted(drawn(land.pyramid(), &wanted)));
        counts.push(made.len());
    }
    assert!(counts[0] > counts[1] && counts[0] > counts[2], "{counts:?}");
}

#[test]
fn tiles_may_be_kept_while_the_scene_is_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let service = service(folder.path());
    let tile = "/collections/hills/ground/0/0/0";
    let plain = service.get(tile);
    assert_eq!(
        plain.header("content-type"),
        Some("application/octet-stream")
    );
    assert_eq!(plain.header("cache-control"), Some("no-cache"));
    let etag = plain.header("etag").unwrap().to_owned();
    let known = service.send("GET", tile, &[("If-None-Match", &etag)], b"");
    assert_eq!((known.status, known.body.len()), (304, 0));
    let revision = plain.header("x-citylod-revision").unwrap().to_owned();
    assert_eq!(
        service.get("/collections/hills").json()["revision"],
        revision.as_str()
    );
    let pinned = service.get(&format!("{tile}?revision={revision}"));
    assert_eq!(pinned.body, plain.body);
    assert!(
        pinned
            .header("cache-control")
            .unwrap()
            .contains("immutable")
    );
    let stale = service.get(&format!("{tile}?revision=1-0-0"));
    assert_eq!(stale.problem(409)["pointer"], "revision");
}

#[test]
fn tiles_that_there_are_not_are_refused_with_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let service = service(folder.path());
    for (path, status, pointer) in [
        ("plain/ground/0/0/0", 404, Some("scene")),
        ("nowhere/ground/0/0/0", 404, Some("scene")),
        ("hills/ground/9/0/0", 404, Some("level")),
        ("hills/ground/1/2/0", 404, Some("x")),
        ("hills/ground/1/0/2", 404, Some("y")),
        ("hills/ground/4294967295/0/0", 404, Some("level")),
        ("hills/ground/-1/0/0", 404, Some("level")),
        ("hills/ground/0/1.5/0", 404, Some("x")),
        ("hills/ground/0/0/99999999999", 404, Some("y")),
        ("hills/ground/a/0/0", 404, Some("level")),
        ("%ff/ground/0/0/0", 404, Some("scene")),
        ("hills/ground/0/0", 404, None),
        ("hills/ground/0/0/0?size=1", 400, Some("size")),
        (
            "hills/ground/0/0/0?revision=1&revision=1",
            400,
            Some("revision"),
        ),
    ] {
        let problem = service.get(&format!("/collections/{path}")).problem(status);
        assert_eq!(problem["pointer"].as_str(), pointer, "{path}: {problem}");
    }
    for (path, detail) in [
        (
            "1.5/0/0",
            "level must be a whole number from 0 to 4294967295, and is the text \"1.5\"",
        ),
        (
            "0/-1/0",
            "x must be a whole number from 0 to 4294967295, and is the text \"-1\"",
        ),
        (
            "0/0/%20",
            "y must be a whole number from 0 to 4294967295, and is the text \" \"",
        ),
    ] {
        let problem = service
            .get(&format!("/collections/hills/ground/{path}"))
            .problem(404);
        assert_eq!(problem["detail"], detail);
    }
    let problem = service.get("/collections/%ff").problem(404);
    assert_eq!(
        problem["detail"],
        "scene has bytes that are no UTF-8, percent-decoded"
    );
}

#[test]
fn settings_that_cannot_be_are_refused_with_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let service = service(folder.path());
    for (scene, settings, status, pointer) in [
        ("plain", json!(true), 422, "/effects/terrain"),
        ("plain", json!({}), 422, "/effects/terrain"),
        (
            "hills",
            json!({ "max_error_px": 1 }),
            422,
            "/effects/terrain/max_error_px",
        ),
        (
            "hills",
            json!({ "max_error_px": 0 }),
            422,
            "/effects/terrain/max_error_px",
        ),
        (
            "hills",
            json!({ "max_triangles": 0 }),
            422,
            "/effects/terrain/max_triangles",
        ),
        (
            "hills",
            json!({ "max_triangles": 20_001 }),
            422,
            "/effects/terrain/max_triangles",
        ),
        (
            "hills",
            json!({ "max_triangles": 1.5 }),
            400,
            "/effects/terrain/max_triangles",
        ),
        (
            "hills",
            json!({ "criterion": "best" }),
            400,
            "/effects/terrain/criterion",
        ),
        (
            "hills",
            json!({ "patches": 1 }),
            400,
            "/effects/terrain/patches",
        ),
        (
            "hills",
            json!({ "tiles": true }),
            400,
            "/effects/terrain/tiles",
        ),
        ("hills", json!(null), 400, "/effects/terrain"),
    ] {
        let reply = ask(&service, scene, &json!({ "terrain": settings }));
        assert_eq!(reply.problem(status)["pointer"], pointer, "{settings}");
    }
    for (query, status, pointer) in [
        ("ground_error_px=1", 422, "ground_error_px"),
        ("ground_error_px=x", 400, "ground_error_px"),
        ("max_triangles=0", 422, "max_triangles"),
        ("criterion=best", 400, "criterion"),
        ("patches=1", 400, "patches"),
        ("without=terrain&patches=true", 422, "patches"),
    ] {
        let reply = service.get(&format!("/collections/hills/{QUERY}&{query}"));
        assert_eq!(reply.problem(status)["pointer"], pointer, "{query}");
    }
}

#[test]
fn patches_go_with_an_answer_that_has_room_for_them() {
    let folder = tempfile::tempdir().unwrap();
    let service = service(folder.path());
    let binary = service.send(
        "GET",
        &format!("/collections/hills/{QUERY}&patches=true"),
        &[("Accept", "application/octet-stream")],
        b"",
    );
    assert_eq!(binary.problem(422)["pointer"], "patches");
    let mut client = Client::open(&service, "hills");
    client.send_text(
        &json!({ "seq": 1, "camera": { "eye": EYE, "target": TARGET },
                 "effects": { "terrain": { "patches": true } } })
        .to_string(),
    );
    let refused = client.receive();
    assert_eq!(refused["problem"]["pointer"], "/effects/terrain/patches");
    client.send_text(&json!({ "seq": 2, "camera": { "eye": EYE, "target": TARGET } }).to_string());
    let answer = client.receive();
    assert!(
        answer["effects"]["terrain"]["triangles"].as_u64() > Some(0),
        "{answer}"
    );
}

#[test]
fn a_scene_that_declares_terrain_has_to_have_it() {
    let mut scenes = Scenes::new();
    let refused = scenes.insert("hills", city(declared()));
    let name = "hills".to_owned();
    assert_eq!(refused, Err(SceneError::Groundless { name }));
}
