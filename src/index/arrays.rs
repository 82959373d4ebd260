//! What a traversal reads.

use wide::f32x8;

/// The arrays of a tree, as a traversal reads them.
#[derive(Debug, Clone, Copy)]
pub struct Arrays<'a> {
    /// First child of each inner node, then the number of nodes. Leaves have no entry.
    pub children: &'a [u32],
    /// First own object of each node, then the number of objects.
    pub own: &'a [u32],
    /// First node of each level, coarsest first, then the number of nodes.
    pub level_nodes: &'a [u32],
    /// First object of each level, coarsest first, then the number of objects.
    pub level_objects: &'a [u32],
    /// The object that stands for each node in its parent.
    pub representatives: &'a [u32],
    /// Largest radius of an object below each node that is not its own, m.
    pub hidden_radii: &'a [f32],
    /// The same for objects stored below one level: for each level c from 1 to the root's less
    /// one, the largest of each inner node, level after level. See [`Arrays::hidden_below`].
    pub cut_radii: &'a [f32],
    /// Boxes of the root, then of the children of each inner node, eight to a block: lanes of min
    /// x, y, z, max x, y, z relative to [`LodTree::origin`](super::LodTree::origin), rounded outward.
    pub child_blocks: &'a [[f32x8; 6]],
    /// For each of these blocks, the largest radius of an object stored with each child or below
    /// it, m, rounded up.
    pub child_radii: &'a [f32x8],
    /// The same for the least radius; infinite where there is none.
    pub child_least_radii: &'a [f32x8],
    /// First block of each inner node's children, then the number of blocks.
    pub child_block_starts: &'a [u32],
    /// The same for each node's own objects.
    pub own_blocks: &'a [[f32x8; 6]],
    /// For each of these blocks, the radius of each object, m, rounded up.
    pub own_radii: &'a [f32x8],
    /// First block of each node's own objects, then the number of blocks.
    pub own_block_starts: &'a [u32],
    /// Exact boxes of nodes: min x, y, z, max x, y, z in scene coordinates.
    pub node_boxes: &'a [[f64; 6]],
    /// Exact boxes of objects.
    pub object_boxes: &'a [[f64; 6]],
}

impl Arrays<'_> {
    /// For eight nodes of `level` from `first` on, the largest radius of an object below that is
    /// stored at a level lower than `cut` and is not the node's own, m.
    #[inline]
    pub fn hidden_below(&self, cut: u32, level: u32, first: u32) -> Option<&[f32; 8]> {
        let radii = if cut >= level {
            self.hidden_radii.get(first as usize..)
        } else {
            let inner_nodes = self.children.len().checked_sub(1)?;
            let plane = (cut as usize).checked_sub(1)? * inner_nodes;
            self.cut_radii.get(plane + first as usize..)
        };
        radii?.first_chunk()
    }
}
