use std::io::{self, Write};

use anyhow::{Result, bail};

use super::args::{ExperimentArg, ExperimentArgs};
use super::progress;
use crate::experiment::{Experiment, Options, Report, run as run_experiment, write_index};

pub(super) fn run(args: &ExperimentArgs) -> Result<()> {
    let experiments = match args.name {
        ExperimentArg::All => &Experiment::ALL[..],
        ExperimentArg::FarDist => &[Experiment::FarDist],
        ExperimentArg::Views => &[Experiment::Views],
        ExperimentArg::Scaling => &[Experiment::Scaling],
    };
    let options = Options {
        cities: args.city.clone(),
        largest: args.largest,
    };
    if matches!(args.name, ExperimentArg::Scaling) && !args.city.is_empty() {
        bail!("--city goes with far-dist and views: scaling makes its cities itself");
    }
    let mut out = io::stdout().lock();
    let mut reports = Vec::new();
    for &experiment in experiments {
        let spinner = progress::spinner();
        let report = run_experiment(experiment, &options, &|doing| {
            spinner.set_message(format!("{}: {doing}", experiment.name()));
        });
        spinner.finish_and_clear();
        let report = report?;
        if !args.json {
            writeln!(out, "{}", report.to_text())?;
        }
        if let Some(folder) = &args.out {
            report.write(folder)?;
        }
        reports.push(report);
    }
    if let (ExperimentArg::All, Some(folder)) = (args.name, &args.out) {
        write_index(&reports, folder)?;
    }
    if args.json {
        writeln!(out, "{}", json(args.name, &reports))?;
    }
    Ok(())
}

/// One object: an experiment's own, or each of all under its name.
fn json(name: ExperimentArg, reports: &[Report]) -> serde_json::Value {
    match (name, reports) {
        (ExperimentArg::FarDist | ExperimentArg::Views | ExperimentArg::Scaling, [report]) => {
            report.json.clone()
        }
        _ => reports
            .iter()
            .map(|report| (report.name.to_owned(), report.json.clone()))
            .collect::<serde_json::Map<_, _>>()
            .into(),
    }
}
