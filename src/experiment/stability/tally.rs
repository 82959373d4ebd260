//! What was asked and what went wrong.

use std::ops::AddAssign;

use serde::Serialize;

/// Counts of cases and of broken promises. A case is one box, of an object or a node, in one
/// view.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Tally {
    /// Boxes asked about.
    pub cases: u64,
    /// Boxes that meet the frustum and were said to be outside, by f64, by f32 or by leaving
    /// them out of an answer (N2).
    pub false_negatives: u64,
    /// Boxes said to be inside that are not (N3).
    pub false_inside: u64,
    /// Boxes nearer than the box around them, in floating point (N4).
    pub monotone_violations: u64,
    /// Answers that depend on what they must not depend on, and distances on the wrong side of
    /// a range (N5).
    pub mismatches: u64,
    /// Of the cases: boxes that meet the frustum.
    pub meeting: u64,
    /// Of the cases: boxes wholly inside.
    pub inside: u64,
    /// Of the cases: boxes kept by the planes that do not meet the frustum.
    pub kept_outside: u64,
    /// Of these: kept by the separating axes too.
    pub not_separated: u64,
    /// Of the cases: touching the frustum too closely to tell; they count as meeting it and as
    /// not inside.
    pub open: u64,
    /// Distances within rounding of a range's border.
    pub at_border: u64,
}

impl Tally {
    /// Whether every promise was kept.
    pub fn is_clean(&self) -> bool {
        self.false_negatives + self.false_inside + self.monotone_violations + self.mismatches == 0
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.cases += other.cases;
        self.false_negatives += other.false_negatives;
        self.false_inside += other.false_inside;
        self.monotone_violations += other.monotone_violations;
        self.mismatches += other.mismatches;
        self.meeting += other.meeting;
        self.inside += other.inside;
        self.kept_outside += other.kept_outside;
        self.not_separated += other.not_separated;
        self.open += other.open;
        self.at_border += other.at_border;
    }
}

impl std::iter::Sum for Tally {
    fn sum<I: Iterator<Item = Self>>(tallies: I) -> Self {
        tallies.fold(Self::default(), |mut sum, tally| {
            sum += tally;
            sum
        })
    }
}
