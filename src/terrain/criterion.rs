//! Whether a node is drawn in parts: the criteria of the four papers.
//!
//! Each compares a quotient f with 1; here it is written as a product, so that nothing divides by
//! the zero of flat ground. A node without error or relief is never split.

use super::block::NodeRecord;
use crate::geom::DVec3;

/// Which paper's criterion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Criterion {
    /// A: distance against roughness.
    Roughness,
    /// B: distance against the largest error.
    Error,
    /// C: spread of heights against distance and speed.
    Motion,
    /// D: vertex error against the largest coordinate difference.
    Vertex,
}

/// What the criteria are tuned by; each uses those that its equation names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knobs {
    /// C1. In A and B a larger one gives more triangles, in C, where it divides, fewer.
    pub c1: f64,
    /// C2, likewise.
    pub c2: f64,
    /// C: speed of the eye, m/s. Up to [`REST_MPS`] the eye counts as standing still.
    pub speed_mps: f64,
    /// D, and the error that C stops at: a larger one gives more triangles.
    pub threshold: f64,
}

/// A knob that cannot be.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{knob} must be a number, {least}, is {value}")]
pub struct KnobError {
    /// Which one.
    pub knob: &'static str,
    /// What it must be.
    pub least: &'static str,
    /// As given.
    pub value: f64,
}

/// A node as an eye sees it.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    /// What is known of it.
    pub record: &'a NodeRecord,
    /// From its centre to the eye.
    pub to_eye: DVec3,
    /// Length of its longer side, m.
    pub side: f64,
    /// That of the block it is in.
    pub block_side: f64,
}

/// Speeds up to this, m/s, are standing still: C's f has the speed in its denominator.
pub const REST_MPS: f64 = 1.0;

impl Criterion {
    /// All of them, in the order of the papers.
    pub const ALL: [Self; 4] = [Self::Roughness, Self::Error, Self::Motion, Self::Vertex];

    /// What it is chosen by.
    pub fn name(self) -> &'static str {
        match self {
            Self::Roughness => "roughness",
            Self::Error => "error",
            Self::Motion => "motion",
            Self::Vertex => "vertex",
        }
    }

    /// Knobs to start from: they split what errs by more than about a thousandth of its distance.
    /// C1 and C2 of C have a unit of their own; from these on they begin to tell in motion.
    pub fn knobs(self) -> Knobs {
        let (c1, c2) = match self {
            Self::Roughness | Self::Vertex => (32.0, 32.0),
            Self::Error => (1024.0, 1024.0),
            Self::Motion => (0.0005, 0.0005),
        };
        Knobs {
            c1,
            c2,
            speed_mps: 0.0,
            threshold: 1024.0,
        }
    }

    /// Whether the node is to be drawn in parts.
    pub fn splits(self, seen: &Seen, knobs: &Knobs) -> bool {
        match self {
            Self::Roughness => roughness(seen, knobs),
            Self::Error => error(seen, knobs),
            Self::Motion => motion(seen, knobs),
            Self::Vertex => vertex(seen, knobs),
        }
    }

    /// The knobs for a share of the detail, in (0, 1]: a node that is split with a share is split
    /// with a larger one.
    #[must_use]
    pub fn share(self, knobs: &Knobs, share: f64) -> Knobs {
        let (c1, c2) = match self {
            Self::Roughness | Self::Vertex => (knobs.c1 * share, knobs.c2),
            Self::Error => (knobs.c1 * share, knobs.c2 * share),
            Self::Motion => (knobs.c1 / share, knobs.c2),
        };
        Knobs {
            c1,
            c2,
            threshold: knobs.threshold * share,
            ..*knobs
        }
    }
}

impl Knobs {
    /// The same knobs, if they can be.
    ///
    /// # Errors
    /// [`KnobError`] for C1, C2 or a threshold that is not a positive number, and for a speed that
    /// is not a number from 0 up.
    pub fn checked(self) -> Result<Self, KnobError> {
        let above_zero = [
            ("c1", self.c1),
            ("c2", self.c2),
            ("threshold", self.threshold),
        ];
        for (knob, value) in above_zero {
            if !(value > 0.0 && value.is_finite()) {
                let least = "above 0";
                return Err(KnobError { knob, least, value });
            }
        }
        let value = self.speed_mps;
        if !(value >= 0.0 && value.is_finite()) {
            return Err(KnobError {
                knob: "speed_mps",
                least: "0 or more",
                value,
            });
        }
        Ok(self)
    }
}

impl Seen<'_> {
    /// L: from the eye to the centre of the node, m.
    pub fn distance(&self) -> f64 {
        self.to_eye.length()
    }

    /// R: the largest Δh of the node over its side.
    ///
    /// Source: A, equation (2).
    pub fn roughness(&self) -> f64 {
        f64::from(self.record.vertex_error) / self.side
    }
}

/// f = L/(D·R·C1·C2) < 1.
///
/// Source: A, equation (5).
fn roughness(seen: &Seen, knobs: &Knobs) -> bool {
    seen.distance() < seen.side * seen.roughness() * knobs.c1 * knobs.c2
}

/// L/D ≤ C1, L/ε < C2 and f = L/(D·ε·C1·C2) < 1.
///
/// The unit of f is 1/m: on large nodes it is below 1 whatever the other two say, so all three
/// must hold.
///
/// Source: B, equations (1) to (3).
fn error(seen: &Seen, knobs: &Knobs) -> bool {
    let (l, d, e) = (seen.distance(), seen.side, f64::from(seen.record.error));
    l <= d * knobs.c1 && l < e * knobs.c2 && l < d * e * knobs.c1 * knobs.c2
}

/// f = D(z)/(C1·C2·L·r·v) ≥ 1 and ε·Threshold > L·v, v in units of [`REST_MPS`] and 1 at rest.
/// Here a small f means good enough, the other way round than in A and B.
///
/// The second is not in the paper. D(z), the spread of heights, says where the ground is rough but
/// not how far off it is drawn: a slope drawn as a slope has a large spread and no error, and f
/// alone splits it to the end. So what errs by less than a standing error is drawn as it is, and
/// with speed both let go by the same measure.
///
/// r is the side of the block, as in C's section 2.1. With that of the node f would rise from
/// parent to child on any ground rougher than a plane, and a block be split whole or not at all.
///
/// Source: C, equation (1).
fn motion(seen: &Seen, knobs: &Knobs) -> bool {
    let v = knobs.speed_mps.max(REST_MPS);
    let (l, e) = (seen.distance(), f64::from(seen.record.error));
    let spread = f64::from(seen.record.deviation);
    spread >= knobs.c1 * knobs.c2 * l * seen.block_side * v
        && e * knobs.threshold > l * v / REST_MPS
}

/// error·Threshold > L1, the largest coordinate difference between eye and vertex. The node's
/// vertices are taken at its centre, D's test of a whole box.
///
/// Source: D, equations (1) and (2). Printed as error·Threshold < L1, which contradicts the text:
/// a larger threshold is to give more detail.
fn vertex(seen: &Seen, knobs: &Knobs) -> bool {
    let l1 = seen.to_eye.abs().max_element();
    f64::from(seen.record.vertex_error) * knobs.threshold > l1
}
