//! The worst of all seeds, as tables, plots and records.

use rayon::prelude::*;
use serde_json::{Value, json};

use super::super::plot::{self, Labels, Series};
use super::super::report::{Plot, Report, ReportError, Table, circumstances};
use super::rivals::Rule;
use super::scenario::{FRAMES, RANGE_M, Run, Scenario, TARGET_MS};
use super::score::Score;
use crate::control::Params;

const SEEDS: u64 = 1_000;

/// Over all seeds of a scenario.
pub(super) struct Row {
    scenario: &'static str,
    rule: Rule,
    worst: Score,
    median_settle: Option<usize>,
    held: u64,
}

impl Row {
    /// The worst of all seeds.
    pub(super) fn over_seeds(scenario: &Scenario, rule: Rule, params: &Params) -> Self {
        let scores: Vec<Score> = (0..SEEDS)
            .into_par_iter()
            .map(|seed| scenario.run(rule, params, seed).1)
            .collect();
        let largest = |of: fn(&Score) -> f64| scores.iter().map(of).fold(0.0, f64::max);
        let medians = scores.iter().filter_map(|s| s.medians_off_pct);
        // One that never settles comes after all that do.
        let mut settled: Vec<usize> = scores
            .iter()
            .map(|s| s.settle_frames.unwrap_or(FRAMES))
            .collect();
        settled.sort_unstable();
        let settles = |at: usize| settled.get(at).copied().filter(|n| *n < FRAMES);
        Row {
            scenario: scenario.name,
            rule,
            worst: Score {
                settle_frames: settles(settled.len() - 1),
                overshoot_pct: largest(|s| s.overshoot_pct),
                rms_pct: largest(|s| s.rms_pct),
                limit_cycle: scores.iter().any(|s| s.limit_cycle),
                medians_off_pct: medians.reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])]),
            },
            median_settle: settles(settled.len() / 2),
            held: scores.iter().filter(|score| score.holds(scenario)).count() as u64,
        }
    }
}

pub(super) fn drawn(name: &str, runs: &[(Rule, Run)]) -> Result<Plot, ReportError> {
    let series = |of: fn(&Run) -> &[f64]| -> Vec<Series> {
        let lines = runs.iter().map(|(rule, run)| Series {
            name: rule.name().into(),
            points: (0_u32..)
                .map(f64::from)
                .zip(of(run).iter().copied())
                .collect(),
            reference: false,
        });
        lines.collect()
    };
    let mut times = series(|run| &run.times_ms);
    let frames = runs.first().map_or(0, |(_, run)| run.times_ms.len());
    times.push(Series {
        name: "target".into(),
        points: vec![(0.0, TARGET_MS), (frames as f64, TARGET_MS)],
        reference: true,
    });
    let labels = |title, y| Labels {
        title,
        x: "frame",
        y,
    };
    let title = format!("Frame time and far_dist: {name}");
    let above = (labels(&title, "frame time, ms"), times);
    let below = (labels("", "far_dist, m"), series(|run| &run.far_dists));
    Ok(Plot {
        name: name.replace(" %", "").replace(' ', "-"),
        svg: plot::over_frames(&[above, below])?,
    })
}

pub(super) fn report(rows: &[Row], flown: &[(Rule, (f64, f64))], plots: Vec<Plot>) -> Report {
    let settle = |n: Option<usize>| n.map_or("-".into(), |n| n.to_string());
    let off = |row: &Row, which: usize| {
        let medians = row.worst.medians_off_pct;
        medians.map_or("-".into(), |medians| format!("{:.1}", medians[which]))
    };
    let table = rows.iter().map(|row| {
        vec![
            row.scenario.into(),
            row.rule.name().into(),
            settle(row.median_settle),
            settle(row.worst.settle_frames),
            format!("{:.1}", row.worst.overshoot_pct),
            format!("{:.1}", row.worst.rms_pct),
            if row.worst.limit_cycle { "yes" } else { "no" }.into(),
            off(row, 0),
            off(row, 1),
            row.held.to_string(),
        ]
    });
    let flight = flown.iter().map(|(rule, (off, late))| {
        vec![
            rule.name().into(),
            format!("{off:.1}"),
            format!("{late:.1}"),
        ]
    });
    let records: Vec<Value> = rows
        .iter()
        .map(|row| {
            json!({
                "scenario": row.scenario, "controller": row.rule.name(), "seeds": SEEDS,
                "settle_frames": row.worst.settle_frames,
                "median_settle_frames": row.median_settle,
                "overshoot_pct": row.worst.overshoot_pct, "rms_pct": row.worst.rms_pct,
                "limit_cycle": row.worst.limit_cycle,
                "median_off_pct": row.worst.medians_off_pct.map(|[whole, _]| whole),
                "quarter_off_pct": row.worst.medians_off_pct.map(|[_, quarter]| quarter),
                "seeds_held": row.held,
            })
        })
        .collect();
    let flights: Vec<Value> = flown
        .iter()
        .map(|(rule, (off, late))| {
            json!({ "controller": rule.name(), "median_off_pct": off, "late_pct": late })
        })
        .collect();
    let parameters = json!({
        "target_ms": TARGET_MS, "far_dist_m": RANGE_M, "seeds": SEEDS, "frames": FRAMES,
    });
    Report {
        name: "controller",
        text: format!(
            "Frame time held at {TARGET_MS} ms; the worst of {SEEDS} plants a scenario. Settled: within 5 % for good, \
             frames beyond the delay.\nHeld: seeds that settle in 12 frames, overshoot by at most \
             10 %, move far_dist by at most 6 % under noise\nand 10 % at a spike, and do not cycle. \
             Where times scatter to one side, the median frame time after 60 frames\nmay lie 3 % off \
             the target (5 % where the load drifts), that of each quarter 10 %.\n\
             Delay 0 to 3: start and right far_dist anywhere in {:.0} to {:.0} m.",
            RANGE_M[0], RANGE_M[1]
        ),
        tables: vec![
            Table {
                columns: vec![
                    "scenario",
                    "controller",
                    "median_settle",
                    "settle_frames",
                    "overshoot_pct",
                    "rms_pct",
                    "limit_cycle",
                    "median_off_pct",
                    "quarter_off_pct",
                    "held",
                ],
                rows: table.collect(),
                ..Table::default()
            },
            Table {
                name: "flight",
                title: "Suburb, downtown, suburb: 200,000 objects, 600 frames".into(),
                columns: vec!["controller", "median_off_pct", "late_pct"],
                rows: flight.collect(),
            },
        ],
        plots,
        json: json!({
            "rows": records, "flight": flights, "circumstances": circumstances(&parameters),
        }),
        ..Report::default()
    }
}
