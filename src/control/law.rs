//! One step: doubt, learn, aim.

use super::curve::Curve;
use super::family::Family;
use super::{Params, Sample, State};

/// A frame time off by more standard deviations than this is in doubt.
const DOUBTFUL: f64 = 4.0;
/// Two frames in doubt agree where neither is off by more than so many times the other.
const AGREEING: f64 = 2.0;
/// How far the first frame of all may move `far_dist`, as a factor: nothing has confirmed it.
const UNCONFIRMED: f64 = 1.1;
/// Frames drawn alike say the same. Until an answer comes, each frame goes another part of the
/// way, so that the answers will tell apart what is not known yet.
const PARTS: [f64; 5] = [1.0, 1.0, 0.8, 0.6, 0.4];

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
        let mut frames = self.recent;
        frames.push(sample);
        if let Some(curve) = Curve::through(&frames, target_ms) {
            self.suspect = None;
            self.recent = frames;
            self.far_dist_m = curve.meets_target();
        } else if self.believes(sample, target_ms) {
            self.suspect = None;
            self.recent.push(sample);
            if let Some(family) = Family::explaining(&self.recent, target_ms, self.scatter()) {
                self.far_dist_m = self.part_of_the_way(sample.far_dist_m, family.aim());
            }
        } else {
            self.suspect = Some(sample);
        }
    }

    /// Whether a frame is as expected, or the one before it was off alike: then what was learnt
    /// before that is forgotten.
    fn believes(&mut self, sample: Sample, target_ms: f64) -> bool {
        let scatter = self.scatter();
        let Some(family) = Family::explaining(&self.recent, target_ms, scatter) else {
            return true;
        };
        let surprise = family.surprise(sample);
        self.notice(surprise);
        if surprise.abs() <= DOUBTFUL * scatter {
            return true;
        }
        let agreeing = 1.0 / AGREEING..=AGREEING;
        let agrees = |first: &Sample| agreeing.contains(&(family.surprise(*first) / surprise));
        let before = self.suspect.filter(Sample::is_usable).filter(agrees);
        if let Some(first) = before {
            self.recent.forget();
            self.recent.push(first);
        }
        before.is_some()
    }

    fn part_of_the_way(&self, from: f64, aim: f64) -> f64 {
        let frames = self.recent.samples();
        if frames.clone().nth(1).is_none() {
            return aim.max(from / UNCONFIRMED).min(from * UNCONFIRMED);
        }
        let alike = frames.take_while(|frame| frame.far_dist_m == from).count();
        from * (aim / from).powf(PARTS[(alike - 1) % PARTS.len()])
    }
}
