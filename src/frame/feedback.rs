//! The loop from the time of a frame to the detail of the next: closed here and nowhere else.

use crate::control::{Params, Sample, State, step};
use crate::lod::RangeLod;

/// What is known before a frame of those already drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feedback {
    /// The frame time to hold, and the range of `far_dist`.
    pub params: Params,
    /// What the controller remembers: [`State::starting_at`] before the first frame, what
    /// [`Feedback::steer`] gave after it.
    pub state: State,
    /// The newest frame whose time is known, with the `far_dist` that [`Feedback::steer`] gave it;
    /// what motion takes off that is a load like any other. `None` where none is known yet.
    pub sample: Option<Sample>,
}

impl Feedback {
    /// The knobs of the next frame, and what to remember: `lod` with its `far_dist` replaced.
    pub fn steer(self, lod: RangeLod) -> (RangeLod, State) {
        let (state, far_dist) = step(&self.params, self.state, self.sample);
        (lod.with_far_dist(far_dist), state)
    }
}
