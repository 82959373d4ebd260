//! The plants T = c + a·D^p that explain the last frames. Frame times are in parts of the target,
//! distances as logarithms.

use super::Sample;
use super::member::{Member, PLAUSIBLE, Point};
use super::plant::EXPONENTS;
use super::state::{FRAMES, Memory};

/// How many exponents are tried.
const MEMBERS: usize = 9;
/// Where fewer of them are plausible they are tried closer together, at most so often.
const FEW: usize = 4;
const CLOSER: usize = 6;
/// How much less each older frame counts.
const FADING: f64 = 0.9;
/// How far a plausible plant may pass the target: so much, or so many standard deviations of what
/// frames scatter anyway, but not all of it.
const MARGIN: f64 = 0.08;
const MARGIN_SCATTER: f64 = 2.0;
const LARGEST_MARGIN: f64 = 0.4;

/// Members with exponents evenly spread over those that are plausible.
#[derive(Debug, Clone, Copy)]
pub(super) struct Family {
    members: [Member; MEMBERS],
    /// ln D of the newest frame.
    origin: f64,
    scatter: f64,
    target_ms: f64,
}

impl Family {
    /// Fits every member; `scatter` is the relative standard deviation of frame times. `None`
    /// where there is no frame.
    pub(super) fn explaining(memory: &Memory, target_ms: f64, scatter: f64) -> Option<Self> {
        let origin = memory.samples().next()?.far_dist_m.ln();
        let mut places = [Point::default(); FRAMES];
        let (mut count, mut weight) = (0, 1.0 / (scatter * scatter));
        for (place, sample) in places.iter_mut().zip(memory.samples()) {
            *place = Point::of(sample, target_ms, origin, weight);
            count += 1;
            weight *= FADING;
        }
        let points = places.get(..count)?;
        let mut exponents = EXPONENTS;
        let mut members = spread(exponents, points);
        for _ in 0..CLOSER {
            let Some(closer) = closer(exponents, &members) else {
                break;
            };
            exponents = closer;
            members = spread(exponents, points);
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
        let point = Point::of(sample, self.target_ms, self.origin, 1.0);
        let surprises = self.plausible().map(|member| {
            let (time, variance) = member.predicts(point.x);
            let open = variance / (time * self.scatter).powi(2);
            (point.y / time).ln() / (1.0 + open).sqrt()
        });
        surprises.fold(
            f64::INFINITY,
            |least, s| if s.abs() < least.abs() { s } else { least },
        )
    }

    /// The `far_dist` to draw with next, m.
    pub(super) fn aim(&self) -> f64 {
        let (mut total, mut sum) = (0.0, 0.0);
        for member in &self.members {
            let likelihood = (-0.5 * member.misfit).exp();
            total += likelihood;
            sum += likelihood * member.meets(1.0, 0.0);
        }
        let estimate = sum / total;
        let margin = MARGIN
            .max(MARGIN_SCATTER * self.scatter)
            .min(LARGEST_MARGIN);
        let ends = |time, deviations| self.plausible().map(move |m| m.meets(time, deviations));
        let way = if estimate > 0.0 {
            let safe = ends(1.0 + margin, PLAUSIBLE).fold(f64::INFINITY, f64::min);
            estimate.min(safe.max(0.0))
        } else {
            let safe = ends(1.0 - margin, -PLAUSIBLE).fold(f64::NEG_INFINITY, f64::max);
            estimate.max(safe.min(0.0))
        };
        (self.origin + way).exp()
    }
}

/// Members with exponents evenly spread over a range, misfits less that of the best.
fn spread([low, high]: [f64; 2], points: &[Point]) -> [Member; MEMBERS] {
    let mut members = [Member::default(); MEMBERS];
    for (n, member) in members.iter_mut().enumerate() {
        let part = n as f64 / (MEMBERS - 1) as f64;
        *member = Member::fitted(low + part * (high - low), points);
    }
    let best = members.iter().map(|m| m.misfit).fold(f64::MAX, f64::min);
    for member in &mut members {
        member.misfit -= best;
    }
    members
}

/// The exponents around the plausible ones, where these are few.
fn closer([low, high]: [f64; 2], members: &[Member; MEMBERS]) -> Option<[f64; 2]> {
    let step = (high - low) / (MEMBERS - 1) as f64;
    let mut plausible = members.iter().filter(|member| member.is_plausible());
    if plausible.clone().count() >= FEW {
        return None;
    }
    let first = plausible.next()?.exponent;
    let last = plausible
        .next_back()
        .map_or(first, |member| member.exponent);
    Some([(first - step).max(low), (last + step).min(high)])
}
