//! The plants T = c + a·D^p that explain the last frames. Frame times are in parts of the target,
//! distances as logarithms.

use super::Sample;
use super::state::{FRAMES, Memory};

/// How many exponents are tried.
const MEMBERS: usize = 9;
/// Fewer plausible members than this are too few, and so often they are spread closer.
const FEW: usize = 4;
const ZOOMS: usize = 6;
/// Exponents of any city.
pub(super) const EXPONENTS: [f64; 2] = [1.0, 3.0];
/// The exponent before anything is seen, and its standard deviation.
const USUAL_EXPONENT: [f64; 2] = [2.0, 1.0];
/// Largest c, in parts of the target.
pub(super) const LARGEST_BASE: f64 = 0.5;
/// c before anything is seen, and its standard deviation.
const USUAL_BASE: [f64; 2] = [0.25, 0.15];
/// Between which parts of the weight the middle of the frames lies: nearly their median, with less scatter.
const MIDDLE: [f64; 2] = [0.3, 0.7];
/// How much less each older sample counts.
const FADING: f64 = 0.9;
/// A sample whose frame time is e times the target, or a part of it, counts half: plants are
/// power laws only nearby.
const NEARBY: f64 = 1.0;
/// The same for the middle: by ln D, which does not favour the fast frames.
const AWAY: f64 = 0.5;
/// A member is plausible up to so many standard deviations from the best one, and so is what it
/// predicts.
const PLAUSIBLE: f64 = 2.0;
/// How far a plausible plant may pass the target: so much, or so many standard deviations of what
/// frames scatter anyway.
const MARGIN: f64 = 0.08;
const MARGIN_SCATTER: f64 = 4.0;

/// A frame: ln D, and T in parts of the target.
#[derive(Debug, Clone, Copy, Default)]
struct Point {
    x: f64,
    y: f64,
    fade: f64,
    /// How much an error of the size of y counts.
    weight: f64,
}

impl Point {
    fn of(sample: Sample, target_ms: f64, fade: f64) -> Self {
        let y = sample.frame_ms / target_ms;
        let off = y.ln() / NEARBY;
        Self {
            x: sample.far_dist_m.ln(),
            y,
            fade,
            weight: fade / (1.0 + off * off),
        }
    }
}

/// One exponent with the c and a that fit best, a at the distance of the newest frame.
#[derive(Debug, Clone, Copy, Default)]
struct Member {
    exponent: f64,
    base: f64,
    scale: f64,
    /// Of base and scale: variance, covariance, variance.
    spread: [f64; 3],
    /// Misfit in squared standard deviations, less that of the best member.
    misfit: f64,
}

/// All members, for one target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Family {
    members: [Member; MEMBERS],
    origin: f64,
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
        let origin = points.first()?.x;
        let mut range = EXPONENTS;
        let mut members = Member::all(range, origin, points);
        for _ in 0..ZOOMS {
            let Some(closer) = closer(range, &members) else {
                break;
            };
            range = closer;
            members = Member::all(range, origin, points);
        }
        Some(Self {
            members,
            origin,
            scatter,
            target_ms,
        })
    }

    fn plausible(&self) -> impl Iterator<Item = &Member> {
        self.members.iter().filter(|member| member.is_plausible())
    }

    /// By how much a frame took longer than any plausible plant explains: ln of the ratio, less
    /// what the plant itself leaves open. Negative where it was faster.
    pub(super) fn surprise(&self, sample: Sample) -> f64 {
        let point = Point::of(sample, self.target_ms, 1.0);
        self.plausible()
            .map(|member| {
                let growth = (member.exponent * (point.x - self.origin)).exp();
                let time = member.base + member.scale * growth;
                let open = member.variance(growth) / (time * time);
                (point.y / time).ln() / (1.0 + open / (self.scatter * self.scatter)).sqrt()
            })
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
            sum += likelihood * member.meets(1.0, 0.0);
        }
        let estimate = self.origin + sum / total;
        let margin = MARGIN.max(MARGIN_SCATTER * self.scatter).min(0.4);
        let reaches = |time, sign: f64| {
            self.plausible()
                .map(move |m| self.origin + m.meets(time, sign * PLAUSIBLE))
        };
        let aim = if estimate > from {
            let up = reaches(1.0 + margin, 1.0).fold(f64::INFINITY, f64::min);
            estimate.min(up.max(from))
        } else {
            let down = reaches(1.0 - margin, -1.0).fold(f64::NEG_INFINITY, f64::max);
            estimate.max(down.min(from))
        };
        aim.exp()
    }
}

/// The exponents around the plausible members, where these are too few to tell how far they reach.
fn closer([low, high]: [f64; 2], members: &[Member; MEMBERS]) -> Option<[f64; 2]> {
    if members.iter().filter(|m| m.is_plausible()).count() >= FEW {
        return None;
    }
    let cell = (high - low) / (MEMBERS - 1) as f64;
    let first = members.iter().find(|m| m.is_plausible())?.exponent;
    let last = members.iter().rfind(|m| m.is_plausible())?.exponent;
    Some([(first - cell).max(low), (last + cell).min(high)])
}

impl Member {
    /// With exponents evenly spread over a range.
    fn all([low, high]: [f64; 2], origin: f64, points: &[Point]) -> [Self; MEMBERS] {
        let mut members = [Self::default(); MEMBERS];
        for (n, member) in members.iter_mut().enumerate() {
            let part = n as f64 / (MEMBERS - 1) as f64;
            *member = Self::fitted(low + part * (high - low), origin, points);
        }
        let best = members.iter().map(|m| m.misfit).fold(f64::MAX, f64::min);
        for member in &mut members {
            member.misfit -= best;
        }
        members
    }

    fn is_plausible(&self) -> bool {
        self.misfit <= PLAUSIBLE * PLAUSIBLE
    }

    /// Weighted least squares with a prior on c. Then the curve is moved so that half of the
    /// weight lies above it: frame times have a long tail, and the median is what is held.
    fn fitted(exponent: f64, origin: f64, points: &[Point]) -> Self {
        let [usual, deviation] = USUAL_BASE;
        let prior = 1.0 / (deviation * deviation);
        let mut rows = [(0.0, 0.0, 0.0, 0.0); FRAMES];
        let (mut cc, mut ca, mut aa, mut cy, mut ay) = (prior, 0.0, 0.0, usual * prior, 0.0);
        for (row, point) in rows.iter_mut().zip(points) {
            let g = (exponent * (point.x - origin)).exp();
            let w = point.weight / (point.y * point.y);
            let away = (point.x - origin) / AWAY;
            *row = (g, point.y, w, point.fade / (1.0 + away * away));
            cc += w;
            ca += w * g;
            aa += w * g * g;
            cy += w * point.y;
            ay += w * g * point.y;
        }
        let rows = &rows[..points.len()];
        let det = cc * aa - ca * ca;
        let spread = [aa / det, -ca / det, cc / det];
        let base = ((aa * cy - ca * ay) / det).clamp(0.0, LARGEST_BASE);
        let scale = ((ay - ca * base) / aa).max(1e-12);
        let mut misfit = (base - usual).powi(2) * prior
            + ((exponent - USUAL_EXPONENT[0]) / USUAL_EXPONENT[1]).powi(2);
        let mut residuals = [(0.0, 0.0); FRAMES];
        for (residual, &(g, y, w, fade)) in residuals.iter_mut().zip(rows) {
            let time = base + scale * g;
            misfit += w * (y - time).powi(2);
            *residual = ((y / time).ln(), fade);
        }
        let shift = middle(&mut residuals[..rows.len()]).exp();
        Self {
            exponent,
            base: base * shift,
            scale: scale * shift,
            spread,
            misfit,
        }
    }

    /// Variance of the frame time where what is drawn has grown so much.
    fn variance(&self, growth: f64) -> f64 {
        let [base, both, scale] = self.spread;
        (base + 2.0 * both * growth + scale * growth * growth).max(0.0)
    }

    /// ln of the `far_dist`, from the origin, at which a frame takes `time` targets, where it takes
    /// so many standard deviations more than expected.
    fn meets(&self, time: f64, deviations: f64) -> f64 {
        let room = time - self.base;
        let growth = if deviations == 0.0 {
            room / self.scale
        } else {
            // (room − a·g)² = k²·variance(g), the root where k has the sign of `deviations`.
            let k2 = deviations * deviations;
            let [vc, vca, va] = self.spread;
            let qa = self.scale * self.scale - k2 * va;
            let qb = room * self.scale + k2 * vca;
            let qc = room * room - k2 * vc;
            let root = (qb * qb - qa * qc).max(0.0).sqrt();
            if deviations > 0.0 { qc / (qb + root) } else if qa > 0.0 { (qb + root) / qa } else { f64::INFINITY }
        };
        growth.max(1e-12).ln() / self.exponent
    }
}

/// Mean of the values, each with its weight, in the middle of the weight ([`MIDDLE`]).
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
