//! `/collections/{scene}/stream`: a WebSocket that tells what comes and what goes as the camera
//! moves.
//!
//! message → [`message`] → [`session`] (what was said and sent) → [`answer`]; [`connection`]
//! carries both ways, [`window`] holds answers back that the client has no room for, [`turn`]
//! those that take long to work out. A stream takes a place among streams, not one among
//! connections or requests in work.

mod answer;
mod connection;
mod end;
mod feedback;
mod message;
mod session;
mod turn;
mod window;

use std::sync::Arc;

use axum::body::Body;
use axum::extract::{FromRequestParts, Request, State};
use axum::response::Response;
use tokio_tungstenite::tungstenite::handshake::server::create_response_with_body;
use tracing::Instrument;

pub use end::Ended;

use super::problem::{Kind, Problem};
use super::request_id::REQUEST_ID;
use super::routes::SceneName;
use super::shared::Shared;

/// `GET`: becomes a WebSocket, or says why not.
pub async fn get(State(shared): State<Arc<Shared>>, request: Request) -> Result<Response, Problem> {
    let (mut parts, _) = request.into_parts();
    let SceneName(name) = SceneName::from_request_parts(&mut parts, &shared).await?;
    let city = shared.city(&name)?;
    let mut request = Request::from_parts(parts, Body::empty());
    let accepted = create_response_with_body(&request, Body::empty);
    let mut response = accepted.map_err(|error| {
        let detail = format!("this is a WebSocket (RFC 6455, version 13): {error}");
        Problem::new(Kind::UpgradeRequired, detail)
    })?;
    let place = shared.streams().try_take().ok_or_else(|| {
        let most = shared.streams().most();
        let detail = format!("{most} streams are open: try again later (option --max-streams)");
        Problem::new(Kind::Overloaded, detail)
    })?;
    let id = shared.request_ids().of(request.headers());
    let span = tracing::info_span!(
        "stream",
        request_id = id.to_str().unwrap_or_default(),
        scene = name
    );
    response.headers_mut().insert(REQUEST_ID, id);
    let upgrade = hyper::upgrade::on(&mut request);
    let streaming = async move {
        match upgrade.await {
            Ok(upgraded) => connection::serve(upgraded, &shared, city).await,
            Err(error) => tracing::debug!(%error, "no stream came of it"),
        }
        drop(place);
    };
    tokio::spawn(streaming.instrument(span));
    Ok(response)
}
