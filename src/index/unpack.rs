//! From a packed tree back to the scene it holds.

use serde_json::value::RawValue;

use super::LodTree;
use crate::scene::{Scene, SceneObject};

impl LodTree {
    /// The city as it was given, its objects in the order of their numbers here.
    ///
    /// Law: [`build`](super::build) makes a tree of it that holds the same; the same to the bit
    /// where this one was built so.
    pub fn scene(&self) -> Scene {
        let objects = (0..self.object_count()).filter_map(|number| {
            let object = self.object(number)?;
            let attributes = object.attributes.map(ToOwned::to_owned);
            Some(SceneObject {
                id: object.id.into(),
                class: object.class.into(),
                bounds: object.bounds,
                footprint_area: object.footprint_area,
                triangles: object.triangles,
                base_known: object.base_known,
                lift_m: object.lift_m,
                // Of a file that was not verified, what is no JSON is left out.
                attributes: attributes.and_then(|text| RawValue::from_string(text).ok()),
            })
        });
        Scene {
            crs: self.crs().map(ToOwned::to_owned),
            effects: *self.effects(),
            objects: objects.collect(),
        }
    }
}
