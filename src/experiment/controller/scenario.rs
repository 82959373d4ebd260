//! What happens to the load, and how well the frame time was held.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::rivals::{Controller, Rule};
use crate::control::{Params, Sample};

pub(super) const TARGET_MS: f64 = 16.7;
/// The `far_dist` that meets the target at a load of 1, m.
const RIGHT_M: f64 = 1_000.0;
pub(super) const RANGE_M: [f64; 2] = [20.0, 20_000.0];
/// Frames of a run, and the one at which something happens.
pub(super) const FRAMES: usize = 160;
pub(super) const EVENT: usize = 80;
/// A frame time this close to the target is settled.
const SETTLED: f64 = 0.05;
/// A quiet tail that still swings by more of the frame time than this is a limit cycle.
const CYCLE: f64 = 0.02;

/// One thing to stand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scenario {
    pub(super) name: &'static str,
    /// `far_dist` at the start, in parts of the right one.
    pub(super) start: f64,
    /// Load from [`EVENT`] on.
    pub(super) load: f64,
    /// Relative standard deviation of frame times.
    pub(super) noise: f64,
    /// How much slower the frame [`EVENT`] is.
    pub(super) spike: f64,
    pub(super) delay: usize,
    /// Exponent of the plant; drawn from [1, 3] where `None`.
    pub(super) exponent: Option<f64>,
}

const PLAIN: Scenario = Scenario {
    name: "",
    start: 1.0,
    load: 1.0,
    noise: 0.0,
    spike: 1.0,
    delay: 0,
    exponent: None,
};

#[rustfmt::skip]
pub(super) const SCENARIOS: [Scenario; 15] = [
    Scenario { name: "start far below", start: 0.1, ..PLAIN },
    Scenario { name: "start far above", start: 10.0, ..PLAIN },
    Scenario { name: "load step up", load: 3.0, ..PLAIN },
    Scenario { name: "load step down", load: 0.33, ..PLAIN },
    Scenario { name: "noise 10 %", noise: 0.1, ..PLAIN },
    Scenario { name: "spike", spike: 10.0, ..PLAIN },
    Scenario { name: "delay 0", start: 0.4, ..PLAIN },
    Scenario { name: "delay 1", start: 0.4, delay: 1, ..PLAIN },
    Scenario { name: "delay 2", start: 0.4, delay: 2, ..PLAIN },
    Scenario { name: "delay 3", start: 0.4, delay: 3, ..PLAIN },
    Scenario { name: "exponent 1", start: 0.25, exponent: Some(1.0), ..PLAIN },
    Scenario { name: "exponent 2", start: 0.25, exponent: Some(2.0), ..PLAIN },
    Scenario { name: "exponent 3", start: 0.25, exponent: Some(3.0), ..PLAIN },
    Scenario { name: "unreachable, then back", load: 1e6, ..PLAIN },
    Scenario { name: "idle, then back", load: 1e-6, ..PLAIN },
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

/// How one run went.
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
}

impl Scenario {
    /// One run of one rule, and how it went.
    pub(super) fn run(&self, rule: Rule, params: &Params, seed: u64) -> (Run, Score) {
        let mut rng = Pcg32::seed_from_u64(seed);
        let p = self.exponent.unwrap_or_else(|| rng.random_range(1.0..=3.0));
        let base = rng.random_range(0.0..=0.5);
        let back = self.load < 1e-3 || self.load > 1e3;
        let controller = Controller::new(rule, *params, RIGHT_M * self.start);
        let run = run(controller, self.delay, FRAMES, |frame, far_dist| {
            // Out of reach first, or from the event on.
            let load = if back == (frame < EVENT) {
                self.load
            } else {
                1.0
            };
            let spike = if frame == EVENT { self.spike } else { 1.0 };
            let drawn = (1.0 - base) * load * (far_dist / RIGHT_M).powf(p);
            let noisy = 1.0 + self.noise * gauss(&mut rng);
            TARGET_MS * ((base + drawn) * spike * noisy).clamp(0.01, 1e4)
        });
        let score = self.score(&run);
        (run, score)
    }

    fn score(&self, run: &Run) -> Score {
        let event = self.load != 1.0 || self.spike != 1.0;
        let from = if event { EVENT } else { 0 };
        let off: Vec<f64> = run.times_ms.iter().map(|t| t / TARGET_MS - 1.0).collect();
        let spike = usize::from(self.spike != 1.0);
        let watched = &off[from + spike..];
        let unsettled = watched.iter().rposition(|off| off.abs() > SETTLED);
        let settled = unsettled.map_or(0, |last| last + 1);
        // Which side it comes from: that of the first frame that is off.
        let side = watched.iter().find(|off| off.abs() > SETTLED);
        let side = side.map_or(0.0, |off| off.signum());
        let passed = watched.iter().map(|off| -off * side).fold(0.0, f64::max);
        let quiet = &run.far_dists[FRAMES - EVENT..];
        let mean = quiet.iter().sum::<f64>() / quiet.len() as f64;
        let rms = (quiet.iter().map(|d| (d / mean - 1.0).powi(2)).sum::<f64>()
            / quiet.len() as f64)
            .sqrt();
        let before = run.far_dists[EVENT];
        let moved = run.far_dists[EVENT..].iter();
        let moved = moved.map(|d| (d / before - 1.0).abs()).fold(0.0, f64::max);
        let tail = &off[FRAMES - 20..];
        let swing = tail.iter().fold(f64::MIN, |a, b| a.max(*b))
            - tail.iter().fold(f64::MAX, |a, b| a.min(*b));
        Score {
            settle_frames: (self.noise == 0.0 && settled < watched.len())
                .then(|| settled.saturating_sub(self.delay)),
            overshoot_pct: if self.noise == 0.0 {
                100.0 * passed
            } else {
                0.0
            },
            rms_pct: 100.0
                * match (self.noise == 0.0, spike) {
                    (false, _) => rms,
                    (true, 1) => moved,
                    _ => 0.0,
                },
            limit_cycle: self.noise == 0.0 && swing > CYCLE,
        }
    }

    /// Whether the promises of the controller hold for the score.
    pub(super) fn holds(&self, score: &Score) -> bool {
        let settles = self.noise > 0.0 || score.settle_frames.is_some_and(|n| n <= 12);
        let moves = if self.noise > 0.0 { 6.0 } else { 10.0 };
        settles && score.overshoot_pct <= 10.0 && score.rms_pct <= moves && !score.limit_cycle
    }
}

/// A normal deviate (Box and Muller, 1958).
fn gauss(rng: &mut Pcg32) -> f64 {
    let (u, v) = (rng.random_range(f64::EPSILON..1.0), rng.random::<f64>());
    (-2.0 * f64::ln(u)).sqrt() * (std::f64::consts::TAU * v).cos()
}
