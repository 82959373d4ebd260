//! Roots and tangents between two dyadic numbers, as close as one likes.

use num_bigint::{BigInt, Sign};

use super::dyadic::Dyadic;

/// A real number that lies between two dyadic ones, or is one.
#[derive(Debug, Clone)]
pub struct Enclosure {
    /// Not above the number.
    pub low: Dyadic,
    /// Not below it.
    pub high: Dyadic,
}

impl Enclosure {
    /// A number that is dyadic itself.
    pub fn exact(number: Dyadic) -> Self {
        Self {
            high: number.clone(),
            low: number,
        }
    }

    /// Whether it is known exactly.
    pub fn is_exact(&self) -> bool {
        self.low == self.high
    }

    /// Times a number of any sign.
    #[must_use]
    pub fn times(&self, factor: &Dyadic) -> Self {
        let (a, b) = (&self.low * factor, &self.high * factor);
        if a <= b {
            Self { low: a, high: b }
        } else {
            Self { low: b, high: a }
        }
    }

    /// Product of two numbers that are not negative.
    #[must_use]
    pub fn times_positive(&self, other: &Self) -> Self {
        Self {
            low: &self.low * &other.low,
            high: &self.high * &other.high,
        }
    }

    /// √x for x ≥ 0, to `bits` significant bits; exact where the root is dyadic and short enough.
    pub fn sqrt(x: &Dyadic, bits: u32) -> Self {
        let Some(magnitude) = x.magnitude() else {
            return Self::exact(Dyadic::zero());
        };
        // Digits to 2^(2·last) give a root to 2^last.
        let last = magnitude.div_euclid(2) - i64::from(bits);
        let shift = x.exponent() - 2 * last;
        let (digits, cut) = if shift >= 0 {
            (x.mantissa() << shift, false)
        } else {
            let digits = x.mantissa() >> -shift;
            let cut = (&digits << -shift) != *x.mantissa();
            (digits, cut)
        };
        let root = digits.sqrt();
        let low = Dyadic::new(root.clone(), last);
        if !cut && &root * &root == digits {
            Self::exact(low)
        } else {
            Self {
                low,
                high: Dyadic::new(root + 1, last),
            }
        }
    }

    /// tan(d/2) for d degrees, 0 < d < 180, to about `bits` significant bits.
    ///
    /// Exact for d = 90. No other dyadic number of degrees has a rational tangent of its half
    /// (Niven, "Irrational Numbers", 3.11), so no other needs to be.
    pub fn tan_half_degrees(degrees: f64, bits: u32) -> Self {
        if degrees == 90.0 {
            return Self::exact(Dyadic::from(1));
        }
        let degrees = Dyadic::from(degrees);
        // Small angles and those near 180° lose leading digits.
        let lost = |x: &Dyadic| x.magnitude().map_or(0, |m| (8 - m).max(0));
        let lost = lost(&degrees) + lost(&(&Dyadic::from(180) - &degrees));
        let unit = i64::from(bits) + 32 + lost; // fixed point, in units of 2^-unit
        // x = π·d/360, off by at most 2 units: π by 2, times less than 1/2, and a division.
        let numerator = &pi(unit) * degrees.mantissa();
        let shift = degrees.exponent();
        let numerator = if shift >= 0 {
            numerator << shift
        } else {
            numerator >> -shift
        };
        let (sine, cosine, error) = sine_and_cosine(&(numerator / 360), unit);
        // Neither moves by more than the angle.
        let error = BigInt::from(error + 3);
        let quotient = |n: BigInt, d: BigInt| (n << unit) / d;
        Self {
            low: Dyadic::new(quotient(&sine - &error, &cosine + &error), -unit),
            high: Dyadic::new(quotient(&sine + &error, &cosine - &error) + 1, -unit),
        }
    }
}

/// π in units of 2^-unit, off by less than 1: π = 16 arctan 1/5 − 4 arctan 1/239 (Machin).
fn pi(unit: i64) -> BigInt {
    const GUARD: i64 = 32;
    let arctan_of_inverse = |x: u32| {
        let mut power = (BigInt::from(1) << (unit + GUARD)) / x;
        let mut sum = BigInt::ZERO;
        let mut n = 1_u32;
        while power.sign() != Sign::NoSign {
            let term = &power / n;
            sum += if n % 4 == 1 { term } else { -term };
            power /= x * x;
            n += 2;
        }
        sum
    };
    // Each of some thousand terms at most is off by 2 of 2^-GUARD units.
    let pi: BigInt = 16 * arctan_of_inverse(5) - 4 * arctan_of_inverse(239);
    pi >> GUARD
}

/// Sine and cosine of 0 ≤ x < 2 by their series, all in units of 2^-unit, and by how many units
/// both may be off.
fn sine_and_cosine(x: &BigInt, unit: i64) -> (BigInt, BigInt, u32) {
    let mut sums = [BigInt::ZERO, BigInt::from(1) << unit]; // odd terms, even terms
    let mut term = sums[1].clone();
    let mut n = 0_u32;
    while term.sign() != Sign::NoSign {
        n += 1;
        term = ((&term * x) >> unit) / n;
        let negative = n % 4 >= 2;
        sums[usize::from(n.is_multiple_of(2))] += if negative { -&term } else { term.clone() };
    }
    let [sine, cosine] = sums;
    // A term is off by at most 2 units, and by x/n < 2 times what the one before was: 6 at most.
    // The series alternates, so what was left out is less than the last term, 1 unit.
    (sine, cosine, 8 * n)
}
