//! Reading a request body up to the limit.

use axum::BoxError;
use axum::body::{Body, Bytes, HttpBody as _};
use axum::http::{HeaderMap, header};
use http_body_util::{BodyExt, LengthLimitError, Limited};

use super::problem::{Kind, Problem};

/// The whole body.
///
/// # Errors
/// 413 when it is longer than `limit` bytes, or says so; 400 when it breaks off.
pub async fn read(headers: &HeaderMap, body: Body, limit: usize) -> Result<Bytes, Problem> {
    let announced = headers
        .get(header::CONTENT_LENGTH)
        .and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    if announced.is_some_and(|length| length > limit as u64) {
        return Err(too_large(limit));
    }
    let mut body = Limited::new(body, limit);
    let refused = |error: BoxError| {
        if error.is::<LengthLimitError>() {
            return too_large(limit);
        }
        let detail = format!("the body broke off: {error}");
        Problem::new(Kind::MalformedJson, detail)
    };
    let first = match body.frame().await {
        None => return Ok(Bytes::new()),
        Some(frame) => frame.map_err(refused)?.into_data().unwrap_or_default(),
    };
    // A request fits a packet, so this is mostly all of it.
    if body.is_end_stream() {
        return Ok(first);
    }
    let rest = body.collect().await.map_err(refused)?.to_bytes();
    Ok([first, rest].concat().into())
}

fn too_large(limit: usize) -> Problem {
    let detail = format!("the body may have {limit} bytes (option --max-body-bytes)");
    Problem::new(Kind::TooLarge, detail)
}
