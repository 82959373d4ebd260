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
            format!("{:.1}", s.budget_us),
            format!("{:.0}", s.linear_us),
            format!("{:.0}", s.linear_over_error),
            format!("{:.0}", s.lowest_linear_over_error),
            format!("{:.2}", s.budget_over_error),
            format!("{:.2}", s.highest_budget_over_error),
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
            "budget_us",
            "linear_us",
            "linear/error",
            "lowest",
            "budget/error",
            "highest",
            "views",
        ],
        rows: rows.collect(),
    }
}

/// Missed pixels against objects and against time, for each city.
pub(super) fn plots(summaries: &[Summary]) -> Result<Vec<Plot>, ReportError> {
    const NAMES: [[&str; 2]; 2] = [["", "time"], ["large", "large-time"]];
    let mut plots = Vec::new();
    let scenes = summaries.chunk_by(|a, b| a.scene == b.scene);
    for (of_scene, names) in scenes.zip(NAMES) {
        let series = |x: fn(&Summary) -> f64| {
            let line = |strategy: Strategy| Series {
                name: strategy.name().into(),
                points: of_scene
                    .iter()
                    .filter(|s| s.strategy == strategy)
                    .map(|s| (x(s), s.missed_px_pct))
                    .collect(),
                reference: strategy.is_reference(),
            };
            Strategy::ALL.map(line)
        };
        let labels = |title, x| Labels {
            title,
            x,
            y: "missed pixels, %",
        };
        let title = format!("Missed pixels against objects drawn: {}", of_scene[0].scene);
        let counts = labels(&title, "objects drawn");
        plots.push(Plot {
            name: names[0],
            svg: plot::log_log(&counts, &series(|s| s.count))?,
        });
        let title = format!("Missed pixels against time: {}", of_scene[0].scene);
        let times = labels(&title, "microseconds");
        plots.push(Plot {
            name: names[1],
            svg: plot::log_log(&times, &series(|s| s.retrieve_us))?,
        });
    }
    Ok(plots)
}
