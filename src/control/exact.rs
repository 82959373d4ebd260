//! The plant T = c + a·D^p that goes through every frame remembered, where frame times do not
//! scatter at all.

use super::Sample;
use super::family::{EXPONENTS, LARGEST_BASE};
use super::state::{FRAMES, Memory};

/// So many distances settle that there is no scatter: three fix the plant, the others confirm it.
const CONFIRMED: usize = 5;
/// A frame is on the curve where it is off by at most this part of T − c: far above what rounding
/// leaves, far below what any clock does.
const ON_CURVE: f64 = 1e-5;
/// Distances whose logarithms differ by less are the same.
const SAME: f64 = 1e-6;
/// Halvings of an interval until it is as short as numbers allow.
const HALVINGS: usize = 52;

/// The `far_dist` that meets the target, m; `None` where frames scatter or too few distances were
/// tried.
pub(super) fn aim(memory: &Memory, target_ms: f64) -> Option<f64> {
    let mut places = [(0.0, 0.0); FRAMES];
    let mut count = 0;
    for (place, sample) in places.iter_mut().zip(memory.samples()) {
        *place = (sample.far_dist_m.ln(), sample.frame_ms / target_ms);
        count += 1;
    }
    let points = &mut places[..count];
    points.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let apart = points.windows(2).filter(|pair| pair[1].0 - pair[0].0 > SAME);
    if apart.count() + 1 < CONFIRMED {
        return None;
    }
    Curve::through(points)?.meets_target()
}

/// T = c + a·e^(p·(x − x₀)), x = ln D.
struct Curve {
    origin: f64,
    base: f64,
    scale: f64,
    exponent: f64,
}

impl Curve {
    /// `points`: (x, T), ascending in x, not all at one x.
    fn through(points: &[(f64, f64)]) -> Option<Self> {
        let (&(x0, y0), &(x2, y2)) = (points.first()?, points.last()?);
        let middle = 0.5 * (x0 + x2);
        let off = |x: f64| (x - middle).abs();
        let &(x1, y1) = points.iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0)))?;
        // What grows with the exponent: the growth over the whole against that up to the middle.
        let bend = |p: f64| (p * (x2 - x0)).exp_m1() / (p * (x1 - x0)).exp_m1();
        let wanted = (y2 - y0) / (y1 - y0);
        let [mut low, mut high] = EXPONENTS;
        for _ in 0..HALVINGS {
            let p = 0.5 * (low + high);
            if bend(p) < wanted { low = p } else { high = p }
        }
        let exponent = 0.5 * (low + high);
        let scale = (y2 - y0) / (exponent * (x2 - x0)).exp_m1();
        let curve = Self { origin: x0, base: y0 - scale, scale, exponent };
        let near = ON_CURVE * scale;
        let possible = scale > 0.0 && (-near..=LARGEST_BASE + near).contains(&curve.base);
        (possible && points.iter().all(|point| curve.meets(*point))).then_some(curve)
    }

    fn meets(&self, (x, y): (f64, f64)) -> bool {
        let drawn = self.scale * (self.exponent * (x - self.origin)).exp();
        (y - self.base - drawn).abs() <= ON_CURVE * drawn
    }

    fn meets_target(&self) -> Option<f64> {
        let x = self.origin + ((1.0 - self.base) / self.scale).ln() / self.exponent;
        let far_dist = x.exp();
        far_dist.is_finite().then_some(far_dist)
    }
}
