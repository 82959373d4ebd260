//! Error mode and budget mode against looking at every object, for the same answer.

use serde::Serialize;

use super::full_detail::ranked;
use super::scan::Scan;
use super::viewpoint::viewpoints;
use crate::experiment::ReportError;
use crate::experiment::timing::{median, median_us};
use crate::index::LodTree;
use crate::lod::{BudgetLod, ErrorLod, Lod, Selection, select};

const COUNTS: [usize; 3] = [1_000, 5_000, 20_000];
const SAMPLES: usize = 5;

/// Medians over the views that have so many objects in the frustum; ratios are taken view by view.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Speed {
    pub(super) objects: u32,
    pub(super) count: usize,
    pub(super) views: usize,
    pub(super) error_us: f64,
    pub(super) budget_us: f64,
    pub(super) linear_us: f64,
    pub(super) linear_over_error: f64,
    /// In the view where it is lowest.
    pub(super) lowest_linear_over_error: f64,
    pub(super) budget_over_error: f64,
    /// In the view where it is highest.
    pub(super) highest_budget_over_error: f64,
}

/// One row for each answer that some view of the city is large enough for.
pub(super) fn measure(tree: &LodTree, scan: &Scan) -> Result<Vec<Speed>, ReportError> {
    let mut found = Vec::new();
    let mut selection = Selection::default();
    let mut times: Vec<(usize, [f64; 3])> = Vec::new();
    for viewpoint in viewpoints(tree)? {
        let view = &viewpoint.view;
        let ranked = ranked(tree, view);
        for count in COUNTS {
            let Some(&(px, _)) = ranked.get(count - 1) else {
                continue;
            };
            let Ok(error) = ErrorLod::new(px) else {
                continue; // the eye is inside as many objects
            };
            let error_us = median_us(SAMPLES, || {
                select(tree, view, &Lod::Error(error), &mut selection);
            });
            // Where sizes tie there are more of them.
            let budget = Lod::Budget(BudgetLod::new(selection.count()));
            let budget_us = median_us(SAMPLES, || select(tree, view, &budget, &mut selection));
            let linear_us = median_us(SAMPLES, || scan.large(tree, view, px, &mut found));
            times.push((count, [error_us, budget_us, linear_us]));
        }
    }
    let rows = COUNTS.into_iter().filter_map(|count| {
        let of_count = times.iter().filter(|time| time.0 == count);
        let times: Vec<[f64; 3]> = of_count.map(|time| time.1).collect();
        let middle = |of: fn(&[f64; 3]) -> f64| median(times.iter().map(of).collect());
        let linear: Vec<f64> = times.iter().map(|[e, _, l]| l / e).collect();
        let budget: Vec<f64> = times.iter().map(|[e, b, _]| b / e).collect();
        (!times.is_empty()).then(|| Speed {
            objects: tree.object_count(),
            count,
            views: times.len(),
            error_us: middle(|t| t[0]),
            budget_us: middle(|t| t[1]),
            linear_us: middle(|t| t[2]),
            lowest_linear_over_error: linear.iter().copied().fold(f64::INFINITY, f64::min),
            linear_over_error: median(linear),
            highest_budget_over_error: budget.iter().copied().fold(0.0, f64::max),
            budget_over_error: median(budget),
        })
    });
    Ok(rows.collect())
}
