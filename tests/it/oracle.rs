use std::collections::BTreeSet;

use citylod::geom::{Aabb, DVec3};
use citylod::index::LodTree;
use citylod::lod::{Beyond, RangeLod};

use crate::support::Camera;

/// A tree as the paper has it: every node holds a set, representatives stand in many of them.
pub struct Gong {
    nodes: Vec<Node>,
    boxes: Vec<Aabb>,
}

struct Node {
    level: u32,
    bounds: Aabb,
    objects: BTreeSet<u32>,
    children: Vec<usize>,
}

/// Where a branch of the query goes on.
enum Step {
    Two(usize),
    Three(usize),
}

impl Gong {
    /// Takes from the packed tree which object lies in which leaf, and nothing else: boxes and
    /// representatives are found again by looking at all objects below.
    pub fn of(tree: &LodTree, score: impl Fn(u32) -> f64) -> Self {
        let a = tree.arrays();
        let count = tree.node_count() as usize;
        let boxes: Vec<Aabb> = (0..tree.object_count())
            .map(|o| tree.bounds_of(o).unwrap())
            .collect();
        let ids: Vec<String> = (0..tree.object_count())
            .map(|o| tree.id(o).unwrap().into_owned())
            .collect();
        let mut below: Vec<BTreeSet<u32>> = vec![BTreeSet::new(); count];
        let mut nodes: Vec<Node> = Vec::with_capacity(count);
        let best = |objects: &BTreeSet<u32>| {
            objects
                .iter()
                .copied()
                .max_by(|&x, &y| {
                    score(x)
                        .total_cmp(&score(y))
                        .then_with(|| ids[y as usize].cmp(&ids[x as usize]))
                })
                .unwrap()
        };
        for node in (0..count).rev() {
            let children: Vec<usize> = match (a.children.get(node), a.children.get(node + 1)) {
                (Some(&start), Some(&end)) => (start as usize..end as usize).collect(),
                _ => Vec::new(),
            };
            if children.is_empty() {
                below[node] = (a.own[node]..a.own[node + 1]).collect();
                below[node].insert(a.representatives[node]);
            } else {
                for &child in &children {
                    let part = below[child].clone();
                    below[node].extend(part);
                }
            }
            let objects = if children.is_empty() {
                below[node].clone()
            } else {
                children.iter().map(|&c| best(&below[c])).collect()
            };
            let bounds = below[node]
                .iter()
                .fold(Aabb::EMPTY, |all, &o| all.union(&boxes[o as usize]));
            let level = a.level_nodes.partition_point(|&s| s as usize <= node) as u32;
            nodes.push(Node {
                level: tree.level_count() - level,
                bounds,
                objects,
                children,
            });
        }
        nodes.reverse();
        if let Some(root) = below.first() {
            assert_eq!(root.len(), boxes.len(), "every object lies in a leaf");
        }
        Self { nodes, boxes }
    }

    /// The paper's seven steps, set by set. A box counts as outside the frustum by `margin`.
    pub fn retrieve(&self, camera: &Camera, lod: &RangeLod, margin: f64) -> BTreeSet<u32> {
        let mut answer = BTreeSet::new();
        if self.nodes.is_empty() {
            return answer;
        }
        let levels = lod.level_count();
        let last = levels.min(self.nodes[0].level + 1) - 1;
        let range = |level: u32| {
            let far_of = |k: u32| (0..k).fold(lod.far_dist(), |d, _| d * lod.dist_factor());
            let near = if level == 0 { 0.0 } else { far_of(level - 1) };
            let far = if level == last && lod.beyond() == Beyond::Show {
                f64::INFINITY
            } else {
                far_of(level)
            };
            (near, far)
        };
        let outside = |b: &Aabb| camera.sees_nothing_of(b, margin);
        let inside = |b: &Aabb| {
            // All corners visible: then the box is, the frustum being convex.
            (0..8).all(|i| {
                let pick = |bit: usize| {
                    if i >> bit & 1 == 1 {
                        b.max()[bit]
                    } else {
                        b.min()[bit]
                    }
                };
                let corner = DVec3::new(pick(0), pick(1), pick(2));
                !camera.sees_nothing_of(&Aabb::new(corner, corner).unwrap(), -1e-9)
            })
        };
        let distance = |b: &Aabb| {
            let gap = |axis: usize| {
                let below = b.min()[axis] - camera.eye[axis];
                let above = camera.eye[axis] - b.max()[axis];
                below.max(above).max(0.0)
            };
            (gap(0) * gap(0) + gap(1) * gap(1) + gap(2) * gap(2)).sqrt()
        };

        let mut open = vec![Step::Two(0)]; // step 1
        while let Some(step) = open.pop() {
            let (node, whole) = match step {
                Step::Two(node) if outside(&self.nodes[node].bounds) => continue,
                Step::Two(node) => (node, inside(&self.nodes[node].bounds)),
                Step::Three(node) => (node, true),
            };
            let Node {
                level,
                bounds,
                objects,
                children,
            } = &self.nodes[node];
            let distance = distance(bounds);
            let ranged = *level < levels;
            let (near, far) = range(*level);
            if ranged && distance >= far {
                continue;
            }
            if ranged {
                // Steps 3 and 5.
                let drawn = objects
                    .iter()
                    .filter(|&&o| whole || !outside(&self.boxes[o as usize]));
                answer.extend(drawn);
            }
            if !ranged || distance < near {
                for &child in children {
                    if whole {
                        open.push(Step::Three(child)); // step 4
                    } else if !outside(&self.nodes[child].bounds) {
                        open.push(Step::Two(child)); // step 6
                    }
                }
            }
        }
        answer // step 7
    }
}
