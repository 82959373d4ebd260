//! The way in: `/`, `/about`, `/api`, `/conformance`, `/health`.

use std::sync::Arc;

use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use super::documents::{Link, json};
use super::negotiate::accepted;
use super::page::Viewer;
use super::problem::Problem;
use super::shared::Shared;
use super::{OPENAPI, page, viewer};

/// What OGC API documents call an `OpenAPI` description.
const OPENAPI_YAML: &str = "application/vnd.oai.openapi";

#[derive(Serialize)]
struct Landing<'a> {
    title: &'static str,
    description: &'static str,
    links: [Link<'a>; 6],
}

/// `GET /`: the viewer for browsers, a document for programs.
pub async fn landing(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    if accepted(&headers, &["application/json", "text/html"])? == "text/html" {
        let viewer = viewer::page(&headers);
        return Ok(viewer.unwrap_or_else(|| page(&shared, &headers, Viewer::Missing)));
    }
    Ok(json(&Landing {
        title: "citylod",
        description: "Which objects of a 3D city to draw for a camera, at what detail, and how wrong the answer is.",
        links: [
            Link::json("self", "/", "this document"),
            Link::new("alternate", "/", "text/html", "the scenes to fly through"),
            Link::new(
                "service-doc",
                "/about",
                "text/html",
                "the service explained",
            ),
            Link::new("service-desc", "/api", OPENAPI_YAML, "the API"),
            Link::json("conformance", "/conformance", "what it conforms to"),
            Link::json("data", "/collections", "the scenes"),
        ],
    }))
}

/// `GET /about`: the page that explains the service.
pub async fn about(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    accepted(&headers, &["text/html"])?;
    let there = viewer::page(&headers).map_or(Viewer::Missing, |_| Viewer::There);
    Ok(page(&shared, &headers, there))
}

fn page(shared: &Shared, headers: &HeaderMap, viewer: Viewer) -> Response {
    let host = headers.get(header::HOST).and_then(|h| h.to_str().ok());
    let html = HeaderValue::from_static("text/html; charset=utf-8");
    let page = page::render(&shared.scenes(), host.unwrap_or("127.0.0.1:8080"), viewer);
    ([(header::CONTENT_TYPE, html)], page).into_response()
}

/// `GET /api`.
pub async fn api(headers: HeaderMap) -> Result<Response, Problem> {
    let chosen = accepted(
        &headers,
        &[OPENAPI_YAML, "application/yaml", "text/yaml", "text/plain"],
    )?;
    let media_type = HeaderValue::from_static(chosen);
    Ok(([(header::CONTENT_TYPE, media_type)], OPENAPI).into_response())
}

#[derive(Serialize)]
struct Conformance {
    #[serde(rename = "conformsTo")]
    conforms_to: [&'static str; 4],
}

/// `GET /conformance`.
pub async fn conformance(headers: HeaderMap) -> Result<Response, Problem> {
    accepted(&headers, &["application/json"])?;
    Ok(json(&Conformance {
        conforms_to: [
            "http://www.opengis.net/spec/ogcapi-common-1/1.0/conf/core",
            "http://www.opengis.net/spec/ogcapi-common-1/1.0/conf/landing-page",
            "http://www.opengis.net/spec/ogcapi-common-1/1.0/conf/json",
            "http://www.opengis.net/spec/ogcapi-common-2/1.0/conf/collections",
        ],
    }))
}

#[derive(Serialize)]
struct Health {
    status: &'static str,
    version: &'static str,
    scenes: usize,
}

/// `GET /health`.
pub async fn health(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    accepted(&headers, &["application/json"])?;
    Ok(json(&Health {
        status: "ok",
        version: env!("CARGO_PKG_VERSION"),
        scenes: shared.scenes().len(),
    }))
}
