//! All that is kept of each object, in canonical order.
//!
//! Objects of a scene lie all over the memory. A tree looks at each several times in an order of
//! its own, so they are first read once, one after another, into as little memory as they need.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::MAX_FAN_OUT;
use super::hierarchy::Canonical;
use super::meta::Meta;
use super::texts::{self, Texts};
use crate::geom::Aabb;
use crate::scene::SceneObject;

/// Objects that are read together.
const PIECE: usize = 4096;

/// An object but for its texts: one line of a cache.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Row {
    bounds: [f64; 6],
    pub(super) footprint_area: f64,
    pub(super) triangles: u32,
    /// Its place in the classes of the scene.
    pub(super) class: u32,
}

impl Row {
    fn of(object: &SceneObject, class: u32) -> Self {
        Self {
            bounds: object.bounds.to_array(),
            footprint_area: object.footprint_area,
            triangles: object.triangles,
            class,
        }
    }

    pub(super) fn bounds(&self) -> Aabb {
        // Comes from a box.
        Aabb::from_array(self.bounds).unwrap_or(Aabb::EMPTY)
    }
}

/// What is kept of all objects.
pub(super) struct Rows {
    each: Vec<Row>,
    /// Ids as JSON strings with commas.
    pub(super) ids: Texts,
    /// Attributes as they are; not even counted where no object has any.
    pub(super) attributes: Texts,
    /// Whether the source says how high each one stands; empty where it says so of all.
    pub(super) base_known: Vec<bool>,
    /// Those that begin above their ground, in order, and how far, m.
    pub(super) lifts: Vec<(Canonical, f64)>,
}

impl Rows {
    /// Of `objects`, which are in canonical order and whose classes `meta` knows.
    pub(super) fn new(objects: &[&SceneObject], meta: &Meta) -> Self {
        let lengths: Vec<[usize; 2]> = objects
            .par_chunks(PIECE)
            .map(|objects| {
                let total = |length: fn(&SceneObject) -> usize| {
                    objects.iter().map(|object| length(object)).sum()
                };
                [total(texts::id_length), total(texts::attributes_length)]
            })
            .collect();
        let total = |which: usize| lengths.iter().map(|lengths| lengths[which]).sum();
        let mut all = Self {
            each: bytemuck::zeroed_vec(objects.len()),
            ids: Texts::zeroed(objects.len(), total(0)),
            attributes: Texts::zeroed(objects.len(), total(1)),
            base_known: base_known(objects),
            lifts: lifts(objects),
        };
        let (mut ids, mut attributes) = (all.ids.all_mut(), all.attributes.all_mut());
        let pieces = objects.chunks(PIECE).zip(all.each.chunks_mut(PIECE));
        let pieces: Vec<_> = pieces
            .zip(&lengths)
            .map(|((objects, rows), &[id_bytes, attribute_bytes])| {
                let ids = ids.split_off(objects.len(), id_bytes);
                let attributes = attributes.split_off(objects.len(), attribute_bytes);
                (objects, rows, ids, attributes)
            })
            .collect();
        ids.finish();
        attributes.finish();
        pieces
            .into_par_iter()
            .for_each(|(objects, rows, mut ids, mut attributes)| {
                let mut class = (None, 0);
                for (object, row) in objects.iter().zip(rows) {
                    // Neighbours are mostly of one kind.
                    if class.0 != Some(&object.class) {
                        class = (Some(&object.class), meta.class_number(&object.class));
                    }
                    *row = Row::of(object, class.1);
                    let id = texts::id_length(object);
                    ids.write(id, |out| texts::write_id(object, out));
                    let length = texts::attributes_length(object);
                    attributes.write(length, |out| texts::write_attributes(object, out));
                }
            });
        all
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.each.len()
    }

    /// Those of a few objects. Each is most likely a miss of the caches: read one right after
    /// another, the misses wait side by side. Zeros behind the last.
    pub(super) fn of(&self, objects: &[Canonical]) -> [Row; MAX_FAN_OUT] {
        let mut rows = [Row::zeroed(); MAX_FAN_OUT];
        for (row, &object) in rows.iter_mut().zip(objects) {
            *row = self.each[object as usize];
        }
        rows
    }

    pub(super) fn all(&self) -> &[Row] {
        &self.each
    }
}

fn base_known(objects: &[&SceneObject]) -> Vec<bool> {
    let known = || objects.par_iter().map(|object| object.base_known);
    if known().all(|known| known) {
        Vec::new()
    } else {
        known().collect()
    }
}

fn lifts(objects: &[&SceneObject]) -> Vec<(Canonical, f64)> {
    let lifts = objects.par_iter().enumerate();
    let lifts = lifts.map(|(at, object)| (at as Canonical, object.lift_m));
    lifts
        .filter(|(_, lift_m)| *lift_m > 0.0 && lift_m.is_finite())
        .collect()
}
