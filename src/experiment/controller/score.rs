//! How well the frame time was held, and whether that is what the controller promises.

use super::super::timing::median;
use super::scenario::{EVENT, Run, Scatter, Scenario, TARGET_MS};

/// A frame time this close to the target is settled.
const SETTLED: f64 = 0.05;
/// A quiet tail that still swings by more of the frame time than this is a limit cycle.
const CYCLE: f64 = 0.02;
/// Frames before medians are taken.
const WARM_UP: usize = 60;

/// How one run went; the worst of many.
#[derive(Debug, Clone, Copy)]
pub(super) struct Score {
    /// Frames to settle after the start or the event, beyond the delay; `None` if it never does.
    pub(super) settle_frames: Option<usize>,
    /// How far the frame time passes the target, to the side that it did not come from.
    pub(super) overshoot_pct: f64,
    /// How much `far_dist` moves when nothing happens; for the spike, how far it is moved.
    pub(super) rms_pct: f64,
    /// Whether the frame time still swings at the end, where there is no noise.
    pub(super) limit_cycle: bool,
    /// How far the median frame time lies from the target, and that of the worst quarter of the
    /// run; where times scatter to one side.
    pub(super) medians_off_pct: Option<[f64; 2]>,
}

impl Score {
    pub(super) fn of(scenario: &Scenario, run: &Run) -> Self {
        let still = scenario.scatter == Scatter::Still;
        let spike = scenario.spike != 1.0;
        let off: Vec<f64> = run.times_ms.iter().map(|t| t / TARGET_MS - 1.0).collect();
        let from = if scenario.load != 1.0 || spike {
            EVENT + usize::from(spike)
        } else {
            0
        };
        let watched = &off[from..];
        let unsettled = watched.iter().rposition(|off| off.abs() > SETTLED);
        let settled = unsettled.map_or(0, |last| last + 1);
        // Which side it comes from: that of the first frame that is off.
        let side = watched.iter().find(|off| off.abs() > SETTLED);
        let side = side.map_or(0.0, |off| off.signum());
        let passed = watched.iter().map(|off| -off * side).fold(0.0, f64::max);
        let tail = &off[off.len() - 20..];
        let swing = tail.iter().fold(f64::MIN, |a, b| a.max(*b))
            - tail.iter().fold(f64::MAX, |a, b| a.min(*b));
        Self {
            settle_frames: (still && settled < watched.len())
                .then(|| settled.saturating_sub(scenario.delay)),
            overshoot_pct: if still { 100.0 * passed } else { 0.0 },
            rms_pct: match (still, spike) {
                (true, true) => moved(&run.far_dists[EVENT..]),
                (false, _) if scenario.drift == 1.0 => rms(&run.far_dists[EVENT..]),
                _ => 0.0,
            },
            limit_cycle: still && swing > CYCLE,
            medians_off_pct: matches!(scenario.scatter, Scatter::LongTail | Scatter::Ticks)
                .then(|| medians(&off[WARM_UP..])),
        }
    }

    /// Whether the promises of the controller hold for the scenario.
    pub(super) fn holds(&self, scenario: &Scenario) -> bool {
        let settles = self.settle_frames.is_some_and(|frames| frames <= 12);
        let rms_pct = match scenario.scatter {
            Scatter::Still => 10.0,
            Scatter::Normal(_) => 6.0,
            Scatter::LongTail | Scatter::Ticks => f64::INFINITY,
        };
        // What changes all the time is followed, not met.
        let median_pct = if scenario.drift == 1.0 { 3.0 } else { 5.0 };
        let centred = |[whole, quarter]: [f64; 2]| whole <= median_pct && quarter <= 10.0;
        (settles || scenario.scatter != Scatter::Still)
            && self.overshoot_pct <= 10.0
            && self.rms_pct <= rms_pct
            && !self.limit_cycle
            && self.medians_off_pct.is_none_or(centred)
    }
}

/// Farthest from the first value, %.
fn moved(values: &[f64]) -> f64 {
    let off = values.iter().map(|value| (value / values[0] - 1.0).abs());
    100.0 * off.fold(0.0, f64::max)
}

/// Standard deviation in parts of the mean, %.
fn rms(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares = values.iter().map(|value| (value / mean - 1.0).powi(2));
    100.0 * (squares.sum::<f64>() / values.len() as f64).sqrt()
}

/// Distance of the median from 0, %, for the whole and for the worst quarter.
fn medians(off: &[f64]) -> [f64; 2] {
    let of = |part: &[f64]| 100.0 * median(part.to_vec()).abs();
    let quarters = off.chunks(off.len().div_ceil(4)).map(of);
    [of(off), quarters.fold(0.0, f64::max)]
}
