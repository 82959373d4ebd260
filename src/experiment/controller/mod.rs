//! How well a frame time is held: ours beside the controllers that people use today, on synthetic
//! plants T = c + a·D^p and on a flight through a generated city.

mod flight;
mod rivals;
mod scenario;
mod score;
mod tables;

use super::report::Plot;
use super::{Progress, Report, ReportError};
use crate::control::Params;
use rivals::Rule;
use scenario::{DRAWN, RANGE_M, SCENARIOS, TARGET_MS};
use tables::{Row, drawn, report};

pub(super) fn run(progress: &Progress) -> Result<Report, ReportError> {
    let [least, most] = RANGE_M;
    let params = Params::new(TARGET_MS, least, most)
        .map_err(|error| ReportError::Plot(error.to_string()))?;
    let mut rows = Vec::new();
    let mut plots = Vec::new();
    for scenario in &SCENARIOS {
        progress(scenario.name);
        rows.extend(Rule::ALL.map(|rule| Row::over_seeds(scenario, rule, &params)));
        if DRAWN.contains(&scenario.name) {
            let runs = Rule::ALL.map(|rule| (rule, scenario.run(rule, &params, 1).0));
            plots.push(drawn(scenario.name, &runs)?);
        }
    }
    progress("flight");
    let flights = flight::flights(&params)?;
    plots.insert(
        0,
        Plot {
            name: String::new(),
            ..drawn("flight", &flights)?
        },
    );
    let flown = flights.iter().map(|(rule, run)| (*rule, flight::held(run)));
    Ok(report(&rows, &flown.collect::<Vec<_>>(), plots))
}
