//! The largest size on the screen of things known by radius and distance.

use wide::{f32x8, i32x8};

use super::filter::DISTANCE_SLACK;
use super::{EightDistances, Filter, Floats, Lanes, PixelScale};

/// Keeps an upper bound of radius/distance in a perspective, of the radius otherwise.
///
/// Most of what comes is smaller than what came before, and is told so without a root: with b
/// the bound so far and e the error of a distance d, r/(d − e) ≤ b follows from (r + b·e)² ≤
/// b²·d².
#[derive(Debug, Clone)]
pub struct LargestSize {
    perspective: bool,
    distance_error: f32,
    bound: f32,
    /// b·e, and so much that squares of radii do not vanish.
    margin: f32x8,
    /// b², less than all roundings of the comparison.
    squared: f32x8,
}

impl LargestSize {
    /// Nothing seen yet, 0.
    pub fn new(filter: &Filter, pixels: PixelScale) -> Self {
        let mut largest = Self {
            perspective: matches!(pixels, PixelScale::PerRadian(_)),
            distance_error: (filter.distance_error as f32).next_up(),
            bound: 0.0,
            margin: f32x8::ZERO,
            squared: f32x8::ZERO,
        };
        largest.set(0.0);
        largest
    }

    /// The bound.
    pub fn bound(&self) -> f32 {
        self.bound
    }

    /// Those of `set` that may be larger than the bound.
    #[inline(always)]
    pub fn exceeding<F: Floats>(
        &self,
        radii: F,
        distances: &EightDistances<F>,
        set: Lanes,
    ) -> Lanes {
        let within = if self.perspective {
            let radii = radii + F::of(&self.margin);
            (radii * radii).at_most(distances.squared * F::of(&self.squared))
        } else {
            radii.at_most(F::splat(self.bound))
        };
        set & !within
    }

    /// Takes the boxes in `set` into account, infinitely large around the eye.
    #[inline(never)]
    pub fn raise(&mut self, radii: f32x8, distances: &EightDistances, set: Lanes) {
        let radii = of_set(radii, set);
        let sizes = if self.perspective {
            let distance = distances.squared.sqrt()
                * f32x8::splat(1.0 - 2.0 * DISTANCE_SLACK as f32)
                - f32x8::splat(self.distance_error);
            radii / distance.max(f32x8::ZERO) * f32x8::splat(1.0 + 4.0 * f32::EPSILON)
        } else {
            radii
        };
        // 0 / 0 is NaN and gives way to the bound: nothing hidden, however near.
        let largest = sizes.to_array().into_iter().fold(self.bound, f32::max);
        self.set(largest);
    }

    fn set(&mut self, bound: f32) {
        const TINY: f32 = 1e-18;
        self.bound = bound;
        self.margin = f32x8::splat(bound * self.distance_error + TINY);
        let squared = bound * bound * (1.0 - 8.0 * DISTANCE_SLACK as f32);
        // Below, squares are rounded by more than the slack.
        let is_normal = squared >= f32::MIN_POSITIVE;
        self.squared = f32x8::splat(if is_normal { squared } else { 0.0 });
    }
}

/// The values of the boxes in `set`, 0 elsewhere.
fn of_set(values: f32x8, set: Lanes) -> f32x8 {
    const BITS: [i32; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
    let bits = i32x8::from(BITS);
    let mask = (i32x8::splat(set.cast_signed()) & bits).simd_eq(bits);
    bytemuck::cast::<i32x8, f32x8>(mask) & values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::ALL_LANES;

    fn with(bound: f32, distance_error: f32) -> LargestSize {
        let mut largest = LargestSize {
            perspective: true,
            distance_error,
            bound,
            margin: f32x8::ZERO,
            squared: f32x8::ZERO,
        };
        largest.set(bound);
        largest
    }

    /// Where nothing is certain, nothing is told to be within the bound, until that is infinite.
    #[test]
    fn what_is_not_known_exceeds() {
        let distances = |squared: f32| EightDistances {
            squared: f32x8::splat(squared),
        };
        let exceeding = |largest: &LargestSize, radius: f32, squared: f32| {
            let set = largest.exceeding(f32x8::splat(radius), &distances(squared), ALL_LANES);
            assert!(set == 0 || set == ALL_LANES);
            set == ALL_LANES
        };
        // An infinite error: coordinates that overflow when squared.
        assert!(exceeding(&with(0.0, f32::INFINITY), 1.0, 1e4));
        // No distance known.
        assert!(exceeding(&with(0.0, 0.0), 1.0, f32::INFINITY));
        assert!(exceeding(&with(1e-3, 0.1), f32::INFINITY, 1e30));
        // Around the eye.
        assert!(exceeding(&with(1e6, 0.1), 1.0, 0.0));
        // Squares of tiny bounds are no normal numbers.
        assert!(exceeding(&with(1.05e-22, 0.0), 1.055e-14, 1e16));
        // And what is known.
        assert!(exceeding(&with(0.01, 0.1), 1.1, 1e4));
        assert!(!exceeding(&with(0.01, 0.1), 0.9, 1e4));
    }
}
