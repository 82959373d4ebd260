//! The papers' questions, answered by measurement: run → records → table, csv, svg, json.
//!
//! Each experiment is one file. Timings are medians beside a baseline measured in the same run.

mod city;
mod culling;
pub mod exact;
mod far_dist;
mod fit;
mod plot;
mod report;
mod scaling;
pub mod stability;
mod timing;

use std::path::PathBuf;

pub use report::{Report, ReportError, write_index};

/// What can be asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Experiment {
    /// Objects drawn against `far_dist` (Gong, figure 4).
    FarDist,
    /// Cost against the number of objects.
    Scaling,
    /// Methods of culling: what they cost and what they keep.
    Culling,
    /// Promises about rounding, against exact arithmetic.
    Stability,
}

impl Experiment {
    /// All of them, in the order of the report.
    pub const ALL: [Self; 4] = [Self::FarDist, Self::Scaling, Self::Culling, Self::Stability];

    /// The name on the command line and of the files written.
    pub fn name(self) -> &'static str {
        match self {
            Self::FarDist => "far-dist",
            Self::Scaling => "scaling",
            Self::Culling => "culling",
            Self::Stability => "stability",
        }
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
        Experiment::Culling => culling::run(options, progress),
        Experiment::Stability => stability::run(progress),
    }
}
