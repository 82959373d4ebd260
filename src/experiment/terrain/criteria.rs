//! Four criteria on one ground: triangles, error and time as their knobs are turned.

use serde_json::json;

use super::measured::measured;
use super::place::{POSITIONS, flight, mountains};
use crate::experiment::plot::{self, Labels, Series};
use crate::experiment::report::{Plot, Table, circumstances, thousands};
use crate::experiment::timing::{median, median_us};
use crate::experiment::{Options, Progress, Report, ReportError};
use crate::geom::View;
use crate::terrain::{Criterion, Detail, Ground, Workers, select};

/// Shares of each criterion's own detail, in powers of two.
const SHARES: std::ops::RangeInclusive<i32> = -5..=3;
const SAMPLES: usize = 3;

struct Row {
    criterion: Criterion,
    share: f64,
    triangles: f64,
    error_px: f64,
    measured_px: f64,
    measured_m: f64,
    select_us: f64,
}

pub(in crate::experiment) fn run(
    options: &Options,
    progress: &Progress,
) -> Result<Report, ReportError> {
    let (field, ground) = mountains(options)?;
    let views = flight(&field)?;
    let mut rows = Vec::new();
    for criterion in Criterion::ALL {
        for power in SHARES {
            let share = 2.0_f64.powi(power);
            progress(&format!("{} at {share}", criterion.name()));
            let detail = Detail {
                knobs: criterion.share(&criterion.knobs(), share),
                ..Detail::of(criterion)
            };
            rows.push(fly(&ground, &views, &detail, share)?);
        }
    }
    report(&rows, field.grid().count() as u64)
}

/// Medians over the views.
fn fly(ground: &Ground, views: &[View], detail: &Detail, share: f64) -> Result<Row, ReportError> {
    let mut each: [Vec<f64>; 5] = Default::default();
    for view in views {
        let selection = select(ground, view, detail, Workers::One)?;
        let found = measured(ground, &selection.mesh(ground), view);
        let us = median_us(SAMPLES, || select(ground, view, detail, Workers::One));
        let numbers = [
            selection.triangles() as f64,
            selection.error_px(),
            found.worst_px,
            found.worst_m,
            us,
        ];
        for (all, number) in each.iter_mut().zip(numbers) {
            all.push(number);
        }
    }
    let [triangles, error_px, measured_px, measured_m, select_us] = each.map(median);
    Ok(Row {
        criterion: detail.criterion,
        share,
        triangles,
        error_px,
        measured_px,
        measured_m,
        select_us,
    })
}

fn report(rows: &[Row], posts: u64) -> Result<Report, ReportError> {
    let text = format!(
        "{} posts, a flight of {POSITIONS} positions, medians. The share multiplies the knobs that \
         a criterion starts from.\nThe certified error is a bound: no post is drawn farther from \
         its place than that. The measured one is the worst of all posts.",
        thousands(posts)
    );
    let cells = rows.iter().map(|row| {
        vec![
            row.criterion.name().to_owned(),
            format!("{}", row.share),
            thousands(row.triangles as u64),
            format!("{:.2}", row.error_px),
            format!("{:.2}", row.measured_px),
            format!("{:.2}", row.measured_m),
            format!("{:.0}", row.select_us),
        ]
    });
    let json_rows = rows.iter().map(|row| {
        json!({
            "criterion": row.criterion.name(), "share": row.share, "triangles": row.triangles,
            "error_px": row.error_px, "measured_px": row.measured_px,
            "measured_m": row.measured_m, "select_us": row.select_us,
        })
    });
    let series = Criterion::ALL.map(|criterion| {
        let points = rows.iter().filter(|row| row.criterion == criterion);
        Series {
            name: criterion.name().to_owned(),
            points: points
                .filter(|row| row.measured_px > 0.0)
                .map(|row| (row.triangles, row.measured_px))
                .collect(),
            reference: false,
        }
    });
    let labels = Labels {
        title: "Worst error on the screen against triangles",
        x: "triangles",
        y: "pixels",
    };
    Ok(Report {
        name: "terrain-criteria",
        text,
        tables: vec![Table {
            columns: vec![
                "criterion",
                "share",
                "triangles",
                "error_px",
                "measured_px",
                "measured_m",
                "select_us",
            ],
            rows: cells.collect(),
            ..Table::default()
        }],
        json: json!({
            "rows": json_rows.collect::<Vec<_>>(),
            "circumstances": circumstances(&json!({ "posts": posts, "positions": POSITIONS })),
        }),
        plots: vec![Plot {
            svg: plot::log_log(&labels, &series)?,
            ..Plot::default()
        }],
        ..Report::default()
    })
}
