use std::io::{self, Write};
use std::time::Instant;

use anyhow::{Result, bail};

use super::args::{ExperimentArgs, misuse};
use super::progress::{self, Steps};
use crate::experiment::{Entry, Experiment, Options, Outcome, run as run_experiment, write_index};

pub(super) fn run(args: &ExperimentArgs) -> Result<()> {
    let options = Options {
        cities: args.city.clone(),
        largest: args.largest,
        program: std::env::current_exe().ok(),
    };
    let named = |experiment: &Experiment| experiment.name() == args.name;
    match Experiment::ALL.into_iter().find(named) {
        Some(experiment) => run_one(experiment, args, &options),
        None => run_all(args, &options),
    }
}

fn run_one(experiment: Experiment, args: &ExperimentArgs, options: &Options) -> Result<()> {
    let name = experiment.name();
    if !args.city.is_empty() && !experiment.looks_at_cities() {
        let looking = Experiment::ALL.into_iter().filter(|e| e.looks_at_cities());
        let looking: Vec<&str> = looking.map(Experiment::name).collect();
        let looking = looking.join(", ");
        let reason =
            format!("--city: {name} makes its cities itself; --city goes with {looking} and all");
        return Err(misuse("experiment", reason).into());
    }
    let spinner = progress::spinner();
    let report = run_experiment(experiment, options, &|doing| {
        spinner.set_message(format!("{name}: {doing}"));
    });
    spinner.finish_and_clear();
    let report = report?;
    if let Some(folder) = &args.out {
        report.write(folder)?;
    }
    let mut out = io::stdout().lock();
    if args.json {
        writeln!(out, "{}", report.json)?;
    } else {
        writeln!(out, "{}", report.to_text())?;
    }
    Ok(())
}

/// Runs them one after another; one that fails does not keep the others from being run.
///
/// The page is written after each, so that whenever this is interrupted, it shows what was found.
fn run_all(args: &ExperimentArgs, options: &Options) -> Result<()> {
    let mut entries = Experiment::ALL.map(|experiment| Entry {
        experiment,
        outcome: Outcome::Waiting,
    });
    let steps = Steps::new(entries.len());
    for n in 0..entries.len() {
        let (experiment, start) = (entries[n].experiment, Instant::now());
        let name = experiment.name();
        steps.doing(name);
        let report = run_experiment(experiment, options, &|doing| {
            steps.doing(&format!("{name}: {doing}"));
        });
        let report = report.and_then(|report| {
            args.out
                .as_deref()
                .map_or(Ok(()), |folder| report.write(folder))?;
            Ok(Box::new(report))
        });
        let took = start.elapsed();
        entries[n].outcome = match report {
            Ok(report) => {
                steps.done(&format!("{name}: {:.1} s", took.as_secs_f64()));
                if !args.json {
                    steps.suspend(|| writeln!(io::stdout(), "{}", report.to_text()))?;
                }
                Outcome::Done(report, took)
            }
            Err(error) => {
                let reason = format!("{:#}", anyhow::Error::from(error));
                steps.done(&format!("{name} failed: {reason}"));
                Outcome::Failed(reason)
            }
        };
        if let Some(folder) = &args.out {
            write_index(&entries, options, folder)?;
        }
    }
    steps.finish();
    if args.json {
        writeln!(io::stdout(), "{}", json(&entries))?;
    }
    let failed = |entry: &&Entry| matches!(entry.outcome, Outcome::Failed(_));
    let failed: Vec<&str> = entries
        .iter()
        .filter(failed)
        .map(|entry| entry.experiment.name())
        .collect();
    if !failed.is_empty() {
        bail!("not every experiment could be run: {}", failed.join(", "));
    }
    Ok(())
}

/// Each report under its name.
fn json(entries: &[Entry]) -> serde_json::Value {
    let reports = entries.iter().filter_map(|entry| match &entry.outcome {
        Outcome::Done(report, _) => Some((report.name.to_owned(), report.json.clone())),
        _ => None,
    });
    reports.collect::<serde_json::Map<_, _>>().into()
}
