//! What is asked: a camera, the knobs, the form of the answer. As JSON, or (`query`) as
//! parameters of the same names.

use serde::{Deserialize, Deserializer};

use super::super::json::{List, Whole, given, keyword, object};
pub use super::effects::Effects;
use super::feedback::Feedback;
use crate::frame::Culling;
use crate::lod::Beyond;

/// A whole request; `Body` reads it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    #[serde(deserialize_with = "object")]
    pub camera: Camera,
    #[serde(default, deserialize_with = "object")]
    pub lod: Lod,
    #[serde(default)]
    pub effects: Effects,
    #[serde(default, deserialize_with = "feedback")]
    pub feedback: Option<Feedback>,
    #[serde(default, deserialize_with = "object")]
    pub output: Output,
}

fn feedback<'de, D: Deserializer<'de>>(source: D) -> Result<Option<Feedback>, D::Error> {
    object(source).map(Some)
}

/// A request as a JSON object.
#[derive(Debug)]
pub struct Body(pub Request);

impl<'de> Deserialize<'de> for Body {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        object(source).map(Self)
    }
}

/// The camera as it was given: alternatives are sorted out by [`Camera::view`].
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    pub eye: List<f64, 3>,
    #[serde(default, deserialize_with = "given")]
    pub target: Option<List<f64, 3>>,
    #[serde(default, deserialize_with = "given")]
    pub up: Option<List<f64, 3>>,
    #[serde(default, deserialize_with = "given")]
    pub quaternion: Option<List<f64, 4>>,
    #[serde(default, deserialize_with = "given")]
    pub fov_y_deg: Option<f64>,
    #[serde(default, deserialize_with = "given")]
    pub orthographic_height_m: Option<f64>,
    #[serde(default, deserialize_with = "given")]
    pub off_axis: Option<List<f64, 4>>,
    #[serde(default, deserialize_with = "given")]
    pub view_projection: Option<List<f64, 16>>,
    #[serde(default, deserialize_with = "given")]
    pub viewport: Option<List<Whole, 2>>,
    #[serde(default, deserialize_with = "given")]
    pub near: Option<f64>,
    /// `Some(None)` was given as null.
    #[serde(default, deserialize_with = "given")]
    #[expect(
        clippy::option_option,
        reason = "null is a value, and beside a matrix even that is wrong"
    )]
    pub far: Option<Option<f64>>,
}

/// Knobs as they were given: what belongs to which mode is sorted out by [`Lod::knobs`].
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Lod {
    pub mode: Mode,
    /// `Some(None)` was given as null, which is infinite.
    #[serde(deserialize_with = "given")]
    #[expect(clippy::option_option, reason = "null is a value")]
    pub far_dist_m: Option<Option<f64>>,
    #[serde(deserialize_with = "given")]
    pub dist_factor: Option<f64>,
    #[serde(deserialize_with = "given")]
    pub levels: Option<Whole>,
    #[serde(deserialize_with = "beyond")]
    pub beyond: Option<Beyond>,
    #[serde(deserialize_with = "given")]
    pub max_error_px: Option<f64>,
    #[serde(deserialize_with = "given")]
    pub max_objects: Option<Whole>,
    #[serde(deserialize_with = "culling")]
    pub culling: Culling,
}

/// How objects are chosen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Mode {
    #[default]
    Range,
    Error,
    Budget,
}

impl Mode {
    pub const NAMES: [&'static str; 3] = ["range", "error", "budget"];
    pub const VALUES: [Self; 3] = [Self::Range, Self::Error, Self::Budget];

    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

impl<'de> Deserialize<'de> for Mode {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        keyword(source, &Self::NAMES, &Self::VALUES)
    }
}

pub const CULLING_NAMES: [&str; 2] = ["fast", "exact"];
pub const CULLING_VALUES: [Culling; 2] = [Culling::Fast, Culling::Exact];

fn culling<'de, D: Deserializer<'de>>(source: D) -> Result<Culling, D::Error> {
    keyword(source, &CULLING_NAMES, &CULLING_VALUES)
}

pub const BEYOND_NAMES: [&str; 2] = ["show", "hide"];
pub const BEYOND_VALUES: [Beyond; 2] = [Beyond::Show, Beyond::Hide];

fn beyond<'de, D: Deserializer<'de>>(source: D) -> Result<Option<Beyond>, D::Error> {
    keyword(source, &BEYOND_NAMES, &BEYOND_VALUES).map(Some)
}

/// What the answer lists.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Form {
    #[default]
    Ids,
    Objects,
    Ranges,
}

impl Form {
    pub const NAMES: [&'static str; 3] = ["ids", "objects", "ranges"];
    pub const VALUES: [Self; 3] = [Self::Ids, Self::Objects, Self::Ranges];
}

impl<'de> Deserialize<'de> for Form {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        keyword(source, &Self::NAMES, &Self::VALUES)
    }
}

#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    pub form: Form,
}
