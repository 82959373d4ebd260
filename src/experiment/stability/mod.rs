//! Whether the promises of DESIGN.md, section 5, hold: production code against exact arithmetic
//! over random and over hard cases.

mod examine;
mod hard;
mod place;
mod random;
mod ranges;
mod tally;

use serde_json::json;

pub use examine::examine;
pub use hard::adversarial;
pub use random::random;
pub use tally::Tally;

use super::plot::{self, Labels, Series};
use super::report::{Plot, Table, circumstances, thousands};
use super::{Progress, Report, ReportError};
use crate::geom::Aabb;
use crate::index::{self, LodTree, Promotion};
use crate::scene::{Scene, SceneObject};

/// Random cases, at least.
const RANDOM_CASES: u64 = 10_000_000;

/// The tree of a scene of boxes.
pub(super) fn city(boxes: &[Aabb]) -> Result<LodTree, ReportError> {
    city_turned(boxes, 0)
}

/// The same scene given in another order: beginning with another box.
fn city_turned(boxes: &[Aabb], first: usize) -> Result<LodTree, ReportError> {
    let object = |(n, b): (usize, &Aabb)| SceneObject {
        id: format!("{n:07}").into(),
        class: "Building".into(),
        bounds: *b,
        footprint_area: b.size().x * b.size().y,
        triangles: 12,
        base_known: true,
        lift_m: 0.0,
        attributes: None,
    };
    let mut objects: Vec<SceneObject> = boxes.iter().enumerate().map(object).collect();
    objects.rotate_left(first);
    let mut scene = Scene {
        objects,
        ..Scene::default()
    };
    scene.canonicalize();
    Ok(index::build(&scene, Promotion::default())?)
}

pub(super) fn run(progress: &Progress) -> Result<Report, ReportError> {
    progress("hard cases");
    let mut rows = adversarial()?;
    let hard: Tally = rows.iter().map(|(_, tally)| *tally).sum();
    let random = random(RANDOM_CASES, progress)?;
    rows.push(("random", random));
    let all: Tally = [hard, random].into_iter().sum();
    rows.push(("all", all));
    report(&rows, &all)
}

fn report(rows: &[(&'static str, Tally)], all: &Tally) -> Result<Report, ReportError> {
    let text = format!(
        "Culling, \"inside\" and distances against exact arithmetic, over boxes of objects and \
         nodes.\n{} cases: {} false negatives, {} false inside, {} monotone violations, {} \
         mismatches.",
        thousands(all.cases),
        all.false_negatives,
        all.false_inside,
        all.monotone_violations,
        all.mismatches
    );
    let cells = rows.iter().map(|(name, t)| {
        let numbers = [
            t.cases,
            t.meeting,
            t.inside,
            t.kept_outside,
            t.not_separated,
            t.open,
            t.at_border,
            t.false_negatives,
            t.false_inside,
            t.monotone_violations,
            t.mismatches,
        ];
        let name = std::iter::once((*name).to_owned());
        name.chain(numbers.map(|n| n.to_string())).collect()
    });
    let series = |name: &str, of: fn(&Tally) -> u64| Series {
        name: name.into(),
        points: rows
            .iter()
            .zip(1_u32..)
            .map(|((_, t), n)| (f64::from(n), of(t) as f64))
            .filter(|(_, count)| *count > 0.0)
            .collect(),
        reference: false,
    };
    let labels = Labels {
        title: "Cases put to exact arithmetic",
        x: "row of the table",
        y: "boxes",
    };
    let svg = plot::log_log(
        &labels,
        &[
            series("asked about", |t| t.cases),
            series("meet the frustum", |t| t.meeting),
            series("kept without meeting it", |t| t.kept_outside),
        ],
    )?;
    let mut json = json!(all);
    json["rows"] = rows
        .iter()
        .map(|(name, tally)| {
            let mut row = json!(tally);
            row["case"] = json!(name);
            row
        })
        .collect();
    json["circumstances"] = circumstances(&json!({ "random_cases": RANDOM_CASES }));
    Ok(Report {
        name: "stability",
        text,
        tables: vec![Table {
            columns: vec![
                "case",
                "cases",
                "meeting",
                "inside",
                "kept_outside",
                "not_separated",
                "open",
                "at_border",
                "false_negatives",
                "false_inside",
                "monotone_violations",
                "mismatches",
            ],
            rows: cells.collect(),
            ..Table::default()
        }],
        json,
        plots: vec![Plot {
            svg,
            ..Plot::default()
        }],
        ..Report::default()
    })
}
