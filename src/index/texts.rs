//! Texts of objects, laid end to end.

use super::MAX_FAN_OUT;
use super::hierarchy::Canonical;
use crate::scene::SceneObject;

/// Bytes of an object's id as a JSON string with a comma.
pub(super) fn id_length(object: &SceneObject) -> usize {
    match escaped(&object.id) {
        None => object.id.len() + 3,
        Some(escaped) => escaped.len() + 1,
    }
}

/// Writes exactly [`id_length`] bytes.
pub(super) fn write_id(object: &SceneObject, out: &mut [u8]) {
    // As long as the id with quotes and comma: nothing of it is escaped.
    if out.len() == object.id.len() + 3 {
        if let [open, inner @ .., close, comma] = out {
            (*open, *close, *comma) = (b'"', b'"', b',');
            inner.copy_from_slice(object.id.as_bytes());
        }
    } else if let (Some((comma, text)), Some(escaped)) = (out.split_last_mut(), escaped(&object.id))
    {
        *comma = b',';
        text.copy_from_slice(escaped.as_bytes());
    }
}

/// Bytes of an object's attributes.
pub(super) fn attributes_length(object: &SceneObject) -> usize {
    object.attributes.as_ref().map_or(0, |raw| raw.get().len())
}

/// Writes exactly [`attributes_length`] bytes.
pub(super) fn write_attributes(object: &SceneObject, out: &mut [u8]) {
    if let Some(raw) = &object.attributes {
        out.copy_from_slice(raw.get().as_bytes());
    }
}

/// The id as a JSON string where it has something to escape.
fn escaped(id: &str) -> Option<String> {
    let plain = id.bytes().all(|b| b >= b' ' && b != b'"' && b != b'\\');
    (!plain).then(|| serde_json::Value::from(id).to_string())
}

/// A text for each object; nothing at all where all of them are empty.
pub(super) struct Texts {
    starts: Vec<u64>,
    bytes: Vec<u8>,
}

impl Texts {
    /// To be written: so many texts that take so many bytes.
    pub(super) fn zeroed(texts: usize, bytes: usize) -> Self {
        Self {
            starts: bytemuck::zeroed_vec(if bytes > 0 { texts + 1 } else { 0 }),
            bytes: bytemuck::zeroed_vec(bytes),
        }
    }

    pub(super) fn all_mut(&mut self) -> TextsMut<'_> {
        TextsMut::new(&mut self.starts, &mut self.bytes)
    }

    /// The text of an object.
    fn of(&self, object: Canonical) -> &[u8] {
        let starts = self.starts.get(object as usize..);
        match starts.and_then(|starts| starts.first_chunk()) {
            Some(&[start, end]) => &self.bytes[start as usize..end as usize],
            None => &[],
        }
    }

    /// Bytes of the texts of some objects.
    pub(super) fn length_of(&self, objects: &[Canonical]) -> usize {
        if self.bytes.is_empty() {
            return 0;
        }
        objects.iter().map(|&object| self.of(object).len()).sum()
    }

    /// All of them, end to end.
    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

/// Texts still to be written one after another, and where each begins in the whole.
pub(super) struct TextsMut<'a> {
    starts: &'a mut [u64],
    bytes: &'a mut [u8],
    begin: u64,
}

impl<'a> TextsMut<'a> {
    /// `starts` has one number more than there are texts, or none.
    pub(super) fn new(starts: &'a mut [u64], bytes: &'a mut [u8]) -> Self {
        Self {
            starts,
            bytes,
            begin: 0,
        }
    }

    /// The first so many, which take so many bytes.
    pub(super) fn split_off(&mut self, texts: usize, bytes: usize) -> TextsMut<'a> {
        let texts = texts.min(self.starts.len());
        let (starts, later_starts) = std::mem::take(&mut self.starts).split_at_mut(texts);
        let (now, later) = std::mem::take(&mut self.bytes).split_at_mut(bytes);
        let begin = self.begin;
        *self = Self {
            starts: later_starts,
            bytes: later,
            begin: begin + bytes as u64,
        };
        TextsMut {
            starts,
            bytes: now,
            begin,
        }
    }

    /// The next one, of so many bytes.
    pub(super) fn write(&mut self, length: usize, text: impl FnOnce(&mut [u8])) {
        if !self.starts.is_empty() {
            let one = self.split_off(1, length);
            one.starts[0] = one.begin;
            text(one.bytes);
        }
    }

    /// The next ones, as a few objects have them. Misses of the caches wait side by side, as in
    /// [`super::rows::Rows::of`].
    pub(super) fn copy(&mut self, texts: &Texts, objects: &[Canonical]) {
        if self.starts.is_empty() {
            return;
        }
        for objects in objects.chunks(MAX_FAN_OUT) {
            let mut found: [&[u8]; MAX_FAN_OUT] = [&[]; MAX_FAN_OUT];
            for (text, &object) in found.iter_mut().zip(objects) {
                *text = texts.of(object);
            }
            for text in &found[..objects.len()] {
                self.write(text.len(), |out| out.copy_from_slice(text));
            }
        }
    }

    /// After the last one: where they end.
    pub(super) fn finish(self) {
        if let [end] = self.starts {
            *end = self.begin;
        }
    }
}
