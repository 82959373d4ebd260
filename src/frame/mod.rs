//! One frame: a view and knobs → what to draw; and from the time that it takes, the knobs of the
//! next ([`Feedback`]).
//!
//! knobs → motion → view → haze → [`lod::select`](crate::lod::select) → haze → terrain →
//! occlusion → [`Frame::selection`]. An effect that is not active is a branch not taken.
//!
//! Reads no clock: durations come in through an argument.

mod active;
mod feedback;
mod overview;
mod sights;
mod work_out;

pub use active::{Active, Culling, Effects, Ran};
pub use feedback::Feedback;
pub use overview::{GroundAt, Overview, densest};
pub use work_out::Frame;
