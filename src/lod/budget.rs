//! Budget mode: so many objects, the largest on the screen.

use super::Selection;
use super::border::{Cut, Sized};
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
    let mut search = match &selection.sizes.last {
        Some(last) if last.resembles(tree, view) => {
            let growth = f64::from(budget.max(1)) / f64::from(last.budget.max(1));
            Search::new(budget, last.px / growth.sqrt(), FRAME)
        }
        _ => {
            let survey = &mut selection.sizes.survey;
            let px = survey.estimate(tree, view, &filter, budget);
            Search::new(
                budget,
                px,
                STRAYS + STRAYS_ALONE / f64::from(budget.max(1)).sqrt(),
            )
        }
    };
    loop {
        let wanted = search.wanted();
        let missed = sweep(tree, view, &filter, wanted, selection);
        let (verdict, cut) = judge(tree, view, &filter, budget, wanted, missed, selection);
        let goes_on = verdict.is_some_and(|miss| search.goes_on(wanted, miss));
        if !goes_on {
            let Selection { sizes, ranges, .. } = &mut *selection;
            ranges.merge(sizes.border.taken());
            sizes.last = Last::new(tree, view, budget, cut.smallest.min(wanted.sure));
            let missed = if missed { wanted.least } else { 0.0 };
            selection.conclude(cut.left.max(missed));
            break;
        }
        selection.forget_ranges();
    }
}

/// Takes of the border what is missing from a budget, and tells what keeps that from being right.
fn judge(
    tree: &LodTree,
    view: &View,
    filter: &Filter,
    budget: u32,
    wanted: Wanted,
    missed: bool,
    selection: &mut Selection,
) -> (Option<Miss>, Cut) {
    let sure = selection.count();
    let border = &mut selection.sizes.border;
    // What is sure must be larger than what is left, and what is taken than what was missed.
    let least = if missed { wanted.least } else { 0.0 };
    let largest = if sure > 0 { wanted.sure } else { f64::INFINITY };
    let missing = budget.saturating_sub(sure) as usize;
    let boxes = tree.arrays().object_boxes;
    let cut = border.take(filter, view, boxes, missing, least..largest);
    let [smallest, left] = cut.decided;
    let found = sure.saturating_add(border.len() as u32);
    let miss = if sure > budget {
        Some(Miss::Many { sure })
    } else if sure > 0 && left.is_some_and(|left| left >= wanted.sure) {
        Some(Miss::Many {
            sure: budget.saturating_add(1),
        })
    } else if missed && found < budget {
        Some(Miss::Few { found })
    } else if smallest.is_some_and(|smallest| smallest < least) {
        Some(Miss::Few { found: budget - 1 })
    } else {
        None
    };
    (miss, cut)
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
}

/// Frames follow one another while the eye moves by no more than this share of the city.
const STEP: f64 = 0.01;
/// What sizes change by from frame to frame, as a ratio.
const FRAME: f64 = 1.01;
/// What a survey may stray by.
const STRAYS: f64 = 1.025;
/// The same of a single object; the more there are, the more it evens out.
const STRAYS_ALONE: f64 = 0.5;

impl Last {
    fn new(tree: &LodTree, view: &View, budget: u32, px: f64) -> Option<Self> {
        (px > 0.0 && px < f64::INFINITY).then(|| Self {
            objects: tree.object_count(),
            eye: view.eye(),
            scale: view.pixels(),
            budget,
            px,
        })
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
        Some(Sized { size, object })
    };
    let mut ranked: Vec<Sized> = selection.objects().filter_map(sized).collect();
    if ranked.len() <= most as usize {
        return; // only in a damaged file
    }
    let (kept, best_left, _) = ranked.select_nth_unstable_by(most as usize, Sized::order);
    let omitted = best_left.size.max(selection.error_px());
    kept.sort_unstable_by_key(|sized| sized.object);
    let mut kept = kept.iter().map(|sized| sized.object).peekable();
    selection.retain(|object| kept.next_if_eq(&object).is_some());
    selection.conclude(omitted);
}
