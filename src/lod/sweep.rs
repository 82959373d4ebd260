//! Everything of a size: the walk that error mode and budget mode share.
//!
//! Level by level, siblings eight at a time.
//!
//! The law that makes the cut valid: a node's distance is at most that of anything in it and the
//! radius kept for it at least that of anything in it, in floating point too, and the size is
//! monotone in both ([`View::size_px`]). So what is certainly too small for the node is too small
//! for all it holds. Certainty is f32's ([`SizeThreshold`]); what it leaves open is entered if a
//! node; an object is listed in the border, or decided in f64 where there is none.

use std::ops::Range;

use super::border::Border;
use super::budget::Last;
use super::descent::Descent;
use super::gather::Gathered;
use super::ranges::Ranges;
use super::selection::Stats;
use super::sight::Sight;
use super::sizing::Sizing;
use super::survey::Survey;
use super::{Selection, lanes};
use crate::geom::{Eight, Filter, Floats, Kernel, PlaneSet, SizeThreshold, View, widest};
use crate::index::LodTree;

/// Two sizes, pixels, `least` ≤ `sure`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// Objects of this size or larger are drawn; where it is infinite, none is sure.
    pub(super) sure: f64,
    /// Those between are listed, in [`Sizes::border`].
    pub(super) least: f64,
}

/// Memory of a walk.
#[derive(Debug, Clone, Default)]
pub(super) struct Sizes {
    /// What is to be looked at in a level, and in the one below it.
    open: Vec<Open>,
    below: Vec<Open>,
    own: Gathered,
    /// Objects too small to be sure and too large to be left out.
    pub(super) border: Border,
    /// What the last budget came to.
    pub(super) last: Option<Last>,
    pub(super) survey: Survey,
}

/// Neighbouring nodes.
#[derive(Debug, Clone)]
enum Open {
    /// The children of a node.
    Siblings {
        nodes: Range<u32>,
        /// Where their boxes begin.
        block: u32,
        /// Planes the parent crosses.
        planes: PlaneSet,
    },
    /// Whatever they hold is drawn.
    Whole { nodes: Range<u32> },
}

/// Adds what is sure to `selection`, which has been cleared, and lists the border. Returns whether
/// anything of the frustum may be left out, all of which is smaller than `wanted.least`.
pub(super) fn sweep(
    tree: &LodTree,
    view: &View,
    filter: &Filter,
    wanted: Wanted,
    selection: &mut Selection,
) -> bool {
    let stats = selection.stats();
    let Selection { sizes, ranges, .. } = &mut *selection;
    let Sizes {
        open,
        below,
        own,
        border,
        ..
    } = sizes;
    border.clear(view, wanted.least..wanted.sure);
    open.clear();
    open.push(Open::Siblings {
        nodes: 0..1,
        block: 0,
        planes: filter.all_planes(),
    });
    let threshold = |px| SizeThreshold::new(filter, view.pixels(), px);
    let arrays = tree.arrays();
    let mut sweep = Sweep {
        sizing: Sizing {
            arrays,
            sight: Sight::new(view, filter, &arrays),
            sure: threshold(wanted.sure),
            least: threshold(wanted.least),
            missed: false,
            border: (wanted.least < wanted.sure || wanted.sure == f64::INFINITY).then_some(border),
        },
        stats,
        descent: Descent::to(&arrays, 1),
        below,
        own,
    };
    let mut next = 0;
    for level in (0..tree.level_count()).rev() {
        sweep.start(tree.level_count() - level);
        widest(JudgeNodes {
            sweep: &mut sweep,
            level,
            open,
        });
        widest(ListObjects {
            sweep: &mut sweep,
            next: &mut next,
            ranges,
        });
        std::mem::swap(open, sweep.below);
    }
    let (missed, stats) = (sweep.sizing.missed, sweep.stats);
    selection.set_stats(stats);
    missed
}

struct Sweep<'a> {
    sizing: Sizing<'a>,
    stats: Stats,
    descent: Descent,
    below: &'a mut Vec<Open>,
    own: &'a mut Gathered,
}

/// Decides of the nodes of a level.
struct JudgeNodes<'a, 'b> {
    sweep: &'a mut Sweep<'b>,
    level: u32,
    open: &'a [Open],
}

impl Kernel for JudgeNodes<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Floats>(self) {
        for open in self.open {
            self.sweep.look_at::<F>(self.level, open);
        }
    }
}

/// Lists the objects that a level adds: those that are sure.
struct ListObjects<'a, 'b> {
    sweep: &'a mut Sweep<'b>,
    next: &'a mut u32,
    ranges: &'a mut Ranges,
}

impl Kernel for ListObjects<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Floats>(self) {
        let Sweep {
            sizing, own, stats, ..
        } = self.sweep;
        let arrays = sizing.arrays;
        let sure = |block, boxes: &Eight, first, set, planes| {
            sizing.sure::<F>(block, boxes, first, set, planes)
        };
        let tested = own.list(&arrays, self.next, self.ranges, sure);
        stats.objects_tested = stats.objects_tested.saturating_add(tested);
    }
}

impl Sweep<'_> {
    /// Begins a level whose children lie at this depth.
    fn start(&mut self, depth: u32) {
        self.descent = Descent::to(&self.sizing.arrays, depth);
        self.below.clear();
        self.own.clear();
    }

    #[inline(always)]
    fn look_at<F: Floats>(&mut self, level: u32, open: &Open) {
        match open {
            Open::Siblings {
                nodes,
                block,
                planes,
            } => self.siblings::<F>(level, nodes, *block as usize, *planes),
            Open::Whole { nodes } => {
                self.own.whole(nodes);
                if level > 0 {
                    self.open_whole(nodes.clone());
                }
            }
        }
    }

    #[inline(always)]
    fn siblings<F: Floats>(
        &mut self,
        level: u32,
        nodes: &Range<u32>,
        block: usize,
        planes: PlaneSet,
    ) {
        for (block, first) in (block..).zip(nodes.clone().step_by(8)) {
            let count = (nodes.end - first).min(8);
            self.eight::<F>(level, block, first, count, planes);
        }
    }

    /// Lists the children of neighbouring nodes, all of which are drawn.
    #[inline]
    fn open_whole(&mut self, nodes: Range<u32>) {
        if let Some(nodes) = self.descent.children(&self.sizing.arrays, nodes) {
            match self.below.last_mut() {
                Some(Open::Whole { nodes: last }) if last.end == nodes.start => {
                    last.end = nodes.end;
                }
                _ => self.below.push(Open::Whole { nodes }),
            }
        }
    }

    #[inline(always)]
    fn eight<F: Floats>(
        &mut self,
        level: u32,
        block: usize,
        first: u32,
        count: u32,
        planes: PlaneSet,
    ) {
        let arrays = &self.sizing.arrays;
        let (Some(boxes), Some(largest), Some(least)) = (
            arrays.child_blocks.get(block),
            arrays.child_radii.get(block),
            arrays.child_least_radii.get(block),
        ) else {
            return; // only in a damaged file
        };
        let visited = &mut self.stats.nodes_visited;
        *visited = visited.saturating_add(count);
        let relations = self.sizing.sight.filter.relations_in::<F>(boxes, planes);
        let visible = lanes::first(count) & !relations.outside;
        if visible == 0 {
            return;
        }
        let distances = self.sizing.sight.filter.distances_in::<F>(boxes);
        let large = self
            .sizing
            .large_enough(F::of(largest), &distances, visible);
        if large == 0 {
            return;
        }
        let deeper = match self.sizing.arrays.hidden_radii.get(first as usize..) {
            Some(radii) if level > 0 => match radii.first_chunk::<8>() {
                Some(hidden) => self
                    .sizing
                    .large_enough(F::of_array(hidden), &distances, large),
                None => 0, // only in a damaged file
            },
            _ => 0,
        };
        let inside = large & relations.inside;
        let whole = if inside == 0 {
            0
        } else {
            let farthest = self.sizing.sight.filter.farthest_in::<F>(boxes);
            inside & self.sizing.sure.reached(F::of(least), &farthest)
        };
        self.own.nodes(first, large, whole, &relations);
        if level == 0 {
            return;
        }
        for lane in lanes::each(deeper | whole) {
            if lanes::has(whole, lane) {
                self.open_whole(first + lane..first + lane + 1);
            } else {
                self.open(first + lane, relations.open_planes(lane));
            }
        }
    }

    /// Lists the children of a node to be looked at.
    #[inline]
    fn open(&mut self, node: u32, planes: PlaneSet) {
        if let Some(&block) = self.sizing.arrays.child_block_starts.get(node as usize)
            && let Some(nodes) = self.descent.children(&self.sizing.arrays, node..node + 1)
        {
            self.below.push(Open::Siblings {
                nodes,
                block,
                planes,
            });
        }
    }
}
