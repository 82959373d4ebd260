//! `/collections/{scene}/boxes`: the geometry a viewer needs once, in bulk.

use std::ops::Range;
use std::sync::Arc;

use axum::body::Body;
use axum::extract::{RawQuery, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::Response;

use super::documents::{cached, make};
use super::negotiate::accepted;
use super::problem::Problem;
use super::routes::SceneName;
use super::shared::Shared;
use super::span::Span;
use crate::index::LodTree;

/// Most boxes in one answer: 24 MB.
pub const MOST_BOXES: u32 = 1_000_000;

/// Length of a box, bytes.
const BOX: usize = 24;

/// Header: what the coordinates are relative to, `x,y,z` in scene coordinates.
pub const ORIGIN: HeaderName = HeaderName::from_static("x-citylod-origin");

/// `GET`: boxes `start .. end`, six f32 each (min x, y, z, max x, y, z), little endian, rounded
/// outward, relative to the origin.
pub async fn boxes(
    State(shared): State<Arc<Shared>>,
    SceneName(name): SceneName,
    RawQuery(query): RawQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let city = shared.city(&name)?;
    accepted(&headers, &["application/octet-stream"])?;
    let span = Span::read(&city, &query.unwrap_or_default(), MOST_BOXES)?;
    let mut response = cached(&headers, city.etag(), || {
        let range = span.range.clone();
        let body = make(range.len() * BOX, || encode(city.tree(), range));
        let mut response = Response::new(Body::from(body));
        let binary = HeaderValue::from_static("application/octet-stream");
        response.headers_mut().insert(header::CONTENT_TYPE, binary);
        response
    });
    span.describe(&city, &mut response);
    let [x, y, z] = city.tree().origin().to_array();
    if let Ok(origin) = HeaderValue::try_from(format!("{x},{y},{z}")) {
        response.headers_mut().insert(ORIGIN, origin);
    }
    Ok(response)
}

fn encode(tree: &LodTree, range: Range<u32>) -> Vec<u8> {
    let mut out = Vec::with_capacity(range.len() * BOX);
    for corners in range.filter_map(|object| tree.relative_box(object)) {
        for corner in corners {
            out.extend_from_slice(&corner.to_le_bytes());
        }
    }
    out
}
