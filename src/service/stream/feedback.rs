//! What the client says of the frame it drew last, and the `far_dist` of the next.

use serde::Deserialize;

use super::super::json::given;
use super::super::problem::Problem;
use super::super::visible::{self, Naming};
use crate::control::State;
use crate::lod::Lod;

/// The member `feedback` of a message. The controller's state stays with the stream.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feedback {
    /// The frame time to hold, ms.
    pub target_ms: f64,
    /// What the last frame took, ms.
    #[serde(default, deserialize_with = "given")]
    pub frame_ms: Option<f64>,
    /// The `far_dist` that it was drawn with, m.
    #[serde(default, deserialize_with = "given")]
    pub far_dist_m: Option<f64>,
}

impl Feedback {
    /// The controller's next step, from `state` or, where there is none yet, from the `far_dist`
    /// of the knobs.
    ///
    /// # Errors
    /// As [`visible::Feedback::steer`].
    pub fn steer(&self, knobs: &Lod, state: Option<&State>) -> Result<(State, f64), Problem> {
        let feedback = visible::Feedback {
            target_ms: self.target_ms,
            frame_ms: self.frame_ms,
            far_dist_m: self.far_dist_m,
            state: state.copied(),
            ..visible::Feedback::default()
        };
        let (_, steered) = feedback.steer(knobs, Naming::Pointer)?;
        Ok((steered.state, steered.far_dist_m))
    }
}

/// The knobs with the `far_dist` that the controller chose, m.
pub fn steered(knobs: &Lod, far_dist: f64) -> Lod {
    match knobs {
        Lod::Range(range) => Lod::Range(range.with_far_dist(far_dist)),
        _ => *knobs,
    }
}
