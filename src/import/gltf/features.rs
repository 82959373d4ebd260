//! `EXT_mesh_features`: which vertices of a primitive belong together.

use super::accessor::{Content, Reader, Values};
use super::document::{FeatureIds, Primitive};
use super::mesh::At;
use crate::import::ImportError;

/// Feature of a property table, or of the mesh where there is no table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Feature {
    pub(super) table: Option<usize>,
    pub(super) id: u64,
}

/// How the vertices of a primitive are told apart.
pub(super) enum Split<'a> {
    No,
    Attribute(Values<'a>, &'a FeatureIds),
    Implicit(&'a FeatureIds),
}

impl<'a> Split<'a> {
    #[inline]
    pub(super) fn feature(&self, vertex: usize) -> Option<Feature> {
        let (id, ids) = match self {
            Self::No => return None,
            Self::Implicit(ids) => (vertex as u64, ids),
            Self::Attribute(values, ids) => {
                let id = values.value(vertex, 0).round();
                // NaN and negative numbers are no features.
                (id >= 0.0).then_some((id as u64, ids))?
            }
        };
        (ids.null_feature_id != Some(id)).then_some(Feature {
            table: ids.property_table,
            id,
        })
    }

    /// How `EXT_mesh_features` tells the vertices apart: by the first set of ids that can be read,
    /// one with a property table if there is any.
    /// Beside it, what could not be read of the ids.
    pub(super) fn of(
        reader: &Reader<'a>,
        primitive: &'a Primitive,
        vertices: usize,
        at: At,
    ) -> Result<(Self, Option<&'static str>), ImportError> {
        let Some(features) = &primitive.extensions.features else {
            return Ok((Self::No, None));
        };
        let sets = || {
            features
                .feature_ids
                .iter()
                .filter(|ids| ids.texture.is_none())
        };
        let found = sets()
            .find(|ids| ids.property_table.is_some())
            .or_else(|| sets().next());
        let Some(ids) = found else {
            const TEXTURE: &str =
                "its feature ids are in a texture, which is not read; taken as one object";
            return Ok((
                Self::No,
                (!features.feature_ids.is_empty()).then_some(TEXTURE),
            ));
        };
        let Some(number) = ids.attribute else {
            return Ok((Self::Implicit(ids), None));
        };
        let name = format!("_FEATURE_ID_{number}");
        let Some(&accessor) = primitive.attributes.get(name.as_str()) else {
            let place = at.field("/extensions/EXT_mesh_features/featureIds");
            return reader.fail(place, format!("the primitive has no attribute {name}"));
        };
        let asked_by = || at.field(&format!("/attributes/{name}"));
        match reader.values(accessor, "SCALAR", &asked_by)? {
            Content::Values(values) if values.count < vertices => {
                let reason = format!("{} feature ids for {vertices} vertices", values.count);
                reader.fail(format!("/accessors/{accessor}/count"), reason)
            }
            Content::Values(values) => Ok((Self::Attribute(values, ids), None)),
            Content::Missing => {
                const MISSING: &str = "its feature ids cannot be read; taken as one object";
                Ok((Self::No, Some(MISSING)))
            }
        }
    }
}
