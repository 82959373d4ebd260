//! What the JSON formats share: values split off a stream, numbers out of nested arrays, places.

mod arrays;
mod split;

use std::fmt::Write as _;

pub(super) use arrays::{Arrays, Token};
pub(super) use split::{Next, Splitter};

/// `base` followed by one more step, escaped as RFC 6901 asks.
pub(super) fn pointer(base: &str, step: impl std::fmt::Display) -> String {
    let mut pointer = base.to_owned();
    let _ = write!(pointer, "/{step}");
    if pointer[base.len() + 1..].contains(['~', '/']) {
        let escaped = pointer[base.len() + 1..]
            .replace('~', "~0")
            .replace('/', "~1");
        pointer.truncate(base.len() + 1);
        pointer.push_str(&escaped);
    }
    pointer
}

/// What `serde_json` says, without the place that it counts from the start of the value.
pub(super) fn reason(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.rfind(" at line ") {
        Some(end) => text[..end].to_owned(),
        None => text,
    }
}
