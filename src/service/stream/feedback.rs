//! What the client says of the frame it drew last, and the `far_dist` of the next.

use serde::Deserialize;

use super::super::json::given;
use super::super::problem::Problem;
use super::super::visible::Naming;
use crate::control::{Params, Sample, State, step};
use crate::lod::{Lod, RangeLod};

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
    /// 422 for knobs without `far_dist`, a target that cannot be, and half a sample.
    pub fn steer(&self, knobs: &Lod, state: Option<State>) -> Result<(State, f64), Problem> {
        let problem = |member, detail: String| Naming::Pointer.problem("feedback", member, detail);
        let Lod::Range(range) = knobs else {
            let detail = "goes with mode \"range\": the controller chooses far_dist_m";
            return Err(problem("target_ms", detail.to_owned()));
        };
        let [least, most] = Params::USUAL_FAR_DIST_M;
        let params = Params::new(self.target_ms, least, most)
            .map_err(|error| problem(error.field, error.reason))?;
        let sample = match (self.frame_ms, self.far_dist_m) {
            (None, None) => None,
            (Some(frame_ms), Some(far_dist_m)) => Some(Sample {
                frame_ms,
                far_dist_m,
            }),
            (Some(_), None) => {
                let detail = "missing: the far_dist_m that the frame was drawn with";
                return Err(problem("far_dist_m", detail.to_owned()));
            }
            (None, Some(_)) => {
                let detail = "missing: what the frame took, ms";
                return Err(problem("frame_ms", detail.to_owned()));
            }
        };
        let state = state.unwrap_or_else(|| State::starting_at(range.far_dist()));
        Ok(step(&params, state, sample))
    }
}

/// The knobs with the `far_dist` that the controller chose, m, above 0 and finite.
pub fn steered(knobs: &Lod, far_dist: f64) -> Lod {
    let Lod::Range(range) = knobs else {
        return *knobs;
    };
    let (factor, levels) = (range.dist_factor(), range.level_count());
    RangeLod::new(far_dist, factor, levels, range.beyond()).map_or(*knobs, Lod::Range)
}
