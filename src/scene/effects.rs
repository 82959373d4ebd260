use std::fmt;

use serde::{Deserialize, Serialize};

/// What a scene calls for beyond its objects. An effect that is not declared is not computed and
/// costs nothing; a frame may switch a declared one off, not an undeclared one on.
///
/// As JSON, each member may be left out:
///
/// ```json
/// { "motion": { "reference_speed_mps": 10 },
///   "haze": { "visibility_m": 3000 },
///   "occlusion": { "width_px": 512, "min_pixels": 1 },
///   "terrain": { "criterion": "error", "max_error_px": 1.5, "max_triangles": 100000 } }
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Effects {
    /// Less detail at speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
    /// Nothing beyond the visibility range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub haze: Option<Haze>,
    /// Nothing that is hidden behind nearer objects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub occlusion: Option<Occlusion>,
    /// The ground beside the objects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub terrain: Option<Terrain>,
}

/// How detail falls with the camera's speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Speed up to which detail is full, m/s, > 0; at twice the speed it is half.
    #[serde(default = "Motion::walking")]
    pub reference_speed_mps: f64,
}

impl Motion {
    fn walking() -> f64 {
        1.5
    }
}

/// How far one sees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Haze {
    /// Nothing whose nearest point lies beyond this is drawn, m, > 0.
    pub visibility_m: f64,
}

/// How finely it is found out what hides what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Occlusion {
    /// Width of the id-buffer, 16 to 4096 pixels; its height follows from the viewport. Finer
    /// finds more small objects and takes longer.
    #[serde(default = "Occlusion::usual_width")]
    pub width_px: u32,
    /// Objects that cover fewer pixels of the id-buffer are taken for hidden, at least 1.
    #[serde(default = "Occlusion::one")]
    pub min_pixels: u32,
}

impl Occlusion {
    /// Narrowest and widest id-buffer, pixels.
    pub const WIDTHS_PX: std::ops::RangeInclusive<u32> = 16..=4096;

    fn usual_width() -> u32 {
        512
    }

    fn one() -> u32 {
        1
    }
}

/// How finely the ground is drawn, and which ground it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Terrain {
    /// Which paper decides what is drawn in parts.
    #[serde(default)]
    pub criterion: Criterion,
    /// No post is drawn farther above or below its place than this on the screen, pixels, > 0,
    /// unless triangles run out. Counted as sizes of objects are: an error times the pixels per
    /// radian in the middle of the picture, by the distance to the nearest point of its box; off
    /// the axis a picture shows it larger.
    #[serde(default = "Terrain::usual_error")]
    pub max_error_px: f64,
    /// Most triangles, at least 1; two for each block in view and what holes need are always drawn.
    #[serde(default = "Terrain::usual_triangles")]
    pub max_triangles: u32,
    /// The ground that was laid under this city: the checksum of its file. None while there is
    /// none yet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground: Option<u32>,
}

/// The criteria of four papers ([`crate::terrain::Criterion`]).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Criterion {
    /// A: distance against roughness.
    Roughness,
    /// B: distance against the largest error.
    #[default]
    Error,
    /// C: spread of heights against distance and speed.
    Motion,
    /// D: vertex error against the largest coordinate difference.
    Vertex,
}

impl Criterion {
    /// What they are called, in the order of the papers.
    pub const NAMES: [&'static str; 4] = ["roughness", "error", "motion", "vertex"];
    /// All of them, likewise.
    pub const VALUES: [Self; 4] = [Self::Roughness, Self::Error, Self::Motion, Self::Vertex];
}

impl Terrain {
    fn usual_error() -> f64 {
        1.5
    }

    fn usual_triangles() -> u32 {
        100_000
    }
}

impl Default for Terrain {
    fn default() -> Self {
        Self {
            criterion: Criterion::default(),
            max_error_px: Self::usual_error(),
            max_triangles: Self::usual_triangles(),
            ground: None,
        }
    }
}

/// A declaration of effects that cannot be: where it is wrong, and why.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct EffectsError {
    /// JSON pointer, where the document can be read as JSON of the right shape.
    pub pointer: Option<&'static str>,
    /// What is wrong there.
    pub reason: String,
}

impl fmt::Display for EffectsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.pointer {
            Some(pointer) => write!(f, "{pointer}: {}", self.reason),
            None => f.write_str(&self.reason),
        }
    }
}

impl Effects {
    /// Whether none is declared.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Reads a declaration.
    ///
    /// # Errors
    /// [`EffectsError`] with line and column of what is no such document, or the pointer of a
    /// value that cannot be.
    pub fn from_json(text: &str) -> Result<Self, EffectsError> {
        let effects: Self = serde_json::from_str(text).map_err(|error| EffectsError {
            pointer: None,
            reason: error.to_string(),
        })?;
        effects.check()?;
        Ok(effects)
    }

    /// That all values can be.
    ///
    /// # Errors
    /// [`EffectsError`] for the first that cannot.
    pub fn check(&self) -> Result<(), EffectsError> {
        let positive = |pointer, value: f64| {
            let reason = || format!("must be a finite number above 0, is {value}");
            refuse_unless(value > 0.0 && value.is_finite(), pointer, reason)
        };
        if let Some(motion) = &self.motion {
            positive("/motion/reference_speed_mps", motion.reference_speed_mps)?;
        }
        if let Some(haze) = &self.haze {
            positive("/haze/visibility_m", haze.visibility_m)?;
        }
        if let Some(occlusion) = &self.occlusion {
            let width = occlusion.width_px;
            refuse_unless(
                Occlusion::WIDTHS_PX.contains(&width),
                "/occlusion/width_px",
                || format!("must be 16 to 4096 pixels, is {width}"),
            )?;
            refuse_unless(occlusion.min_pixels > 0, "/occlusion/min_pixels", || {
                "must be at least 1".into()
            })?;
        }
        if let Some(terrain) = &self.terrain {
            positive("/terrain/max_error_px", terrain.max_error_px)?;
            refuse_unless(terrain.max_triangles > 0, "/terrain/max_triangles", || {
                "must be at least 1".into()
            })?;
        }
        Ok(())
    }
}

fn refuse_unless(
    holds: bool,
    pointer: &'static str,
    reason: impl FnOnce() -> String,
) -> Result<(), EffectsError> {
    if holds {
        return Ok(());
    }
    Err(EffectsError {
        pointer: Some(pointer),
        reason: reason(),
    })
}
