//! What is wanted of the controller.

/// The frame time to hold, and the range that `far_dist` stays in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Params {
    target_ms: f64,
    min_far_dist: f64,
    max_far_dist: f64,
}

/// A parameter that cannot be; field names are those of the JSON form.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{field}: {reason}")]
pub struct ParamsError {
    /// The field at fault.
    pub field: &'static str,
    /// What is wrong with it.
    pub reason: String,
}

impl Params {
    /// Usual range of `far_dist`, m.
    pub const USUAL_FAR_DIST_M: [f64; 2] = [20.0, 20_000.0];

    /// `target_ms`: the frame time to hold, milliseconds, above 0 and at most an hour.
    /// `min_far_dist`, `max_far_dist`: metres, above 0, finite, the first at most the second.
    /// Between them lies what the controller may choose from.
    ///
    /// # Errors
    /// [`ParamsError`] naming the parameter that is out of range.
    pub fn new(target_ms: f64, min_far_dist: f64, max_far_dist: f64) -> Result<Self, ParamsError> {
        let error = |field, reason| Err(ParamsError { field, reason });
        if !(target_ms > 0.0 && target_ms <= super::state::LONGEST_FRAME_MS) {
            let reason = format!("must be above 0 and at most an hour, is {target_ms} ms");
            return error("target_ms", reason);
        }
        if !(min_far_dist > 0.0 && min_far_dist.is_finite()) {
            let reason = format!("must be above 0 and finite, is {min_far_dist}");
            return error("min_far_dist_m", reason);
        }
        if !(max_far_dist >= min_far_dist && max_far_dist.is_finite()) {
            let reason = format!("must be finite and at least {min_far_dist}, is {max_far_dist}");
            return error("max_far_dist_m", reason);
        }
        Ok(Self {
            target_ms,
            min_far_dist,
            max_far_dist,
        })
    }

    /// The frame time to hold, ms.
    pub fn target_ms(&self) -> f64 {
        self.target_ms
    }

    /// Least `far_dist`, m.
    pub fn min_far_dist(&self) -> f64 {
        self.min_far_dist
    }

    /// Greatest `far_dist`, m.
    pub fn max_far_dist(&self) -> f64 {
        self.max_far_dist
    }

    /// The nearest `far_dist` in range; the least for what is no number.
    pub(super) fn clamp(&self, far_dist: f64) -> f64 {
        far_dist.max(self.min_far_dist).min(self.max_far_dist)
    }
}
