//! Which form of an answer the client can read (RFC 9110, section 12.5.1).

use axum::http::{HeaderMap, header};

use super::problem::{Kind, Problem};

/// A form that can be given, e.g. `application/json`.
pub type MediaType = &'static str;

/// The one of `offered` that the client likes best; the first where it likes several the same.
///
/// # Errors
/// 406 when it accepts none of them.
pub fn accepted(headers: &HeaderMap, offered: &[MediaType]) -> Result<MediaType, Problem> {
    let mut best: Option<(MediaType, f32)> = None;
    let mut values = headers.get_all(header::ACCEPT).iter().peekable();
    if values.peek().is_none() {
        return Ok(offered.first().copied().unwrap_or_default());
    }
    let text: Vec<&str> = values.filter_map(|value| value.to_str().ok()).collect();
    for &media_type in offered {
        let quality = quality(&text, media_type);
        if quality > best.map_or(0.0, |(_, quality)| quality) {
            best = Some((media_type, quality));
        }
    }
    best.map(|(media_type, _)| media_type).ok_or_else(|| {
        let detail = format!("this is given as {}", offered.join(" or "));
        Problem::new(Kind::NotAcceptable, detail).at("Accept")
    })
}

/// Whether the client takes a body that was compressed beforehand.
pub fn takes_gzip(headers: &HeaderMap) -> bool {
    let values = headers.get_all(header::ACCEPT_ENCODING).iter();
    let text: Vec<&str> = values.filter_map(|value| value.to_str().ok()).collect();
    quality(&text, "gzip") > 0.0
}

/// Quality by the most specific range that matches; 0 when none does.
fn quality(accept: &[&str], media_type: &str) -> f32 {
    let mut found = (0, 0.0);
    for range in accept.iter().flat_map(|value| value.split(',')) {
        let mut parts = range.split(';').map(str::trim);
        let name = parts.next().unwrap_or_default();
        let specificity = match name.split_once('/') {
            _ if name.eq_ignore_ascii_case(media_type) => 3,
            Some(("*", "*")) => 1,
            Some((family, "*"))
                if media_type
                    .split_once('/')
                    .is_some_and(|(of, _)| of.eq_ignore_ascii_case(family)) =>
            {
                2
            }
            _ => continue,
        };
        let quality = parts
            .find_map(|p| p.strip_prefix("q=").or_else(|| p.strip_prefix("Q=")))
            .map_or(1.0, |q| q.parse().unwrap_or(0.0));
        if specificity > found.0 {
            found = (specificity, quality);
        }
    }
    found.1
}

/// Refuses a body that says it is something else than JSON. One that says nothing is taken for
/// JSON.
///
/// # Errors
/// 415.
pub fn json_body(headers: &HeaderMap) -> Result<(), Problem> {
    let Some(value) = headers.get(header::CONTENT_TYPE) else {
        return Ok(());
    };
    let name = value.to_str().unwrap_or_default();
    let name = name.split(';').next().unwrap_or_default().trim();
    if name.eq_ignore_ascii_case("application/json") {
        return Ok(());
    }
    let detail = format!("Content-Type must be application/json, is {name:?}");
    Err(Problem::new(Kind::UnsupportedMediaType, detail).at("Content-Type"))
}
