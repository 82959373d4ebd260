//! What happens to the load, and frames drawn meanwhile.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::rivals::{Controller, Rule};
use super::score::Score;
use crate::control::{Params, Sample};

pub(super) const TARGET_MS: f64 = 16.7;
/// The `far_dist` that meets the target at a load of 1, m.
const RIGHT_M: f64 = 1_000.0;
pub(super) const RANGE_M: [f64; 2] = Params::USUAL_FAR_DIST_M;
/// Frames of a run, and the one at which something happens.
pub(super) const FRAMES: usize = 160;
pub(super) const EVENT: usize = 80;
/// Frame times in parts of the target: what a clock can tell, and what is still a frame.
const TIMES: [f64; 2] = [1e-12, 1e5];

/// What a frame takes more or less than the plant says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scatter {
    Still,
    /// Normal, with this relative standard deviation.
    Normal(f64),
    /// Never less, exponentially more, by 15 % on average; one frame in twenty takes two to three
    /// times as long.
    LongTail,
    /// Exponentially more, by 10 % on average, and shown at the next of eight ticks a target.
    Ticks,
}

/// One thing to stand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scenario {
    pub(super) name: &'static str,
    /// `far_dist` at the start, in parts of the right one; where `None` both lie anywhere in the
    /// range.
    pub(super) start: Option<f64>,
    /// Load from [`EVENT`] on.
    pub(super) load: f64,
    /// The load rises and falls by this factor all the time, once in 300 to 600 frames.
    pub(super) drift: f64,
    pub(super) scatter: Scatter,
    /// How much slower the frame [`EVENT`] is.
    pub(super) spike: f64,
    pub(super) delay: usize,
    /// Exponent of the plant; drawn from [1, 3] where `None`.
    pub(super) exponent: Option<f64>,
    pub(super) frames: usize,
}

const PLAIN: Scenario = Scenario {
    name: "",
    start: Some(1.0),
    load: 1.0,
    drift: 1.0,
    scatter: Scatter::Still,
    spike: 1.0,
    delay: 0,
    exponent: None,
    frames: FRAMES,
};
const LONG: Scenario = Scenario {
    start: Some(0.3),
    scatter: Scatter::LongTail,
    delay: 1,
    frames: 660,
    ..PLAIN
};

#[rustfmt::skip]
pub(super) const SCENARIOS: [Scenario; 18] = [
    Scenario { name: "start far below", start: Some(0.1), ..PLAIN },
    Scenario { name: "start far above", start: Some(10.0), ..PLAIN },
    Scenario { name: "load step up", load: 3.0, ..PLAIN },
    Scenario { name: "load step down", load: 0.33, ..PLAIN },
    Scenario { name: "noise 10 %", scatter: Scatter::Normal(0.1), ..PLAIN },
    Scenario { name: "spike", spike: 10.0, ..PLAIN },
    Scenario { name: "delay 0", start: None, ..PLAIN },
    Scenario { name: "delay 1", start: None, delay: 1, ..PLAIN },
    Scenario { name: "delay 2", start: None, delay: 2, ..PLAIN },
    Scenario { name: "delay 3", start: None, delay: 3, ..PLAIN },
    Scenario { name: "exponent 1", start: Some(0.25), exponent: Some(1.0), ..PLAIN },
    Scenario { name: "exponent 2", start: Some(0.25), exponent: Some(2.0), ..PLAIN },
    Scenario { name: "exponent 3", start: Some(0.25), exponent: Some(3.0), ..PLAIN },
    Scenario { name: "unreachable, then back", load: 1e6, ..PLAIN },
    Scenario { name: "idle, then back", load: 1e-6, ..PLAIN },
    Scenario { name: "long tail", ..LONG },
    Scenario { name: "long tail and drift", drift: 3.0, ..LONG },
    Scenario { name: "ticks", scatter: Scatter::Ticks, ..LONG },
];
/// Those that are drawn.
pub(super) const DRAWN: [&str; 7] = [
    "start far below",
    "start far above",
    "load step up",
    "noise 10 %",
    "spike",
    "delay 3",
    "long tail and drift",
];

/// Frames as they were drawn.
#[derive(Debug, Clone, Default)]
pub(super) struct Run {
    pub(super) far_dists: Vec<f64>,
    pub(super) times_ms: Vec<f64>,
}

/// Draws frames; with delay d the newest known time, when frame f is chosen, is that of f − 1 − d.
pub(super) fn run(
    mut controller: Controller,
    delay: usize,
    frames: usize,
    mut time_ms: impl FnMut(usize, f64) -> f64,
) -> Run {
    let mut run = Run::default();
    for frame in 0..frames {
        let known = frame.checked_sub(1 + delay).map(|known| Sample {
            frame_ms: run.times_ms[known],
            far_dist_m: run.far_dists[known],
        });
        let far_dist = controller.next(known);
        run.far_dists.push(far_dist);
        run.times_ms.push(time_ms(frame, far_dist));
    }
    run
}

impl Scenario {
    /// One run of one rule, and how it went.
    pub(super) fn run(&self, rule: Rule, params: &Params, seed: u64) -> (Run, Score) {
        let mut rng = Pcg32::seed_from_u64(seed);
        let p = self.exponent.unwrap_or_else(|| rng.random_range(1.0..=3.0));
        let base = rng.random_range(0.0..=0.5);
        let mut anywhere = || f64::exp(rng.random_range(RANGE_M[0].ln()..=RANGE_M[1].ln()));
        let (right, start) = match self.start {
            Some(start) => (RIGHT_M, RIGHT_M * start),
            None => (anywhere(), anywhere()),
        };
        // From farther above the first frame would take longer than any frame.
        let start = start.min(right * TIMES[1].powf(1.0 / p));
        let period = rng.random_range(300.0..600.0);
        let phase = rng.random_range(0.0..1.0);
        let back = self.load < 1e-3 || self.load > 1e3;
        let controller = Controller::new(rule, *params, start);
        let run = run(controller, self.delay, self.frames, |frame, far_dist| {
            // Out of reach first, or from the event on.
            let load = if back == (frame < EVENT) {
                self.load
            } else {
                1.0
            };
            let turn = std::f64::consts::TAU * (phase + frame as f64 / period);
            let load = load * self.drift.powf(0.5 * turn.sin());
            let spike = if frame == EVENT { self.spike } else { 1.0 };
            let drawn = (1.0 - base) * load * (far_dist / right).powf(p);
            let time = self.scatter.over((base + drawn) * spike, &mut rng);
            TARGET_MS * time.clamp(TIMES[0], TIMES[1])
        });
        let score = Score::of(self, &run);
        (run, score)
    }
}

impl Scatter {
    fn over(self, time: f64, rng: &mut Pcg32) -> f64 {
        match self {
            Self::Still => time,
            Self::Normal(deviation) => time * (1.0 + deviation * gauss(rng)),
            Self::LongTail => {
                let often = if rng.random_bool(0.05) {
                    rng.random_range(2.0..3.0)
                } else {
                    1.0
                };
                time * (1.0 + 0.15 * exponential(rng)) * often
            }
            Self::Ticks => (8.0 * time * (1.0 + 0.1 * exponential(rng))).ceil() / 8.0,
        }
    }
}

/// A normal deviate (Box and Muller, 1958).
fn gauss(rng: &mut Pcg32) -> f64 {
    (2.0 * exponential(rng)).sqrt() * (std::f64::consts::TAU * rng.random::<f64>()).cos()
}

/// An exponential deviate of mean 1.
fn exponential(rng: &mut Pcg32) -> f64 {
    -f64::ln(rng.random_range(f64::EPSILON..1.0))
}
