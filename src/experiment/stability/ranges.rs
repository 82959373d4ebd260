//! Which objects the ranges of a tree's levels call for, by exact distances.

use std::cmp::Ordering;

use crate::experiment::exact::compare_distance;
use crate::geom::{Aabb, DVec3};
use crate::index::LodTree;
use crate::lod::{Beyond, RangeLod};

/// What an f64 distance is off by, relative: a difference 1 u, a square 1 u more, two sums 2 u,
/// all but the sums doubled by squaring and halved by the root, which adds 1 u: less than 4 u.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// And where squares underflow, m: √(3·2⁻¹⁰⁷⁵).
const UNDERFLOW: f64 = 1e-160;

/// The objects that distances call for, whatever the frustum.
pub(super) struct Ranges {
    /// For each object.
    pub called_for: Vec<bool>,
    /// Nodes whose distance lies within rounding of a border, but not on it.
    pub at_border: u64,
}

impl Ranges {
    /// A node of level k is drawn where it is nearer than the far distance of its level: the
    /// nodes above it are nearer still, so each is nearer than its own level's near distance,
    /// and the walk comes by (DESIGN.md, section 4).
    pub fn new(tree: &LodTree, eye: DVec3, lod: &RangeLod) -> Self {
        let arrays = tree.arrays();
        let levels = tree.level_count();
        let ranged = lod.level_count().min(levels);
        let mut ranges = Self {
            called_for: vec![false; tree.object_count() as usize],
            at_border: 0,
        };
        let mut far = lod.far_dist();
        for level in 0..ranged {
            if lod.beyond() == Beyond::Show && level + 1 == ranged {
                far = f64::INFINITY;
            }
            let coarser = (levels - 1 - level) as usize;
            for node in arrays.level_nodes[coarser]..arrays.level_nodes[coarser + 1] {
                let node = node as usize;
                if !ranges.nearer(&arrays.node_boxes[node], eye, far) {
                    continue;
                }
                for object in arrays.own[node]..arrays.own[node + 1] {
                    ranges.called_for[object as usize] = true;
                }
                // Above, nobody has drawn what stands for the nodes of the coarsest range.
                if level + 1 == ranged && level + 1 < levels {
                    ranges.called_for[arrays.representatives[node] as usize] = true;
                }
            }
            far *= lod.dist_factor();
        }
        ranges
    }

    /// Whether a box is nearer than `far`; where rounding may decide, what f64 says.
    fn nearer(&mut self, b: &[f64; 6], eye: DVec3, far: f64) -> bool {
        let Ok(b) = Aabb::from_array(*b) else {
            return false;
        };
        let order = compare_distance(&b, eye, far);
        let least = (far * (1.0 - ROUNDING) - UNDERFLOW).max(0.0);
        let most = far * (1.0 + ROUNDING) + UNDERFLOW;
        let clear = compare_distance(&b, eye, least) == Ordering::Less
            || compare_distance(&b, eye, most) == Ordering::Greater
            || order == Ordering::Equal && (far == 0.0 || far > UNDERFLOW / f64::EPSILON);
        if clear {
            return order == Ordering::Less;
        }
        self.at_border += 1;
        b.distance(eye) < far
    }
}
