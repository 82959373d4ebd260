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

    /// Takes one thing into account whose radius by distance, or radius, is known.
    pub fn raise_to(&mut self, ratio: f64) {
        let ratio = (ratio as f32).next_up();
        if ratio > self.bound {
            self.set(ratio);
        }
    }

    fn set(&mut self, bound: f32) {
        const TINY: f32 = 1e-18;
        self.bound = bound;
        self.margin = f32x8::splat(bound * self.distance_error + TINY);
        self.squared = f32x8::splat(bound * bound * (1.0 - 8.0 * DISTANCE_SLACK as f32));
    }
}

/// The values of the boxes in `set`, 0 elsewhere.
fn of_set(values: f32x8, set: Lanes) -> f32x8 {
    const BITS: [i32; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
    let bits = i32x8::from(BITS);
    let mask = (i32x8::splat(set.cast_signed()) & bits).simd_eq(bits);
    bytemuck::cast::<i32x8, f32x8>(mask) & values
}
