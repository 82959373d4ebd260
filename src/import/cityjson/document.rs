use std::borrow::Cow;
use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;

use crate::geom::DVec3;
use crate::import::json::reason;

/// Where in a document, and what is wrong there.
pub(super) type Fault<P = String> = (P, String);

/// A `CityJSON` document or a `CityJSONFeature`, its parts still text.
#[derive(Deserialize)]
pub(super) struct Document<'a> {
    #[serde(rename = "type", borrow)]
    pub(super) kind: Option<Cow<'a, str>>,
    #[serde(borrow)]
    pub(super) version: Option<Cow<'a, str>>,
    #[serde(borrow)]
    pub(super) transform: Option<&'a RawValue>,
    #[serde(borrow)]
    metadata: Option<&'a RawValue>,
    #[serde(rename = "CityObjects", borrow)]
    pub(super) city_objects: Option<Entries<'a>>,
    #[serde(borrow)]
    pub(super) vertices: Option<&'a RawValue>,
    #[serde(rename = "geometry-templates", borrow)]
    pub(super) templates: Option<&'a RawValue>,
}

impl Document<'_> {
    /// Of the metadata; `None` where there is none or it is no string.
    pub(super) fn reference_system(&self) -> Option<String> {
        #[derive(Deserialize)]
        struct Metadata {
            #[serde(rename = "referenceSystem")]
            reference_system: Option<String>,
        }
        let metadata: Metadata = serde_json::from_str(self.metadata?.get()).ok()?;
        metadata.reference_system.filter(|name| !name.is_empty())
    }
}

/// The members of an object in document order, each kept, also where a key comes twice.
pub(super) struct Entries<'a>(pub(super) Vec<(Cow<'a, str>, &'a RawValue)>);

/// A key, borrowed where it has no escapes.
#[derive(Deserialize)]
struct Key<'a>(#[serde(borrow)] Cow<'a, str>);

impl<'de: 'a, 'a> Deserialize<'de> for Entries<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Members;
        impl<'de> Visitor<'de> for Members {
            type Value = Entries<'de>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Entries<'de>, M::Error> {
                let mut entries = Vec::new();
                while let Some((Key(key), value)) = map.next_entry()? {
                    entries.push((key, value));
                }
                Ok(Entries(entries))
            }
        }
        deserializer.deserialize_map(Members)
    }
}

/// From the integers of `vertices` to metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Transform {
    scale: DVec3,
    translate: DVec3,
}

impl Transform {
    /// Of the document's `transform`, which `CityJSON` 1.0 leaves to choice.
    pub(super) fn read(
        text: Option<&RawValue>,
        optional: bool,
    ) -> Result<Self, Fault<&'static str>> {
        #[derive(Deserialize)]
        struct Raw {
            scale: [f64; 3],
            translate: [f64; 3],
        }
        let Some(text) = text else {
            return if optional {
                Ok(Self {
                    scale: DVec3::ONE,
                    translate: DVec3::ZERO,
                })
            } else {
                Err((
                    "/transform",
                    "is missing; CityJSON 1.1 and later require it".into(),
                ))
            };
        };
        let raw: Raw = serde_json::from_str(text.get()).map_err(|e| ("/transform", reason(&e)))?;
        let scale = DVec3::from_array(raw.scale);
        if scale.cmpeq(DVec3::ZERO).any() {
            let reason = format!("{scale} has a zero, which would make the city flat");
            return Err(("/transform/scale", reason));
        }
        Ok(Self {
            scale,
            translate: DVec3::from_array(raw.translate),
        })
    }

    pub(super) fn apply(&self, vertex: DVec3) -> DVec3 {
        vertex * self.scale + self.translate
    }
}
