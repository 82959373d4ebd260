//! The HTTP service: which objects of which city to draw for a camera, over the wire.
//!
//! request → gate (limits) → [`ROUTES`] → handler → answer or problem document.
//! Stateless but for the cities, which are replaced whole, and for streams, each of which knows
//! what it has sent.
//!
//! Knows nothing of the command line or of experiments.

mod body;
mod boxes;
mod collections;
mod config;
mod cors;
mod documents;
mod gate;
mod ground;
mod items;
mod json;
mod landing;
mod metrics;
mod negotiate;
mod overwritten;
mod page;
mod patience;
mod places;
mod plain;
mod plan;
mod problem;
mod reload;
mod request_id;
mod routes;
mod scenes;
mod server;
mod shared;
mod signals;
mod span;
mod stream;
mod viewer;
mod visible;

use std::fmt::Write as _;
use std::net::SocketAddr;
use std::pin::pin;
use std::sync::Arc;

use tokio::sync::Notify;

pub use config::Config;
pub use reload::ReadError;
pub use routes::{ROUTES, Route, Verb, router};
pub use scenes::{City, SceneError, Scenes};
pub use server::{ListenError, Server};
pub use shared::Shared;
pub use signals::stop_signal;
pub use visible::{Lists, Tail};

use signals::{HangUp, HangUps};

/// The description of the API, as served at `/api`.
pub const OPENAPI: &str = include_str!("../../openapi.yaml");

/// Serves the cities until the process is told to stop. `ready` gets what to tell the user once
/// requests are taken: address, cities, a command to try. On SIGHUP, what `reread` returns is
/// served instead, at once for requests; streams begin anew with it.
///
/// # Errors
/// [`ListenError`] when the address cannot be had.
pub async fn serve(
    config: Config,
    scenes: Scenes,
    reread: impl Fn() -> Result<Scenes, ReadError> + Send + Sync + 'static,
    ready: impl FnOnce(&str),
) -> Result<(), ListenError> {
    let cities = Greeting::of(&scenes);
    let shared = Shared::new(scenes, &config);
    let server = Server::bind(Arc::clone(&shared), router(Arc::clone(&shared))).await?;
    let mut hang_ups = HangUps::listen();
    ready(&cities.text(server.address()));
    let reread_now = Arc::new(Notify::new());
    let watching = tokio::spawn(overwritten::watch(Arc::clone(&shared)));
    let reloading = tokio::spawn(reload::reload_when(Arc::clone(&reread_now), shared, reread));
    let told_to_stop = async {
        let mut stop = pin!(stop_signal());
        loop {
            tokio::select! {
                () = &mut stop => break,
                hang_up = hang_ups.next() => match hang_up {
                    HangUp::Reload => reread_now.notify_one(),
                    HangUp::TerminalClosed => break,
                },
            }
        }
    };
    server.run(told_to_stop).await;
    reloading.abort();
    watching.abort();
    Ok(())
}

/// What to tell the user; taken before the router takes the cities.
struct Greeting {
    cities: Vec<(String, u32)>,
    example: Option<(String, String)>,
}

impl Greeting {
    fn of(scenes: &Scenes) -> Self {
        Self {
            cities: scenes
                .iter()
                .map(|city| (city.name().to_owned(), city.tree().object_count()))
                .collect(),
            example: scenes
                .iter()
                .next()
                .map(|city| (city.path(), city.example_request())),
        }
    }

    fn text(&self, address: SocketAddr) -> String {
        let mut text = format!("citylod listens on http://{address}\n");
        for (name, objects) in &self.cities {
            let _ = writeln!(text, "  {name}: {} objects", page::grouped(*objects));
        }
        if let Some((path, request)) = &self.example {
            let _ = writeln!(
                text,
                "try\n  {}",
                curl(&format!("http://{address}"), path, request)
            );
        }
        text
    }
}

/// A command that asks for what a camera sees. Nothing in it needs quoting: addresses are
/// percent-encoded, the body is numbers.
fn curl(base: &str, path: &str, request: &str) -> String {
    format!("curl -s {base}{path}/visible -H 'Content-Type: application/json' -d '{request}'")
}
