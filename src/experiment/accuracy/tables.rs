//! The tables and plots.

use super::full_detail::{DISTRICT_M, FAR_M};
use super::rows::{Cost, Summary};
use super::speed::Speed;
use super::strategy::Strategy;
use crate::experiment::ReportError;
use crate::experiment::plot::{self, Labels, Series};
use crate::experiment::report::{Plot, Table, thousands};

/// Each strategy at each number of objects.
pub(super) fn strategies(summaries: &[Summary]) -> Table {
    let rows = summaries.iter().map(|s| {
        vec![
            s.scene.clone(),
            thousands(s.asked as u64),
            s.strategy.name().into(),
            format!("{:.0}", s.count),
            format!("{:.1}", s.retrieve_us),
            percent(s.missed_px_pct),
            percent(s.coverage_err_pct),
            format!("{:.1}", s.worst_missed_px),
            format!("{:.1}", s.bound_px),
            s.far_districts_kept_pct
                .map_or("-".into(), |p| format!("{p:.0}")),
        ]
    });
    Table {
        name: "",
        title: format!(
            "What is missed at equal numbers of objects. Far districts: squares of {DISTRICT_M} m \
             farther than {FAR_M} m."
        ),
        columns: vec![
            "scene",
            "asked",
            "strategy",
            "count",
            "retrieve_us",
            "missed_px_pct",
            "coverage_err_pct",
            "worst_missed_px",
            "bound_px",
            "far_districts_kept_pct",
        ],
        rows: rows.collect(),
    }
}

fn percent(share: f64) -> String {
    if share == 0.0 || share >= 10.0 {
        format!("{share:.1}")
    } else {
        let digits = (1.0 - share.log10().floor()).clamp(1.0, 4.0) as usize;
        format!("{share:.digits$}")
    }
}

/// What it takes to miss no more than so much.
pub(super) fn costs(costs: &[Cost]) -> Table {
    let rows = costs.iter().map(|c| {
        vec![
            c.scene.clone(),
            c.missed_px_pct.to_string(),
            c.strategy.name().into(),
            format!("{:.3}", c.parameter),
            c.knob.into(),
            format!("{:.0}", c.count),
            format!("{:.1}", c.retrieve_us),
        ]
    });
    Table {
        name: "cost",
        title: "What it takes to miss no more of the city's pixels".into(),
        columns: vec![
            "scene",
            "missed_px_pct",
            "strategy",
            "parameter",
            "knob",
            "count",
            "retrieve_us",
        ],
        rows: rows.collect(),
    }
}

/// Times for the same answer.
pub(super) fn speeds(speeds: &[Speed]) -> Table {
    let rows = speeds.iter().map(|s| {
        vec![
            thousands(s.objects.into()),
            thousands(s.count as u64),
            format!("{:.1}", s.error_us),
            format!("{:.1}", s.moving_error_us),
            format!("{:.1}", s.moving_budget_us),
            format!("{:.1}", s.first_error_us),
            format!("{:.1}", s.first_budget_us),
            format!("{:.0}", s.linear_us),
            format!("{:.0}", s.plain_us),
            format!("{:.0}", s.linear_over_error),
            format!("{:.0}", s.lowest_linear_over_error),
            format!("{:.0}", s.plain_over_error),
            format!("{:.2}", s.moving_budget_over_error),
            format!("{:.2}", s.highest_moving_budget_over_error),
            format!("{:.2}", s.first_budget_over_error),
            s.views.to_string(),
        ]
    });
    Table {
        name: "speed",
        title: "Time for the same answer: with the tree, and by looking at every object".into(),
        columns: vec![
            "objects",
            "answer",
            "error_us",
            "moving_error_us",
            "moving_budget_us",
            "first_error_us",
            "first_budget_us",
            "linear_us",
            "plain_us",
            "linear/error",
            "lowest",
            "plain/error",
            "moving_budget/error",
            "highest",
            "first_budget/error",
            "views",
        ],
        rows: rows.collect(),
    }
}

/// Missed pixels against objects and against time, for each city.
pub(super) fn plots(summaries: &[Summary]) -> Result<Vec<Plot>, ReportError> {
    let mut plots = Vec::new();
    for (n, of_scene) in summaries.chunk_by(|a, b| a.scene == b.scene).enumerate() {
        let scene = &of_scene[0].scene;
        let line = |strategy: Strategy, name: &str, x: fn(&Summary) -> f64| Series {
            name: name.into(),
            points: of_scene
                .iter()
                .filter(|s| s.strategy == strategy)
                .map(|s| (x(s), s.missed_px_pct))
                .collect(),
            reference: strategy.is_reference(),
        };
        // Error and budget mode and the oracle draw the same objects.
        let by_count: Vec<Series> = Strategy::ALL
            .into_iter()
            .filter(|s| !matches!(s, Strategy::Budget | Strategy::Oracle))
            .map(|strategy| match strategy {
                Strategy::Error => line(strategy, "error = budget = oracle", |s| s.count),
                _ => line(strategy, strategy.name(), |s| s.count),
            })
            .collect();
        let by_time = Strategy::ALL.map(|s| line(s, s.name(), |s| s.retrieve_us));
        for (against, x, series) in [
            ("objects", "objects drawn, mean of the views", &by_count[..]),
            (
                "time",
                "time of a retrieval, µs, mean of the views",
                &by_time,
            ),
        ] {
            let labels = Labels {
                title: &format!("Missed pixels against {against}: {scene}"),
                x,
                y: "missed pixels, %",
            };
            plots.push(Plot {
                name: match (n, against) {
                    (0, "objects") => String::new(),
                    (0, _) => against.into(),
                    _ => format!("{}-{against}", n + 1),
                },
                svg: plot::log_log(&labels, series)?,
            });
        }
    }
    Ok(plots)
}
