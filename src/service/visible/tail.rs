//! What an answer says beside its list: how objects were chosen, what the effects did, what it
//! took. The same over HTTP and from the command.

use std::time::Duration;

use serde::{Serialize, Serializer};

use super::feedback::Steered;
use crate::frame::{Frame, Ran};
use crate::lod::Lod;
use crate::terrain::Patch;

/// The members that follow the list.
#[derive(Debug, Serialize)]
pub struct Tail<'a> {
    lod: LodTail,
    effects: EffectsTail<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    feedback: Option<&'a Steered>,
    stats: StatsTail,
}

#[derive(Debug, Serialize)]
#[serde(tag = "mode", rename_all = "lowercase")]
enum LodTail {
    Range {
        /// JSON has no infinity: null.
        far_dist_m: Option<f64>,
        dist_factor: f64,
        levels: u32,
        error_px: Option<f64>,
    },
    Error {
        max_error_px: f64,
        error_px: Option<f64>,
    },
    Budget {
        max_objects: u32,
        error_px: Option<f64>,
    },
}

#[derive(Debug, Serialize)]
struct EffectsTail<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    motion: Option<MotionTail>,
    #[serde(skip_serializing_if = "Option::is_none")]
    haze: Option<HazeTail>,
    #[serde(skip_serializing_if = "Option::is_none")]
    occlusion: Option<OcclusionTail<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    terrain: Option<TerrainTail<'a>>,
}

#[derive(Debug, Serialize)]
struct MotionTail {
    slowdown: f64,
    took_us: f64,
}

#[derive(Debug, Serialize)]
struct HazeTail {
    removed: u32,
    took_us: f64,
}

#[derive(Debug, Serialize)]
struct OcclusionTail<'a> {
    removed: u32,
    width_px: u32,
    height_px: u32,
    took_us: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    visible_pixels: Option<Pixels<'a>>,
}

#[derive(Debug, Serialize)]
struct TerrainTail<'a> {
    patches: u32,
    triangles: usize,
    /// JSON has no infinity: null.
    error_px: Option<f64>,
    took_us: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    list: Option<Patches<'a>>,
}

#[derive(Debug, Serialize)]
struct StatsTail {
    nodes_visited: u32,
    objects_tested: u32,
    retrieve_us: f64,
}

/// What an answer lists besides the objects, where the effects ran that find it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Lists {
    /// Of occlusion: the pixels of each object, in the order of the objects.
    pub pixels: bool,
    /// Of terrain: the patches of the ground.
    pub patches: bool,
}

impl<'a> Tail<'a> {
    /// Of a frame just worked out, with these lists.
    pub fn of(frame: &'a Frame, lists: Lists) -> Self {
        let selection = frame.selection();
        let effects = frame.effects();
        let [width_px, height_px] = frame.buffer_size();
        Self {
            lod: LodTail::of(frame.lod(), selection.error_px()),
            effects: EffectsTail {
                motion: effects.motion.map(|ran| MotionTail {
                    slowdown: ran.result,
                    took_us: took_us(&ran),
                }),
                haze: effects.haze.map(|ran| HazeTail {
                    removed: ran.result,
                    took_us: took_us(&ran),
                }),
                occlusion: effects.occlusion.map(|ran| OcclusionTail {
                    removed: ran.result,
                    width_px,
                    height_px,
                    took_us: took_us(&ran),
                    visible_pixels: lists.pixels.then(|| Pixels(frame.visible_pixels())),
                }),
                terrain: effects.terrain.map(|ran| TerrainTail {
                    patches: ran.result.patches,
                    triangles: ran.result.triangles,
                    error_px: finite(ran.result.error_px),
                    took_us: took_us(&ran),
                    list: frame
                        .surface()
                        .filter(|_| lists.patches)
                        .map(|surface| Patches(surface.patches())),
                }),
            },
            feedback: None,
            stats: StatsTail {
                nodes_visited: selection.stats().nodes_visited,
                objects_tested: selection.stats().objects_tested,
                retrieve_us: us(frame.retrieval()),
            },
        }
    }
}

impl<'a> Tail<'a> {
    /// The same with what the controller chose.
    #[must_use]
    pub fn with_feedback(self, feedback: Option<&'a Steered>) -> Self {
        Self { feedback, ..self }
    }
}

impl LodTail {
    fn of(lod: &Lod, error_px: f64) -> Self {
        let error_px = finite(error_px);
        match lod {
            Lod::Range(lod) => Self::Range {
                far_dist_m: finite(lod.far_dist()),
                dist_factor: lod.dist_factor(),
                levels: lod.level_count(),
                error_px,
            },
            Lod::Error(lod) => Self::Error {
                max_error_px: lod.max_error_px(),
                error_px,
            },
            Lod::Budget(lod) => Self::Budget {
                max_objects: lod.max_objects(),
                error_px,
            },
        }
    }
}

/// The pixels alone.
#[derive(Debug)]
struct Pixels<'a>(&'a [(u32, u32)]);

impl Serialize for Pixels<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(self.0.iter().map(|(_, pixels)| pixels))
    }
}

/// Each as `[level, x, y, [fan, …]]`.
#[derive(Debug)]
struct Patches<'a>(&'a [Patch]);

impl Serialize for Patches<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(
            self.0
                .iter()
                .map(|Patch { tile, fans }| (tile.level, tile.x, tile.y, fans)),
        )
    }
}

fn finite(number: f64) -> Option<f64> {
    number.is_finite().then_some(number)
}

fn took_us<T>(ran: &Ran<T>) -> f64 {
    us(ran.took)
}

fn us(duration: Duration) -> f64 {
    duration.as_nanos() as f64 / 1000.0
}
