//! f64 intervals, rounded outward: what they decide is certain, what they leave open is left to
//! exact numbers.

use std::ops::{Add, Mul};

/// All numbers from `low` to `high`.
///
/// An operation rounds its f64 result to the nearest, so the next f64 on either side encloses
/// it, overflow and underflow included. `low` is never +∞ and `high` never −∞, so no sum is NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Not above the number.
    pub low: f64,
    /// Not below it.
    pub high: f64,
}

impl Interval {
    const ENTIRE: Self = Self {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };

    /// a − b.
    pub fn difference(a: f64, b: f64) -> Self {
        let near = a - b;
        Self {
            low: near.next_down(),
            high: near.next_up(),
        }
    }

    /// The larger of two numbers.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            low: self.low.max(other.low),
            high: self.high.max(other.high),
        }
    }

    /// The smaller of two numbers.
    #[must_use]
    pub fn min(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.min(other.high),
        }
    }

    /// x² for x ≥ 0.
    #[must_use]
    pub fn squared(self) -> Self {
        Self {
            low: (self.low.max(0.0) * self.low.max(0.0)).next_down(),
            high: (self.high * self.high).next_up(),
        }
    }
}

impl From<f64> for Interval {
    fn from(number: f64) -> Self {
        Self {
            low: number,
            high: number,
        }
    }
}

impl Add for Interval {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            low: (self.low + other.low).next_down(),
            high: (self.high + other.high).next_up(),
        }
    }
}

impl Mul for Interval {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let products = [
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ];
        if products.iter().any(|p| p.is_nan()) {
            return Self::ENTIRE;
        }
        Self {
            low: products
                .into_iter()
                .fold(f64::INFINITY, f64::min)
                .next_down(),
            high: products
                .into_iter()
                .fold(f64::NEG_INFINITY, f64::max)
                .next_up(),
        }
    }
}
