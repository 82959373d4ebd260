//! Names by which a request is found in the log: the client's own, or one of ours.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use axum::http::{HeaderMap, HeaderName, HeaderValue};

/// Carries the name, both ways.
pub const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Longer names, or ones that cannot be printed, are not taken over, bytes.
const LONGEST: usize = 128;

/// Where names come from.
#[derive(Debug)]
pub struct RequestIds {
    /// Tells one run of the service from the next: when it began, µs.
    run: u64,
    next: AtomicU64,
}

impl Default for RequestIds {
    fn default() -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        Self {
            run: since.map_or(0, |since| since.as_micros() as u64),
            next: AtomicU64::new(1),
        }
    }
}

impl RequestIds {
    /// The name that the client gave, or a new one.
    pub fn of(&self, headers: &HeaderMap) -> HeaderValue {
        given(headers).cloned().unwrap_or_else(|| self.new_one())
    }

    /// A new one.
    pub fn new_one(&self) -> HeaderValue {
        let number = self.next.fetch_add(1, Ordering::Relaxed);
        let text = format!("{:x}-{number}", self.run);
        // Digits and a dash: always a header value.
        HeaderValue::try_from(text).unwrap_or_else(|_| HeaderValue::from(number))
    }
}

/// The name that the client gave, if it can be taken over.
pub fn given(headers: &HeaderMap) -> Option<&HeaderValue> {
    let value = headers.get(REQUEST_ID)?;
    let printable = value.as_bytes().iter().all(u8::is_ascii_graphic);
    (printable && (1..=LONGEST).contains(&value.len())).then_some(value)
}
