//! Error mode: all objects of the frustum that are large enough on the screen.

use super::sweep::{Wanted, sweep};
use super::{LodError, Selection};
use crate::geom::{Filter, View};
use crate::index::LodTree;

/// The knob of error mode: exactly the objects of the frustum whose projected size
/// ([`View::size_px`]) is at least this are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorLod {
    max_error_px: f64,
}

impl ErrorLod {
    /// `max_error_px` in pixels, finite; 0 draws everything.
    ///
    /// # Errors
    /// [`LodError`] where it is negative or not finite.
    pub fn new(max_error_px: f64) -> Result<Self, LodError> {
        if max_error_px >= 0.0 && max_error_px.is_finite() {
            let max_error_px = max_error_px + 0.0; // -0.0 becomes 0.0
            Ok(Self { max_error_px })
        } else {
            Err(LodError {
                field: "max_error_px",
                reason: format!("must be 0 or more and finite, is {max_error_px}"),
            })
        }
    }

    pub(super) fn coarsened(self, factor: f64) -> Self {
        Self {
            max_error_px: (self.max_error_px * factor).min(f64::MAX),
        }
    }

    /// The smallest size that is drawn, pixels.
    pub fn max_error_px(&self) -> f64 {
        self.max_error_px
    }
}

pub(super) fn select(tree: &LodTree, view: &View, lod: ErrorLod, selection: &mut Selection) {
    let wanted = Wanted {
        sure: lod.max_error_px,
        least: lod.max_error_px,
    };
    selection.clear();
    if tree.object_count() == 0 {
        return;
    }
    let filter = Filter::new(view.frustum(), tree.origin(), &tree.bounds());
    let missed = sweep(tree, view, &filter, wanted, selection);
    // What was left out is smaller by definition.
    let below = lod.max_error_px.next_down().max(0.0);
    selection.conclude(if missed { below } else { 0.0 });
}
