//! The one integration test binary: a module per subject.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that fails may panic"
)]
#![allow(missing_docs, reason = "tests are not an interface")]

/// The paper's seven steps, transcribed set by set.
mod oracle;
/// Retrieval against the transcription and against brute force.
mod retrieval;
/// The HTTP service: answers, refusals, limits, description.
mod service;
/// Random scenes and cameras.
mod support;
/// The sources keep the layer table and the house rules.
mod tidy;
