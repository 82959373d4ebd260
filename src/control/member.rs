//! All plants of one exponent: c and a by weighted least squares, and how well the frames tell
//! them.

use super::Sample;
use super::plant::{LARGEST_BASE, USUAL_BASE, USUAL_EXPONENT};
use super::state::FRAMES;

/// A member is plausible up to so many standard deviations from the best one, and so is what it
/// predicts.
pub(super) const PLAUSIBLE: f64 = 2.0;
/// A frame counts half in the fit where its time is e times the target, or that part of it:
/// plants are power laws only nearby.
const FIT_REACH: f64 = 1.0;
/// A frame counts half in the middle where it was drawn so far off the newest, in ln D.
const MIDDLE_REACH: f64 = 0.5;
/// Between these parts of the weight lies the middle of the frames: nearly their median, but it
/// scatters less.
const MIDDLE: [f64; 2] = [0.3, 0.7];
/// Frame times in parts of the target, and ln of ratios of distances, beyond which numbers would
/// run out.
const TIMES: [f64; 2] = [1e-9, 1e9];
const FARTHEST: f64 = 60.0;
/// Nothing costs less, in parts of the target.
const LEAST_SCALE: f64 = 1e-12;

/// A frame seen from the newest: x = ln(D/D₀), y = T in parts of the target.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Point {
    pub(super) x: f64,
    pub(super) y: f64,
    /// One over the variance of T.
    in_fit: f64,
    /// By distance, not by time: that would favour the fast frames.
    in_middle: f64,
}

impl Point {
    /// `origin`: ln D₀; `weight`: what it counts for its age and scatter.
    pub(super) fn of(sample: Sample, target_ms: f64, origin: f64, weight: f64) -> Self {
        let x = (sample.far_dist_m.ln() - origin).clamp(-FARTHEST, FARTHEST);
        let y = (sample.frame_ms / target_ms).clamp(TIMES[0], TIMES[1]);
        let half = |off: f64, reach: f64| weight / (1.0 + (off / reach).powi(2));
        Self {
            x,
            y,
            in_fit: half(y.ln(), FIT_REACH) / (y * y),
            in_middle: half(x, MIDDLE_REACH),
        }
    }
}

/// T = c + a·g with g = (D/D₀)^p, for one p; D₀ is the distance of the newest frame.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Member {
    pub(super) exponent: f64,
    base: f64,
    scale: f64,
    /// Variance of c, covariance, variance of a.
    spread: [f64; 3],
    /// In squared standard deviations.
    pub(super) misfit: f64,
}

impl Member {
    /// Least squares with c near what is usual. Then the curve is moved to the middle of the
    /// frames: their times have a floor and a long tail, and it is the median that is held.
    pub(super) fn fitted(exponent: f64, points: &[Point]) -> Self {
        let [usual, deviation] = USUAL_BASE;
        let prior = deviation.powi(-2);
        // The normal equations.
        let (mut cc, mut ca, mut aa, mut cy, mut ay) = (prior, 0.0, 0.0, prior * usual, 0.0);
        let mut grown = [0.0; FRAMES];
        for (g, point) in grown.iter_mut().zip(points) {
            *g = (exponent * point.x).exp();
            let (g, w) = (*g, point.in_fit);
            cc += w;
            ca += w * g;
            aa += w * g * g;
            cy += w * point.y;
            ay += w * g * point.y;
        }
        let det = cc * aa - ca * ca;
        let base = ((aa * cy - ca * ay) / det).clamp(0.0, LARGEST_BASE);
        let scale = ((ay - ca * base) / aa).max(LEAST_SCALE);
        let [usual_exponent, deviation] = USUAL_EXPONENT;
        let mut misfit =
            prior * (base - usual).powi(2) + ((exponent - usual_exponent) / deviation).powi(2);
        let mut ratios = [(0.0, 0.0); FRAMES];
        for ((ratio, g), point) in ratios.iter_mut().zip(grown).zip(points) {
            let time = base + scale * g;
            misfit += point.in_fit * (point.y - time).powi(2);
            *ratio = ((point.y / time).ln(), point.in_middle);
        }
        let moved = middle(&mut ratios[..points.len()]).exp();
        Self {
            exponent,
            base: base * moved,
            scale: scale * moved,
            spread: [aa / det, -ca / det, cc / det],
            misfit,
        }
    }

    pub(super) fn is_plausible(&self) -> bool {
        self.misfit <= PLAUSIBLE * PLAUSIBLE
    }

    /// Frame time at a distance, and its variance; `x` = ln(D/D₀).
    pub(super) fn predicts(&self, x: f64) -> (f64, f64) {
        let g = (self.exponent * x).exp();
        let [base, both, scale] = self.spread;
        let variance = base + 2.0 * both * g + scale * g * g;
        (self.base + self.scale * g, variance.max(0.0))
    }

    /// ln(D/D₀) at which a frame takes `time`, where frames take so many standard deviations more
    /// than predicted: the end of the band around the curve.
    pub(super) fn meets(&self, time: f64, deviations: f64) -> f64 {
        // (room − a·g)² = k²·variance(g)
        let room = time - self.base;
        let k2 = deviations * deviations;
        let [base, both, scale] = self.spread;
        let square = self.scale * self.scale - k2 * scale;
        let half = room * self.scale + k2 * both;
        let constant = room * room - k2 * base;
        let root = (half * half - square * constant).max(0.0).sqrt();
        let g = if deviations > 0.0 {
            constant / (half + root)
        } else if square > 0.0 {
            (half + root) / square
        } else {
            f64::INFINITY
        };
        (g.ln() / self.exponent).clamp(-FARTHEST, FARTHEST)
    }
}

/// Mean of the values, each with its weight, in the middle of the weight.
fn middle(values: &mut [(f64, f64)]) -> f64 {
    values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = values.iter().map(|value| value.1).sum();
    let [low, high] = MIDDLE.map(|part| part * total);
    let (mut below, mut sum) = (0.0, 0.0);
    for &(value, weight) in values.iter() {
        let above = below + weight;
        sum += value * (f64::min(above, high) - f64::max(below, low)).max(0.0);
        below = above;
    }
    sum / (high - low)
}
