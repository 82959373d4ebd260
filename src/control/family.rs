//! The plants T = c + a·D^p that explain the last frames. Frame times are in parts of the target,
//! distances as logarithms.

use super::Sample;
use super::state::{FRAMES, Memory};

/// How many values of c are tried.
const MEMBERS: usize = 14;
/// How far c stays below what it can be at most, the fastest frame or [`LARGEST_BASE`]: all of it
/// for the first member, and so much less for each that follows. Where a frame is little more than
/// c, what is left decides.
const NEXT_PART: f64 = 0.65;
/// Largest c, in parts of the target.
pub(super) const LARGEST_BASE: f64 = 0.5;
/// Exponents of any city.
pub(super) const EXPONENTS: [f64; 2] = [1.0, 3.0];
/// The exponent before anything is seen, and its standard deviation.
const PRIOR: [f64; 2] = [2.0, 1.0];
/// How much less each older sample counts.
const FADING: f64 = 0.88;
/// A sample whose frame time is e times the target, or a part of it, counts half: plants are
/// power laws only nearby.
const NEARBY: f64 = 1.0;
/// A member is plausible up to so many standard deviations from the best one, and its exponent
/// up to so many from its estimate.
const PLAUSIBLE: f64 = 2.0;
/// How far the steepest plausible plant may pass the target.
const MARGIN: f64 = 0.08;

/// A frame: ln D, and T in parts of the target.
#[derive(Debug, Clone, Copy, Default)]
struct Point {
    x: f64,
    y: f64,
    /// How much it counts.
    weight: f64,
    fade: f64,
}

impl Point {
    fn of(sample: Sample, target_ms: f64, fade: f64) -> Self {
        let y = sample.frame_ms / target_ms;
        let off = y.ln() / NEARBY;
        Self {
            x: sample.far_dist_m.ln(),
            y,
            weight: fade / (1.0 + off * off),
            fade,
        }
    }
}

/// One value of c with the line ln(y − c) = u + p·(x − x̄) that fits best.
#[derive(Debug, Clone, Copy, Default)]
struct Member {
    base: f64,
    exponent: f64,
    exponent_variance: f64,
    mean_x: f64,
    mean_u: f64,
    /// Sum of the weights: the inverse variance of `mean_u`.
    weight: f64,
    /// Misfit in squared standard deviations, less that of the best member.
    misfit: f64,
}

/// All members, for one target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Family {
    members: [Member; MEMBERS],
    scatter: f64,
    target_ms: f64,
}

impl Family {
    /// Fits every member; `scatter` is the relative standard deviation of frame times. `None`
    /// where there is no sample.
    pub(super) fn explaining(memory: &Memory, target_ms: f64, scatter: f64) -> Option<Self> {
        let mut places = [Point::default(); FRAMES];
        let (mut count, mut fade) = (0, 1.0 / (scatter * scatter));
        for (place, sample) in places.iter_mut().zip(memory.samples()) {
            *place = Point::of(sample, target_ms, fade);
            count += 1;
            fade *= FADING;
        }
        let points = places.get(..count)?;
        let fastest = points.iter().map(|point| point.y).reduce(f64::min)?;
        let mut part = 1.0;
        let mut members = [Member::default(); MEMBERS];
        for member in &mut members {
            let base = fastest.min(LARGEST_BASE) * (1.0 - part);
            *member = Member::fitted(base, points);
            part *= NEXT_PART;
        }
        let best = members.iter().map(|m| m.misfit).fold(f64::MAX, f64::min);
        for member in &mut members {
            member.misfit -= best;
        }
        Some(Self {
            members,
            scatter,
            target_ms,
        })
    }

    fn plausible(&self) -> impl Iterator<Item = &Member> {
        let plausible = |member: &&Member| member.misfit <= PLAUSIBLE * PLAUSIBLE;
        self.members.iter().filter(plausible)
    }

    /// By how much a frame took longer than any plausible plant explains: ln of the ratio, less
    /// what the plant itself leaves open. Negative where it was faster.
    pub(super) fn surprise(&self, sample: Sample) -> f64 {
        let point = Point::of(sample, self.target_ms, 1.0);
        self.plausible()
            .map(|member| member.residual(point, self.scatter))
            .fold(
                f64::INFINITY,
                |least, r| if r.abs() < least.abs() { r } else { least },
            )
    }

    /// The `far_dist` to draw with next, m, where `sample` is the newest frame.
    pub(super) fn aim(&self, sample: Sample) -> f64 {
        let from = sample.far_dist_m.ln();
        let (mut total, mut sum) = (0.0, 0.0);
        for member in &self.members {
            let likelihood = (-0.5 * member.misfit).exp();
            total += likelihood;
            sum += likelihood * member.meets(1.0, member.exponent);
        }
        let estimate = sum / total;
        let reaches = |member: &Member, time| member.meets(time, member.steepest());
        let up = || self.plausible().map(|m| reaches(m, 1.0 + MARGIN));
        let down = || self.plausible().map(|m| reaches(m, 1.0 - MARGIN));
        let aim = if estimate > from {
            estimate.min(up().fold(f64::INFINITY, f64::min).max(from))
        } else {
            estimate.max(down().fold(f64::NEG_INFINITY, f64::max).min(from))
        };
        aim.exp()
    }
}

impl Member {
    /// Weighted least squares with a prior on the exponent. An error of T counts in ln(T − c) by
    /// T/(T − c) as much.
    fn fitted(base: f64, points: &[Point]) -> Self {
        let mut rows = [(0.0, 0.0, 0.0); FRAMES];
        for (row, point) in rows.iter_mut().zip(points) {
            let part = 1.0 - base / point.y;
            *row = (point.x, (part * point.y).ln(), part * part * point.weight);
        }
        let rows = &rows[..points.len()];
        let (mut weight, mut sum_x, mut sum_u) = (0.0, 0.0, 0.0);
        for &(x, u, w) in rows {
            weight += w;
            sum_x += w * x;
            sum_u += w * u;
        }
        let (mean_x, mean_u) = (sum_x / weight, sum_u / weight);
        let (mut spread_xx, mut spread_xu, mut spread_uu) = (0.0, 0.0, 0.0);
        for &(x, u, w) in rows {
            let (dx, du) = (x - mean_x, u - mean_u);
            spread_xx += w * dx * dx;
            spread_xu += w * dx * du;
            spread_uu += w * du * du;
        }
        let [usual, deviation] = PRIOR;
        let prior = 1.0 / (deviation * deviation);
        let exponent = (spread_xu + usual * prior) / (spread_xx + prior);
        let exponent = exponent.clamp(EXPONENTS[0], EXPONENTS[1]);
        let of_line = spread_uu - 2.0 * exponent * spread_xu + exponent * exponent * spread_xx;
        let mut residuals = [(0.0, 0.0); FRAMES];
        for ((residual, &(x, u, _)), point) in residuals.iter_mut().zip(rows).zip(points) {
            *residual = (u - mean_u - exponent * (x - mean_x), point.fade);
        }
        let shift = median(&mut residuals[..points.len()]);
        Self {
            base,
            exponent,
            exponent_variance: 1.0 / (spread_xx + prior),
            mean_x,
            mean_u: mean_u + shift,
            weight,
            misfit: of_line.max(0.0) + (exponent - usual).powi(2) * prior,
        }
    }

    fn steepest(&self) -> f64 {
        let steep = self.exponent + PLAUSIBLE * self.exponent_variance.sqrt();
        steep.min(EXPONENTS[1])
    }

    /// ln of the `far_dist` at which a frame takes `time` targets.
    fn meets(&self, time: f64, exponent: f64) -> f64 {
        self.mean_x + ((time - self.base).ln() - self.mean_u) / exponent
    }

    fn residual(&self, point: Point, scatter: f64) -> f64 {
        let dx = point.x - self.mean_x;
        let grown = (self.mean_u + self.exponent * dx).exp();
        let part = grown / (self.base + grown);
        let open = part * part * (1.0 / self.weight + dx * dx * self.exponent_variance);
        (point.y / (self.base + grown)).ln() / (1.0 + open / (scatter * scatter)).sqrt()
    }
}

/// Weighted median of (value, weight), between neighbours.
fn median(values: &mut [(f64, f64)]) -> f64 {
    values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * values.iter().map(|v| v.1).sum::<f64>();
    let mut below = 0.0;
    let mut last: Option<(f64, f64)> = None;
    for &(value, weight) in values.iter() {
        let at = below + 0.5 * weight;
        if at >= half {
            let Some((v, a)) = last else { return value };
            return v + (value - v) * (half - a) / (at - a);
        }
        last = Some((value, at));
        below += weight;
    }
    last.map_or(0.0, |l| l.0)
}
