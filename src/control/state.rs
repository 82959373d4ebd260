//! What the controller remembers.

use serde::de::{Error, Unexpected};
use serde::{Deserialize, Deserializer, Serialize};

/// Longer frames are no frames: a debugger, a laptop's lid.
pub(super) const LONGEST_FRAME_MS: f64 = 3_600_000.0;
/// How many frames are remembered.
pub(super) const FRAMES: usize = 16;
/// Least relative standard deviation of frame times: clocks and schedulers are no better.
const LEAST_SCATTER: f64 = 0.01;
/// What is taken for it before frames were seen.
const USUAL_SCATTER: f64 = 0.04;
/// One part in so many is what a frame adds to the estimate of the scatter, and at most so many
/// standard deviations.
const SCATTER_FRAMES: f64 = 8.0;
const SCATTER_LIMIT: f64 = 3.0;

/// One frame that was drawn: what it took, and what it was drawn with. Whatever the delay between
/// choosing a `far_dist` and measuring its frame, the two belong together here.
///
/// As JSON: `[frame_ms, far_dist_m]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 2]", into = "[f64; 2]")]
pub struct Sample {
    /// Frame time, ms.
    pub frame_ms: f64,
    /// The `far_dist` that this frame was drawn with, m.
    pub far_dist_m: f64,
}

impl Sample {
    /// Whether it can be a frame: both numbers finite and above 0, and less than an hour.
    pub fn is_usable(&self) -> bool {
        let Self {
            frame_ms,
            far_dist_m,
        } = *self;
        frame_ms > 0.0 && frame_ms < LONGEST_FRAME_MS && far_dist_m > 0.0 && far_dist_m.is_finite()
    }
}

/// All that the controller knows between frames. Any values whatever are safe to step from: what
/// cannot be is not used.
///
/// As JSON: `{"far_dist_m", "recent": [sample, …], "suspect", "scatter", "ignored"}`, below a
/// kilobyte.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// The `far_dist` chosen last, m.
    pub(super) far_dist_m: f64,
    /// The last frames that the plant is judged by.
    pub(super) recent: Memory,
    /// A frame that nothing explains, until the next one speaks for it or against it.
    pub(super) suspect: Option<Sample>,
    /// Relative standard deviation of frame times.
    scatter: f64,
    /// Samples that could not be frames.
    #[serde(deserialize_with = "whole")]
    pub(super) ignored: u32,
}

impl State {
    /// Begins at a `far_dist`, m, knowing nothing.
    pub fn starting_at(far_dist_m: f64) -> Self {
        Self {
            far_dist_m,
            recent: Memory::default(),
            suspect: None,
            scatter: USUAL_SCATTER,
            ignored: 0,
        }
    }

    /// The `far_dist` chosen last, m; what it started at before the first step.
    pub fn far_dist(&self) -> f64 {
        self.far_dist_m
    }

    /// How many samples were ignored because they cannot be frames ([`Sample::is_usable`]).
    pub fn ignored(&self) -> u32 {
        self.ignored
    }

    /// Relative standard deviation of frame times, 0.01 to 1.
    pub(super) fn scatter(&self) -> f64 {
        if self.scatter.is_nan() {
            return USUAL_SCATTER;
        }
        self.scatter.clamp(LEAST_SCATTER, 1.0)
    }

    /// Learns the scatter from how much a frame surprised.
    pub(super) fn notice(&mut self, surprise: f64) {
        let known = self.scatter();
        let seen = surprise.abs().min(SCATTER_LIMIT * known);
        let variance = known * known + (seen * seen - known * known) / SCATTER_FRAMES;
        self.scatter = variance.sqrt();
    }
}

/// The last frames, newest first; entries that cannot be frames are empty places.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Sample>", into = "Vec<Sample>")]
pub(super) struct Memory([Sample; FRAMES]);

impl Memory {
    pub(super) fn samples(&self) -> impl Iterator<Item = Sample> + Clone {
        self.0.into_iter().filter(Sample::is_usable)
    }

    pub(super) fn push(&mut self, sample: Sample) {
        self.0.rotate_right(1);
        self.0[0] = sample;
    }

    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }
}

impl From<Memory> for Vec<Sample> {
    fn from(memory: Memory) -> Self {
        memory.samples().collect()
    }
}

impl TryFrom<Vec<Sample>> for Memory {
    type Error = String;

    fn try_from(samples: Vec<Sample>) -> Result<Self, String> {
        let mut memory = Self::default();
        let count = samples.len();
        let Some(places) = memory.0.get_mut(..count) else {
            return Err(format!("must be at most {FRAMES} frames, is {count}"));
        };
        places.copy_from_slice(&samples);
        Ok(memory)
    }
}

impl From<Sample> for [f64; 2] {
    fn from(sample: Sample) -> Self {
        [sample.frame_ms, sample.far_dist_m]
    }
}

impl From<[f64; 2]> for Sample {
    fn from([frame_ms, far_dist_m]: [f64; 2]) -> Self {
        Self {
            frame_ms,
            far_dist_m,
        }
    }
}

/// A count; `2.0` is one, as JSON Schema has it.
fn whole<'de, D: Deserializer<'de>>(source: D) -> Result<u32, D::Error> {
    let number = f64::deserialize(source)?;
    if number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number) {
        return Ok(number as u32);
    }
    let expected = "a whole number from 0 to 4294967295";
    Err(D::Error::invalid_value(
        Unexpected::Float(number),
        &expected,
    ))
}
