//! The one plant T = c + a·D^p that goes through all frames remembered, where frame times do not
//! scatter at all.

use super::plant::{EXPONENTS, LARGEST_BASE};
use super::state::{FRAMES, Memory};

/// So many distances settle it: three fix the plant, two confirm that it is one.
const CONFIRMED: usize = 5;
/// How far off the curve a frame may lie, in parts of T − c: far above what rounding leaves, far
/// below what any clock does.
const ON_CURVE: f64 = 1e-5;
/// Distances whose logarithms differ by less are the same.
const SAME: f64 = 1e-6;
/// Halvings of an interval until it is as short as numbers allow.
const HALVINGS: usize = 52;

/// T = c + a·e^(p·(x − x₀)); T in parts of the target, x = ln D, x₀ the least of all.
#[derive(Debug, Clone, Copy)]
pub(super) struct Curve {
    origin: f64,
    base: f64,
    scale: f64,
    exponent: f64,
}

impl Curve {
    /// `None` where frames scatter, or too few distances were tried to tell.
    pub(super) fn through(memory: &Memory, target_ms: f64) -> Option<Self> {
        let mut places = [(0.0, 0.0); FRAMES];
        let mut count = 0;
        for (place, sample) in places.iter_mut().zip(memory.samples()) {
            *place = (sample.far_dist_m.ln(), sample.frame_ms / target_ms);
            count += 1;
        }
        let points = places.get_mut(..count)?;
        points.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let apart = points
            .windows(2)
            .filter(|pair| pair[1].0 - pair[0].0 > SAME);
        if apart.count() + 1 < CONFIRMED {
            return None;
        }
        Self::fitted(points).filter(|curve| points.iter().all(|point| curve.meets(*point)))
    }

    /// Through the first point, the last, and the one nearest to half-way.
    fn fitted(points: &[(f64, f64)]) -> Option<Self> {
        let (&(x0, y0), &(x2, y2)) = (points.first()?, points.last()?);
        let off = |x: f64| (x - 0.5 * (x0 + x2)).abs();
        let &(x1, y1) = points.iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0)))?;
        // The growth over the whole against that up to the middle: it rises with the exponent.
        let bend = |p: f64| (p * (x2 - x0)).exp_m1() / (p * (x1 - x0)).exp_m1();
        let wanted = (y2 - y0) / (y1 - y0);
        let [mut low, mut high] = EXPONENTS;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if bend(middle) < wanted {
                low = middle;
            } else {
                high = middle;
            }
        }
        let scale = (y2 - y0) / (low * (x2 - x0)).exp_m1();
        let (base, rounding) = (y0 - scale, ON_CURVE * scale);
        let can_be = scale > 0.0 && base >= -rounding && base <= LARGEST_BASE + rounding;
        can_be.then_some(Self {
            origin: x0,
            base,
            scale,
            exponent: low,
        })
    }

    fn meets(&self, (x, y): (f64, f64)) -> bool {
        let drawn = self.scale * (self.exponent * (x - self.origin)).exp();
        (y - self.base - drawn).abs() <= ON_CURVE * drawn
    }

    /// The `far_dist` that meets the target, m.
    pub(super) fn meets_target(&self) -> f64 {
        let growth = (1.0 - self.base) / self.scale;
        (self.origin + growth.ln() / self.exponent).exp()
    }
}
