//! What can be asked, how, and the call that answers it.

use std::path::PathBuf;

use super::{
    Report, ReportError, accuracy, controller, culling, effects, far_dist, scaling, stability,
    terrain, views,
};

/// What can be asked. To add one: a variant, its place in [`Experiment::ALL`], its name, its
/// question, and the call in [`run`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Experiment {
    /// Objects drawn against `far_dist` (Gong, figure 4).
    FarDist,
    /// Level, far and near views with and without LOD (Gong, figures 1 to 3).
    Views,
    /// Cost against the number of objects.
    Scaling,
    /// What accuracy costs in time.
    Accuracy,
    /// Methods of culling: what they cost and what they keep.
    Culling,
    /// Cost of each effect, declared and not.
    Effects,
    /// How well a frame time is held.
    Controller,
    /// Promises about rounding, against exact arithmetic.
    Stability,
    /// Four criteria on one ground.
    TerrainCriteria,
    /// Ways to mend cracks.
    TerrainCracks,
    /// Bilinear, bicubic, and by variance.
    TerrainInterpolation,
    /// Detail at rest and in motion (C, table 1).
    TerrainMotion,
    /// Refinement by several threads (D, table 3).
    TerrainParallel,
    /// Tiles kept and tiles read again (A, table 1); memory as the ground grows (D, table 3).
    TerrainStore,
}

impl Experiment {
    /// All of them, in the order of the report.
    pub const ALL: [Self; 14] = [
        Self::FarDist,
        Self::Views,
        Self::Scaling,
        Self::Accuracy,
        Self::Culling,
        Self::Stability,
        Self::Effects,
        Self::Controller,
        Self::TerrainCriteria,
        Self::TerrainCracks,
        Self::TerrainInterpolation,
        Self::TerrainMotion,
        Self::TerrainParallel,
        Self::TerrainStore,
    ];

    /// The name on the command line and of the files written.
    pub fn name(self) -> &'static str {
        match self {
            Self::FarDist => "far-dist",
            Self::Views => "views",
            Self::Scaling => "scaling",
            Self::Accuracy => "accuracy",
            Self::Culling => "culling",
            Self::Effects => "effects",
            Self::Controller => "controller",
            Self::Stability => "stability",
            Self::TerrainCriteria => "terrain-criteria",
            Self::TerrainCracks => "terrain-cracks",
            Self::TerrainInterpolation => "terrain-interpolation",
            Self::TerrainMotion => "terrain-motion",
            Self::TerrainParallel => "terrain-parallel",
            Self::TerrainStore => "terrain-store",
        }
    }

    /// What is asked, for people.
    pub fn question(self) -> &'static str {
        match self {
            Self::FarDist => "How many objects are drawn as the far distance grows?",
            Self::Views => "What does a city look like with levels of detail and without?",
            Self::Scaling => "What does an answer cost as the city grows?",
            Self::Accuracy => "What does accuracy cost in time, and what does each mode miss?",
            Self::Culling => "What does each way to cull cost, and what does it keep?",
            Self::Effects => "What does each effect cost, declared and not?",
            Self::Controller => "How well does each controller hold a frame time?",
            Self::Stability => "Do the promises about rounding hold against exact arithmetic?",
            Self::TerrainCriteria => "What do the criteria of four papers draw of one ground?",
            Self::TerrainCracks => "What does it cost to draw ground without cracks?",
            Self::TerrainInterpolation => "How are heights between posts found best?",
            Self::TerrainMotion => "How much less ground is drawn in motion?",
            Self::TerrainParallel => "How much faster do several threads refine the ground?",
            Self::TerrainStore => "What does it bring to keep the tiles that were read?",
        }
    }

    /// Whether it looks at [`Options::cities`]; the others make their cities themselves.
    pub fn looks_at_cities(self) -> bool {
        matches!(
            self,
            Self::FarDist | Self::Views | Self::Accuracy | Self::Culling
        )
    }
}

/// How to run.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Cities to look at beside the generated ones; any file that can be imported or opened.
    pub cities: Vec<PathBuf>,
    /// Largest generated city, objects, default 10,000,000; of ground, posts.
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
        Experiment::Accuracy => accuracy::run(options, progress),
        Experiment::Culling => culling::run(options, progress),
        Experiment::Effects => effects::run(options, progress),
        Experiment::Controller => controller::run(progress),
        Experiment::Stability => stability::run(progress),
        Experiment::TerrainCriteria => terrain::criteria(options, progress),
        Experiment::TerrainCracks => terrain::cracks(options, progress),
        Experiment::TerrainInterpolation => terrain::interpolation(options, progress),
        Experiment::TerrainMotion => terrain::motion(options, progress),
        Experiment::TerrainParallel => terrain::parallel(options, progress),
        Experiment::TerrainStore => terrain::store(options, progress),
    }
}
