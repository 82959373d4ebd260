//! Motion: the faster the camera, the less detail the eye can follow.
//!
//! Source: paper C (transmission-line corridors), evaluation function f = D(z)/(C1·C2·L·r·v): the
//! distance L up to which a piece of the scene is drawn in full falls with the speed v. Here v is
//! in units of the declared reference speed and never below 1, so that a slow camera and one
//! that stands still see the same.

use crate::scene;

/// Beyond this nothing but the coarsest is left of any city, and no knob overflows.
const SLOWEST: f64 = 1e6;

/// How many times shorter the distance of full detail becomes at `speed_mps` (m/s, ≥ 0); 1 up to
/// the reference speed, at most a million.
pub fn slowdown(declared: &scene::Motion, speed_mps: f64) -> f64 {
    (speed_mps / declared.reference_speed_mps).clamp(1.0, SLOWEST)
}
