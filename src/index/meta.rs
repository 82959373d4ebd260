//! What is kept of a scene as a whole.

use std::collections::BTreeSet;

use compact_str::CompactString;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::scene::{Effects, Scene, SceneObject};

/// Objects whose classes are collected together.
const PIECE: usize = 4096;

/// The `meta` section.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Meta {
    crs: Option<String>,
    #[serde(default, skip_serializing_if = "Effects::is_empty")]
    effects: Effects,
    /// Sorted.
    classes: Vec<CompactString>,
}

impl Meta {
    /// What a scene says of itself, without its classes.
    pub(super) fn of(scene: &Scene) -> Self {
        Self {
            crs: scene.crs.clone(),
            effects: scene.effects,
            classes: vec![],
        }
    }

    /// The same with the classes of all objects.
    pub(super) fn with_classes(self, objects: &[&SceneObject]) -> Self {
        let classes = objects
            .par_chunks(PIECE)
            .map(|objects| {
                // Neighbours are mostly of one kind.
                let kinds = objects.chunk_by(|a, b| a.class == b.class);
                kinds.map(|kind| kind[0].class.clone()).collect()
            })
            .reduce(
                BTreeSet::new,
                |mut all, mut more: BTreeSet<CompactString>| {
                    all.append(&mut more);
                    all
                },
            );
        Self {
            classes: classes.into_iter().collect(),
            ..self
        }
    }

    /// The same scene with other effects.
    pub(super) fn declaring(&self, effects: Effects) -> Self {
        Self {
            effects,
            ..self.clone()
        }
    }

    pub(super) fn crs(&self) -> Option<&str> {
        self.crs.as_deref()
    }

    pub(super) fn effects(&self) -> &Effects {
        &self.effects
    }

    pub(super) fn classes(&self) -> &[CompactString] {
        &self.classes
    }

    pub(super) fn class_number(&self, class: &CompactString) -> u32 {
        self.classes.partition_point(|c| c < class) as u32
    }

    /// Reads the section; what it says can be relied on. Errors say what is wrong.
    pub(super) fn from_json(bytes: &[u8]) -> Result<Self, String> {
        let meta: Self = serde_json::from_slice(bytes).map_err(|e| e.to_string())?;
        let effects = meta.effects.check();
        effects.map_err(|e| format!("effects: {e}"))?;
        Ok(meta)
    }

    pub(super) fn to_json(&self) -> Vec<u8> {
        serde_json::to_vec(self).unwrap_or_default()
    }
}
