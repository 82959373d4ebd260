//! Ways to mend cracks: how many there are without one, and what each way costs.

use std::collections::HashSet;

use serde_json::json;

use super::place::{POSITIONS, flight, mountains};
use crate::experiment::report::{Table, circumstances, thousands};
use crate::experiment::timing::{median, median_us};
use crate::experiment::{Options, Progress, Report, ReportError};
use crate::terrain::{
    Criterion, Cut, Detail, Ground, Post, State, Workers, doubled_area, height_on, refine, select,
};

const SAMPLES: usize = 5;
/// B's m, m.
const WITHIN_M: f64 = 1_000.0;

struct Row {
    method: &'static str,
    triangles: f64,
    cracks: f64,
    worst_gap_m: f64,
    /// `None` where no bound is given.
    error_px: Option<f64>,
    us: f64,
}

/// What a set of triangles comes to.
#[derive(Default)]
struct Found {
    cracks: usize,
    worst_gap_m: f64,
}

pub(in crate::experiment) fn run(
    options: &Options,
    progress: &Progress,
) -> Result<Report, ReportError> {
    let (field, ground) = mountains(options)?;
    let views = flight(&field)?;
    let detail = |subdivide_within| Detail {
        subdivide_within,
        ..Detail::of(Criterion::Error)
    };
    let methods = [
        ("none", None),
        ("skip vertices of the finer side", Some(0.0)),
        ("skip beyond 1 km, subdivide within", Some(WITHIN_M)),
        ("subdivide the coarser side", Some(f64::INFINITY)),
    ];
    let mut rows = Vec::new();
    for (method, within) in methods {
        progress(method);
        let mut each: [Vec<f64>; 5] = Default::default();
        for view in &views {
            let numbers = if let Some(within) = within {
                let detail = detail(within);
                let selection = select(&ground, view, &detail, Workers::One)?;
                let mut triangles = Vec::new();
                selection
                    .cut()
                    .facets(&ground, |facet| triangles.push(facet.corners));
                let found = examine(&ground, &triangles);
                let us = median_us(SAMPLES, || select(&ground, view, &detail, Workers::One));
                (triangles.len(), found, selection.error_px(), us)
            } else {
                let detail = detail(0.0);
                let cut = refine(&ground, view, &detail, Workers::One)?;
                let triangles = unmended(&ground, &cut);
                let us = median_us(SAMPLES, || refine(&ground, view, &detail, Workers::One));
                (triangles.len(), examine(&ground, &triangles), f64::NAN, us)
            };
            let (triangles, found, error_px, us) = numbers;
            let numbers = [
                triangles as f64,
                found.cracks as f64,
                found.worst_gap_m,
                error_px,
                us,
            ];
            for (all, number) in each.iter_mut().zip(numbers) {
                all.push(number);
            }
        }
        let [triangles, cracks, worst_gap_m, error_px, us] = each.map(median);
        rows.push(Row {
            method,
            triangles,
            cracks,
            worst_gap_m,
            error_px: within.map(|_| error_px),
            us,
        });
    }
    Ok(report(&rows, field.grid().count()))
}

/// The triangles of a cut whose nodes know nothing of their neighbours.
fn unmended(ground: &Ground, cut: &Cut) -> Vec<[Post; 3]> {
    let (layout, levels) = (ground.layout(), ground.layout().levels());
    let mut triangles = Vec::new();
    for number in 0..layout.block_count() {
        let root = layout.block(number);
        if cut.state(root) == State::Drawn {
            let [a, b, c, d] = layout.posts(root).corners();
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for node in (0..levels).flat_map(|level| cut.splits(level)) {
        let posts = layout.posts(node);
        let (corners, midpoints) = (posts.corners(), posts.midpoints());
        for quarter in 0..4 {
            let child = node.child(quarter);
            let drawn = if child.level == levels {
                ground.record(child).has_ground()
            } else {
                cut.state(child) == State::Drawn
            };
            if drawn {
                let (middle, corner) = (posts.middle, corners[quarter]);
                triangles.push([middle, corner, midpoints[quarter]]);
                triangles.push([middle, midpoints[(quarter + 3) % 4], corner]);
            }
        }
    }
    triangles.retain(|triangle| doubled_area(*triangle) != 0);
    triangles
}

/// A crack is a corner within the side of another triangle at another height.
fn examine(ground: &Ground, triangles: &[[Post; 3]]) -> Found {
    let corners: HashSet<Post> = triangles.iter().flatten().copied().collect();
    let z = |post: Post| f64::from(ground.post(post[0], post[1]));
    let mut found = Found::default();
    for &[a, b, c] in triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let steps = gcd(from[0].abs_diff(to[0]), from[1].abs_diff(to[1]));
            for step in 1..steps {
                let between = [0, 1].map(|axis| {
                    let (from, to) = (i64::from(from[axis]), i64::from(to[axis]));
                    (from + (to - from) / i64::from(steps) * i64::from(step)) as u32
                });
                if corners.contains(&between) {
                    // The side's line, as an edge of the triangle.
                    let heights = [a, b, c].map(z);
                    let gap = (z(between) - height_on([a, b, c], heights, between).0).abs();
                    found.cracks += usize::from(gap > 0.0);
                    found.worst_gap_m = found.worst_gap_m.max(gap);
                }
            }
        }
    }
    found
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

fn report(rows: &[Row], posts: usize) -> Report {
    let text = format!(
        "{} posts, a flight of {POSITIONS} positions, criterion `error`, medians.\nA crack is a \
         corner that lies within the side of another triangle, at another height.",
        thousands(posts as u64)
    );
    let cells = rows.iter().map(|row| {
        vec![
            row.method.to_owned(),
            thousands(row.triangles as u64),
            thousands(row.cracks as u64),
            format!("{:.2}", row.worst_gap_m),
            row.error_px.map_or("-".to_owned(), |px| format!("{px:.2}")),
            format!("{:.0}", row.us),
        ]
    });
    let json_rows = rows.iter().map(|row| {
        json!({
            "method": row.method, "triangles": row.triangles, "cracks": row.cracks,
            "worst_gap_m": row.worst_gap_m, "error_px": row.error_px, "select_us": row.us,
        })
    });
    Report {
        name: "terrain-cracks",
        text,
        json: json!({
            "rows": json_rows.collect::<Vec<_>>(),
            "circumstances": circumstances(&json!({
                "posts": posts, "positions": POSITIONS, "within_m": WITHIN_M,
            })),
        }),
        tables: vec![Table {
            columns: vec![
                "method",
                "triangles",
                "cracks",
                "worst_gap_m",
                "error_px",
                "select_us",
            ],
            rows: cells.collect(),
            ..Table::default()
        }],
        ..Report::default()
    }
}
