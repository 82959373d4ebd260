//! The viewer: the files that `npm run build` left in `viewer/dist` when this was compiled. Without
//! Node.js there are none, and `/` shows the page about the service instead.

use axum::body::Body;
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::Response;
use rust_embed::{Embed, EmbeddedFile};

use super::documents::cached;
use super::negotiate::{accepted, takes_gzip};
use super::problem::{Kind, Problem};
use super::routes::FileName;

#[derive(Embed)]
#[folder = "viewer/dist"]
#[allow_missing = true]
struct Dist;

/// What the page may do: run what this service serves, and ask this service.
const POLICY: &str = "default-src 'self'; connect-src 'self' ws: wss:; img-src 'self' data:; \
                      object-src 'none'; base-uri 'none'";

/// The page; `None` in a build without it.
pub fn page(headers: &HeaderMap) -> Option<Response> {
    let file = Dist::get("index.html")?;
    let mut response = cached(headers, &etag(&file), || {
        of_type("text/html; charset=utf-8", &file)
    });
    let policy = HeaderValue::from_static(POLICY);
    let name = HeaderName::from_static("content-security-policy");
    response.headers_mut().insert(name, policy);
    Some(response)
}

/// `GET /assets/{file}`. The name of a file changes with its contents, so it may be kept for ever.
/// Large ones were compressed when the viewer was built, better than there is time for here.
pub async fn asset(FileName(name): FileName, headers: HeaderMap) -> Result<Response, Problem> {
    let Some(file) = Dist::get(&format!("assets/{name}")) else {
        let detail = format!("the viewer has no part {name:?}: GET / names those it has");
        return Err(Problem::new(Kind::NotFound, detail).at("file"));
    };
    let media_type = media_type(&name);
    accepted(&headers, &[media_type])?;
    let packed = takes_gzip(&headers).then(|| Dist::get(&format!("assets/{name}.gz")));
    let packed = packed.flatten();
    let mut response = cached(&headers, &etag(&file), || {
        let mut response = of_type(media_type, packed.as_ref().unwrap_or(&file));
        if packed.is_some() {
            let gzip = HeaderValue::from_static("gzip");
            response
                .headers_mut()
                .insert(header::CONTENT_ENCODING, gzip);
        }
        response
    });
    let forever = HeaderValue::from_static("public, max-age=31536000, immutable");
    response
        .headers_mut()
        .insert(header::CACHE_CONTROL, forever);
    Ok(response)
}

fn of_type(media_type: &'static str, file: &EmbeddedFile) -> Response {
    let body = match &file.data {
        std::borrow::Cow::Borrowed(bytes) => Body::from(*bytes),
        std::borrow::Cow::Owned(bytes) => Body::from(bytes.clone()),
    };
    let mut response = Response::new(body);
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(media_type));
    // A file is what it is said to be, or nothing.
    headers.insert(
        header::X_CONTENT_TYPE_OPTIONS,
        HeaderValue::from_static("nosniff"),
    );
    response
}

/// Weak, as files are sent compressed or not.
fn etag(file: &EmbeddedFile) -> HeaderValue {
    let [a, b, c, d, e, f, g, h, ..] = file.metadata.sha256_hash();
    let start = u64::from_be_bytes([a, b, c, d, e, f, g, h]);
    let etag = HeaderValue::try_from(format!("W/\"{start:016x}\""));
    etag.unwrap_or_else(|_| HeaderValue::from_static("W/\"0\""))
}

fn media_type(name: &str) -> &'static str {
    match name.rsplit('.').next() {
        Some("js") => "text/javascript",
        Some("css") => "text/css",
        Some("woff2") => "font/woff2",
        Some("md") => "text/markdown",
        _ => "application/octet-stream",
    }
}
