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
    /// A frame after another, the camera moving.
    pub(super) budget_us: f64,
    /// The first frame of all.
    pub(super) first_budget_us: f64,
    /// Every object, eight at a time in f32, from tables made for it.
    pub(super) linear_us: f64,
    /// Every object, one at a time in f64, from their boxes.
    pub(super) plain_us: f64,
    pub(super) plain_over_error: f64,
    pub(super) linear_over_error: f64,
    /// In the view where it is lowest.
    pub(super) lowest_linear_over_error: f64,
    pub(super) budget_over_error: f64,
    pub(super) first_budget_over_error: f64,
    /// In the view where it is highest.
    pub(super) highest_budget_over_error: f64,
}

/// One row for each answer that some view of the city is large enough for.
pub(super) fn measure(tree: &LodTree, scan: &Scan) -> Result<Vec<Speed>, ReportError> {
    let mut found = Vec::new();
    let mut selection = Selection::default();
    let mut times: Vec<(usize, [f64; 5])> = Vec::new();
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
            let two_us = median_us(SAMPLES, || {
                select(tree, &viewpoint.next, &budget, &mut selection);
                select(tree, view, &budget, &mut selection);
            });
            let first_us = median_us(SAMPLES, || {
                selection = Selection::default();
                select(tree, view, &budget, &mut selection);
            });
            let linear_us = median_us(SAMPLES, || scan.large(tree, view, px, &mut found));
            let plain_us = median_us(SAMPLES, || Scan::plain(tree, view, px, &mut found));
            times.push((
                count,
                [error_us, two_us / 2.0, first_us, linear_us, plain_us],
            ));
        }
    }
    let rows = COUNTS.into_iter().filter_map(|count| {
        let of_count = times.iter().filter(|time| time.0 == count);
        let times: Vec<[f64; 5]> = of_count.map(|time| time.1).collect();
        let middle = |of: fn(&[f64; 5]) -> f64| median(times.iter().map(of).collect());
        let over_error = |at: usize| -> Vec<f64> { times.iter().map(|t| t[at] / t[0]).collect() };
        let (budget, linear) = (over_error(1), over_error(3));
        (!times.is_empty()).then(|| Speed {
            objects: tree.object_count(),
            count,
            views: times.len(),
            error_us: middle(|t| t[0]),
            budget_us: middle(|t| t[1]),
            first_budget_us: middle(|t| t[2]),
            linear_us: middle(|t| t[3]),
            plain_us: middle(|t| t[4]),
            plain_over_error: median(over_error(4)),
            first_budget_over_error: median(over_error(2)),
            lowest_linear_over_error: linear.iter().copied().fold(f64::INFINITY, f64::min),
            linear_over_error: median(linear),
            highest_budget_over_error: budget.iter().copied().fold(0.0, f64::max),
            budget_over_error: median(budget),
        })
    });
    Ok(rows.collect())
}
