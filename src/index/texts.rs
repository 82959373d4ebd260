//! Texts of objects, laid end to end.

use rayon::prelude::*;

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
        if let Some((comma, text)) = out.split_last_mut() {
            *comma = b',';
            if let Some(escaped) = escaped(&object.id) {
                text.copy_from_slice(escaped.as_bytes());
            } else if let [open, inner @ .., close] = text {
                (*open, *close) = (b'"', b'"');
                inner.copy_from_slice(object.id.as_bytes());
            }
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

/// First byte of each object's text, then the length of all.
pub(super) fn starts(objects: &[&SceneObject], text: &impl Text) -> Vec<u64> {
    let lengths: Vec<u64> = objects
        .par_iter()
        .map(|object| text.length(object) as u64)
        .collect();
    let mut starts = Vec::with_capacity(lengths.len() + 1);
    let mut end = 0;
    starts.push(0);
    for length in lengths {
        end += length;
        starts.push(end);
    }
    starts
}

/// Writes the texts of all objects to where they start.
pub(super) fn write(objects: &[&SceneObject], text: &impl Text, starts: &[u64], out: &mut [u8]) {
    const PIECE: usize = 4096;
    let mut rest = out;
    let mut pieces = Vec::new();
    for from in (0..objects.len()).step_by(PIECE) {
        let to = (from + PIECE).min(objects.len());
        let (piece, after) = rest.split_at_mut((starts[to] - starts[from]) as usize);
        pieces.push((from..to, piece));
        rest = after;
    }
    pieces.into_par_iter().for_each(|(range, out)| {
        let first = starts[range.start];
        for at in range {
            let slot = (starts[at] - first) as usize..(starts[at + 1] - first) as usize;
            text.write(objects[at], &mut out[slot]);
        }
    });
}
