//! Retrieval in seven steps.
//!
//! Source: Gong et al., "An adaptive control method of LODs for 3D scene based on R-tree index",
//! section 2.2. Steps are cited where they are taken.
//!
//! Every object is stored once, at the highest level it is promoted to, so "the node's objects"
//! of the paper are its own ones and its representative, which an ancestor stores. On the way
//! down from the root the ancestor has added it already; only where the levels that have a range
//! begin below the root is it added with the node ([`Traversal::representative`]).
//!
//! Two shortcuts leave the answer as it is. A node inside the frustum that lies wholly in the
//! range of one level below adds its subtree down to that level as one range per level. And
//! siblings are taken eight at a time, runs of them as one range.
//!
//! The law that makes the cut valid: a child's box lies inside its parent's, and the view
//! distance is monotone, in floating point too ([`crate::geom::Aabb::distance_squared`]), so no
//! node is nearer than its parent.

use std::ops::Range;

use wide::f32x8;

use super::{RangeLod, Selection};
use crate::geom::{
    Aabb, DVec3, Eight, EightDistances, EightRelations, Filter, Lanes, PixelScale, PlaneSet,
    Threshold, View,
};
use crate::index::{Arrays, Boxes, LodTree};

/// Finds what a view calls for, into `selection`, whose memory is used again.
///
/// Total: answers for every view and every setting, in time linear in the nodes visited. Source:
/// Gong, section 2.2.
pub fn retrieve(tree: &LodTree, view: &View, lod: &RangeLod, selection: &mut Selection) {
    selection.clear(tree.level_count());
    let Some(root) = tree.level_count().checked_sub(1) else {
        return;
    };
    let filter = Filter::new(view.frustum(), tree.origin(), &tree.bounds());
    let far: Vec<Threshold> = lod
        .far_dists(tree.level_count())
        .into_iter()
        .map(|distance| filter.threshold(distance))
        .collect();
    let mut traversal = Traversal {
        arrays: tree.arrays(),
        view,
        ranged_levels: far.len() as u32,
        far,
        root,
        next: vec![0; tree.level_count() as usize],
        largest_omitted: f32x8::ZERO,
        filter,
        selection,
    };
    let planes = traversal.filter.all_planes();
    traversal.siblings(root, 0..1, planes, f32::INFINITY); // step 1
    let largest = traversal.largest_omitted;
    selection.finish(largest.to_array(), view.pixels());
}

struct Traversal<'a> {
    arrays: Arrays<'a>,
    view: &'a View,
    filter: Filter,
    /// Far distance of each level that has a range, level 0 first.
    far: Vec<Threshold>,
    /// How many levels have a range; those above pass through.
    ranged_levels: u32,
    /// Level of the root.
    root: u32,
    /// For each level, the first node not yet visited. In a sound file it only states what is so:
    /// nodes come in tree order. In a damaged one it keeps the walk finite.
    next: Vec<u32>,
    /// Largest hidden radius of all nodes at which the walk stopped, divided by the distance where
    /// things look smaller with distance.
    largest_omitted: f32x8,
    selection: &'a mut Selection,
}

/// Eight siblings, sorted by what becomes of them.
#[derive(Clone, Copy)]
struct Siblings {
    level: u32,
    first: u32,
    /// Not outside the frustum and not beyond the range.
    kept: Lanes,
    /// Inside the frustum.
    inside: Lanes,
    /// Nearer than the range of their level, so their children are looked at.
    nearer: Lanes,
    relations: EightRelations,
}

impl Traversal<'_> {
    /// Steps 2 to 6 for the nodes `nodes` of one level, which are all children of one node.
    /// `planes` are those the parent crosses; `parent_hidden` is its hidden radius.
    fn siblings(&mut self, level: u32, nodes: Range<u32>, planes: PlaneSet, parent_hidden: f32) {
        let mut first = nodes.start;
        while first < nodes.end {
            let count = (nodes.end - first).min(8);
            self.eight(level, first, count, planes, parent_hidden);
            first += count;
        }
    }

    fn eight(&mut self, level: u32, first: u32, count: u32, planes: PlaneSet, parent_hidden: f32) {
        let Some(boxes) = self.arrays.nodes.eight(first) else {
            return;
        };
        self.selection.stats.nodes_visited += count;
        let lanes = ((1_u16 << count) - 1) as Lanes;
        // Step 2. Of an ambiguous box it is safe to say that it crosses: its objects are tested.
        let relations = self.filter.relations(&boxes, planes);
        let visible = lanes & !relations.outside;
        if visible == 0 {
            return;
        }
        let inside = visible & relations.inside;
        let distances = self.filter.distances(&boxes);

        // Steps 3 and 5: where does the distance lie to the range of the level?
        let limit = self.far[level.min(self.ranged_levels - 1) as usize];
        let kept = self.nearer(first, &distances, &limit, visible);
        let nearer = match level {
            0 => 0,
            level if level < self.ranged_levels => {
                let near = self.far[level as usize - 1];
                self.nearer(first, &distances, &near, kept)
            }
            _ => kept,
        };
        let siblings = Siblings {
            level,
            first,
            kept,
            inside,
            nearer,
            relations,
        };
        let wholes = self.whole_subtrees(&boxes, &distances, &siblings);
        let stopped = (kept & !nearer) | wholes.cut();
        let beyond = visible & !kept;
        if level > 0 && stopped != 0 {
            self.note_hidden(first, &distances, stopped);
        }
        if beyond != 0 {
            self.note_beyond(&boxes, &distances, beyond, parent_hidden);
        }
        self.take(&siblings, &wholes);
    }

    /// The boxes of `set` nearer than a threshold; what f32 leaves open is decided in f64.
    fn nearer(
        &self,
        first: u32,
        distances: &EightDistances,
        threshold: &Threshold,
        set: Lanes,
    ) -> Lanes {
        if threshold.distance == f64::INFINITY {
            return set;
        }
        let mut nearer = set & distances.nearer(threshold);
        let open = set & !nearer & !distances.not_nearer(threshold);
        if open == 0 {
            return nearer;
        }
        for lane in bits(open) {
            if let Some(exact) = exact(&self.arrays.nodes, first + lane)
                && exact.distance(self.view.eye()) < threshold.distance
            {
                nearer |= 1 << lane;
            }
        }
        nearer
    }

    /// Nodes inside the frustum whose subtree is cut at one level: (nodes, that level).
    ///
    /// All points of the box lie in the range of level j; so do the distances of all nodes below.
    /// Those above level j are nearer than their ranges, those at level j in it.
    fn whole_subtrees(
        &self,
        boxes: &Eight,
        distances: &EightDistances,
        siblings: &Siblings,
    ) -> Wholes {
        let mut wholes = Wholes::default();
        let mut candidates = siblings.nearer & siblings.inside;
        let levels = siblings.level.min(self.ranged_levels);
        for level in 0..levels {
            if candidates == 0 {
                break;
            }
            let from_near = match level {
                0 => Lanes::MAX,
                _ => distances.not_nearer(&self.far[level as usize - 1]),
            };
            let set = candidates
                & from_near
                & self.filter.wholly_nearer(boxes, &self.far[level as usize]);
            if set != 0 {
                wholes.push(set, level);
                candidates &= !set;
            }
        }
        wholes
    }

    /// Steps 3 to 6 for siblings in their order, which is that of their objects.
    fn take(&mut self, siblings: &Siblings, wholes: &Wholes) {
        let in_range = siblings.kept & siblings.inside & !siblings.nearer;
        let mut rest = siblings.kept;
        while rest != 0 {
            let lane = rest.trailing_zeros();
            let node = siblings.first + lane;
            let run = if let Some(&(set, down_to)) = wholes.of(lane) {
                let run = run_length(set, lane);
                self.add_inside(siblings.level, &(node..node + run));
                self.add_subtrees(siblings.level, node..node + run, down_to);
                run
            } else if in_range >> lane & 1 == 1 {
                let run = run_length(in_range, lane);
                self.add_inside(siblings.level, &(node..node + run));
                run
            } else {
                self.take_one(siblings, lane);
                1
            };
            rest &= !run_of(run, lane);
        }
    }

    /// Steps 3 and 4, or 5 and 6, for a node whose children are looked at or which crosses the
    /// frustum.
    fn take_one(&mut self, siblings: &Siblings, lane: u32) {
        let level = siblings.level;
        let node = siblings.first + lane;
        let planes = siblings.relations.open_planes(lane);
        let ranged = level < self.ranged_levels;
        if ranged && planes == 0 {
            self.add_inside(level, &(node..node + 1));
        } else if ranged {
            if self.enters(level) {
                self.representative(node, planes);
            }
            if let Some(own) = self.own(&(node..node + 1)) {
                self.add_tested(level, own, planes);
            }
        }
        if siblings.nearer >> lane & 1 == 1
            && let Some(children) = self.children(level, &(node..node + 1))
        {
            // A node without a range has added nothing, its own objects neither.
            let hidden = if ranged {
                self.hidden(node)
            } else {
                f32::INFINITY
            };
            self.siblings(level - 1, children, planes, hidden);
        }
    }

    /// Whether nobody above has added the representatives of nodes at this level: the levels
    /// above have no range.
    fn enters(&self, level: u32) -> bool {
        level < self.root && level + 1 >= self.ranged_levels
    }

    /// Adds the objects of nodes inside the frustum.
    fn add_inside(&mut self, level: u32, nodes: &Range<u32>) {
        if self.enters(level) {
            nodes.clone().for_each(|node| self.representative(node, 0));
        }
        self.add(level, nodes);
    }

    /// Adds everything below `nodes` that is stored at `down_to` or above.
    fn add_subtrees(&mut self, level: u32, nodes: Range<u32>, down_to: u32) {
        let mut nodes = nodes;
        for level in (down_to..level).rev() {
            match self.children(level + 1, &nodes) {
                Some(children) => nodes = children,
                None => return,
            }
            self.add(level, &nodes);
        }
    }

    /// The nodes below `nodes`, one level down, which are not visited twice.
    fn children(&mut self, level: u32, nodes: &Range<u32>) -> Option<Range<u32>> {
        let below = level.checked_sub(1)? as usize;
        let start = *self.arrays.children.get(nodes.start as usize)?;
        let end = *self.arrays.children.get(nodes.end as usize)?;
        let level_end = *self
            .arrays
            .level_nodes
            .get(self.root as usize - below + 1)?;
        let next = self.next.get_mut(below)?;
        if start < *next || end < start || end > level_end {
            return None; // only in a damaged file
        }
        *next = end;
        Some(start..end)
    }

    /// The own objects of `nodes`.
    fn own(&self, nodes: &Range<u32>) -> Option<Range<u32>> {
        let start = *self.arrays.own.get(nodes.start as usize)?;
        let end = *self.arrays.own.get(nodes.end as usize)?;
        (start <= end && end as usize <= self.arrays.objects.exact.len()).then_some(start..end)
    }

    fn hidden(&self, node: u32) -> f32 {
        let hidden = self.arrays.hidden_radii.get(node as usize);
        hidden.copied().unwrap_or(f32::INFINITY)
    }

    fn add(&mut self, level: u32, nodes: &Range<u32>) {
        if let Some(own) = self.own(nodes) {
            self.selection.add(level, own);
        }
    }

    /// Adds the object that stands for `node`, stored with an ancestor, unless it is outside one
    /// of `planes`.
    fn representative(&mut self, node: u32, planes: PlaneSet) {
        let Some(&object) = self.arrays.representatives.get(node as usize) else {
            return;
        };
        if object as usize >= self.arrays.objects.exact.len() {
            return; // only in a damaged file
        }
        let starts = self.arrays.level_objects;
        let coarser = starts.partition_point(|&start| start <= object) as u32;
        let Some(level) = (self.root + 1).checked_sub(coarser) else {
            return; // only in a damaged file
        };
        self.add_tested(level, object..object + 1, planes);
    }

    /// Adds the `objects` that are not outside one of `planes`.
    fn add_tested(&mut self, level: u32, objects: Range<u32>, planes: PlaneSet) {
        if planes == 0 {
            return self.selection.add(level, objects);
        }
        self.selection.stats.objects_tested += objects.end - objects.start;
        let mut first = objects.start;
        while first < objects.end {
            let count = (objects.end - first).min(8);
            let visible = self.visible(first, ((1_u16 << count) - 1) as Lanes, planes);
            let mut rest = visible;
            while rest != 0 {
                let lane = rest.trailing_zeros();
                let run = run_length(rest, lane);
                let start = first + lane;
                self.selection.add(level, start..start + run);
                rest &= !run_of(run, lane);
            }
            first += count;
        }
    }

    /// Which of eight objects are not outside; what f32 leaves open is decided in f64.
    fn visible(&self, first: u32, lanes: Lanes, planes: PlaneSet) -> Lanes {
        let Some(boxes) = self.arrays.objects.eight(first) else {
            return 0;
        };
        let (outside, touching) = self.filter.outside_or_touching(&boxes, planes);
        let mut visible = lanes & touching;
        let open = lanes & !outside & !touching;
        if open != 0 {
            for lane in bits(open) {
                if exact(&self.arrays.objects, first + lane)
                    .is_some_and(|exact| !self.view.frustum().is_outside(&exact))
                {
                    visible |= 1 << lane;
                }
            }
        }
        visible
    }

    /// Keeps the largest size on the screen of what lies below the nodes the walk stopped at.
    fn note_hidden(&mut self, first: u32, distances: &EightDistances, stopped: Lanes) {
        let at = first as usize;
        let radii = self.arrays.hidden_radii.get(at..at + 8);
        if let Some(radii) = radii.and_then(|r| r.try_into().ok()) {
            self.note(radii, distances, stopped);
        }
    }

    /// The same for nodes left out altogether: what they hold is hidden below their parent, and
    /// no larger than their box.
    fn note_beyond(
        &mut self,
        boxes: &Eight,
        distances: &EightDistances,
        beyond: Lanes,
        parent_hidden: f32,
    ) {
        let radii = Filter::radii(boxes).map(|radius| radius.min(parent_hidden));
        self.note(&radii, distances, beyond);
    }

    fn note(&mut self, radii: &[f32; 8], distances: &EightDistances, set: Lanes) {
        let size = match self.view.pixels() {
            PixelScale::PerRadian(_) => self.filter.largest_angles(radii, distances, set),
            PixelScale::PerMetre(_) => Filter::of_set(radii, set),
        };
        self.largest_omitted = self.largest_omitted.max(size);
    }
}

/// At most one entry per level that has a range; a handful in practice.
#[derive(Default)]
struct Wholes {
    sets: [(Lanes, u32); 8],
    count: usize,
}

impl Wholes {
    fn push(&mut self, set: Lanes, level: u32) {
        // Eight disjoint, non-empty sets of eight lanes are the most there can be.
        self.sets[self.count] = (set, level);
        self.count += 1;
    }

    fn iter(&self) -> std::slice::Iter<'_, (Lanes, u32)> {
        self.sets[..self.count].iter()
    }

    /// Nodes of which a part is left out.
    fn cut(&self) -> Lanes {
        let cut = self.iter().filter(|(_, level)| *level > 0);
        cut.fold(0, |all, (set, _)| all | set)
    }

    fn of(&self, lane: u32) -> Option<&(Lanes, u32)> {
        self.iter().find(|(set, _)| set >> lane & 1 == 1)
    }
}

/// The exact box, where it is one.
fn exact(boxes: &Boxes, at: u32) -> Option<Aabb> {
    let [x0, y0, z0, x1, y1, z1] = *boxes.exact.get(at as usize)?;
    Aabb::new(DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1)).ok()
}

/// How many lanes from `lane` on are in the set one after another.
fn run_length(set: Lanes, lane: u32) -> u32 {
    (!set >> lane).trailing_zeros().min(8 - lane)
}

fn run_of(length: u32, lane: u32) -> Lanes {
    (((1_u16 << length) - 1) << lane) as Lanes
}

fn bits(set: Lanes) -> impl Iterator<Item = u32> {
    (0..8).filter(move |lane| set >> lane & 1 == 1)
}

impl Selection {
    fn clear(&mut self, levels: u32) {
        self.levels.resize_with(levels as usize, Vec::new);
        self.levels.iter_mut().for_each(Vec::clear);
        self.ranges.clear();
        self.bound = 0.0;
        self.stats = super::Stats::default();
    }

    /// Adds objects stored at `level`; they follow those added there before.
    #[inline]
    fn add(&mut self, level: u32, objects: Range<u32>) {
        let Some(list) = self.levels.get_mut(level as usize) else {
            return;
        };
        match list.last_mut() {
            Some(last) if last.end == objects.start => last.end = objects.end,
            Some(last) if last.end > objects.start => {} // only in a damaged file
            _ if objects.is_empty() => {}
            _ => list.push(objects),
        }
    }

    /// Step 7: puts the levels together, coarsest first, and turns the size into pixels.
    fn finish(&mut self, sizes: [f32; 8], pixels: PixelScale) {
        for list in self.levels.iter().rev() {
            for objects in list {
                match self.ranges.last_mut() {
                    Some(last) if last.end == objects.start => last.end = objects.end,
                    _ => self.ranges.push(objects.clone()),
                }
            }
        }
        let largest = f64::from(sizes.into_iter().fold(0.0, f32::max));
        let (PixelScale::PerRadian(scale) | PixelScale::PerMetre(scale)) = pixels;
        self.bound = 2.0 * largest * scale;
    }
}
