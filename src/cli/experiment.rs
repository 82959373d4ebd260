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
        ExperimentArg::Culling => &[Experiment::Culling],
        ExperimentArg::Effects => &[Experiment::Effects],
        ExperimentArg::Stability => &[Experiment::Stability],
    };
    let options = Options {
        cities: args.city.clone(),
        largest: args.largest,
        program: std::env::current_exe().ok(),
    };
    let own_cities = matches!(
        args.name,
        ExperimentArg::Scaling | ExperimentArg::Stability | ExperimentArg::Effects
    );
    if own_cities && !args.city.is_empty() {
        bail!(
            "--city goes with far-dist, views and culling: scaling, stability and effects make their cities themselves"
        );
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
        (ExperimentArg::All, _) => reports
            .iter()
            .map(|report| (report.name.to_owned(), report.json.clone()))
            .collect::<serde_json::Map<_, _>>()
            .into(),
        (_, reports) => reports
            .first()
            .map_or(serde_json::Value::Null, |report| report.json.clone()),
    }
}
