//! Texts of objects, laid end to end.

use rayon::prelude::*;

use super::hierarchy::Canonical;
use crate::scene::SceneObject;

/// What an object says, as the bytes that are stored.
pub(super) trait Text: Sync {
    fn length(&self, object: &SceneObject) -> usize;
    /// Writes exactly `length` bytes.
    fn write(&self, object: &SceneObject, out: &mut [u8]);
}

/// The id as a JSON string with a comma.
pub(super) struct Id;

/// The attributes as they are.
pub(super) struct Attributes;

impl Text for Id {
    fn length(&self, object: &SceneObject) -> usize {
        match escaped(&object.id) {
            None => object.id.len() + 3,
            Some(escaped) => escaped.len() + 1,
        }
    }

    fn write(&self, object: &SceneObject, out: &mut [u8]) {
        // As long as the id with quotes and comma: nothing of it was escaped.
        if out.len() == object.id.len() + 3 {
            if let [open, inner @ .., close, comma] = out {
                (*open, *close, *comma) = (b'"', b'"', b',');
                inner.copy_from_slice(object.id.as_bytes());
            }
        } else if let (Some((comma, text)), Some(escaped)) =
            (out.split_last_mut(), escaped(&object.id))
        {
            *comma = b',';
            text.copy_from_slice(escaped.as_bytes());
        }
    }
}

impl Text for Attributes {
    fn length(&self, object: &SceneObject) -> usize {
        object.attributes.as_ref().map_or(0, |raw| raw.get().len())
    }

    fn write(&self, object: &SceneObject, out: &mut [u8]) {
        if let Some(raw) = &object.attributes {
            out.copy_from_slice(raw.get().as_bytes());
        }
    }
}

/// The id as a JSON string where it has something to escape.
fn escaped(id: &str) -> Option<String> {
    let plain = id.bytes().all(|b| b >= b' ' && b != b'"' && b != b'\\');
    (!plain).then(|| serde_json::Value::from(id).to_string())
}

/// Bytes that the text of each object takes.
pub(super) struct Lengths {
    /// In canonical order; empty where no object says anything.
    each: Vec<usize>,
    total: usize,
}

impl Lengths {
    /// `objects` are in canonical order.
    pub(super) fn new(objects: &[&SceneObject], text: &impl Text) -> Self {
        let lengths = objects.par_iter().map(|object| text.length(object));
        let each: Vec<usize> = lengths.collect();
        let total = each.par_iter().sum();
        Self {
            each: if total > 0 { each } else { vec![] },
            total,
        }
    }

    pub(super) fn of(&self, object: Canonical) -> usize {
        self.each.get(object as usize).copied().unwrap_or(0)
    }

    pub(super) fn of_all(&self, objects: &[Canonical]) -> usize {
        if self.total == 0 {
            return 0;
        }
        objects.iter().map(|&object| self.of(object)).sum()
    }

    pub(super) fn total(&self) -> usize {
        self.total
    }
}
