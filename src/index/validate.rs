//! Every invariant of a packed tree, stated once.

use std::fmt;

use wide::f32x8;

use super::LodTree;
use super::outward::stored_radius;
use crate::geom::Aabb;

/// A broken invariant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// The law that does not hold.
    pub law: &'static str,
    /// Where, e.g. `node 17`.
    pub place: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.law)
    }
}

/// How many violations are listed; a damaged file breaks millions.
const MOST_LISTED: usize = 100;

impl LodTree {
    /// Every broken invariant; see [`validate`].
    pub fn validate(&self) -> Vec<Violation> {
        validate(self)
    }
}

struct Check<'a> {
    tree: &'a LodTree,
    violations: Vec<Violation>,
}

/// All broken invariants of a tree, the first hundred of them; empty when it is sound.
pub fn validate(tree: &LodTree) -> Vec<Violation> {
    let mut check = Check {
        tree,
        violations: Vec::new(),
    };
    check.starts();
    if check.violations.is_empty() {
        check.boxes();
        check.blocks();
        check.radii();
        check.ids();
        check.representatives();
        check.require(
            tree.has_sound_lifts(),
            "lifts are lengths of objects, in order",
            || "lifts".into(),
        );
    }
    check.violations
}

impl Check<'_> {
    fn require(&mut self, holds: bool, law: &'static str, place: impl FnOnce() -> String) {
        if !holds && self.violations.len() < MOST_LISTED {
            self.violations.push(Violation {
                law,
                place: place(),
            });
        }
    }

    /// Level order: every array of starts ascends and ends where the things it counts end.
    fn starts(&mut self) {
        let a = self.tree.arrays();
        let nodes = self.tree.node_count();
        let objects = self.tree.object_count();
        let empty = objects == 0;
        for (name, starts, first, end) in [
            ("levels of nodes", a.level_nodes, 0, nodes),
            ("levels of objects", a.level_objects, 0, objects),
            ("own objects", a.own, 0, objects),
            ("children", a.children, u32::from(!empty), nodes),
        ] {
            let ascending = starts.is_sorted();
            let fits = starts.first() == Some(&first) && starts.last() == Some(&end);
            self.require(
                ascending && fits,
                "starts ascend from first to last",
                || name.to_owned(),
            );
        }
        let h = self.tree.level_count() as usize;
        self.require(empty == (h == 0), "a city with objects has levels", || {
            "header".into()
        });
        if self.violations.is_empty() && h > 0 {
            let inner = a.level_nodes[h - 1] as usize;
            self.require(
                a.children.len() == inner + 1,
                "only leaves have no children",
                || "children".into(),
            );
            self.require(a.level_nodes[1] == 1, "one root", || "levels".into());
            for k in 0..h {
                let node = a.level_nodes[k] as usize;
                self.require(
                    a.own.get(node) == a.level_objects.get(k),
                    "levels of objects follow levels of nodes",
                    || format!("level {}", h - 1 - k),
                );
                let below = a.level_nodes.get(k + 1);
                self.require(
                    k + 1 == h || a.children.get(node) == below,
                    "children lie one level below",
                    || format!("level {}", h - 1 - k),
                );
            }
        }
    }

    /// Box = union of what it bounds, and the hidden radius follows from what is below.
    fn boxes(&mut self) {
        let a = self.tree.arrays();
        let inner = a.children.len() - 1;
        for node in (0..self.tree.node_count()).rev() {
            let at = node as usize;
            let own = || a.own[at]..a.own[at + 1];
            let children = if at < inner {
                a.children[at]..a.children[at + 1]
            } else {
                0..0
            };
            let stated = node_box(self.tree, node);
            let promoted = self.promoted_box(node);
            let union = own()
                .filter_map(|o| self.tree.bounds_of(o))
                .chain(children.clone().map(|c| node_box(self.tree, c)))
                .chain(promoted)
                .fold(Aabb::EMPTY, |all, part| all.union(&part));
            self.require(
                stated == union,
                "box is the union of what it bounds",
                || format!("node {node}"),
            );
            self.hidden(node, children);
        }
        let root = (self.tree.node_count() > 0).then(|| node_box(self.tree, 0));
        self.require(
            self.tree.bounds() == root.unwrap_or(Aabb::EMPTY),
            "bounds are the root's box",
            || "header".into(),
        );
    }

    /// For each level, the hidden radius is the largest of what is stored below that level.
    fn hidden(&mut self, node: u32, children: std::ops::Range<u32>) {
        let a = self.tree.arrays();
        let levels = self.tree.level_count();
        let level_of = |node| levels - a.level_nodes.partition_point(|&start| start <= node) as u32;
        for cut in 1..levels.max(2) {
            let stated = |node| {
                a.hidden_below(cut, level_of(node), node)
                    .map(|radii| radii[0])
            };
            let below = children.clone().flat_map(|c| {
                let own = a.own[c as usize]..a.own[c as usize + 1];
                own.filter(|&o| self.tree.level_of(o) < cut)
                    .filter_map(|o| self.tree.bounds_of(o))
                    .map(|b| stored_radius(b.radius()))
                    .chain(stated(c))
            });
            let largest = below.fold(0.0, f32::max);
            self.require(
                stated(node) == Some(largest),
                "hidden radius is the largest stored below the level",
                || format!("node {node}, level {cut}"),
            );
        }
    }

    /// The box of the node's object that an ancestor stores.
    fn promoted_box(&self, node: u32) -> Option<Aabb> {
        let representative = *self.tree.arrays().representatives.get(node as usize)?;
        self.tree.bounds_of(representative)
    }

    /// f32 boxes contain the exact ones, by no more than rounding, in the blocks they belong to.
    fn blocks(&mut self) {
        let a = self.tree.arrays();
        let root = self.tree.node_count().min(1);
        if let (Some(block), Some(exact)) = (a.child_blocks.get(..1), a.node_boxes.get(..1)) {
            self.block_of("node", block, exact, 0);
        }
        let groups = [
            (
                "node",
                a.children,
                a.child_block_starts,
                a.child_blocks,
                a.node_boxes,
                root,
            ),
            (
                "object",
                a.own,
                a.own_block_starts,
                a.own_blocks,
                a.object_boxes,
                0,
            ),
        ];
        for (what, starts, block_starts, blocks, boxes, first) in groups {
            let mut next = first;
            for (group, &start) in starts.windows(2).zip(block_starts) {
                self.require(start == next, "blocks follow one another", || {
                    format!("block of {what} {}", group[0])
                });
                let count = (group[1] - group[0]).div_ceil(8);
                let Some(blocks) = blocks.get(next as usize..(next + count) as usize) else {
                    return self.require(false, "every box has a block", || what.to_owned());
                };
                let boxes = &boxes[group[0] as usize..group[1] as usize];
                self.block_of(what, blocks, boxes, group[0]);
                next += count;
            }
            self.require(
                block_starts.last() == Some(&next) && blocks.len() == next as usize,
                "blocks end with the last box",
                || what.to_owned(),
            );
        }
    }

    fn block_of(&mut self, what: &str, blocks: &[[f32x8; 6]], boxes: &[[f64; 6]], first: u32) {
        let origin = self.tree.origin().to_array();
        for (at, exact) in boxes.iter().enumerate() {
            for lane in 0..6 {
                let stored = blocks[at / 8][lane].as_array()[at % 8];
                let wanted = exact[lane] - origin[lane % 3];
                let tight = if lane < 3 {
                    f64::from(stored) <= wanted && f64::from(stored.next_up()) > wanted
                } else {
                    f64::from(stored) >= wanted && f64::from(stored.next_down()) < wanted
                };
                self.require(tight, "f32 box is the exact one rounded outward", || {
                    format!("{what} {}", first as usize + at)
                });
            }
        }
    }

    /// Radii follow from the boxes they lie beside, in the same blocks.
    fn radii(&mut self) {
        let a = self.tree.arrays();
        let root = self.tree.node_count().min(1);
        let radius = |o: u32| self.tree.bounds_of(o).map(|b| stored_radius(b.radius()));
        let own = |o: u32| radius(o).unwrap_or(f32::NAN);
        let held = |node: u32| {
            let own = a.own[node as usize]..a.own[node as usize + 1];
            own.filter_map(radius)
                .fold(a.hidden_radii[node as usize], f32::max)
        };
        let mut least = vec![f32::INFINITY; self.tree.node_count() as usize];
        for node in (0..least.len()).rev() {
            let own = (a.own[node]..a.own[node + 1]).filter_map(radius);
            let below = match (a.children.get(node), a.children.get(node + 1)) {
                (Some(&first), Some(&end)) => &least[first as usize..end as usize],
                _ => &[],
            };
            least[node] = own
                .chain(below.iter().copied())
                .fold(f32::INFINITY, f32::min);
        }
        let least = |node: u32| least[node as usize];
        let stated = |radii: &[f32x8], block: u32, at: u32| {
            let block = radii.get(block as usize + at as usize / 8)?;
            Some(block.as_array()[at as usize % 8])
        };
        let mut wrong = Vec::new();
        let differs = |node: u32, block: u32, at: u32| {
            stated(a.child_radii, block, at) != Some(held(node))
                || stated(a.child_least_radii, block, at) != Some(least(node))
        };
        if root == 1 && differs(0, 0, 0) {
            wrong.push("node 0".to_owned());
        }
        for (group, &block) in a.children.windows(2).zip(a.child_block_starts) {
            let nodes = (group[0]..group[1]).zip(0..);
            wrong.extend(
                nodes
                    .filter(|&(node, at)| differs(node, block, at))
                    .map(|(node, _)| format!("node {node}")),
            );
        }
        for (group, &block) in a.own.windows(2).zip(a.own_block_starts) {
            let objects = (group[0]..group[1]).zip(0..);
            let differs =
                |&(object, at): &(u32, u32)| stated(a.own_radii, block, at) != Some(own(object));
            wrong.extend(objects.filter(differs).map(|(o, _)| format!("object {o}")));
        }
        for place in wrong {
            self.require(
                false,
                "radii beside a box are the largest and least it stands for",
                || place,
            );
        }
        self.require(
            a.child_radii.len() == a.child_blocks.len()
                && a.child_least_radii.len() == a.child_blocks.len()
                && a.own_radii.len() == a.own_blocks.len(),
            "radii lie beside every block of boxes",
            || "radii".to_owned(),
        );
    }

    /// Each id once, in order, and found under its object.
    fn ids(&mut self) {
        let count = self.tree.object_count();
        for object in 0..count {
            let found = self.tree.id(object).and_then(|id| self.tree.find(&id));
            self.require(found == Some(object), "each id once and found", || {
                format!("object {object}")
            });
            self.require(
                self.tree.object(object).is_some(),
                "every object has all its fields",
                || format!("object {object}"),
            );
        }
    }

    /// Representative = best of everything below; ties to the lower id. Own objects of inner
    /// nodes = representatives of the children less the one the parent took.
    fn representatives(&mut self) {
        let a = self.tree.arrays();
        let inner = a.children.len() - 1;
        let better = |best: Option<u32>, candidate: u32| match best {
            Some(best) if !self.beats(candidate, best) => Some(best),
            _ => Some(candidate),
        };
        let mut violated = Vec::new();
        for node in (0..self.tree.node_count()).rev() {
            let at = node as usize;
            let own = a.own[at]..a.own[at + 1];
            let stated = a.representatives[at];
            let below: Vec<u32> = if at < inner {
                (a.children[at]..a.children[at + 1])
                    .map(|c| a.representatives[c as usize])
                    .collect()
            } else {
                own.clone().chain([stated]).collect()
            };
            if below.iter().copied().fold(None, better) != Some(stated) {
                violated.push((node, "representative is the best below"));
            }
            let kept = |o: &u32| at == 0 || *o != stated;
            if at < inner && !below.iter().copied().filter(kept).eq(own.clone()) {
                violated.push((node, "own objects are the children's representatives"));
            }
            let level_end = own.start;
            if at > 0 && stated >= level_end {
                violated.push((node, "the representative is stored above"));
            }
        }
        for (node, law) in violated {
            self.require(false, law, || format!("node {node}"));
        }
    }

    fn beats(&self, a: u32, b: u32) -> bool {
        let key = |o: u32| {
            let object = self.tree.object(o)?;
            let score = match self.tree.promotion() {
                super::Promotion::Tallest => object.bounds.size().z,
                super::Promotion::Footprint => object.footprint_area,
                super::Promotion::Largest => object.bounds.radius(),
            };
            Some((score, object.id))
        };
        match (key(a), key(b)) {
            (Some((x, id_x)), Some((y, id_y))) => {
                x.total_cmp(&y).then_with(|| id_y.cmp(&id_x)).is_gt()
            }
            _ => false,
        }
    }
}

fn node_box(tree: &LodTree, node: u32) -> Aabb {
    let boxes = tree.arrays().node_boxes;
    boxes
        .get(node as usize)
        .copied()
        .map_or(Aabb::EMPTY, |b| Aabb::from_array(b).unwrap_or(Aabb::EMPTY))
}
