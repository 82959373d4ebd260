//! What holds a frame time: ours, and what people use today. All see the same samples.

use crate::control::{Params, Sample, State, step};

/// The controllers that are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rule {
    /// [`crate::control`].
    Ours,
    /// Two per cent less detail on overrun, two per cent more below 90 % of the target, as `CesiumJS`
    /// does to its screen-space error on memory (`Cesium3DTileset`: times or over 1.02 a frame, at
    /// rest between two limits), here on the frame time.
    Factor,
    /// One class of detail down while frames are too slow and one up while they are fast, as
    /// viewers such as xeokit do on frame rate; classes a factor of 1.5 apart in `far_dist`.
    Classes,
}

impl Rule {
    pub(super) const ALL: [Self; 3] = [Self::Ours, Self::Factor, Self::Classes];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Ours => "citylod",
            Self::Factor => "factor 1.02",
            Self::Classes => "classes",
        }
    }
}

const FACTOR: f64 = 1.02;
/// Below this part of the target there is room for more.
const ROOM: f64 = 0.9;
const CLASS: f64 = 1.5;

/// A rule at work.
#[derive(Debug, Clone, Copy)]
pub(super) struct Controller {
    rule: Rule,
    params: Params,
    state: State,
    far_dist: f64,
}

impl Controller {
    pub(super) fn new(rule: Rule, params: Params, start: f64) -> Self {
        Self {
            rule,
            params,
            state: State::starting_at(start),
            far_dist: start,
        }
    }

    /// The next `far_dist`, m.
    pub(super) fn next(&mut self, sample: Option<Sample>) -> f64 {
        let by = |factor: f64| match sample {
            Some(sample) if sample.frame_ms > self.params.target_ms() => 1.0 / factor,
            Some(sample) if sample.frame_ms < ROOM * self.params.target_ms() => factor,
            _ => 1.0,
        };
        let far_dist = match self.rule {
            Rule::Ours => {
                let (state, far_dist) = step(&self.params, self.state, sample);
                self.state = state;
                far_dist
            }
            Rule::Factor => self.far_dist * by(FACTOR),
            Rule::Classes => self.far_dist * by(CLASS),
        };
        let (least, most) = (self.params.min_far_dist(), self.params.max_far_dist());
        self.far_dist = far_dist.max(least).min(most);
        self.far_dist
    }
}
