//! What the controller remembers.

use serde::{Deserialize, Serialize};

/// Longer frames are no frames: a debugger, a laptop's lid.
pub(super) const LONGEST_FRAME_MS: f64 = 3_600_000.0;

/// One frame that was drawn: what it took, and what it was drawn with. Whatever the delay between
/// choosing a `far_dist` and measuring its frame, the two belong together here.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sample {
    /// Frame time, ms.
    pub frame_ms: f64,
    /// The `far_dist` that this frame was drawn with, m.
    pub far_dist_m: f64,
}

impl Sample {
    /// Whether it can be a frame: both numbers finite and above 0, and less than an hour.
    pub fn is_usable(&self) -> bool {
        let Self {
            frame_ms,
            far_dist_m,
        } = *self;
        frame_ms > 0.0 && frame_ms < LONGEST_FRAME_MS && far_dist_m > 0.0 && far_dist_m.is_finite()
    }
}

/// All that the controller knows between frames. Any values whatever are safe to step from: what
/// cannot be is not used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// The `far_dist` chosen last, m.
    pub(super) far_dist_m: f64,
    /// Samples that could not be frames.
    pub(super) ignored: u32,
}

impl State {
    /// Begins at a `far_dist`, m, knowing nothing.
    pub fn starting_at(far_dist_m: f64) -> Self {
        Self {
            far_dist_m,
            ignored: 0,
        }
    }

    /// The `far_dist` chosen last, m; what it started at before the first step.
    pub fn far_dist(&self) -> f64 {
        self.far_dist_m
    }

    /// How many samples were ignored because they cannot be frames ([`Sample::is_usable`]).
    pub fn ignored(&self) -> u32 {
        self.ignored
    }
}
