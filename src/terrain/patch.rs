//! A selection as patches: tiles of the pyramid, which are the same for every view, and which
//! triangles to draw between their posts.

use std::collections::BTreeMap;

use super::cut::State;
use super::ground::Ground;
use super::quadtree::{Node, level_start};
use super::select::Selection;

/// A tile and the fans between its posts.
///
/// A fan at node N of level L lies in the tile of level max(0, L + 1 − n) above N, of 2^n + 1 posts
/// a side: the coarsest that has all nine posts of N, its corners, the middles of its sides and its
/// middle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patch {
    /// Whose posts are drawn.
    pub tile: Node,
    /// index·256 + midpoints·16 + quarters each; without any the tile is drawn whole, as the two
    /// triangles south of and above its diagonal from south-west to north-east.
    ///
    /// `index` is the place of the fan's node among all nodes of the tile, coarse levels first,
    /// each level row by row from the south-west. A bit of `quarters` is set where a quarter,
    /// counter-clockwise from the south-west, is drawn; a bit of `midpoints` where the middle of a
    /// side, south, east, north and west, is a vertex. Side k runs from corner k to corner k + 1.
    /// With its midpoint it has two triangles with the middle of the node, one in quarter k and one
    /// in quarter k + 1, each if that is drawn; without it one, if either is.
    ///
    /// Posts beyond the last column or row of the raster lie on it; what then has no area is not
    /// drawn.
    pub fans: Vec<u32>,
}

impl Selection {
    /// The patches of a selection, coarse tiles first. `ground` is the one it was made of, with
    /// tiles of 2^`tile_levels` + 1 posts a side.
    pub fn patches(&self, ground: &Ground, tile_levels: u32) -> Vec<Patch> {
        let cut = self.cut();
        let mut patches: BTreeMap<Node, Vec<u32>> = BTreeMap::new();
        for (root, block) in cut.blocks() {
            if cut.state(root) == State::Drawn {
                patches.entry(root).or_default();
            }
            for node in block.all_splits(root, cut.levels().end) {
                let bits = |set: &dyn Fn(usize) -> bool| {
                    (0..4).fold(0, |bits, k| bits | u32::from(set(k)) << k)
                };
                let quarters = bits(&|k| cut.is_drawn(ground, node.child(k)));
                if quarters == 0 {
                    continue;
                }
                let flags = cut.flags(node);
                let midpoints = bits(&|k| flags[k] && !cut.spares(node, k));
                let tile = above(node, (node.level + 1).saturating_sub(tile_levels));
                let fan = index(tile, node) << 8 | midpoints << 4 | quarters;
                patches.entry(tile).or_default().push(fan);
            }
        }
        let patches = patches.into_iter();
        patches.map(|(tile, fans)| Patch { tile, fans }).collect()
    }
}

/// The node of a level that a node is in.
fn above(node: Node, level: u32) -> Node {
    let up = node.level - level;
    Node {
        level,
        x: node.x >> up,
        y: node.y >> up,
    }
}

/// Place of a node among those of the one it is in.
fn index(tile: Node, node: Node) -> u32 {
    let down = node.level - tile.level;
    let (x, y) = (node.x - (tile.x << down), node.y - (tile.y << down));
    level_start(down) as u32 + (y << down) + x
}
