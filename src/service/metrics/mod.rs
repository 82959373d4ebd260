//! What the service counts, and `/metrics`, where Prometheus reads it.
//!
//! Plain atomics in arrays of known size: counting takes no lock and looks nothing up in a map,
//! since every request pays for it.

mod count;
mod counted;
mod document;
mod process;
mod requests;
mod text;

pub use count::Counter;
pub use counted::{Metrics, StreamMetrics};
pub use document::get;
