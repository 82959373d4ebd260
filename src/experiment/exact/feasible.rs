//! Whether half-spaces have a point in common.
//!
//! Seidel, "Small-dimensional linear programming and convex hulls made easy" (1991), without an
//! objective: half-spaces are taken one after another. Where the point found so far lies outside
//! the next one, the points that satisfy both, if there are any, include one on its border: the
//! way from the old point to a common one crosses it. The border has one dimension less.
//!
//! Points and half-spaces are homogeneous, so nothing is divided and nothing rounded.

use std::cmp::Ordering;

use super::dyadic::Dyadic;

/// What the search computes with.
pub(super) trait Number: Clone {
    fn zero() -> Self;
    fn one() -> Self;
    fn sign(&self) -> Ordering;
    fn negated(&self) -> Self;
    fn times(&self, other: &Self) -> Self;
    fn plus(&self, other: &Self) -> Self;
}

impl Number for Dyadic {
    fn zero() -> Self {
        Self::zero()
    }

    fn one() -> Self {
        Self::from(1)
    }

    fn sign(&self) -> Ordering {
        Self::sign(self)
    }

    fn negated(&self) -> Self {
        -self
    }

    fn times(&self, other: &Self) -> Self {
        self * other
    }

    fn plus(&self, other: &Self) -> Self {
        self + other
    }
}

/// For guesses only: what is found has to be proved otherwise.
impl Number for f64 {
    fn zero() -> Self {
        0.0
    }

    fn one() -> Self {
        1.0
    }

    fn sign(&self) -> Ordering {
        self.partial_cmp(&0.0).unwrap_or(Ordering::Less)
    }

    fn negated(&self) -> Self {
        -self
    }

    fn times(&self, other: &Self) -> Self {
        self * other
    }

    fn plus(&self, other: &Self) -> Self {
        self + other
    }
}

/// A point (x₁, x₂, …, w), w > 0, with Σ aᵢ·xᵢ + b·w ≥ 0 for every row (a₁, a₂, …, b).
pub(super) fn common_point<N: Number>(rows: &[Vec<N>], dimensions: usize) -> Option<Vec<N>> {
    let mut point = vec![N::zero(); dimensions];
    point.push(N::one());
    for (taken, row) in rows.iter().enumerate() {
        if dot(row, &point).sign() != Ordering::Less {
            continue;
        }
        let pivot = (0..dimensions).find(|&k| row[k].sign() != Ordering::Equal)?;
        let on_border: Vec<Vec<N>> = rows[..taken]
            .iter()
            .map(|other| restricted(other, row, pivot))
            .collect();
        point = lifted(&common_point(&on_border, dimensions - 1)?, row, pivot);
    }
    Some(point)
}

fn dot<N: Number>(row: &[N], point: &[N]) -> N {
    let terms = row.iter().zip(point).map(|(a, x)| a.times(x));
    terms.fold(N::zero(), |sum, term| sum.plus(&term))
}

fn absolute<N: Number>(x: &N) -> N {
    if x.sign() == Ordering::Less {
        x.negated()
    } else {
        x.clone()
    }
}

/// `row` on the border of the half-space `border`, without coordinate `pivot`.
fn restricted<N: Number>(row: &[N], border: &[N], pivot: usize) -> Vec<N> {
    let without = |row: &[N]| -> Vec<N> {
        let kept = row.iter().enumerate().filter(|&(k, _)| k != pivot);
        kept.map(|(_, a)| a.clone()).collect()
    };
    if row[pivot].sign() == Ordering::Equal {
        return without(row);
    }
    let scale = absolute(&border[pivot]);
    let taken = if border[pivot].sign() == Ordering::Less {
        row[pivot].clone()
    } else {
        row[pivot].negated()
    };
    let pairs = without(row).into_iter().zip(without(border));
    pairs
        .map(|(a, b)| a.times(&scale).plus(&b.times(&taken)))
        .collect()
}

/// The point on the border of the half-space whose other coordinates are given.
fn lifted<N: Number>(point: &[N], border: &[N], pivot: usize) -> Vec<N> {
    let others = border.iter().enumerate().filter(|&(k, _)| k != pivot);
    let sum = others
        .zip(point)
        .fold(N::zero(), |sum, ((_, a), x)| sum.plus(&a.times(x)));
    let scale = absolute(&border[pivot]);
    let mut lifted: Vec<N> = point.iter().map(|x| x.times(&scale)).collect();
    let coordinate = if border[pivot].sign() == Ordering::Less {
        sum
    } else {
        sum.negated()
    };
    lifted.insert(pivot, coordinate);
    lifted
}
