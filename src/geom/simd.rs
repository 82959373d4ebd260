//! Eight f32 at a time, in the widest registers there are.
//!
//! Every operation is a single IEEE one, none fused, so the bits are the same in two registers of
//! four and in one of eight. What is worth it is compiled twice and chosen where it runs
//! ([`widest`]); there everything on the way must be inlined, so that it is compiled for the
//! instructions of its caller. With registers of eight both kinds of walk, by range and by size,
//! take four fifths of the time.

use std::cell::Cell;
use std::ops::{Add, BitOr, Div, Mul, Sub};

use wide::f32x8;

use super::Lanes;

/// Eight numbers.
pub trait Floats:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + BitOr<Output = Self>
{
    /// As they lie in memory.
    fn of(floats: &f32x8) -> Self;
    /// As they lie in memory, wherever that begins.
    fn of_array(floats: &[f32; 8]) -> Self;
    /// The same number eight times.
    fn splat(float: f32) -> Self;
    /// The larger, or the other where one is no number.
    #[must_use]
    fn larger(self, other: Self) -> Self;
    /// Without signs.
    #[must_use]
    fn abs(self) -> Self;
    /// Those that are less than the others.
    fn less(self, other: Self) -> Lanes;
    /// Those that are not more than the others; not where one is no number.
    fn at_most(self, other: Self) -> Lanes;
    /// Those whose sign is negative.
    fn negative(self) -> Lanes;
    /// One by one.
    fn to_array(self) -> [f32; 8];
}

impl Floats for f32x8 {
    #[inline(always)]
    fn of(floats: &f32x8) -> Self {
        *floats
    }

    #[inline(always)]
    fn of_array(floats: &[f32; 8]) -> Self {
        Self::from(*floats)
    }

    #[inline(always)]
    fn splat(float: f32) -> Self {
        f32x8::splat(float)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.fast_max(other)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f32x8::abs(self)
    }

    #[inline(always)]
    fn less(self, other: Self) -> Lanes {
        self.simd_lt(other).to_bitmask()
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Lanes {
        self.simd_le(other).to_bitmask()
    }

    #[inline(always)]
    fn negative(self) -> Lanes {
        self.to_bitmask()
    }

    #[inline(always)]
    fn to_array(self) -> [f32; 8] {
        f32x8::to_array(self)
    }
}

/// A computation that is compiled for each kind of register.
pub trait Kernel {
    /// What comes of it.
    type Output;

    /// Does it. To be inlined, with all it calls that handles `F`.
    fn run<F: Floats>(self) -> Self::Output;
}

/// Runs in the widest registers of this machine.
#[inline]
pub(crate) fn widest<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(available) = avx2::available() {
        return avx2::run(available, kernel);
    }
    kernel.run::<f32x8>()
}

thread_local! {
    static ONLY_FOUR: Cell<bool> = const { Cell::new(false) };
}

/// Does something on this thread as on a machine that has registers of four only: the same comes
/// of it, in more time. Returns `None` where this is such a machine.
pub fn in_registers_of_four<T>(work: impl FnOnce() -> T) -> Option<T> {
    #[cfg(target_arch = "x86_64")]
    if avx2::available().is_some() {
        struct Again;
        impl Drop for Again {
            fn drop(&mut self) {
                ONLY_FOUR.set(false);
            }
        }
        ONLY_FOUR.set(true);
        let _again = Again; // where the work panics too
        return Some(work());
    }
    drop(work);
    None
}

#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "instructions that not every machine has: all are behind `available`"
)]
mod avx2 {
    use std::arch::x86_64::{
        __m256, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_ps, _mm256_andnot_ps, _mm256_cmp_ps,
        _mm256_div_ps, _mm256_loadu_ps, _mm256_max_ps, _mm256_movemask_ps, _mm256_mul_ps,
        _mm256_or_ps, _mm256_set1_ps, _mm256_storeu_ps, _mm256_sub_ps,
    };
    use std::ops::{Add, BitOr, Div, Mul, Sub};

    use wide::f32x8;

    use super::{Floats, Kernel, ONLY_FOUR};
    use crate::geom::Lanes;

    /// Proof that this machine has AVX2.
    #[derive(Clone, Copy)]
    pub(super) struct Available(());

    #[inline]
    pub(super) fn available() -> Option<Available> {
        let known = !ONLY_FOUR.get()
            && is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2");
        known.then_some(Available(()))
    }

    #[inline]
    pub(super) fn run<K: Kernel>(_: Available, kernel: K) -> K::Output {
        // SAFETY: there is proof that the machine has these instructions.
        unsafe { compiled(kernel) }
    }

    #[target_feature(enable = "avx2,bmi1,bmi2")]
    fn compiled<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<Avx2>()
    }

    /// Eight numbers in one register. There are none but in work that [`run`] does.
    #[derive(Clone, Copy)]
    struct Avx2(__m256);

    macro_rules! operation {
        ($trait:ident $function:ident $instruction:ident) => {
            impl $trait for Avx2 {
                type Output = Self;

                #[inline(always)]
                fn $function(self, other: Self) -> Self {
                    // SAFETY: only what runs behind `available` has such numbers.
                    Self(unsafe { $instruction(self.0, other.0) })
                }
            }
        };
    }

    operation!(Add add _mm256_add_ps);
    operation!(Sub sub _mm256_sub_ps);
    operation!(Mul mul _mm256_mul_ps);
    operation!(Div div _mm256_div_ps);
    operation!(BitOr bitor _mm256_or_ps);

    // SAFETY of all blocks: as above. Loads read the eight numbers of a reference.
    impl Floats for Avx2 {
        #[inline(always)]
        fn of(floats: &f32x8) -> Self {
            Self(unsafe { _mm256_loadu_ps(floats.as_array().as_ptr()) })
        }

        #[inline(always)]
        fn of_array(floats: &[f32; 8]) -> Self {
            Self(unsafe { _mm256_loadu_ps(floats.as_ptr()) })
        }

        #[inline(always)]
        fn splat(float: f32) -> Self {
            Self(unsafe { _mm256_set1_ps(float) })
        }

        #[inline(always)]
        fn larger(self, other: Self) -> Self {
            Self(unsafe { _mm256_max_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn abs(self) -> Self {
            Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
        }

        #[inline(always)]
        fn less(self, other: Self) -> Lanes {
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) as Lanes }
        }

        #[inline(always)]
        fn at_most(self, other: Self) -> Lanes {
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)) as Lanes }
        }

        #[inline(always)]
        fn negative(self) -> Lanes {
            unsafe { _mm256_movemask_ps(self.0) as Lanes }
        }

        #[inline(always)]
        fn to_array(self) -> [f32; 8] {
            let mut floats = [0.0; 8];
            unsafe { _mm256_storeu_ps(floats.as_mut_ptr(), self.0) };
            floats
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    /// Every operation on two times eight numbers.
    struct All([f32x8; 2]);

    impl Kernel for All {
        type Output = ([[u32; 8]; 9], [Lanes; 5]);

        #[inline(always)]
        fn run<F: Floats>(self) -> Self::Output {
            let Self([a, b]) = self;
            let (x, y) = (F::of(&a), F::of_array(b.as_array()));
            let all = [
                x + y,
                x - y,
                x * y,
                x / y,
                x | y,
                x.larger(y),
                x.abs(),
                F::splat(a.as_array()[0]),
                y,
            ];
            (
                all.map(|floats| floats.to_array().map(f32::to_bits)),
                [
                    x.less(y),
                    y.less(x),
                    x.at_most(y),
                    y.at_most(x),
                    x.negative(),
                ],
            )
        }
    }

    #[test]
    fn registers_of_eight_give_the_bits_of_registers_of_four() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(7);
        // Any number, infinities and those too small to be normal too. What is no number comes of
        // infinities only: of two such the compiler may keep either.
        let special = [
            0.0,
            -0.0,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            1e-45,
            1.0,
            -1.0,
        ];
        for _ in 0..100_000 {
            let mut eight = || {
                f32x8::from(std::array::from_fn::<f32, 8, _>(|_| {
                    if random.random_range(0..4) == 0 {
                        special[random.random_range(0..special.len())]
                    } else {
                        let any = f32::from_bits(random.random());
                        if any.is_nan() { 1.0 } else { any }
                    }
                }))
            };
            let numbers = [eight(), eight()];
            assert_eq!(
                widest(All(numbers)),
                All(numbers).run::<f32x8>(),
                "{numbers:?}"
            );
        }
    }
    /// Comparisons of two times eight numbers.
    struct Comparisons([f32x8; 2]);

    impl Kernel for Comparisons {
        type Output = [Lanes; 2];

        #[inline(always)]
        fn run<F: Floats>(self) -> Self::Output {
            let [a, b] = self.0.map(|floats| F::of(&floats));
            [a.less(b), a.at_most(b)]
        }
    }

    #[test]
    fn nothing_compares_with_what_is_no_number() {
        let special = [
            f32::NAN,
            f32::NEG_INFINITY,
            -1.0,
            -0.0,
            0.0,
            1e-45,
            1.0,
            f32::INFINITY,
        ];
        for number in special {
            let numbers = [f32x8::from(special), f32x8::splat(number)];
            let expected = |holds: fn(&f32, &f32) -> bool| {
                (0..8).fold(0, |set, lane| {
                    set | Lanes::from(holds(&special[lane as usize], &number)) << lane
                })
            };
            let expected = [expected(f32::lt), expected(f32::le)];
            assert_eq!(widest(Comparisons(numbers)), expected, "{number}");
            assert_eq!(Comparisons(numbers).run::<f32x8>(), expected, "{number}");
        }
    }
}
