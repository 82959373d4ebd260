//! `EXT_mesh_gpu_instancing`: one node, many copies of its mesh.

use glam::{DMat4, DQuat};

use super::accessor::{Content, Reader, Values};
use super::document::Instancing;
use super::graph::composed;
use crate::import::ImportError;

/// Where the copies lie relative to their node.
pub(super) struct Instances<'a> {
    pub(super) count: usize,
    translation: Option<Values<'a>>,
    rotation: Option<Values<'a>>,
    scale: Option<Values<'a>>,
}

impl<'a> Instances<'a> {
    /// `None` where the bytes are missing or compressed.
    pub(super) fn open(
        reader: &Reader<'a>,
        instancing: &Instancing,
        node: usize,
    ) -> Result<Option<Self>, ImportError> {
        let mut found = [None, None, None];
        let mut count = None;
        let kinds = [
            ("TRANSLATION", "VEC3"),
            ("ROTATION", "VEC4"),
            ("SCALE", "VEC3"),
        ];
        for ((name, shape), slot) in kinds.into_iter().zip(&mut found) {
            let Some(&accessor) = instancing.attributes.get(name) else {
                continue;
            };
            let place =
                || format!("/nodes/{node}/extensions/EXT_mesh_gpu_instancing/attributes/{name}");
            let Content::Values(values) = reader.values(accessor, shape, &place)? else {
                return Ok(None);
            };
            let expected = *count.get_or_insert(values.count);
            if values.count != expected {
                let reason = format!("{} values for {expected} instances", values.count);
                return reader.fail(place(), reason);
            }
            *slot = Some(values);
        }
        let [translation, rotation, scale] = found;
        Ok(Some(Self {
            // Attributes of the user's own do not move anything: a single copy.
            count: count.unwrap_or(1),
            translation,
            rotation,
            scale,
        }))
    }

    /// `None` where the rotation of this copy is none.
    pub(super) fn transform(&self, index: usize) -> Option<DMat4> {
        let translation = self.translation.as_ref();
        let rotation = self.rotation.as_ref();
        let scale = self.scale.as_ref();
        composed(
            translation.map_or([0.0; 3], |v| v.vector(index)),
            rotation.map_or(DQuat::IDENTITY, |v| DQuat::from_array(v.vector(index))),
            scale.map_or([1.0; 3], |v| v.vector(index)),
        )
    }
}
