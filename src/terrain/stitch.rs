//! Makes a cut drawable without cracks.
//!
//! Where two nodes of one level share a side, its midpoint is drawn if both are split, or the
//! ground of the other is not drawn; otherwise it is skipped. So a node may be split only if the
//! midpoints at its corners are drawn: if the nodes across its parent's two outer sides are
//! split. Where that fails, either the finer side is reduced or the coarser subdivided; so too
//! where the criterion asks for a midpoint by itself and only one of its two nodes is split.
//!
//! Source: A, section 2 (vertex skipping with flags for the four neighbours); B, section 2.3.2
//! (reduction when farther than m, subdivision when nearer); D, section 2.1 (vertices are tested by
//! themselves).

use super::cut::{Cut, State};
use super::judge::Judge;
use super::quadtree::Node;

/// Applies the rule to a cut: where neighbours differ too much, nodes up to `reach` (m) from the
/// eye are kept and the coarser side is subdivided; those farther away are reduced. Nodes with
/// holes are always kept.
///
/// Laws: a finer cut gives a finer result, and so does a larger `reach`. Nothing kept is reduced.
pub(super) fn stitch(judge: &Judge, reach: f64, cut: &mut Cut) {
    let ground = judge.ground;
    let seeds: Vec<Node> = cut
        .levels()
        .flat_map(|level| cut.splits(level))
        .filter(|&node| {
            let record = ground.record(node);
            let center = ground.bounds(node, &record).center();
            record.is_mixed() || center.distance(judge.view.eye()) <= reach
        })
        .collect();
    let mut subdivide = Subdivide {
        judge,
        cut,
        waiting: Vec::new(),
    };
    for node in seeds {
        subdivide.require(node);
    }
    subdivide.settle();
    reduce(cut);
}

/// The two nodes across the outer sides of a node's parent, at the parent's level.
fn uncles(node: Node) -> impl Iterator<Item = Node> {
    let quarter = node.quarter();
    let parent = node.parent();
    [quarter, (quarter + 3) % 4]
        .into_iter()
        .filter_map(move |side| parent?.across(side))
}

struct Subdivide<'a> {
    judge: &'a Judge<'a>,
    cut: &'a mut Cut,
    waiting: Vec<Node>,
}

impl Subdivide<'_> {
    /// Keeps a node and all above it, splitting what is not split yet. Where nothing is drawn,
    /// nothing is required.
    fn require(&mut self, node: Node) {
        for up in (0..=node.level).rev() {
            let above = Node {
                level: node.level - up,
                x: node.x >> up,
                y: node.y >> up,
            };
            match self.cut.state(above) {
                State::Unreached | State::Hidden => return,
                State::Kept => continue,
                State::Split => {}
                State::Drawn => self.open(above),
            }
            self.cut.set(above, State::Kept);
            self.waiting.push(above);
        }
    }

    /// Splits a node that was drawn whole. It has no hole, so neither have its children.
    fn open(&mut self, node: Node) {
        self.judge.may_split(); // counts; it must be split in any case
        if node.level + 1 < self.cut.levels().end {
            for quarter in 0..4 {
                let child = node.child(quarter);
                let state = self.judge.whole(child);
                self.cut.set(child, state);
            }
        }
    }

    /// Requires what kept nodes require, until nothing is left.
    fn settle(&mut self) {
        while let Some(node) = self.waiting.pop() {
            for uncle in uncles(node) {
                self.require(uncle);
            }
            for side in 0..4 {
                let Some(neighbour) = node.across(side) else {
                    continue;
                };
                let settled = matches!(self.cut.state(neighbour), State::Kept | State::Hidden);
                if !settled
                    && (self.needs_midpoint(node, side) || self.judge.splits_side(node, side))
                {
                    self.require(neighbour);
                }
            }
        }
    }

    /// Whether only one of the two quarters along a side can be drawn, so that its midpoint
    /// cannot be skipped.
    fn needs_midpoint(&self, node: Node, side: usize) -> bool {
        let ground = self.judge.ground;
        let open = [side, (side + 1) % 4].map(|quarter| {
            let child = node.child(quarter);
            let record = ground.record(child);
            let hidden =
                child.level < self.cut.levels().end && self.cut.state(child) == State::Hidden;
            let gap = record.holes > 0 && (hidden || !record.has_ground());
            (record.has_ground() && !gap, gap)
        });
        open[0].0 && open[1].1 || open[0].1 && open[1].0
    }
}

/// Takes back, from coarse to fine, every node that is not kept and lacks a midpoint.
fn reduce(cut: &mut Cut) {
    for level in cut.levels() {
        let nodes: Vec<Node> = cut.splits(level).collect();
        for node in nodes {
            let state = cut.state(node);
            let supported = || uncles(node).all(|uncle| cut.cover(uncle) != State::Drawn);
            let reduced = match state {
                State::Split if supported() => continue,
                State::Split => State::Drawn,
                State::Kept => continue,
                other => other,
            };
            cut.set(node, reduced);
            if level + 1 < cut.levels().end {
                for quarter in 0..4 {
                    cut.set(node.child(quarter), State::Unreached);
                }
            }
        }
    }
}
