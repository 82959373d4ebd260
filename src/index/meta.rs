//! What is kept of a scene as a whole.

use std::collections::BTreeSet;

use compact_str::CompactString;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::hierarchy::Canonical;
use crate::scene::{Effects, Scene, SceneObject};

/// Objects that are looked at together.
const PIECE: usize = 4096;

/// The `meta` section.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Meta {
    crs: Option<String>,
    #[serde(default, skip_serializing_if = "Effects::is_empty")]
    effects: Effects,
    /// Sorted.
    classes: Vec<CompactString>,
    /// Objects whose base is not known: ranges of their numbers, in order, with gaps between.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    base_unknown: Vec<[u32; 2]>,
}

impl Meta {
    /// What a scene says of itself, without what its objects say.
    pub(super) fn of(scene: &Scene) -> Self {
        Self {
            crs: scene.crs.clone(),
            effects: scene.effects,
            ..Self::default()
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

    /// The same with what is known of bases: of each object in canonical order, of none where all
    /// are known. `order` is that of the file.
    pub(super) fn with_bases(self, known: &[bool], order: &[Canonical]) -> Self {
        let base_unknown = if known.is_empty() {
            Vec::new()
        } else {
            base_unknown(known, order)
        };
        Self {
            base_unknown,
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

    /// Whether the source says how high an object stands.
    pub(super) fn base_known(&self, object: u32) -> bool {
        let after = self
            .base_unknown
            .partition_point(|&[start, _]| start <= object);
        let before = after.checked_sub(1).map(|at| self.base_unknown[at]);
        before.is_none_or(|[_, end]| object >= end)
    }

    /// Of how many objects the base is not known.
    pub(super) fn base_unknown_count(&self) -> u32 {
        let ranges = self.base_unknown.iter();
        ranges.map(|[start, end]| end - start).sum()
    }

    /// Reads the section of a file of so many objects; what it says can be relied on. Errors say
    /// what is wrong.
    pub(super) fn from_json(bytes: &[u8], objects: u32) -> Result<Self, String> {
        let meta: Self = serde_json::from_slice(bytes).map_err(|e| e.to_string())?;
        let effects = meta.effects.check();
        effects.map_err(|e| format!("effects: {e}"))?;
        if !meta.classes.is_sorted_by(|a, b| a < b) {
            return Err("classes: not in order".into());
        }
        let bounds = meta.base_unknown.as_flattened();
        if !bounds.is_sorted_by(|a, b| a < b) || bounds.last().is_some_and(|&end| end > objects) {
            return Err("base_unknown: not ranges of objects".into());
        }
        Ok(meta)
    }

    pub(super) fn to_json(&self) -> Vec<u8> {
        serde_json::to_vec(self).unwrap_or_default()
    }
}

/// Of which objects the base is not known: ranges of their places in the file, in order, with gaps
/// between.
fn base_unknown(known: &[bool], order: &[Canonical]) -> Vec<[u32; 2]> {
    let mut ranges: Vec<[u32; 2]> = Vec::new();
    let places = (0_u32..).zip(order);
    for (place, _) in places.filter(|(_, key)| !known[**key as usize]) {
        match ranges.last_mut() {
            Some([_, end]) if *end == place => *end += 1,
            _ => ranges.push([place, place + 1]),
        }
    }
    ranges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_unknown_bases_are_found_and_read_with_suspicion() {
        let read = |ranges: &str, objects| {
            let text = format!(r#"{{"crs":null,"classes":[],"base_unknown":{ranges}}}"#);
            Meta::from_json(text.as_bytes(), objects)
        };
        let meta = read("[[0,2],[5,6],[9,12]]", 12).expect("ranges");
        let unknown = (0..14).filter(|&object| !meta.base_known(object));
        assert!(unknown.eq([0, 1, 5, 9, 10, 11]));
        assert_eq!(meta.base_unknown_count(), 6);
        for (ranges, objects) in [
            ("[[0,2],[5,6],[9,12]]", 11),
            ("[[2,2]]", 9),
            ("[[3,2]]", 9),
            ("[[0,2],[2,4]]", 9),
            ("[[4,6],[1,2]]", 9),
        ] {
            let refused = read(ranges, objects).expect_err(ranges);
            assert!(refused.contains("base_unknown"), "{refused}");
        }
    }

    /// Files from before it was kept say nothing of it.
    #[test]
    fn without_a_word_every_base_is_known() {
        let meta =
            Meta::from_json(br#"{"crs":null,"classes":["Building"]}"#, 3).expect("a section");
        assert_eq!(meta.base_unknown_count(), 0);
        assert!((0..3).all(|object| meta.base_known(object)));
    }
}
