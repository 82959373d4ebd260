//! Production code against the oracle, for the boxes of one tree in one view.

use wide::f32x8;

use std::cmp::Ordering;
use std::ops::Range;

use super::Tally;
use super::ranges::Ranges;
use crate::experiment::exact::{Answer, Camera, Oracle, compare_distance, compare_farthest};
use crate::geom::{
    Aabb, Eight, Filter, PlaneSet, Relation, SeparatingAxes, Threshold, View, ViewError,
};
use crate::index::LodTree;
use crate::lod::{RangeLod, Selection, retrieve};

/// One box in how many is also put to exact numbers alone, to check the quicker answer.
const CHECKED: u64 = 64;

/// Puts every object and node of the tree to production code and to the oracle, and retrieves at
/// full detail and with each of `lods`.
///
/// # Errors
/// [`ViewError`] when the camera cannot be.
pub fn examine(tree: &LodTree, camera: &Camera, lods: &[RangeLod]) -> Result<Tally, ViewError> {
    let view = camera.view()?;
    let filter = Filter::new(view.frustum(), tree.origin(), &tree.bounds());
    let thresholds = lods.iter().map(|lod| filter.threshold(lod.far_dist()));
    let mut examination = Examination {
        oracle: Oracle::new(camera),
        axes: SeparatingAxes::new(view.frustum()),
        planes: filter.all_planes(),
        thresholds: thresholds.collect(),
        view: &view,
        filter,
        tally: Tally::default(),
        last: None,
    };
    let drawn = examination.objects(tree);
    examination.nodes(tree);
    let mut tally = examination.tally;
    tally += retrievals(tree, &view, lods, &drawn);
    Ok(tally)
}

struct Examination<'a> {
    view: &'a View,
    oracle: Oracle,
    axes: SeparatingAxes,
    filter: Filter,
    planes: PlaneSet,
    thresholds: Vec<Threshold>,
    tally: Tally,
    /// The last box and what was found: neighbours may be identical.
    last: Option<(Aabb, [Answer; 2])>,
}

/// Whether an object is to be drawn at full detail, by f64, and whether it meets the frustum.
struct Drawn {
    kept: bool,
    meets: Answer,
}

impl Examination<'_> {
    fn objects(&mut self, tree: &LodTree) -> Vec<Drawn> {
        let arrays = tree.arrays();
        let mut drawn = Vec::with_capacity(arrays.object_boxes.len());
        let groups = arrays.own.windows(2).zip(arrays.own_block_starts);
        for ((own, &block), node) in groups.zip(arrays.node_boxes) {
            let Some(parent) = Aabb::from_array(*node).ok() else {
                continue;
            };
            let blocks = &arrays.own_blocks[block as usize..];
            let boxes = arrays.object_boxes;
            self.group(boxes, own[0]..own[1], blocks, &parent, &mut drawn);
        }
        drawn
    }

    fn nodes(&mut self, tree: &LodTree) {
        let arrays = tree.arrays();
        let mut seen = Vec::new();
        if let Some(root) = arrays
            .node_boxes
            .first()
            .and_then(|b| Aabb::from_array(*b).ok())
        {
            let boxes = arrays.node_boxes;
            self.group(boxes, 0..1, arrays.child_blocks, &root, &mut seen);
        }
        let groups = arrays.children.windows(2).zip(arrays.child_block_starts);
        for ((children, &block), node) in groups.zip(arrays.node_boxes) {
            let Some(parent) = Aabb::from_array(*node).ok() else {
                continue;
            };
            let blocks = &arrays.child_blocks[block as usize..];
            let boxes = arrays.node_boxes;
            self.group(boxes, children[0]..children[1], blocks, &parent, &mut seen);
        }
    }

    /// Boxes that lie in `parent`, with their f32 forms in `blocks`.
    fn group(
        &mut self,
        boxes: &[[f64; 6]],
        group: Range<u32>,
        blocks: &[Eight],
        parent: &Aabb,
        drawn: &mut Vec<Drawn>,
    ) {
        let eye = self.view.eye();
        let boxes = &boxes[group.start as usize..group.end as usize];
        for (chunk, block) in boxes.chunks(8).zip(blocks) {
            let relations = self.filter.relations(block, self.planes);
            let (outside, touching) = self.filter.outside_or_touching(block, self.planes);
            let (nearest, farthest) = (self.filter.distances(block), self.filter.farthest(block));
            for (lane, b) in chunk.iter().enumerate() {
                let Ok(b) = Aabb::from_array(*b) else {
                    continue;
                };
                let bit = |set: u32| set >> lane & 1 == 1;
                let truth = self.truth(&b);
                let relation = self.view.frustum().relation(&b);
                let kept = relation != Relation::Outside;
                self.note(&b, truth, relation, [bit(relations.outside), bit(outside)]);
                let tally = &mut self.tally;
                tally.false_inside += u64::from(bit(relations.inside) && truth[1] != Answer::Yes);
                // f32 says for certain what f64 says, or nothing.
                let contradicts = (bit(relations.outside) || bit(outside)) && kept
                    || bit(touching) && !kept
                    || kept == self.view.frustum().is_outside(&b);
                tally.mismatches += u64::from(contradicts);
                let alone = block.map(|values| f32x8::splat(values.as_array()[lane]));
                let again = self.filter.relations(&alone, self.planes);
                let differs = [
                    (again.outside, relations.outside),
                    (again.inside, relations.inside),
                ]
                .iter()
                .any(|&(eight, one)| eight != if bit(one) { 0xff } else { 0 });
                tally.mismatches += u64::from(differs);
                tally.monotone_violations +=
                    u64::from(b.distance_squared(eye) < parent.distance_squared(eye));
                for far in &self.thresholds {
                    let order = compare_distance(&b, eye, far.distance);
                    let farther = compare_farthest(&b, eye, far.distance);
                    let wrong = bit(nearest.nearer(far)) && order != Ordering::Less
                        || bit(nearest.not_nearer(far)) && order == Ordering::Less
                        || bit(farthest.nearer(far)) && farther != Ordering::Less
                        || bit(farthest.not_nearer(far)) && farther == Ordering::Less;
                    self.tally.mismatches += u64::from(wrong);
                }
                drawn.push(Drawn {
                    kept,
                    meets: truth[0],
                });
            }
        }
    }

    fn truth(&mut self, b: &Aabb) -> [Answer; 2] {
        if let Some((last, truth)) = self.last
            && last == *b
        {
            return truth;
        }
        let truth = self.oracle.relation(b);
        if self.tally.cases.is_multiple_of(CHECKED) {
            let exact = [
                self.oracle.meets_exactly(b),
                self.oracle.contains_exactly(b),
            ];
            self.tally.mismatches += u64::from(truth != exact);
        }
        self.last = Some((*b, truth));
        truth
    }

    fn note(
        &mut self,
        b: &Aabb,
        truth: [Answer; 2],
        f64_says: Relation,
        f32_says_outside: [bool; 2],
    ) {
        let tally = &mut self.tally;
        let [meets, inside] = truth;
        tally.cases += 1;
        tally.meeting += u64::from(meets == Answer::Yes);
        tally.inside += u64::from(inside == Answer::Yes);
        tally.open += u64::from(meets == Answer::Open || inside == Answer::Open);
        let culled = f64_says == Relation::Outside || f32_says_outside.contains(&true);
        tally.false_negatives += u64::from(culled && meets != Answer::No);
        let separated = !culled && self.axes.separate(b);
        tally.false_negatives += u64::from(separated && meets != Answer::No);
        tally.kept_outside += u64::from(!culled && meets == Answer::No);
        tally.not_separated += u64::from(!culled && !separated && meets == Answer::No);
        let wrong = f64_says == Relation::Inside && inside != Answer::Yes;
        tally.false_inside += u64::from(wrong);
    }
}

/// Full detail draws what f64 keeps, ranges draw what exact distances call for, and twice the
/// same question has one answer.
fn retrievals(tree: &LodTree, view: &View, lods: &[RangeLod], drawn: &[Drawn]) -> Tally {
    let mut tally = Tally::default();
    let (mut selection, mut again) = (Selection::default(), Selection::default());
    retrieve(tree, view, &RangeLod::full_detail(), &mut selection);
    let mut found = vec![false; drawn.len()];
    selection.objects().for_each(|o| found[o as usize] = true);
    for (found, drawn) in found.iter().zip(drawn) {
        tally.mismatches += u64::from(*found != drawn.kept);
        tally.false_negatives += u64::from(!found && drawn.kept && drawn.meets != Answer::No);
    }
    for lod in lods {
        retrieve(tree, view, lod, &mut selection);
        retrieve(tree, view, lod, &mut again);
        let same = selection.ranges() == again.ranges()
            && selection.error_px().to_bits() == again.error_px().to_bits();
        tally.mismatches += u64::from(!same);
        let ranges = Ranges::new(tree, view.eye(), lod);
        tally.at_border += ranges.at_border;
        let mut found = vec![false; drawn.len()];
        selection.objects().for_each(|o| found[o as usize] = true);
        for ((found, drawn), called) in found.iter().zip(drawn).zip(&ranges.called_for) {
            tally.mismatches += u64::from(*found != (*called && drawn.kept));
        }
    }
    tally
}
