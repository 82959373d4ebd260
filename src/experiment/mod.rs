//! The papers' questions, answered by measurement: run → records → table, csv, svg, json.
//!
//! Each experiment is one file. Timings are medians beside a baseline measured in the same run.

mod city;
mod culling;
mod effects;
pub mod exact;
mod far_dist;
mod fit;
mod plot;
mod report;
mod scaling;
pub mod stability;
mod street;
mod timing;
mod views;

use std::path::PathBuf;

pub use report::{Report, ReportError, ReportPicture, write_index};

/// What can be asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Experiment {
    /// Objects drawn against `far_dist` (Gong, figure 4).
    FarDist,
    /// Level, far and near views with and without LOD (Gong, figures 1 to 3).
    Views,
    /// Cost against the number of objects.
    Scaling,
    /// Methods of culling: what they cost and what they keep.
    Culling,
    /// Cost of each effect, declared and not.
    Effects,
    /// Promises about rounding, against exact arithmetic.
    Stability,
}

impl Experiment {
    /// All of them, in the order of the report.
    pub const ALL: [Self; 6] = [
        Self::FarDist,
        Self::Views,
        Self::Scaling,
        Self::Culling,
        Self::Stability,
        Self::Effects,
    ];

    /// The name on the command line and of the files written.
    pub fn name(self) -> &'static str {
        match self {
            Self::FarDist => "far-dist",
            Self::Views => "views",
            Self::Scaling => "scaling",
            Self::Culling => "culling",
            Self::Effects => "effects",
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
    /// This program as a command, whose instructions can be counted.
    pub program: Option<PathBuf>,
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
        Experiment::Views => views::run(options, progress),
        Experiment::Scaling => scaling::run(options, progress),
        Experiment::Culling => culling::run(options, progress),
        Experiment::Effects => effects::run(options, progress),
        Experiment::Stability => stability::run(progress),
    }
}
