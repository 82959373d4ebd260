//! Reading a request body up to the limit.

use axum::body::{Body, Bytes};
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
    match Limited::new(body, limit).collect().await {
        Ok(collected) => Ok(collected.to_bytes()),
        Err(error) if error.is::<LengthLimitError>() => Err(too_large(limit)),
        Err(error) => {
            let detail = format!("the body broke off: {error}");
            Err(Problem::new(Kind::MalformedJson, detail))
        }
    }
}

fn too_large(limit: usize) -> Problem {
    let detail = format!("the body may have {limit} bytes (option --max-body-bytes)");
    Problem::new(Kind::TooLarge, detail)
}
