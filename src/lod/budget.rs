//! Budget mode: so many objects, the largest on the screen.

use std::cmp::Ordering;

use super::Selection;
use super::search::Search;
use super::sweep::{Sized, sweep};
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
            Search::new(budget, px, STRAYS)
        }
    };
    loop {
        let wanted = search.wanted();
        let missed = sweep(tree, view, &filter, wanted, selection);
        let sure = selection.count();
        let found = sure + selection.sizes.border.len() as u32;
        let all = !missed && sure <= budget;
        if all || !search.goes_on(wanted, sure, found) {
            let omitted = if missed { wanted.least } else { 0.0 };
            let missing = budget.saturating_sub(sure) as usize;
            let px = fill(selection, missing, wanted.sure, omitted);
            selection.sizes.last = Last::new(tree, view, budget, px);
            break;
        }
        selection.forget_ranges();
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
}

/// Frames follow one another while the eye moves by no more than this share of the city.
const STEP: f64 = 0.01;
/// What sizes change by from frame to frame, as a ratio.
const FRAME: f64 = 1.01;
/// What a survey may stray by.
const STRAYS: f64 = 1.025;

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
    let (kept, best_left, _) = ranked.select_nth_unstable_by(most as usize, larger);
    let omitted = best_left.size.max(selection.error_px());
    kept.sort_unstable_by_key(|sized| sized.object);
    let mut kept = kept.iter().map(|sized| sized.object).peekable();
    selection.retain(|object| kept.next_if_eq(&object).is_some());
    selection.conclude(omitted);
}

/// Adds the `missing` largest of the border. Returns the smallest size drawn, about.
fn fill(selection: &mut Selection, missing: usize, sure: f64, omitted: f64) -> f64 {
    let mut border = std::mem::take(&mut selection.sizes.border);
    let mut ranked = std::mem::take(&mut selection.sizes.ranked);
    ranked.clear();
    let mut smallest = sure;
    let mut omitted = omitted;
    if missing < border.len() {
        ranked.extend_from_slice(&border);
        let (_, best_left, _) = ranked.select_nth_unstable_by(missing, larger);
        let best_left = *best_left;
        border.retain(|sized| larger(sized, &best_left).is_lt());
        omitted = omitted.max(best_left.size);
    }
    smallest = border
        .iter()
        .map(|sized| sized.size)
        .fold(smallest, f64::min);
    selection
        .ranges
        .merge(border.iter().map(|sized| sized.object));
    selection.sizes.border = border;
    selection.sizes.ranked = ranked;
    // Nothing left out is larger than anything drawn, whatever rounding adds to the bound.
    selection.conclude(omitted.min(smallest));
    smallest
}

/// The larger first, of equals the one with the lower number.
fn larger(a: &Sized, b: &Sized) -> Ordering {
    b.size.total_cmp(&a.size).then(a.object.cmp(&b.object))
}
