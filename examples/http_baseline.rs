//! How much an answer costs beyond its bytes: the service with one more route, `/baseline`, which
//! returns the same bytes from memory behind the same limits.
//!
//! ```text
//! cargo run --release --example http_baseline [OBJECTS] &
//! cat > target/post.lua <<'END'
//! wrk.method = "POST"
//! wrk.headers["Content-Type"] = "application/json"
//! wrk.body = io.open("target/http_baseline.json"):read("*a")
//! END
//! wrk -t1 -c16 -d5 -s target/post.lua http://127.0.0.1:8099/baseline
//! wrk -t1 -c16 -d5 -s target/post.lua http://127.0.0.1:8099/collections/demo/visible
//! oha -c 16 -z 5s -m POST -D target/http_baseline.json -H 'Content-Type: application/json' \
//!     http://127.0.0.1:8099/baseline
//! ```
//!
//! The request, printed and written to `target/http_baseline.json`, has the far distance
//! that makes 1,000 objects visible, or as near to it as can be. Alternate the two and compare
//! medians: neighbours on the machine disturb both alike. The client shares the cores, so the
//! ratio depends on it: the less it takes for itself, the more of a request is the service's.

use std::sync::Arc;

use anyhow::{Context, Result};
use axum::body::Bytes;
use axum::http::header::CONTENT_TYPE;
use axum::routing::post;
use citylod::geom::{DVec3, DepthRange, Orientation, Projection, View};
use citylod::index::{self, LodTree, Promotion};
use citylod::lod::{Beyond, RangeLod, Selection, retrieve};
use citylod::scene::{CityParams, generate};
use citylod::service::{Config, Scenes, Server, Shared, router, stop_signal};

const VISIBLE: u32 = 1_000;
const EYE: DVec3 = DVec3::new(0.0, -1500.0, 400.0);

#[tokio::main]
async fn main() -> Result<()> {
    let objects = match std::env::args().nth(1) {
        Some(text) => text.parse().context("OBJECTS must be a number")?,
        None => 23_951,
    };
    let tree = index::build(
        &generate(&CityParams { objects, seed: 1 }),
        Promotion::Tallest,
    )?;
    let (far_dist, count) = far_dist_for(&tree)?;
    let request = format!(
        r#"{{"camera":{{"eye":[{},{},{}],"target":[0,0,0]}},"lod":{{"far_dist_m":{far_dist}}}}}"#,
        EYE.x, EYE.y, EYE.z
    );
    let mut scenes = Scenes::new();
    scenes.insert("demo", tree)?;
    let config = Config {
        listen: ([127, 0, 0, 1], 8099).into(),
        ..Config::default()
    };
    let shared = Shared::new(scenes, &config);
    let app = router(Arc::clone(&shared));
    let answer = ask(app.clone(), &request).await?;
    eprintln!("{count} objects visible, {} bytes\n{request}", answer.len());
    std::fs::write("target/http_baseline.json", &request)?;
    let from_memory = move |_body: Bytes| {
        let answer = answer.clone();
        async move { ([(CONTENT_TYPE, "application/json")], answer) }
    };
    let app = app.route("/baseline", post(from_memory));
    let server = Server::bind(shared, app).await?;
    eprintln!("http://{}", server.address());
    server.run(stop_signal()).await;
    Ok(())
}

/// The far distance at which the number of visible objects comes nearest to [`VISIBLE`].
fn far_dist_for(tree: &LodTree) -> Result<(f64, u32)> {
    let view = View::new(
        EYE,
        Orientation::LookAt {
            target: DVec3::ZERO,
            up: DVec3::Z,
        },
        Projection::Perspective { fov_y_deg: 60.0 },
        DepthRange::default(),
        [1920, 1080],
    )?;
    let mut selection = Selection::default();
    let mut best = (0.0, 0_u32);
    let (mut low, mut high) = (0.0, 10_000.0);
    for _ in 0..60 {
        let far_dist = 0.5 * (low + high);
        let lod = RangeLod::new(far_dist, 2.5, 4, Beyond::Show)?;
        retrieve(tree, &view, &lod, &mut selection);
        let count = selection.count();
        if count.abs_diff(VISIBLE) < best.1.abs_diff(VISIBLE) {
            best = (far_dist, count);
        }
        if count > VISIBLE {
            high = far_dist;
        } else {
            low = far_dist;
        }
    }
    Ok(best)
}

/// The answer of the service itself.
async fn ask(app: axum::Router, request: &str) -> Result<Bytes> {
    use tower::ServiceExt;
    let request = axum::http::Request::post("/collections/demo/visible")
        .header(CONTENT_TYPE, "application/json")
        .body(axum::body::Body::from(request.to_owned()))?;
    let response = app.oneshot(request).await?;
    Ok(axum::body::to_bytes(response.into_body(), usize::MAX).await?)
}
