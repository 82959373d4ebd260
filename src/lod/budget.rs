//! Budget mode: so many objects, the largest on the screen.

use std::cmp::Ordering;

use super::Selection;
use super::sweep::{Sized, Wanted, sweep};
use crate::geom::{Filter, View};
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
    selection.clear(tree.level_count());
    if tree.object_count() == 0 {
        return;
    }
    let filter = Filter::new(view.frustum(), tree.origin(), &tree.bounds());
    let budget = lod.max_objects as usize;
    let survey = &mut selection.sizes.survey;
    let mut wanted = survey.estimate(tree, view, &filter, lod.max_objects);
    let mut width = WIDTH;
    loop {
        let omitted = sweep(tree, view, &filter, wanted, selection);
        let sure = selection.count() as usize;
        let found = sure + selection.sizes.border.len();
        wanted = if sure > budget {
            Wanted {
                sure: (wanted.sure * width).max(f64::MIN_POSITIVE),
                least: wanted.sure,
            }
        } else if found < budget && wanted.least > 0.0 {
            Wanted {
                sure: wanted.least,
                least: wanted.least.min(LARGEST) / width,
            }
        } else {
            return fill(selection, budget - sure, wanted.sure, omitted);
        };
        width = width.powi(4);
        if width == f64::INFINITY {
            // Every object counts, and is ranked.
            wanted = Wanted {
                sure: f64::INFINITY,
                least: 0.0,
            };
        }
        selection.forget_ranges();
    }
}

/// Ratio of the two sizes of a second attempt, where the estimate was wrong; each further one has
/// the fourth power of it, so that there are but a few.
const WIDTH: f64 = 1.3;
/// Where to go on from infinity, pixels.
const LARGEST: f64 = 1e6;

/// Adds the `missing` largest of the border.
fn fill(selection: &mut Selection, missing: usize, sure: f64, omitted: f64) {
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
    selection.merge(border.iter().map(|sized| sized.object));
    selection.sizes.border = border;
    selection.sizes.ranked = ranked;
    // Nothing left out is larger than anything drawn, whatever rounding adds to the bound.
    selection.conclude(omitted.min(smallest));
}

/// The larger first, of equals the one with the lower number.
fn larger(a: &Sized, b: &Sized) -> Ordering {
    b.size.total_cmp(&a.size).then(a.object.cmp(&b.object))
}
