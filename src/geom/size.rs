//! How large a box appears, and eight at a time whether it is large enough.
//!
//! # Error bound
//! The size is at least p where the distance d is at most k·r, with k twice the pixel scale
//! divided by p. Of eight boxes there are the radius ρ in f32, r ≤ ρ ≤ r·(1 + 2u) + m with u =
//! 2⁻²⁴ and m the smallest radius stored, and the squared distance q, for which |√q − d| ≤ e + δ·d
//! ([`Filter`]). So √q < (k·r − e)·(1 − δ) proves that the size is at least p, and √q >
//! (k·r + e)·(1 + δ) that it is less.
//!
//! Both sides are a multiple of ρ and a constant. Their product, sum and square round 3 times, the
//! factor once; with 2 u of ρ that is less than 8 u = δ, so factors are off by 2δ instead of δ.
//! The definition itself rounds in f64, which is nothing beside that. A constant keeps squares
//! out of the reach of underflow.

use wide::f32x8;

use super::filter::DISTANCE_SLACK;
use super::simd::Floats;
use super::{Aabb, EightDistances, Filter, Lanes, PixelScale, View};

impl View {
    /// Projected size of a box, pixels: the diagonal at the distance of the nearest point;
    /// infinite where a perspective's eye is inside. In a parallel view no distance matters.
    ///
    /// This is *the* size: which objects are large enough, and which are larger than others, is
    /// decided by comparing these numbers.
    ///
    /// Law: never less for a larger radius or a smaller distance, in floating point too: each
    /// operation is monotone. Where both overflow it is infinite.
    pub fn size_px(&self, b: &Aabb) -> f64 {
        let diagonal = 2.0 * b.radius();
        match self.pixels() {
            PixelScale::PerMetre(scale) => diagonal * scale,
            PixelScale::PerRadian(scale) => {
                let distance = b.distance(self.eye());
                let size = diagonal * scale / distance;
                if distance == 0.0 || size.is_nan() {
                    f64::INFINITY
                } else {
                    size
                }
            }
        }
    }
}

/// A size that boxes are compared with, in both certain forms.
#[derive(Debug, Clone, Copy)]
pub struct SizeThreshold {
    /// The size itself, pixels; may be infinite.
    pub px: f64,
    perspective: bool,
    /// A radius times this less that reaches no farther than the box may be away.
    certain: [f32x8; 2],
    /// A radius times this and that reaches as far as the box may be away.
    possible: [f32x8; 2],
}

/// Squares of this are f32 numbers like any other.
const TINY: f64 = 1e-18;
/// Larger factors would turn tiny radii into infinite ones.
const LARGEST_FACTOR: f64 = 1e30;

impl SizeThreshold {
    /// A size to compare with, pixels, 0 or more.
    pub fn new(filter: &Filter, pixels: PixelScale, px: f64) -> Self {
        const LESS: f64 = 1.0 - 2.0 * DISTANCE_SLACK;
        const MORE: f64 = 1.0 + 2.0 * DISTANCE_SLACK;
        let (perspective, scale, distance_error) = match pixels {
            PixelScale::PerRadian(scale) => (true, scale, filter.distance_error),
            // As if everything were 1 away.
            PixelScale::PerMetre(scale) => (false, scale, 0.0),
        };
        let factor = 2.0 * scale / px;
        let less = factor.min(LARGEST_FACTOR);
        let error = distance_error * MORE + TINY;
        let unsure = error + less * 2.0 * f64::from(f32::MIN_POSITIVE);
        let certain = [
            ((less * LESS) as f32).next_down(),
            (unsure as f32).next_up(),
        ];
        let possible = [((factor * MORE) as f32).next_up(), (error as f32).next_up()];
        Self {
            px,
            perspective,
            certain: certain.map(f32x8::splat),
            possible: possible.map(f32x8::splat),
        }
    }

    /// Boxes certainly of this size or larger. `radii` are as they are stored.
    #[inline(always)]
    pub fn reached<F: Floats>(&self, radii: F, distances: &EightDistances<F>) -> Lanes {
        let [factor, less] = &self.certain;
        let reach = radii * F::of(factor) - F::of(less);
        // Negative where nothing is certain.
        self.squared(distances).less(reach * reach.abs())
    }

    /// Boxes certainly smaller; `radii` are at least theirs.
    #[inline(always)]
    pub fn missed<F: Floats>(&self, radii: F, distances: &EightDistances<F>) -> Lanes {
        let [factor, more] = &self.possible;
        let reach = radii * F::of(factor) + F::of(more);
        (reach * reach).less(self.squared(distances))
    }

    /// [`SizeThreshold::reached`] of one box by its squared distance, which is 1 where distances
    /// do not matter.
    #[inline]
    pub fn is_reached(&self, radius: f32, squared_distance: f32) -> bool {
        let [factor, less] = self.certain.map(|same| same.as_array()[0]);
        let reach = radius * factor - less;
        squared_distance < reach * reach.abs()
    }

    /// [`SizeThreshold::missed`] in the same way.
    #[inline]
    pub fn is_missed(&self, radius: f32, squared_distance: f32) -> bool {
        let [factor, more] = self.possible.map(|same| same.as_array()[0]);
        let reach = radius * factor + more;
        reach * reach < squared_distance
    }

    #[inline(always)]
    fn squared<F: Floats>(&self, distances: &EightDistances<F>) -> F {
        if self.perspective {
            distances.squared
        } else {
            F::splat(1.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    #[test]
    fn one_box_is_judged_as_eight_are() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(11);
        for _ in 0..100_000 {
            let mut number = || 10.0_f32.powf(random.random_range(-6.0..6.0));
            let pair = |a: f32, b: f32| [f32x8::splat(a), f32x8::splat(b)];
            let threshold = SizeThreshold {
                px: 1.0,
                perspective: true,
                certain: pair(number(), number()),
                possible: pair(number(), number()),
            };
            // Near the border more often than not.
            let radius = number();
            let reach = radius * threshold.certain[0].as_array()[0];
            let squared = reach * reach * [1.0, 0.999, 1e-3, 1e3][random.random_range(0..4)];
            let distances = EightDistances {
                squared: f32x8::splat(squared),
            };
            let radii = f32x8::splat(radius);
            let lane = |set: Lanes| set & 1 == 1;
            assert_eq!(
                threshold.is_reached(radius, squared),
                lane(threshold.reached(radii, &distances))
            );
            assert_eq!(
                threshold.is_missed(radius, squared),
                lane(threshold.missed(radii, &distances))
            );
        }
    }
}
