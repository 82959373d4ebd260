//! What every request passes: the limits on number and time, panics, compression, other origins,
//! counters and the log.
//!
//! One type instead of a stack of layers, so that what a request does not need costs a branch.

use std::any::Any;
use std::future::{Future, poll_fn};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::pin;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use axum::Router;
use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, Method, Uri, header};
use axum::response::{IntoResponse, Response};
use tower::ServiceExt;
use tower_http::CompressionLevel;
use tower_http::compression::Compression;
use tower_http::compression::predicate::SizeAbove;

use super::cors;
use super::problem::{Kind, Problem};
use super::request_id::{self, REQUEST_ID};
use super::shared::Shared;

/// Shorter bodies fit a packet as they are, bytes.
const WORTH_COMPRESSING: u64 = 1024;

/// A router behind its limits.
#[derive(Clone)]
pub struct Gate {
    router: Router,
    compressed: Compression<Router, SizeAbove>,
    in_work: Arc<AtomicUsize>,
    max_concurrency: usize,
    timeout: Duration,
    shared: Arc<Shared>,
}

impl Gate {
    /// Puts the router behind the limits of the configuration.
    pub fn new(router: Router, shared: Arc<Shared>) -> Self {
        let config = *shared.config();
        Self {
            compressed: Compression::new(router.clone())
                .quality(CompressionLevel::Fastest)
                .compress_when(SizeAbove::new(WORTH_COMPRESSING)),
            router,
            in_work: Arc::default(),
            max_concurrency: config.max_concurrency,
            timeout: config.timeout,
            shared,
        }
    }

    /// Answers a request, whatever happens; counts it, and names and logs it where that is of use.
    pub async fn respond(&self, request: Request) -> Response {
        let start = Instant::now();
        let asked = Asked::of(&request);
        let mut response = self.answer(request, &asked).await;
        let (status, took) = (response.status(), start.elapsed());
        let metrics = self.shared.metrics();
        metrics.requests.count(asked.uri.path(), status, took);
        if asked.id.get().is_some()
            || status.as_u16() >= 400
            || tracing::enabled!(tracing::Level::DEBUG)
        {
            self.log(&asked, &mut response, took);
        }
        response
    }

    /// Names the answer and tells of it: defects always, refusals by default, all the others
    /// where the log is to be verbose.
    #[cold]
    fn log(&self, asked: &Asked, response: &mut Response, took: Duration) {
        let id = match response.headers().get(REQUEST_ID) {
            Some(id) => id.clone(), // a stream has its own name already
            None => asked.id(&self.shared).clone(),
        };
        let (method, path) = (&asked.method, asked.uri.path());
        let (status, took_us) = (response.status().as_u16(), took.as_micros() as u64);
        let request_id = id.to_str().unwrap_or_default();
        let reason = response.extensions().get().map(Problem::reason);
        match status {
            500 => {
                tracing::error!(request_id, %method, path, status, reason, took_us, "request failed");
            }
            400.. => {
                tracing::info!(request_id, %method, path, status, reason, took_us, "request refused");
            }
            _ => tracing::debug!(request_id, %method, path, status, took_us, "request"),
        }
        response.headers_mut().insert(REQUEST_ID, id);
    }

    async fn answer(&self, request: Request, asked: &Asked) -> Response {
        if cors::is_preflight(&request) {
            return cors::preflight();
        }
        let foreign = request.headers().contains_key(header::ORIGIN);
        let negotiable = request.method() == Method::GET || request.method() == Method::HEAD;
        let mut response = self.limited(request, asked).await;
        if foreign {
            cors::allow(response.headers_mut());
        }
        if negotiable {
            let vary = HeaderValue::from_static("accept, accept-encoding");
            response.headers_mut().insert(header::VARY, vary);
        }
        response
    }

    async fn limited(&self, request: Request, asked: &Asked) -> Response {
        let Some(_place) = Place::take(&self.in_work, self.max_concurrency) else {
            let detail = "try again in a second (option --max-concurrency)";
            return Problem::new(Kind::Overloaded, detail).into_response();
        };
        let work = unpanicked(self.routed(request));
        match tokio::time::timeout(self.timeout, work).await {
            Ok(Ok(response)) => response,
            Ok(Err(panic)) => {
                let request_id = asked.id(&self.shared).to_str().unwrap_or_default();
                tracing::error!(request_id, reason = reason(&*panic), "a handler panicked");
                let detail = "this is a defect: please report what you asked for";
                Problem::new(Kind::Internal, detail).into_response()
            }
            Err(_) => {
                let seconds = self.timeout.as_secs_f64();
                let detail = format!("no answer within {seconds} s (option --timeout-ms)");
                Problem::new(Kind::Timeout, detail).into_response()
            }
        }
    }

    async fn routed(&self, request: Request) -> Response {
        if takes_gzip(request.headers()) {
            match self.compressed.clone().oneshot(request).await {
                Ok(response) => response.map(Body::new),
                Err(never) => match never {},
            }
        } else {
            match self.router.clone().oneshot(request).await {
                Ok(response) => response,
                Err(never) => match never {},
            }
        }
    }
}

/// What is known of a request once it is answered.
struct Asked {
    method: Method,
    uri: Uri,
    /// The client's name for it, or ours once it is needed.
    id: OnceLock<HeaderValue>,
}

impl Asked {
    fn of(request: &Request) -> Self {
        let id = OnceLock::new();
        if let Some(given) = request_id::given(request.headers()) {
            id.get_or_init(|| given.clone());
        }
        Self {
            method: request.method().clone(),
            uri: request.uri().clone(),
            id,
        }
    }

    fn id(&self, shared: &Shared) -> &HeaderValue {
        self.id.get_or_init(|| shared.request_ids().new_one())
    }
}

/// Whether it is worth asking the compression layer, which reads the header properly.
fn takes_gzip(headers: &HeaderMap) -> bool {
    headers
        .get_all(header::ACCEPT_ENCODING)
        .iter()
        .any(|value| {
            let bytes = value.as_bytes();
            memchr::memmem::find(bytes, b"gzip").is_some() || bytes.contains(&b'*')
        })
}

/// One of the requests in work, until it is dropped.
struct Place<'a>(&'a AtomicUsize);

impl<'a> Place<'a> {
    fn take(in_work: &'a AtomicUsize, most: usize) -> Option<Self> {
        let place = Self(in_work);
        (in_work.fetch_add(1, Ordering::Relaxed) < most).then_some(place)
    }
}

impl Drop for Place<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Turns a panic into an error. What the handlers share is read-only, so no half-made state can
/// be seen afterwards.
async fn unpanicked<F: Future>(work: F) -> Result<F::Output, Box<dyn Any + Send>> {
    let mut work = pin!(work);
    poll_fn(
        |cx| match catch_unwind(AssertUnwindSafe(|| work.as_mut().poll(cx))) {
            Ok(poll) => poll.map(Ok),
            Err(panic) => std::task::Poll::Ready(Err(panic)),
        },
    )
    .await
}

fn reason(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("of unknown kind")
}
