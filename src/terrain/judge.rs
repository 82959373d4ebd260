//! How a view judges the nodes of a ground.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::block::NodeRecord;
use super::criterion::{Criterion, KnobError, Knobs, Seen};
use super::cut::State;
use super::ground::Ground;
use super::quadtree::Node;
use super::select::Detail;
use super::triangle::height_between;
use crate::geom::{Aabb, DVec3, View};

/// A ground, who looks at it, and what decides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judge<'a> {
    pub ground: &'a Ground,
    pub view: &'a View,
    pub criterion: Criterion,
    pub knobs: Knobs,
    /// What errs by more on the screen is drawn in parts, whatever the criterion says.
    pub max_error_px: f64,
    /// What may be split, where that is limited.
    pub allowance: Option<&'a Allowance>,
}

/// How many nodes may be split, those not counted that have holes.
#[derive(Debug)]
pub(super) struct Allowance {
    splits: usize,
    used: AtomicUsize,
}

impl Allowance {
    pub fn new(splits: usize) -> Self {
        Self {
            splits,
            used: AtomicUsize::new(0),
        }
    }

    /// Whether more would have been split.
    pub fn is_exceeded(&self) -> bool {
        self.used.load(Ordering::Relaxed) > self.splits
    }
}

impl<'a> Judge<'a> {
    pub fn new(ground: &'a Ground, view: &'a View, detail: &Detail) -> Result<Self, KnobError> {
        if detail.subdivide_within.is_nan() || detail.subdivide_within < 0.0 {
            return Err(KnobError {
                knob: "subdivide_within",
                least: "0 or more",
                value: detail.subdivide_within,
            });
        }
        Ok(Self {
            ground,
            view,
            criterion: detail.criterion,
            knobs: detail.knobs.checked()?,
            max_error_px: f64::INFINITY,
            allowance: None,
        })
    }

    /// Counts a node that is to be split; false where those before it are all that may be.
    pub fn may_split(&self) -> bool {
        self.allowance.is_none_or(|allowance| {
            allowance.used.fetch_add(1, Ordering::Relaxed) < allowance.splits
        })
    }

    /// The same with a share of the detail; with 0 nothing is split but what has holes.
    pub fn with_share(self, share: f64) -> Self {
        Self {
            knobs: self.criterion.share(&self.knobs, share),
            max_error_px: self.max_error_px / share,
            ..self
        }
    }

    /// What a node is by itself.
    ///
    /// A node with holes is split down to the cells, so that holes are drawn as they are. A
    /// single cell has nothing to be split into.
    pub fn state(&self, node: Node) -> State {
        let record = self.ground.record(node);
        let bounds = self.ground.bounds(node, &record);
        if self.is_hidden(&record, &bounds) {
            return State::Hidden;
        }
        if record.is_mixed() {
            return State::Split;
        }
        let posts = self.ground.layout().posts(node);
        let cells = [0, 1].map(|axis| posts.last[axis] - posts.first[axis]);
        let splits = || {
            self.splits(node.level, &record, bounds.center()) || self.errs(record.error, &bounds)
        };
        if cells != [1, 1] && splits() && self.may_split() {
            State::Split
        } else {
            State::Drawn
        }
    }

    /// The state of a node that is not to be split.
    pub fn whole(&self, node: Node) -> State {
        let record = self.ground.record(node);
        let bounds = self.ground.bounds(node, &record);
        if self.is_hidden(&record, &bounds) {
            State::Hidden
        } else {
            State::Drawn
        }
    }

    /// Whether the criterion would split what errs as a side of a node does without its midpoint,
    /// seen there, or the side errs by more than it may.
    pub fn splits_side(&self, node: Node, side: usize) -> bool {
        if self.allowance.is_some_and(Allowance::is_exceeded) {
            return false; // what is made is given up
        }
        if self.errs_without_midpoint(node, side) {
            return true;
        }
        let (layout, grid) = (self.ground.layout(), self.ground.layout().grid());
        let posts = layout.posts(node);
        let (corners, middle) = (posts.corners(), posts.midpoints()[side]);
        let ends = [corners[side], corners[(side + 1) % 4]];
        let z = |post| f64::from(self.ground.height(node, post));
        let error = (z(middle) - height_between(ends, ends.map(z), middle)).abs();
        let record = self.ground.record(node);
        let record = NodeRecord {
            vertex_error: error as f32,
            error: record.skipped[side],
            // Of an area, which a side has none of by itself.
            deviation: record.deviation,
            ..NodeRecord::NOTHING
        };
        let vertex = DVec3::new(grid.x(middle[0]), grid.y(middle[1]), z(middle));
        self.splits(node.level, &record, vertex)
    }

    fn is_hidden(&self, record: &NodeRecord, bounds: &Aabb) -> bool {
        !record.has_ground() || self.view.frustum().is_outside(bounds)
    }

    fn splits(&self, level: u32, record: &NodeRecord, at: DVec3) -> bool {
        let layout = self.ground.layout();
        let seen = Seen {
            record,
            to_eye: self.view.eye() - at,
            side: layout.side_m(level),
            block_side: layout.side_m(0),
        };
        self.criterion.splits(&seen, &self.knobs)
    }
}
