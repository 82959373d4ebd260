use std::io::{self, Write};

use anyhow::Result;

use super::args::{ExperimentArg, ExperimentArgs};
use super::progress;
use crate::experiment::{Experiment, Options, run as run_experiment};

pub(super) fn run(args: &ExperimentArgs) -> Result<()> {
    let experiments = match args.name {
        ExperimentArg::All => &Experiment::ALL[..],
        ExperimentArg::FarDist => &[Experiment::FarDist],
        ExperimentArg::Scaling => &[Experiment::Scaling],
    };
    let options = Options {
        cities: args.city.clone(),
        largest: args.largest,
    };
    let mut out = io::stdout().lock();
    for &experiment in experiments {
        let spinner = progress::spinner();
        let report = run_experiment(experiment, &options, &|doing| {
            spinner.set_message(format!("{}: {doing}", experiment.name()));
        });
        spinner.finish_and_clear();
        let report = report?;
        if args.json {
            writeln!(out, "{}", report.json)?;
        } else {
            writeln!(out, "{}", report.to_text())?;
        }
        if let Some(folder) = &args.out {
            report.write(folder)?;
        }
    }
    Ok(())
}
