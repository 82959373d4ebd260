//! What accuracy costs in time, and what each way to choose objects misses.
//!
//! At equal numbers of objects: range mode by both of Gong's promotions, error mode and budget
//! mode, beside three references. Errors are counted pixel by pixel against full detail. Then how
//! long error mode and budget mode take beside a scan of all objects for the same answer, and what
//! it takes to miss less and less.

mod choice;
mod full_detail;
mod rows;
mod scan;
mod speed;
mod strategy;
mod tables;
mod text;
mod viewpoint;

use serde_json::json;

use self::choice::City;
use self::rows::{Cost, Row};
use self::scan::Scan;
use self::speed::Speed;
use super::report::{circumstances, thousands};
use super::{Options, Progress, Report, ReportError, city};
use crate::index::{self, Promotion};

/// The generated city that is compared on, objects.
const COMPARED: u32 = 1_000_000;
/// The larger one that only times are taken on, objects.
const LARGEST: u32 = 10_000_000;

/// Everything that was measured.
#[derive(Default)]
struct Measured {
    rows: Vec<Row>,
    costs: Vec<Cost>,
    speeds: Vec<Speed>,
}

pub(super) fn run(options: &Options, progress: &Progress) -> Result<Report, ReportError> {
    let largest = options.largest.unwrap_or(LARGEST);
    let mut measured = Measured::default();
    progress("reading the cities");
    for city in choice::cities(&options.cities)? {
        measured.compare(&city, progress)?;
    }
    let objects = largest.min(COMPARED);
    let name = format!("generated city of {} objects", thousands(objects.into()));
    progress(&name);
    let city = City::new(name, &city::generated_scene(objects))?;
    measured.compare(&city, progress)?;
    progress(&format!("{}: times", city.name));
    measured.speeds = speed::measure(&city.tree, &city.scan)?;
    drop(city);
    if largest > COMPARED {
        progress(&format!("{} objects: times", thousands(largest.into())));
        let tree = index::build(&city::generated_scene(largest), Promotion::Largest)?;
        let scan = Scan::new(&tree, (0..tree.object_count()).collect());
        measured.speeds.extend(speed::measure(&tree, &scan)?);
    }
    measured.report()
}

impl Measured {
    fn compare(&mut self, city: &City, progress: &Progress) -> Result<(), ReportError> {
        let at = |view: &str| progress(&format!("{}: {view}", city.name));
        let (rows, costs) = rows::measure(city, &at)?;
        self.rows.extend(rows);
        self.costs.extend(costs);
        Ok(())
    }

    fn report(&self) -> Result<Report, ReportError> {
        let summaries = rows::summaries(&self.rows);
        let broken = |row: &&Row| row.worst_missed_px > row.bound_px;
        let violations = self.rows.iter().filter(broken).count();
        let parameters = json!({
            "counts": rows::COUNTS,
            "dist_factor": choice::DIST_FACTOR,
            "viewport": viewpoint::VIEWPORT,
            "district_m": full_detail::DISTRICT_M,
            "far_m": full_detail::FAR_M,
        });
        Ok(Report {
            name: "accuracy",
            text: text::text(self, &summaries),
            tables: vec![
                tables::strategies(&summaries),
                tables::costs(&self.costs),
                tables::speeds(&self.speeds),
            ],
            plots: tables::plots(&summaries)?,
            json: json!({
                "rows": self.rows,
                "summary": summaries,
                "cost": self.costs,
                "speed": self.speeds,
                "bound_violations": violations,
                "circumstances": circumstances(&parameters),
            }),
            ..Report::default()
        })
    }
}
