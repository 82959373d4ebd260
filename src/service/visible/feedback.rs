//! What a request says of the frame drawn last, and what the answer says of the next.

use serde::{Deserialize, Deserializer, Serialize};

use super::super::json::{given, object};
use super::super::problem::Problem;
use super::query::Parameter;
use super::resolve::Naming;
use crate::control::{Params, Sample, State};
use crate::frame;
use crate::lod::{Lod, RangeLod};

/// The member `feedback` of a request.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
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
    /// Least `far_dist` to choose, m.
    #[serde(default, deserialize_with = "given")]
    pub min_far_dist_m: Option<f64>,
    /// Greatest `far_dist` to choose, m.
    #[serde(default, deserialize_with = "given")]
    pub max_far_dist_m: Option<f64>,
    /// That of the last answer; null before the first.
    #[serde(default, deserialize_with = "object_or_null")]
    pub state: Option<State>,
}

/// What the controller chose; the member `feedback` of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Steered {
    /// The `far_dist` to tell of this frame in the next request, m.
    pub far_dist_m: f64,
    /// To be sent back with it.
    pub state: State,
}

impl Feedback {
    /// The knobs of the frame, and what the answer tells the client.
    ///
    /// # Errors
    /// 422 for knobs without `far_dist`, parameters that cannot be, and half a sample.
    pub fn steer(&self, lod: &Lod, naming: Naming) -> Result<(Lod, Steered), Problem> {
        let Lod::Range(range) = lod else {
            let detail = "goes with mode \"range\": the controller chooses far_dist_m";
            return Err(naming.feedback("target_ms", detail));
        };
        let (range, state) = self.of_range(range, naming)?.steer(*range);
        let far_dist_m = range.far_dist();
        Ok((Lod::Range(range), Steered { far_dist_m, state }))
    }

    fn of_range(&self, range: &RangeLod, naming: Naming) -> Result<frame::Feedback, Problem> {
        let [least, most] = Params::USUAL_FAR_DIST_M;
        let params = Params::new(
            self.target_ms,
            self.min_far_dist_m.unwrap_or(least),
            self.max_far_dist_m.unwrap_or(most),
        )
        .map_err(|error| naming.feedback(error.field, error.reason))?;
        let sample = match (self.frame_ms, self.far_dist_m) {
            (None, None) => None,
            (Some(frame_ms), Some(far_dist_m)) => Some(Sample {
                frame_ms,
                far_dist_m,
            }),
            (Some(_), None) => {
                let detail = "missing: the far_dist that the frame was drawn with, m";
                return Err(naming.feedback("far_dist_m", detail));
            }
            (None, Some(_)) => {
                let detail = "missing: what the frame took, ms";
                return Err(naming.feedback("frame_ms", detail));
            }
        };
        Ok(frame::Feedback {
            params,
            state: self
                .state
                .unwrap_or_else(|| State::starting_at(range.far_dist())),
            sample,
        })
    }
}

impl Naming {
    /// A member of the feedback; in a query the `far_dist` of the last frame has a name of its own.
    fn feedback(self, member: &str, detail: impl Into<String>) -> Problem {
        match (self, member) {
            (Self::Parameter, "far_dist_m") => self.problem("feedback", DRAWN_FAR_DIST, detail),
            _ => self.problem("feedback", member, detail),
        }
    }
}

/// Name of the parameter for the `far_dist` of the last frame: `far_dist_m` is a knob.
pub const DRAWN_FAR_DIST: &str = "frame_far_dist_m";

/// Takes a parameter of a query; `false` where it is none of feedback.
///
/// # Errors
/// 400 that names the parameter.
pub fn take(feedback: &mut Option<Feedback>, parameter: &Parameter) -> Result<bool, Problem> {
    let mut said = feedback.unwrap_or_default();
    match parameter.name {
        "target_ms" => said.target_ms = parameter.number()?,
        "frame_ms" => said.frame_ms = Some(parameter.number()?),
        DRAWN_FAR_DIST => said.far_dist_m = Some(parameter.number()?),
        "min_far_dist_m" => said.min_far_dist_m = Some(parameter.number()?),
        "max_far_dist_m" => said.max_far_dist_m = Some(parameter.number()?),
        "state" => {
            let mut source = serde_json::Deserializer::from_str(parameter.text);
            let state = object_or_null(&mut source).and_then(|state| source.end().map(|()| state));
            said.state = state.map_err(|error| {
                parameter.problem(format!("must be the state of the last answer: {error}"))
            })?;
        }
        _ => return Ok(false),
    }
    *feedback = Some(said);
    Ok(true)
}

fn object_or_null<'de, D: Deserializer<'de>>(source: D) -> Result<Option<State>, D::Error> {
    struct Object(State);
    impl<'de> Deserialize<'de> for Object {
        fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
            object(source).map(Self)
        }
    }
    let state = Option::<Object>::deserialize(source)?;
    Ok(state.map(|Object(state)| state))
}
