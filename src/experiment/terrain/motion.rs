//! Triangles at rest and in motion (C, table 1): C against ROAM and a regular quadtree.
//!
//! All three are tuned so that at rest no post is off by more than a standing error. ROAM and the
//! quadtree do not know of speed. The regular quadtree is the one of this library, split where the
//! error asks for it and nothing else: B's criterion with a C1 that is always met.

use serde_json::json;

use super::measured::{Measured, measured};
use super::place::{mountains, overview, real};
use super::roam::Roam;
use crate::experiment::report::{Table, circumstances, thousands};
use crate::experiment::{Options, Progress, Report, ReportError};
use crate::geom::View;
use crate::terrain::{
    Criterion, Detail, Ground, HeightField, Knobs, Layout, REST_MPS, Workers, select,
};

/// What all are tuned to at rest, pixels.
const STANDING_PX: f64 = 2.0;
/// Speeds in units of what counts as rest.
const SPEEDS: [f64; 5] = [1.25, 1.5, 2.0, 5.0, 20.0];
const BISECTIONS: u32 = 20;
/// So large or small that a condition with it always holds.
const SLACK: f64 = 1e12;

struct Row {
    ground: String,
    method: &'static str,
    speed_mps: f64,
    triangles: usize,
    error: Measured,
    /// Triangles of ROAM and of the quadtree at the same error at rest.
    others: [usize; 2],
}

pub(in crate::experiment) fn run(
    options: &Options,
    progress: &Progress,
) -> Result<Report, ReportError> {
    let (field, ground) = mountains(options)?;
    let mut rows = compared("made up", &field, &ground, progress)?;
    for (name, field) in real()? {
        let ground = Ground::cut(&field, &Layout::new(*field.grid()));
        rows.extend(compared(&name, &field, &ground, progress)?);
    }
    Ok(report(&rows, field.grid().count()))
}

fn compared(
    name: &str,
    field: &HeightField,
    ground: &Ground,
    progress: &Progress,
) -> Result<Vec<Row>, ReportError> {
    let view = overview(field)?;
    let tuner = Tuner {
        ground,
        view: &view,
    };
    progress(&format!("{name}: ROAM"));
    let bisected = Roam::new(field);
    let roam = |power: f64| {
        let mesh = bisected.mesh(&view, (-power).exp2());
        (mesh.triangles.len(), measured(ground, &mesh, &view))
    };
    let standing = least(|power| Ok(roam(power).1.worst_px <= STANDING_PX))?;
    let roam = roam(standing);
    progress(&format!("{name}: regular quadtree"));
    let quadtree = tuner.tuned(Criterion::Error, |power| Knobs {
        c1: SLACK,
        c2: power.exp2(),
        ..Criterion::Error.knobs()
    })?;
    let quadtree = tuner.found(&quadtree)?;
    let others = [roam.0, quadtree.0];
    let row = |method, speed_mps, (triangles, error)| Row {
        ground: name.to_owned(),
        method,
        speed_mps,
        triangles,
        error,
        others,
    };
    let mut rows = Vec::new();
    for (method, found) in [("ROAM", roam), ("regular quadtree", quadtree)] {
        for speed in [0.0, SPEEDS[0]] {
            rows.push(row(method, speed * REST_MPS, found));
        }
    }
    progress(&format!("{name}: C"));
    let alone = tuner.tuned(Criterion::Motion, |power| Knobs {
        c1: (-power).exp2(),
        threshold: SLACK,
        ..Criterion::Motion.knobs()
    })?;
    let bound = tuner.tuned(Criterion::Motion, |power| Knobs {
        c1: 1.0 / SLACK,
        threshold: power.exp2(),
        ..Criterion::Motion.knobs()
    })?;
    // With that bound, as large a C1 as keeps it.
    let both = tuner.tuned(Criterion::Motion, |power| Knobs {
        c1: (-power).exp2(),
        ..bound.knobs
    })?;
    for (method, detail) in [("C, f alone", alone), ("C", both)] {
        for speed in [0.0].into_iter().chain(SPEEDS) {
            let mut detail = detail;
            detail.knobs.speed_mps = speed * REST_MPS;
            rows.push(row(method, detail.knobs.speed_mps, tuner.found(&detail)?));
        }
    }
    Ok(rows)
}

/// The least power of two found that is enough.
fn least(enough: impl Fn(f64) -> Result<bool, ReportError>) -> Result<f64, ReportError> {
    let (mut low, mut high) = (-30.0, 30.0);
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

impl Tuner<'_> {
    fn found(&self, detail: &Detail) -> Result<(usize, Measured), ReportError> {
        let selection = select(self.ground, self.view, detail, Workers::One)?;
        let mesh = selection.mesh(self.ground);
        let error = measured(self.ground, &mesh, self.view);
        Ok((selection.triangles(), error))
    }

    /// The least detail found that keeps the standing error.
    fn tuned(
        &self,
        criterion: Criterion,
        knobs: impl Fn(f64) -> Knobs,
    ) -> Result<Detail, ReportError> {
        let with = |power: f64| Detail {
            knobs: knobs(power),
            ..Detail::of(criterion)
        };
        let enough = |power| Ok(self.found(&with(power))?.1.worst_px <= STANDING_PX);
        Ok(with(least(enough)?))
    }
}

impl Row {
    /// Triangles saved against ROAM and the quadtree, %.
    fn fewer_pct(&self) -> [f64; 2] {
        let fewer = |other: usize| 100.0 * (1.0 - self.triangles as f64 / other as f64);
        self.others.map(fewer)
    }
}

fn report(rows: &[Row], posts: usize) -> Report {
    let text = format!(
        "{} posts made up, and real ground where CITYLOD_DATA names any, each in one view. At rest \
         all err by at most {STANDING_PX} pixels, measured over all posts.\nUp to {REST_MPS} m/s \
         is rest. Fewer: triangles saved against ROAM and the quadtree at that error. \"f alone\" \
         is C as printed,\nwithout the standing error at which this library stops it.",
        thousands(posts as u64)
    );
    let cells = rows.iter().map(|row| {
        let [roam, quadtree] = row.fewer_pct();
        vec![
            row.ground.clone(),
            row.method.to_owned(),
            format!("{}", row.speed_mps),
            thousands(row.triangles as u64),
            format!("{:.2}", row.error.worst_px),
            format!("{:.3}", row.error.mean_px),
            format!("{roam:.1}"),
            format!("{quadtree:.1}"),
        ]
    });
    let json_rows = rows.iter().map(|row| {
        let [roam, quadtree] = row.fewer_pct();
        json!({
            "ground": row.ground, "method": row.method, "speed_mps": row.speed_mps,
            "triangles": row.triangles, "worst_px": row.error.worst_px,
            "mean_px": row.error.mean_px, "fewer_than_roam_pct": roam,
            "fewer_than_quadtree_pct": quadtree,
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
                "ground",
                "method",
                "speed_mps",
                "triangles",
                "worst_px",
                "mean_px",
                "fewer_than_roam_pct",
                "fewer_than_quadtree_pct",
            ],
            rows: cells.collect(),
            ..Table::default()
        }],
        ..Report::default()
    }
}
