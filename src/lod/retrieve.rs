use super::{RangeLod, Selection};
use crate::geom::View;
use crate::index::LodTree;

/// Placeholder until the traversal lands: everything.
pub fn retrieve(tree: &LodTree, view: &View, lod: &RangeLod, selection: &mut Selection) {
    let _ = (view, lod);
    selection.ranges.clear();
    selection.ranges.push(0..tree.object_count());
}
