//! How a box lies to the frustum of a view, decided in exact arithmetic: the oracle that
//! production code is held against. Shares no code with it.
//!
//! All that enters is f64, so rational. What is irrational about a frustum are lengths of
//! directions and the tangent of half the opening angle; each comes in as one factor κ of a
//! half-space, enclosed between two dyadic numbers. The frustum with the upper bounds put in
//! contains the given one, the frustum with the lower bounds lies in it. Where the two answers
//! differ the enclosure is made closer. What is still open at [`LAST_BITS`] bits touches the
//! frustum within that, and is called [`Answer::Open`].
//!
//! Most boxes are nowhere near a border and are decided in f64 intervals first
//! ([`Oracle::meets`]); [`Oracle::meets_exactly`] never uses these.

mod camera;
mod dyadic;
mod feasible;
mod interval;
mod oracle;
mod quick;
mod real;

pub use camera::Camera;
pub use dyadic::Dyadic;
pub use oracle::{Answer, LAST_BITS, Oracle, compare_distance, compare_farthest};
pub use real::Enclosure;
