//! Numbers m·2ᵉ with m of any length: every finite f64 is one, and so are sums and products.

use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

use num_bigint::{BigInt, Sign};

/// m·2ᵉ, exact.
#[derive(Debug, Clone)]
pub struct Dyadic {
    mantissa: BigInt,
    exponent: i64,
}

impl Dyadic {
    /// m·2ᵉ.
    pub fn new(mantissa: BigInt, exponent: i64) -> Self {
        Self { mantissa, exponent }
    }

    /// 0.
    pub fn zero() -> Self {
        Self::from(0)
    }

    /// m.
    pub fn mantissa(&self) -> &BigInt {
        &self.mantissa
    }

    /// e.
    pub fn exponent(&self) -> i64 {
        self.exponent
    }

    /// How the number compares with 0.
    pub fn sign(&self) -> Ordering {
        match self.mantissa.sign() {
            Sign::Minus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Plus => Ordering::Greater,
        }
    }

    /// The same multiplied by 2ᵏ.
    #[must_use]
    pub fn shifted(mut self, k: i64) -> Self {
        self.exponent += k;
        self
    }

    /// The least k with |x| < 2ᵏ; `None` for 0.
    pub fn magnitude(&self) -> Option<i64> {
        (self.sign() != Ordering::Equal).then(|| self.exponent + self.mantissa.bits().cast_signed())
    }

    /// The largest f64 that is not above the number; −∞ below all of them.
    pub fn floor_f64(&self) -> f64 {
        let Some(magnitude) = self.magnitude() else {
            return 0.0;
        };
        if magnitude > 1024 {
            return if self.sign() == Ordering::Greater {
                f64::MAX
            } else {
                f64::NEG_INFINITY
            };
        }
        // The last bit an f64 of this size has room for.
        let last = (magnitude - 53).max(-1074);
        let down = last - self.exponent;
        // A shift of a negative number to the right rounds down, too.
        let (mantissa, exponent) = if down > 0 {
            (&self.mantissa >> down, last)
        } else {
            (self.mantissa.clone(), self.exponent)
        };
        let digits = i64::try_from(&mantissa).unwrap_or(0) as f64;
        // In two steps, as 2^exponent alone may be out of range; neither rounds.
        let half = exponent / 2;
        digits * power_of_two(half) * power_of_two(exponent - half)
    }

    /// The smallest f64 that is not below the number; ∞ above all of them.
    pub fn ceil_f64(&self) -> f64 {
        -(-self).floor_f64()
    }
}

/// 2ᵏ for −1022 ≤ k ≤ 1023.
fn power_of_two(k: i64) -> f64 {
    f64::from_bits(((k + 1023) as u64) << 52)
}

impl From<i32> for Dyadic {
    fn from(n: i32) -> Self {
        Self::new(BigInt::from(n), 0)
    }
}

impl From<u32> for Dyadic {
    fn from(n: u32) -> Self {
        Self::new(BigInt::from(n), 0)
    }
}

impl From<f64> for Dyadic {
    /// Exact; for what is not finite there is no number, and 0 stands in.
    fn from(x: f64) -> Self {
        let bits = x.to_bits();
        let fraction = (bits & ((1 << 52) - 1)).cast_signed();
        let (digits, exponent) = match ((bits >> 52) & 0x7ff).cast_signed() {
            0 => (fraction, -1074),
            2047 => (0, 0),
            biased => (fraction | 1 << 52, biased - 1075),
        };
        if digits == 0 {
            return Self::new(BigInt::ZERO, 0);
        }
        let zeros = digits.trailing_zeros();
        let digits = (digits >> zeros) * if x < 0.0 { -1 } else { 1 };
        Self::new(BigInt::from(digits), exponent + i64::from(zeros))
    }
}

/// Both mantissas at the lower of the two exponents.
fn combine(a: &Dyadic, b: &Dyadic, f: impl FnOnce(&BigInt, &BigInt) -> BigInt) -> Dyadic {
    let exponent = a.exponent.min(b.exponent);
    let mantissa = match a.exponent.cmp(&b.exponent) {
        Ordering::Equal => f(&a.mantissa, &b.mantissa),
        Ordering::Greater => f(&(&a.mantissa << (a.exponent - exponent)), &b.mantissa),
        Ordering::Less => f(&a.mantissa, &(&b.mantissa << (b.exponent - exponent))),
    };
    Dyadic { mantissa, exponent }
}

impl Add for &Dyadic {
    type Output = Dyadic;

    fn add(self, other: Self) -> Dyadic {
        match (self.mantissa.sign(), other.mantissa.sign()) {
            (Sign::NoSign, _) => other.clone(),
            (_, Sign::NoSign) => self.clone(),
            _ => combine(self, other, |a, b| a + b),
        }
    }
}

impl Sub for &Dyadic {
    type Output = Dyadic;

    fn sub(self, other: Self) -> Dyadic {
        match (self.mantissa.sign(), other.mantissa.sign()) {
            (Sign::NoSign, _) => -other,
            (_, Sign::NoSign) => self.clone(),
            _ => combine(self, other, |a, b| a - b),
        }
    }
}

impl Mul for &Dyadic {
    type Output = Dyadic;

    fn mul(self, other: Self) -> Dyadic {
        Dyadic {
            mantissa: &self.mantissa * &other.mantissa,
            exponent: self.exponent + other.exponent,
        }
    }
}

impl Neg for &Dyadic {
    type Output = Dyadic;

    fn neg(self) -> Dyadic {
        Dyadic {
            mantissa: -&self.mantissa,
            exponent: self.exponent,
        }
    }
}

impl PartialEq for Dyadic {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Dyadic {}

impl PartialOrd for Dyadic {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Dyadic {
    fn cmp(&self, other: &Self) -> Ordering {
        (self - other).sign()
    }
}
