//! The one integration test binary: a module per subject.

/// The sources keep the layer table and the house rules.
mod tidy;
