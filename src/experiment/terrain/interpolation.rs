//! Heights between posts: error against time of bilinear, bicubic and the choice by variance.

use serde_json::json;

use super::place::mountains;
use crate::experiment::report::{Table, circumstances, thousands};
use crate::experiment::timing::median_us;
use crate::experiment::{Options, Progress, Report, ReportError};
use crate::terrain::{Grid, HeightField, Interpolation};

const SAMPLES: usize = 7;
/// Thresholds as shares of the cells that are interpolated bicubically.
const SHARES: [f64; 5] = [0.1, 0.2, 0.3, 0.45, 0.6];

struct Row {
    method: &'static str,
    threshold_m: f64,
    bicubic_share: f64,
    rms_m: f64,
    ns: f64,
}

/// Every second post each way is kept; the heights of the others are asked for.
pub(in crate::experiment) fn run(
    options: &Options,
    progress: &Progress,
) -> Result<Report, ReportError> {
    let (field, _) = mountains(options)?;
    let kept = every_second(&field)?;
    let asked = left_out(&field);
    let deviations = deviations(&kept);
    let share_above = |threshold: f64| {
        let above = deviations.iter().filter(|d| **d >= threshold).count();
        above as f64 / deviations.len() as f64
    };
    let mut methods = vec![
        ("bilinear", f64::INFINITY, Interpolation::Bilinear),
        ("bicubic", 0.0, Interpolation::Bicubic),
    ];
    methods.extend(SHARES.map(|share| {
        let at = ((1.0 - share) * (deviations.len() - 1) as f64) as usize;
        let threshold = deviations[at];
        (
            "by variance",
            threshold,
            Interpolation::ByVariance { threshold },
        )
    }));
    let rows: Vec<Row> = methods
        .into_iter()
        .map(|(method, threshold_m, how)| {
            progress(method);
            let errors = asked.iter().map(|&[x, y, z]| {
                let error = kept.height_at(x, y, how).unwrap_or(f64::NAN) - z;
                error * error
            });
            let rms_m = (errors.sum::<f64>() / asked.len() as f64).sqrt();
            let all = || -> f64 {
                let heights = asked
                    .iter()
                    .filter_map(|&[x, y, _]| kept.height_at(x, y, how));
                heights.sum()
            };
            Row {
                method,
                threshold_m,
                bicubic_share: share_above(threshold_m),
                rms_m,
                ns: median_us(SAMPLES, all) * 1e3 / asked.len() as f64,
            }
        })
        .collect();
    Ok(report(&rows, asked.len()))
}

fn every_second(field: &HeightField) -> Result<HeightField, ReportError> {
    let grid = field.grid();
    let [columns, rows] = [grid.columns(), grid.rows()].map(|posts| posts.div_ceil(2));
    let coarse = Grid::new(columns, rows, grid.origin(), grid.spacing() * 2.0)?;
    let posts = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let heights = posts.map(|(column, row)| field.height(2 * column, 2 * row));
    Ok(HeightField::new(coarse, heights.collect())?)
}

/// Easting, northing and height of the posts that are not kept.
fn left_out(field: &HeightField) -> Vec<[f64; 3]> {
    let grid = field.grid();
    let posts = (0..grid.rows()).flat_map(|row| (0..grid.columns()).map(move |c| (c, row)));
    let odd = posts.filter(|(column, row)| (column | row) % 2 == 1);
    odd.map(|(column, row)| {
        let z = f64::from(field.height(column, row));
        [grid.x(column), grid.y(row), z]
    })
    .collect()
}

/// Standard deviation of each cell's four heights, m, in rising order.
fn deviations(field: &HeightField) -> Vec<f64> {
    let grid = field.grid();
    let cells = (1..grid.rows()).flat_map(|row| (1..grid.columns()).map(move |c| (c, row)));
    let mut deviations: Vec<f64> = cells
        .map(|(c, r)| {
            let posts = [(c - 1, r - 1), (c, r - 1), (c - 1, r), (c, r)];
            let heights = posts.map(|(c, r)| f64::from(field.height(c, r)));
            let mean = heights.iter().sum::<f64>() / 4.0;
            (heights.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / 4.0).sqrt()
        })
        .collect();
    deviations.sort_by(f64::total_cmp);
    deviations
}

fn report(rows: &[Row], asked: usize) -> Report {
    let [bilinear, bicubic] = [0, 1].map(|n| (rows[n].rms_m, rows[n].ns));
    let to_bicubic = |row: &Row| {
        let extra = (row.ns - bilinear.1) / (bicubic.1 - bilinear.1);
        (row.rms_m / bicubic.0, extra)
    };
    let text = format!(
        "{} heights between posts twice as far apart as those that are asked for. Error and time \
         beyond bilinear are also given as shares of bicubic's.",
        thousands(asked as u64)
    );
    let cells = rows.iter().map(|row| {
        let (error, extra) = to_bicubic(row);
        vec![
            row.method.to_owned(),
            format!("{:.3}", row.threshold_m),
            format!("{:.2}", row.bicubic_share),
            format!("{:.4}", row.rms_m),
            format!("{:.1}", row.ns),
            format!("{error:.3}"),
            format!("{extra:.2}"),
        ]
    });
    let json_rows = rows.iter().map(|row| {
        let (error, extra) = to_bicubic(row);
        json!({
            "method": row.method, "threshold_m": row.threshold_m,
            "bicubic_share": row.bicubic_share, "rms_m": row.rms_m, "ns": row.ns,
            "error_to_bicubic": error, "extra_time_to_bicubic": extra,
        })
    });
    Report {
        name: "terrain-interpolation",
        text,
        json: json!({
            "rows": json_rows.collect::<Vec<_>>(),
            "circumstances": circumstances(&json!({ "asked": asked, "samples": SAMPLES })),
        }),
        tables: vec![Table {
            columns: vec![
                "method",
                "threshold_m",
                "bicubic_share",
                "rms_m",
                "ns",
                "error_to_bicubic",
                "extra_time_to_bicubic",
            ],
            rows: cells.collect(),
            ..Table::default()
        }],
        ..Report::default()
    }
}
