//! What was measured of a city: view by view, and put together over the views.

use serde::Serialize;

use super::choice::City;
use super::full_detail::FullDetail;
use super::strategy::Strategy;
use super::viewpoint::{Viewpoint, viewpoints};
use crate::experiment::ReportError;
use crate::experiment::timing::median;

/// Objects asked for.
pub(super) const COUNTS: [usize; 7] = [250, 500, 1_000, 2_000, 5_000, 10_000, 20_000];
/// Shares of the city's pixels that may be missed, percent.
const MISSED_PX_PCT: [f64; 9] = [50.0, 40.0, 30.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.1];
const MODES: [Strategy; 3] = [
    Strategy::Error,
    Strategy::RangeTallest,
    Strategy::RangeFootprint,
];

/// One strategy in one view.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Row {
    pub(super) scene: String,
    pub(super) view: &'static str,
    pub(super) strategy: Strategy,
    pub(super) knob: &'static str,
    pub(super) parameter: f64,
    /// Objects asked for, or all of the frustum where there are fewer.
    pub(super) asked: usize,
    pub(super) count: usize,
    pub(super) retrieve_us: f64,
    pub(super) missed_px_pct: f64,
    pub(super) coverage_err_pct: f64,
    /// Certified by the modes; for the references, the largest size that was left out.
    pub(super) bound_px: f64,
    pub(super) worst_missed_px: f64,
    pub(super) largest_omitted_px: f64,
    /// Districts of the far field with an object in the frustum, and those with one in the answer.
    pub(super) far_districts: usize,
    pub(super) far_districts_kept: usize,
    /// Which of [`COUNTS`].
    #[serde(skip)]
    pub(super) step: usize,
}

/// What it takes to miss no more than so much on average over the views, with the same parameter
/// in each: means.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Cost {
    pub(super) scene: String,
    pub(super) missed_px_pct: f64,
    pub(super) strategy: Strategy,
    pub(super) knob: &'static str,
    pub(super) parameter: f64,
    pub(super) count: f64,
    pub(super) retrieve_us: f64,
}

/// A strategy over all views of a city.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Summary {
    pub(super) scene: String,
    pub(super) strategy: Strategy,
    /// Objects asked for.
    pub(super) asked: usize,
    /// Mean.
    pub(super) count: f64,
    /// Mean.
    pub(super) retrieve_us: f64,
    /// Mean.
    pub(super) missed_px_pct: f64,
    /// Mean.
    pub(super) coverage_err_pct: f64,
    /// Median.
    pub(super) bound_px: f64,
    /// Median.
    pub(super) worst_missed_px: f64,
    /// Of the far districts of all views, those of which an object is drawn, percent; `None` where
    /// there are none.
    pub(super) far_districts_kept_pct: Option<f64>,
    /// Mean.
    pub(super) far_districts: f64,
}

/// Measures every strategy in every view.
pub(super) fn measure(
    city: &City,
    progress: &dyn Fn(&str),
) -> Result<(Vec<Row>, Vec<Cost>), ReportError> {
    let mut rows = Vec::new();
    let mut views = Vec::new();
    for viewpoint in viewpoints(&city.tree)? {
        progress(viewpoint.name);
        let mut full = FullDetail::new(&city.tree, &viewpoint.view);
        for (step, &count) in COUNTS.iter().enumerate() {
            let asked = count.min(full.ranked.len());
            for strategy in Strategy::ALL {
                rows.extend(row(city, &viewpoint, &mut full, strategy, step, asked));
            }
        }
        views.push((viewpoint, full));
    }
    let mut costs = Vec::new();
    for missed_px_pct in MISSED_PX_PCT {
        progress(&format!("what {missed_px_pct} % takes"));
        for mode in MODES {
            costs.push(cost(city, &mut views, mode, missed_px_pct));
        }
    }
    Ok((rows, costs))
}

fn row(
    city: &City,
    viewpoint: &Viewpoint,
    full: &mut FullDetail,
    strategy: Strategy,
    step: usize,
    asked: usize,
) -> Option<Row> {
    let answer = city.choose(strategy, &viewpoint.view, asked, &full.ranked)?;
    let missed = full.missed_by(&answer.objects);
    Some(Row {
        scene: city.name.clone(),
        view: viewpoint.name,
        strategy,
        knob: strategy.knob(),
        parameter: answer.parameter,
        asked,
        count: answer.objects.len(),
        retrieve_us: answer.retrieve_us,
        missed_px_pct: missed.px_pct,
        coverage_err_pct: missed.coverage_pct,
        bound_px: answer.error_px.unwrap_or(missed.largest_px),
        worst_missed_px: missed.worst_px,
        largest_omitted_px: missed.largest_px,
        far_districts: full.far_districts(),
        far_districts_kept: missed.far_districts_kept,
        step,
    })
}

fn cost(
    city: &City,
    views: &mut [(Viewpoint, FullDetail)],
    mode: Strategy,
    missed_px_pct: f64,
) -> Cost {
    let parameter = city.parameter_for(mode, missed_px_pct, views);
    let answers = views
        .iter()
        .filter_map(|(v, _)| city.ask(mode, &v.view, parameter));
    let (count, us) = answers
        .map(|answer| (answer.objects.len() as f64, answer.retrieve_us))
        .fold((0.0, 0.0), |sum, answer| {
            (sum.0 + answer.0, sum.1 + answer.1)
        });
    Cost {
        scene: city.name.clone(),
        missed_px_pct,
        strategy: mode,
        knob: mode.knob(),
        parameter,
        count: count / views.len() as f64,
        retrieve_us: us / views.len() as f64,
    }
}

/// Puts the views together, in the order of [`COUNTS`] and [`Strategy::ALL`].
pub(super) fn summaries(rows: &[Row]) -> Vec<Summary> {
    let mut found = Vec::new();
    for of_scene in rows.chunk_by(|a, b| a.scene == b.scene) {
        for (step, &asked) in COUNTS.iter().enumerate() {
            for strategy in Strategy::ALL {
                let of_both = |r: &&Row| r.step == step && r.strategy == strategy;
                let rows: Vec<&Row> = of_scene.iter().filter(of_both).collect();
                found.extend(summary(asked, &rows));
            }
        }
    }
    found
}

fn summary(asked: usize, rows: &[&Row]) -> Option<Summary> {
    let first = rows.first()?;
    let middle = |of: fn(&Row) -> f64| median(rows.iter().map(|row| of(row)).collect());
    let count = rows.len() as f64;
    let mean_of = |of: fn(&Row) -> f64| rows.iter().map(|row| of(row)).sum::<f64>() / count;
    let far: usize = rows.iter().map(|row| row.far_districts).sum();
    let kept: usize = rows.iter().map(|row| row.far_districts_kept).sum();
    Some(Summary {
        scene: first.scene.clone(),
        strategy: first.strategy,
        asked,
        count: mean_of(|row| row.count as f64),
        retrieve_us: mean_of(|row| row.retrieve_us),
        missed_px_pct: mean_of(|row| row.missed_px_pct),
        coverage_err_pct: mean_of(|row| row.coverage_err_pct),
        bound_px: middle(|row| row.bound_px),
        worst_missed_px: middle(|row| row.worst_missed_px),
        far_districts_kept_pct: (far > 0).then(|| 100.0 * kept as f64 / far as f64),
        far_districts: mean_of(|row| row.far_districts as f64),
    })
}
