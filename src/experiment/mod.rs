//! The papers' questions, answered by measurement: run → records → tables, plots, pictures, json.
//!
//! Each experiment is one file, or a folder of its name. Timings are medians beside a baseline
//! measured in the same run. To add one: a variant of [`Experiment`], its place in
//! [`Experiment::ALL`], its name, its question, and the call that runs it.

mod accuracy;
mod city;
mod far_dist;
mod fit;
mod page;
mod plot;
mod report;
mod scaling;
mod timing;

use std::path::PathBuf;

pub use page::{Entry, Outcome, write_index};
pub use report::{Picture, Plot, Report, ReportError, Table};

/// What can be asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Experiment {
    /// Objects drawn against `far_dist` (Gong, figure 4).
    FarDist,
    /// Cost against the number of objects.
    Scaling,
    /// What accuracy costs in time.
    Accuracy,
}

impl Experiment {
    /// All of them, in the order of the report.
    pub const ALL: [Self; 3] = [Self::FarDist, Self::Scaling, Self::Accuracy];

    /// The name on the command line and of the files written.
    pub fn name(self) -> &'static str {
        match self {
            Self::FarDist => "far-dist",
            Self::Scaling => "scaling",
            Self::Accuracy => "accuracy",
        }
    }

    /// What is asked, for people.
    pub fn question(self) -> &'static str {
        match self {
            Self::FarDist => "How many objects are drawn as the far distance grows?",
            Self::Scaling => "What does an answer cost as the city grows?",
            Self::Accuracy => "What does accuracy cost in time, and what does each mode miss?",
        }
    }

    /// Whether it looks at [`Options::cities`]; the others make their cities themselves.
    pub fn looks_at_cities(self) -> bool {
        matches!(self, Self::FarDist | Self::Accuracy)
    }
}

/// How to run.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Cities to look at beside the generated ones; any file that can be imported or opened.
    pub cities: Vec<PathBuf>,
    /// Largest generated city, objects; default 10,000,000.
    pub largest: Option<u32>,
}

/// Called with what is being done.
pub type Progress<'a> = dyn Fn(&str) + 'a;

/// Runs one experiment.
///
/// # Errors
/// [`ReportError`] when a city cannot be read or a temporary file not written.
pub fn run(
    experiment: Experiment,
    options: &Options,
    progress: &Progress,
) -> Result<Report, ReportError> {
    match experiment {
        Experiment::FarDist => far_dist::run(options, progress),
        Experiment::Scaling => scaling::run(options, progress),
        Experiment::Accuracy => accuracy::run(options, progress),
    }
}
