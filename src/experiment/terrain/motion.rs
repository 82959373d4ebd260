//! Triangles at rest and in motion (C, table 1): C against ROAM and a regular quadtree.

use serde_json::json;

use super::measured::worst;
use super::place::{mountains, overview};
use super::roam::Roam;
use crate::experiment::report::{Table, circumstances, thousands};
use crate::experiment::{Options, Progress, Report, ReportError};
use crate::geom::View;
use crate::terrain::{Criterion, Detail, Ground, REST_MPS, Selection, Workers, select};

/// What all are tuned to at rest, pixels.
const STANDING_PX: f64 = 2.0;
/// Speeds in units of what counts as rest.
const SPEEDS: [f64; 5] = [1.25, 1.5, 2.0, 5.0, 20.0];
const BISECTIONS: u32 = 16;

struct Row {
    method: &'static str,
    tuned_to: &'static str,
    speed_mps: f64,
    triangles: usize,
    measured_px: f64,
}

pub(in crate::experiment) fn run(
    options: &Options,
    progress: &Progress,
) -> Result<Report, ReportError> {
    let (field, ground) = mountains(options)?;
    let view = overview(&field)?;
    let mut rows = Vec::new();
    let tuner = Tuner {
        ground: &ground,
        view: &view,
    };
    progress("ROAM");
    let bisected = Roam::new(&field);
    let standing = least(|power| {
        let mesh = bisected.mesh(&view, (-power).exp2());
        Ok(worst(&ground, &mesh, &view).pixels <= STANDING_PX)
    })?;
    let mesh = bisected.mesh(&view, (-standing).exp2());
    let roam = mesh.triangles.len();
    let measured_px = worst(&ground, &mesh, &view).pixels;
    for speed_mps in [0.0, SPEEDS[0]] {
        rows.push(Row {
            method: "ROAM",
            tuned_to: "error",
            speed_mps,
            triangles: roam,
            measured_px,
        });
    }
    progress("regular quadtree");
    let quadtree = tuner.tuned(Criterion::Error, |found| found.measured_px <= STANDING_PX)?;
    for speed_mps in [0.0, SPEEDS[0]] {
        rows.push(tuner.row("regular quadtree", "error", &quadtree, speed_mps)?);
    }
    progress("C");
    let count = tuner.tuned(Criterion::Motion, |found| found.triangles >= roam)?;
    let error = tuner.tuned(Criterion::Motion, |found| found.measured_px <= STANDING_PX)?;
    for (tuned_to, detail) in [("count", count), ("error", error)] {
        for speed in [0.0].into_iter().chain(SPEEDS) {
            rows.push(tuner.row("C", tuned_to, &detail, speed * REST_MPS)?);
        }
    }
    Ok(report(&rows, field.grid().count()))
}

/// The least power of two found that is enough.
fn least(enough: impl Fn(f64) -> Result<bool, ReportError>) -> Result<f64, ReportError> {
    let (mut low, mut high) = (-20.0, 20.0);
    for _ in 0..BISECTIONS {
        let middle = f64::midpoint(low, high);
        if enough(middle)? {
            high = middle;
        } else {
            low = middle;
        }
    }
    Ok(high)
}

struct Tuner<'a> {
    ground: &'a Ground,
    view: &'a View,
}

struct Found {
    triangles: usize,
    measured_px: f64,
}

impl Tuner<'_> {
    fn select(&self, detail: &Detail) -> Result<Selection, ReportError> {
        Ok(select(self.ground, self.view, detail, Workers::One)?)
    }

    fn found(&self, detail: &Detail) -> Result<Found, ReportError> {
        let selection = self.select(detail)?;
        let mesh = selection.mesh(self.ground);
        Ok(Found {
            triangles: selection.triangles(),
            measured_px: worst(self.ground, &mesh, self.view).pixels,
        })
    }

    /// The least detail found that is enough.
    fn tuned(
        &self,
        criterion: Criterion,
        enough: impl Fn(&Found) -> bool,
    ) -> Result<Detail, ReportError> {
        let with = |power: f64| Detail {
            knobs: criterion.share(&criterion.knobs(), power.exp2()),
            ..Detail::of(criterion)
        };
        Ok(with(least(|power| Ok(enough(&self.found(&with(power))?)))?))
    }

    fn row(
        &self,
        method: &'static str,
        tuned_to: &'static str,
        detail: &Detail,
        speed_mps: f64,
    ) -> Result<Row, ReportError> {
        let mut detail = *detail;
        detail.knobs.speed_mps = speed_mps;
        let found = self.found(&detail)?;
        Ok(Row {
            method,
            tuned_to,
            speed_mps,
            triangles: found.triangles,
            measured_px: found.measured_px,
        })
    }
}

fn report(rows: &[Row], posts: usize) -> Report {
    let roam = rows[0].triangles;
    let text = format!(
        "{} posts in one view. At rest ROAM and the regular quadtree err by at most {STANDING_PX} \
         pixels; measured over all posts; C is tuned once to ROAM's count and once to that error.\nUp to {REST_MPS} m/s is \
         rest. Fewer: triangles saved against ROAM.",
        thousands(posts as u64)
    );
    let fewer = |row: &Row| 100.0 * (1.0 - row.triangles as f64 / roam as f64);
    let cells = rows.iter().map(|row| {
        vec![
            row.method.to_owned(),
            row.tuned_to.to_owned(),
            format!("{}", row.speed_mps),
            thousands(row.triangles as u64),
            format!("{:.2}", row.measured_px),
            format!("{:.1}", fewer(row)),
        ]
    });
    let json_rows = rows.iter().map(|row| {
        json!({
            "method": row.method, "tuned_to": row.tuned_to, "speed_mps": row.speed_mps,
            "triangles": row.triangles, "measured_px": row.measured_px,
            "fewer_than_roam_pct": fewer(row),
        })
    });
    Report {
        name: "terrain-motion",
        text,
        json: json!({
            "rows": json_rows.collect::<Vec<_>>(),
            "circumstances": circumstances(&json!({ "posts": posts, "standing_px": STANDING_PX })),
        }),
        tables: vec![Table {
            columns: vec![
                "method",
                "tuned_to",
                "speed_mps",
                "triangles",
                "measured_px",
                "fewer_than_roam_pct",
            ],
            rows: cells.collect(),
            ..Table::default()
        }],
        ..Report::default()
    }
}
