//! The control law.

use super::{Params, Sample, State};

/// Chooses the `far_dist` of the next frame, m, within the range of `params`.
///
/// `sample` is the newest frame whose time is known, `None` where there is none: then the
/// controller rests. Total: a sample that cannot be a frame is counted and not used, and no state
/// leads out of the range.
pub fn step(params: &Params, mut state: State, sample: Option<Sample>) -> (State, f64) {
    if let Some(sample) = sample {
        if sample.is_usable() {
            // No frame time grows faster than with the cube: this far and the target is not passed.
            let room = params.target_ms() / sample.frame_ms;
            state.far_dist_m = sample.far_dist_m * room.cbrt();
        } else {
            state.ignored = state.ignored.saturating_add(1);
        }
    }
    state.far_dist_m = params.clamp(state.far_dist_m);
    (state, state.far_dist_m)
}
