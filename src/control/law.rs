//! One step: doubt, learn, aim.

use super::exact;
use super::family::Family;
use super::{Params, Sample, State};

/// A frame time off by more standard deviations than this is in doubt.
const DOUBTFUL: f64 = 4.0;
/// How far the first frame of all may move `far_dist`, as a factor: nothing has confirmed it.
const UNCONFIRMED: f64 = 1.1;

/// Shares of the way.
const SHARES: [f64; 4] = [1.0, 0.8, 0.6, 0.4];

/// Chooses the `far_dist` of the next frame, m, within the range of `params`.
///
/// `sample` is the newest frame whose time is known, `None` where there is none: then the
/// controller rests. Each frame is to be given once. Total: a sample that cannot be a frame is
/// counted and not used ([`State::ignored`]), and no state leads out of the range.
pub fn step(params: &Params, mut state: State, sample: Option<Sample>) -> (State, f64) {
    match sample {
        Some(sample) if sample.is_usable() => state.react(sample, params.target_ms()),
        Some(_) => state.ignored = state.ignored.saturating_add(1),
        None => {}
    }
    state.far_dist_m = params.clamp(state.far_dist_m);
    (state, state.far_dist_m)
}

impl State {
    fn react(&mut self, sample: Sample, target_ms: f64) {
        let mut with = self.recent;
        with.push(sample);
        if let Some(aim) = exact::aim(&with, target_ms) {
            self.suspect = None;
            self.recent = with;
            self.far_dist_m = aim;
            return;
        }
        let scatter = self.scatter();
        if let Some(family) = Family::explaining(&self.recent, target_ms, scatter) {
            let surprise = family.surprise(sample);
            self.notice(surprise);
            if surprise.abs() > DOUBTFUL * scatter {
                let before = self.suspect.filter(Sample::is_usable);
                let agrees = |first: &Sample| {
                    let ratio = family.surprise(*first) / surprise;
                    (0.5..=2.0).contains(&ratio)
                };
                let Some(first) = before.filter(agrees) else {
                    self.suspect = Some(sample);
                    return;
                };
                self.recent.forget();
                self.recent.push(first);
            }
        }
        self.suspect = None;
        self.recent.push(sample);
        if let Some(family) = Family::explaining(&self.recent, target_ms, self.scatter()) {
            let from = sample.far_dist_m;
            let aim = family.aim(sample);
            let same = self.recent.samples().take_while(|s| s.far_dist_m == from).count();
            self.far_dist_m = match same {
                1 if self.recent.samples().nth(1).is_none() => aim.max(from / UNCONFIRMED).min(from * UNCONFIRMED),
                1 => aim,
                n => from * (aim / from).powf(SHARES[(n - 2) % SHARES.len()]),
            };
        }
    }
}
