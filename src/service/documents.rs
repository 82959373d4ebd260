//! Shared by all documents: links, JSON bodies, revalidation.

use std::borrow::Cow;

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::Response;
use serde::Serialize;

/// A link as OGC API Common has it.
#[derive(Debug, Serialize)]
pub struct Link<'a> {
    rel: &'static str,
    href: Cow<'a, str>,
    r#type: &'static str,
    title: &'static str,
}

impl<'a> Link<'a> {
    /// To something of any type.
    pub fn new(
        rel: &'static str,
        href: impl Into<Cow<'a, str>>,
        r#type: &'static str,
        title: &'static str,
    ) -> Self {
        Self {
            rel,
            href: href.into(),
            r#type,
            title,
        }
    }

    /// To a JSON document.
    pub fn json(rel: &'static str, href: impl Into<Cow<'a, str>>, title: &'static str) -> Self {
        Self::new(rel, href, "application/json", title)
    }
}

/// A JSON body.
pub fn json(document: &impl Serialize) -> Response {
    let mut response = Response::new(Body::from(serde_json::to_vec(document).unwrap_or_default()));
    let json = HeaderValue::from_static("application/json");
    response.headers_mut().insert(header::CONTENT_TYPE, json);
    response
}

/// Answers of fewer bytes are made in less time than it takes to hand them to another thread.
const LARGE: usize = 1 << 19;

/// Makes something of about so many bytes. What takes long is kept from holding up the requests
/// that share the thread.
pub fn make<T>(bytes: usize, work: impl FnOnce() -> T) -> T {
    use tokio::runtime::{Handle, RuntimeFlavor::MultiThread};
    // Elsewhere there is no other thread that could take over.
    let moves = |handle: Handle| handle.runtime_flavor() == MultiThread;
    if bytes >= LARGE && Handle::try_current().is_ok_and(moves) {
        tokio::task::block_in_place(work)
    } else {
        work()
    }
}

/// 304 where the client has this version already; otherwise the document, to be revalidated.
pub fn cached(
    headers: &HeaderMap,
    etag: &HeaderValue,
    make: impl FnOnce() -> Response,
) -> Response {
    let made: Result<_, std::convert::Infallible> = try_cached(headers, etag, || Ok(make()));
    made.unwrap_or_else(|never| match never {})
}

/// As [`cached`], of a document that may fail to be made.
///
/// # Errors
/// What `make` says.
pub fn try_cached<E>(
    headers: &HeaderMap,
    etag: &HeaderValue,
    make: impl FnOnce() -> Result<Response, E>,
) -> Result<Response, E> {
    let mut response = if is_known(headers, etag) {
        let mut response = Response::new(Body::empty());
        *response.status_mut() = StatusCode::NOT_MODIFIED;
        response
    } else {
        make()?
    };
    let headers = response.headers_mut();
    headers.insert(header::ETAG, etag.clone());
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    Ok(response)
}

/// `If-None-Match` (RFC 9110, section 13.1.2): weak comparison.
fn is_known(headers: &HeaderMap, etag: &HeaderValue) -> bool {
    let known = headers.get_all(header::IF_NONE_MATCH);
    known
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .map(str::trim)
        .any(|tag| tag == "*" || opaque(tag.as_bytes()) == opaque(etag.as_bytes()))
}

/// A tag without the mark that it is weak.
fn opaque(tag: &[u8]) -> &[u8] {
    tag.strip_prefix(b"W/").unwrap_or(tag)
}
