//! Haze: nothing is drawn beyond the visibility range.

use crate::geom::{Aabb, View};
use crate::lod::Selection;
use crate::scene;

/// The view with as much cut off beyond the visibility range as a plane can: what retrieval then
/// need not look at. No box within the range is lost; see [`clear`] for the rest.
pub fn shortened(declared: scene::Haze, view: &View) -> View {
    view.within(declared.visibility_m)
}

/// Takes out the objects whose nearest point lies beyond the visibility range, and tells how many
/// there were. `boxes` are those of all objects, by number: min x, y, z, max x, y, z.
pub fn clear(
    declared: scene::Haze,
    view: &View,
    boxes: &[[f64; 6]],
    selection: &mut Selection,
) -> u32 {
    selection.retain(|object| {
        Aabb::nth(boxes, object).is_some_and(|b| b.distance(view.eye()) <= declared.visibility_m)
    })
}
