//! Budget mode: so many objects, the largest on the screen.

use std::ops::Range;

use super::Selection;
use super::border::{Cut, SizedObject};
use super::search::{Miss, Search};
use super::sweep::{Wanted, sweep};
use crate::geom::{DVec3, Filter, PixelScale, View};
use crate::index::LodTree;

/// The knob of budget mode: exactly this many objects of the frustum are drawn, those of the
/// largest projected size ([`View::size_px`]), of equals those with the lower number; all of
/// them where there are fewer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BudgetLod {
    max_objects: u32,
}

impl BudgetLod {
    /// Any number will do; 0 draws nothing.
    pub fn new(max_objects: u32) -> Self {
        Self { max_objects }
    }

    pub(super) fn coarsened(self, factor: f64) -> Self {
        let max_objects = f64::from(self.max_objects) / (factor * factor);
        Self {
            max_objects: max_objects.ceil() as u32,
        }
    }

    /// How many objects are drawn at most.
    pub fn max_objects(&self) -> u32 {
        self.max_objects
    }
}

pub(super) fn select(tree: &LodTree, view: &View, lod: BudgetLod, selection: &mut Selection) {
    selection.clear();
    if tree.object_count() == 0 {
        return;
    }
    let filter = Filter::new(view.frustum(), tree.origin(), &tree.bounds());
    let budget = lod.max_objects;
    let last = selection.sizes.last.as_ref();
    let last = last.filter(|last| last.resembles(tree, view));
    let (expected, width) = if let Some(last) = last {
        last.expects(budget)
    } else {
        let survey = &mut selection.sizes.survey;
        let px = survey.estimate(tree, view, &filter, budget);
        (px, STRAYS + STRAYS_ALONE / f64::from(budget.max(1)).sqrt())
    };
    let is_first = last.is_none();
    let mut search = Search::new(budget, expected, width);
    loop {
        let wanted = search.wanted();
        let missed = sweep(tree, view, &filter, wanted, selection);
        let attempt = Attempt {
            budget,
            wanted,
            missed,
            sure: selection.ranges.count(),
            border: selection.sizes.border.len(),
        };
        let boxes = tree.arrays().object_boxes;
        let mut take = || {
            let border = &mut selection.sizes.border;
            border.take(&filter, view, boxes, attempt.missing(), attempt.sizes())
        };
        let (miss, cut) = if let Some(miss) = attempt.miss_by_number() {
            (Some(miss), None)
        } else {
            let cut = take();
            (attempt.miss_by_size(&cut), Some(cut))
        };
        if miss.is_some_and(|miss| search.goes_on(wanted, miss)) {
            selection.forget_ranges();
            continue;
        }
        let cut = cut.unwrap_or_else(take);
        selection.ranges.merge(selection.sizes.border.taken());
        let px = cut.smallest.min(wanted.sure);
        let strayed = if is_first { FRAME } else { px / expected };
        selection.sizes.last = Last::new(tree, view, budget, px, strayed);
        selection.conclude(cut.left.unwrap_or(0.0));
        return;
    }
}

/// What came of a sweep for a budget.
struct Attempt {
    budget: u32,
    wanted: Wanted,
    /// Whether anything smaller than [`Wanted::least`] was left out.
    missed: bool,
    /// Objects at least as large as [`Wanted::sure`], and those listed.
    sure: u32,
    border: usize,
}

impl Attempt {
    /// How many of the border are wanted.
    fn missing(&self) -> usize {
        self.budget.saturating_sub(self.sure) as usize
    }

    /// What is sure must be larger than what is left of the border, and that as large as what was
    /// missed: the sizes to be told from others.
    fn sizes(&self) -> Range<f64> {
        let least = if self.missed { self.wanted.least } else { 0.0 };
        let sure = if self.sure > 0 {
            self.wanted.sure
        } else {
            f64::INFINITY
        };
        least..sure
    }

    /// What shows without a look at the border.
    fn miss_by_number(&self) -> Option<Miss> {
        let found = self.sure.saturating_add(self.border as u32);
        if self.sure > self.budget {
            Some(Miss::Many { sure: self.sure })
        } else if self.missed && found <= self.budget {
            Some(Miss::Few { found })
        } else {
            None
        }
    }

    /// What shows where the border is cut.
    fn miss_by_size(&self, cut: &Cut) -> Option<Miss> {
        let Self {
            budget,
            wanted,
            missed,
            sure,
            ..
        } = *self;
        if sure > 0 && cut.left.is_some_and(|left| left >= wanted.sure) {
            let sure = budget.saturating_add(1);
            Some(Miss::Many { sure })
        } else if missed && cut.left.is_none_or(|left| left < wanted.least) {
            Some(Miss::Few { found: budget })
        } else {
            None
        }
    }
}

/// What the last budget came to: where a frame loop begins, as sizes hardly move from one frame to
/// the next.
#[derive(Debug, Clone)]
pub(super) struct Last {
    objects: u32,
    eye: DVec3,
    scale: PixelScale,
    budget: u32,
    px: f64,
    /// By how much that was other than expected, as a ratio of at least 1.
    strayed: f64,
}

/// Frames follow one another while the eye moves by no more than this share of the city.
const STEP: f64 = 0.01;
/// What sizes change by from frame to frame, as a ratio, where nothing is known of the frame before;
/// mostly they change by as much as in that one.
const FRAME: f64 = 1.01;
/// And at most: to look farther than that takes longer than to look twice.
const FARTHEST: f64 = 1.05;
/// And at least, that not every bend in a path is a miss.
const STILL: f64 = 1.001;
/// What a survey may stray by.
const STRAYS: f64 = 1.025;
/// The same of a single object; the more there are, the more it evens out.
const STRAYS_ALONE: f64 = 0.5;

impl Last {
    fn new(tree: &LodTree, view: &View, budget: u32, px: f64, strayed: f64) -> Option<Self> {
        (px > 0.0 && px < f64::INFINITY).then(|| Self {
            objects: tree.object_count(),
            eye: view.eye(),
            scale: view.pixels(),
            budget,
            px,
            strayed: strayed.max(1.0 / strayed),
        })
    }

    /// Where the size is to be expected in the next frame, pixels, and within which ratio.
    fn expects(&self, budget: u32) -> (f64, f64) {
        let growth = f64::from(budget.max(1)) / f64::from(self.budget.max(1));
        let width = if budget == self.budget {
            // Sizes lie the farther apart the fewer there are.
            (self.strayed * self.strayed + 1.0 / f64::from(budget.max(1))).clamp(STILL, FARTHEST)
        } else {
            FRAME
        };
        (self.px / growth.sqrt(), width)
    }

    fn resembles(&self, tree: &LodTree, view: &View) -> bool {
        let step = self.eye.distance(view.eye());
        self.objects == tree.object_count()
            && self.scale == view.pixels()
            && step <= STEP * tree.bounds().size().length()
    }
}

/// Keeps the `most` largest objects of a selection, of equals those with the lower number. What
/// goes counts for [`Selection::error_px`].
pub fn keep_largest(tree: &LodTree, view: &View, most: u32, selection: &mut Selection) {
    if selection.count() <= most {
        return;
    }
    let sized = |object| {
        let size = view.size_px(&tree.bounds_of(object)?);
        Some(SizedObject { size, object })
    };
    let mut ranked: Vec<SizedObject> = selection.objects().filter_map(sized).collect();
    if ranked.len() <= most as usize {
        return; // only in a damaged file
    }
    let (kept, best_left, _) = ranked.select_nth_unstable_by(most as usize, SizedObject::order);
    let omitted = best_left.size.max(selection.error_px());
    kept.sort_unstable_by_key(|sized| sized.object);
    let mut kept = kept.iter().map(|sized| sized.object).peekable();
    selection.retain(|object| kept.next_if_eq(&object).is_some());
    selection.conclude(omitted);
}
