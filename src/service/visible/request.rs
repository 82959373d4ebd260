//! What is asked: a camera, the knobs, the form of the answer. As JSON, or (`query`) as
//! parameters of the same names.

use std::fmt;

use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::super::json::{List, Whole, given, keyword, object};
use crate::lod::{Beyond, RangeLod};

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
    #[serde(default, deserialize_with = "object")]
    pub output: Output,
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

/// Knobs; `far_dist_m` = `None` is infinite.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Lod {
    pub mode: Mode,
    pub far_dist_m: Option<f64>,
    pub dist_factor: f64,
    pub levels: Whole,
    #[serde(deserialize_with = "beyond")]
    pub beyond: Beyond,
}

impl Default for Lod {
    fn default() -> Self {
        let knobs = RangeLod::default();
        Self {
            mode: Mode::Range,
            far_dist_m: Some(knobs.far_dist()).filter(|far| far.is_finite()),
            dist_factor: knobs.dist_factor(),
            levels: Whole(knobs.level_count()),
            beyond: knobs.beyond(),
        }
    }
}

/// How objects are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    Range,
}

impl Mode {
    pub const NAMES: [&'static str; 1] = ["range"];
    pub const VALUES: [Self; 1] = [Self::Range];
}

impl<'de> Deserialize<'de> for Mode {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        keyword(source, &Self::NAMES, &Self::VALUES)
    }
}

pub const BEYOND_NAMES: [&str; 2] = ["show", "hide"];
pub const BEYOND_VALUES: [Beyond; 2] = [Beyond::Show, Beyond::Hide];

fn beyond<'de, D: Deserializer<'de>>(source: D) -> Result<Beyond, D::Error> {
    keyword(source, &BEYOND_NAMES, &BEYOND_VALUES)
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

/// The effects asked for, by name.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Effects {
    pub names: Vec<String>,
}

impl<'de> Deserialize<'de> for Effects {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Names;
        impl<'de> Visitor<'de> for Names {
            type Value = Effects;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Effects, A::Error> {
                let mut names = Vec::new();
                while let Some((name, IgnoredAny)) = map.next_entry()? {
                    names.push(name);
                }
                Ok(Effects { names })
            }
        }
        source.deserialize_map(Names)
    }
}
