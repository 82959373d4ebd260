//! f64 boxes as f32 ones that contain them.

use super::LodTree;
use crate::geom::DVec3;

/// The corners relative to `origin`, lower ones rounded down, upper ones up.
pub(super) fn outward(corners: &[f64; 6], origin: DVec3) -> [f32; 6] {
    let origin = origin.to_array();
    std::array::from_fn(|lane| {
        let round = if lane < 3 { round_down } else { round_up };
        round(corners[lane] - origin[lane % 3])
    })
}

/// The largest f32 not above `x`.
fn round_down(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x {
        near.next_down()
    } else {
        near
    }
}

/// The smallest f32 not below `x`.
fn round_up(x: f64) -> f32 {
    -round_down(-x)
}

/// A radius as it is stored: rounded up, and never 0, so that a point is something too.
pub(super) fn stored_radius(radius: f64) -> f32 {
    round_up(radius).max(f32::MIN_POSITIVE)
}

impl LodTree {
    /// The box of an object relative to [`LodTree::origin`], rounded outward: min x, y, z, max x,
    /// y, z.
    pub fn relative_box(&self, object: u32) -> Option<[f32; 6]> {
        let corners = self.arrays().object_boxes.get(object as usize)?;
        Some(outward(corners, self.origin()))
    }
}
