//! What errors come to on the screen, and what is split because of it.

use super::judge::Judge;
use super::quadtree::Node;
use crate::geom::{Aabb, PixelScale, View};

/// How large a vertical error is on the screen at a distance, m; infinite at 0. Rounded up by more
/// than the three roundings it takes.
pub(super) fn error_px(error: f64, distance: f64, view: &View) -> f64 {
    let px = match view.pixels() {
        _ if error == 0.0 => 0.0,
        PixelScale::PerMetre(scale) => error * scale,
        PixelScale::PerRadian(scale) if distance > 0.0 => error * scale / distance,
        PixelScale::PerRadian(_) => f64::INFINITY,
    };
    px * (1.0 + 8.0 * f64::EPSILON)
}

impl Judge<'_> {
    /// Whether an error anywhere in a box is, or may be, larger on the screen than it is to be.
    pub fn errs(&self, error: f32, bounds: &Aabb) -> bool {
        self.max_error_px < f64::INFINITY
            && error_px(
                f64::from(error),
                bounds.distance(self.view.eye()),
                self.view,
            ) > self.max_error_px
    }

    /// The same for a side of a split node that is drawn without its midpoint.
    pub fn errs_without_midpoint(&self, node: Node, side: usize) -> bool {
        let record = self.ground.record(node);
        self.errs(record.skipped[side], &self.ground.bounds(node, &record))
    }
}
