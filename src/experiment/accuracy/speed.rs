//! Error mode and budget mode against looking at every object, for the same answer.

use serde::Serialize;

use super::full_detail::ranked;
use super::scan::Scan;
use super::viewpoint::{Viewpoint, viewpoints};
use crate::experiment::ReportError;
use crate::experiment::timing::{median, median_us};
use crate::geom::View;
use crate::index::LodTree;
use crate::lod::{BudgetLod, ErrorLod, Lod, Selection, select};

const COUNTS: [usize; 3] = [1_000, 5_000, 20_000];
const SAMPLES: usize = 5;

/// Medians over the views that have so many objects in the frustum; ratios are taken view by view,
/// of two modes in the same circumstances.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Speed {
    pub(super) objects: u32,
    pub(super) count: usize,
    pub(super) views: usize,
    /// The same view again and again, as the scans.
    pub(super) error_us: f64,
    /// A frame after another, the camera moving: the mean of its path.
    pub(super) moving_error_us: f64,
    pub(super) moving_budget_us: f64,
    /// The same frames, each as if it were the first of all, its memory included.
    pub(super) first_error_us: f64,
    pub(super) first_budget_us: f64,
    /// Every object, eight at a time in f32, from tables made for it.
    pub(super) linear_us: f64,
    /// Every object, one at a time in f64, from their boxes.
    pub(super) plain_us: f64,
    pub(super) plain_over_error: f64,
    pub(super) linear_over_error: f64,
    /// In the view where it is lowest.
    pub(super) lowest_linear_over_error: f64,
    pub(super) moving_budget_over_error: f64,
    /// In the view where it is highest.
    pub(super) highest_moving_budget_over_error: f64,
    pub(super) first_budget_over_error: f64,
}

/// What the same answer took in one view, µs.
#[derive(Debug, Clone, Copy)]
struct Times {
    count: usize,
    error: f64,
    /// Error and budget mode, the camera moving.
    moving: [f64; 2],
    /// The same, the first frame.
    first: [f64; 2],
    linear: f64,
    plain: f64,
}

/// One row for each answer that some view of the city is large enough for.
pub(super) fn measure(tree: &LodTree, scan: &Scan) -> Result<Vec<Speed>, ReportError> {
    let mut found = Vec::new();
    let mut selection = Selection::default();
    let mut times: Vec<Times> = Vec::new();
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
            let error = Lod::Error(error);
            let error_us = median_us(SAMPLES, || select(tree, view, &error, &mut selection));
            let Some(path) = path(tree, &viewpoint, count, &mut selection) else {
                continue;
            };
            let frame_us = |us: f64| us / path.len() as f64;
            let moving = MODES.map(|mode| {
                frame_us(median_us(SAMPLES, || {
                    for frame in &path {
                        select(tree, frame.view, &frame.lods[mode], &mut selection);
                    }
                }))
            });
            let first = MODES.map(|mode| {
                frame_us(median_us(SAMPLES, || {
                    for frame in &path {
                        selection = Selection::default();
                        select(tree, frame.view, &frame.lods[mode], &mut selection);
                    }
                }))
            });
            times.push(Times {
                count,
                error: error_us,
                moving,
                first,
                linear: median_us(SAMPLES, || scan.large(tree, view, px, &mut found)),
                plain: median_us(SAMPLES, || Scan::plain(tree, view, px, &mut found)),
            });
        }
    }
    let rows = COUNTS.into_iter().filter_map(|count| {
        let times = times.iter().filter(|times| times.count == count);
        speed(
            tree.object_count(),
            count,
            &times.copied().collect::<Vec<_>>(),
        )
    });
    Ok(rows.collect())
}

/// A frame of a camera's path, and two ways to ask for the same objects.
struct Frame<'a> {
    view: &'a View,
    lods: [Lod; 2],
}

/// Error mode and budget mode, in this order.
const MODES: [usize; 2] = [0, 1];

/// The frames from a viewpoint on, for so many objects; where sizes tie there are more of them.
/// `None` where a frame has not as many, or the eye is inside them all.
fn path<'a>(
    tree: &LodTree,
    viewpoint: &'a Viewpoint,
    count: usize,
    selection: &mut Selection,
) -> Option<Vec<Frame<'a>>> {
    let frame = |view: &'a View| {
        let most = Lod::Budget(BudgetLod::new(count as u32));
        select(tree, view, &most, selection);
        if (selection.count() as usize) < count {
            return None;
        }
        let sizes = selection.objects().filter_map(|object| {
            let bounds = tree.bounds_of(object)?;
            Some(view.size_px(&bounds))
        });
        let px = sizes.fold(f64::INFINITY, f64::min);
        let error = Lod::Error(ErrorLod::new(px).ok()?);
        select(tree, view, &error, selection);
        let budget = Lod::Budget(BudgetLod::new(selection.count()));
        let lods = [error, budget];
        Some(Frame { view, lods })
    };
    viewpoint.path.iter().map(frame).collect()
}

fn speed(objects: u32, count: usize, times: &[Times]) -> Option<Speed> {
    let all = |of: fn(&Times) -> f64| -> Vec<f64> { times.iter().map(of).collect() };
    let middle = |of| median(all(of));
    let linear = all(|t| t.linear / t.error);
    let budget = all(|t| t.moving[1] / t.moving[0]);
    (!times.is_empty()).then(|| Speed {
        objects,
        count,
        views: times.len(),
        error_us: middle(|t| t.error),
        moving_error_us: middle(|t| t.moving[0]),
        moving_budget_us: middle(|t| t.moving[1]),
        first_error_us: middle(|t| t.first[0]),
        first_budget_us: middle(|t| t.first[1]),
        linear_us: middle(|t| t.linear),
        plain_us: middle(|t| t.plain),
        plain_over_error: middle(|t| t.plain / t.error),
        lowest_linear_over_error: linear.iter().copied().fold(f64::INFINITY, f64::min),
        linear_over_error: median(linear),
        highest_moving_budget_over_error: budget.iter().copied().fold(0.0, f64::max),
        moving_budget_over_error: median(budget),
        first_budget_over_error: middle(|t| t.first[1] / t.first[0]),
    })
}
