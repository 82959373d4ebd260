//! What is kept of each object and of the objects of each node, written in one pass.
//!
//! Objects lie in memory as the scene has them and are stored in the order of the tree, so a look
//! at one mostly misses the caches: here each is looked at once, for all that is kept of it.

use std::ops::Range;

use compact_str::CompactString;
use rayon::prelude::*;

use super::blocks::{self, Blocks};
use super::file::{Block, Radii, Section};
use super::image::Sections;
use super::meta::Meta;
use super::outward::stored_radius;
use super::plan::Plan;
use super::texts::{Attributes, Id, Lengths, Text};
use crate::geom::DVec3;
use crate::scene::SceneObject;

/// Nodes that are written together.
const PIECE: usize = 1024;

/// What the columns are made from.
pub(super) struct Source<'a> {
    /// In canonical order.
    pub(super) objects: &'a [&'a SceneObject],
    pub(super) plan: &'a Plan,
    pub(super) own_blocks: &'a Blocks<'a>,
    pub(super) meta: &'a Meta,
    pub(super) ids: &'a Lengths,
    pub(super) attributes: &'a Lengths,
    /// What the boxes of blocks are relative to.
    pub(super) origin: DVec3,
}

/// Extreme radii of each node's own objects, m, rounded up.
pub(super) struct OwnRadii {
    /// 0 where there is none.
    pub(super) largest: Vec<f32>,
    /// Infinite where there is none.
    pub(super) least: Vec<f32>,
}

/// The columns of a run of nodes and of their own objects.
struct Columns<'a> {
    boxes: &'a mut [[f64; 6]],
    classes: &'a mut [u32],
    footprints: &'a mut [f64],
    triangles: &'a mut [u32],
    ids: Texts<'a>,
    attributes: Texts<'a>,
    blocks: &'a mut [Block],
    block_radii: &'a mut [Radii],
    largest: &'a mut [f32],
    least: &'a mut [f32],
}

/// Texts still to be written, and where each begins in the whole section.
struct Texts<'a> {
    starts: &'a mut [u64],
    bytes: &'a mut [u8],
    begin: u64,
}

impl<'a> Texts<'a> {
    fn split_off(&mut self, objects: usize, bytes: usize) -> Option<Texts<'a>> {
        // Texts that nobody has are not even counted.
        let objects = if self.starts.is_empty() { 0 } else { objects };
        let begin = self.begin;
        self.begin += bytes as u64;
        Some(Texts {
            starts: self.starts.split_off_mut(..objects)?,
            bytes: self.bytes.split_off_mut(..bytes)?,
            begin,
        })
    }

    fn write(&mut self, text: &impl Text, object: &SceneObject, length: usize) {
        if let Some(start) = self.starts.split_off_first_mut() {
            *start = self.begin;
            self.begin += length as u64;
            if let Some(bytes) = self.bytes.split_off_mut(..length) {
                text.write(object, bytes);
            }
        }
    }

    /// After the last one: where they end.
    fn finish(self) {
        if let [end] = self.starts {
            *end = self.begin;
        }
    }
}

/// Writes the sections that hold something of each object.
pub(super) fn fill(source: &Source, sections: &mut Sections) -> OwnRadii {
    let nodes = source.plan.own.len() - 1;
    let mut radii = OwnRadii {
        largest: vec![0.0; nodes],
        least: vec![f32::INFINITY; nodes],
    };
    let mut rest = Columns {
        boxes: sections.take(Section::ObjectBoxes),
        classes: sections.take(Section::Classes),
        footprints: sections.take(Section::Footprints),
        triangles: sections.take(Section::Triangles),
        ids: Texts {
            starts: sections.take(Section::IdStarts),
            bytes: sections.take(Section::Ids),
            begin: 0,
        },
        attributes: Texts {
            starts: sections.take(Section::AttributeStarts),
            bytes: sections.take(Section::Attributes),
            begin: 0,
        },
        blocks: sections.take(Section::OwnBlocks),
        block_radii: sections.take(Section::OwnRadii),
        largest: &mut radii.largest,
        least: &mut radii.least,
    };
    let pieces: Vec<Range<usize>> = (0..nodes)
        .step_by(PIECE)
        .map(|from| from..(from + PIECE).min(nodes))
        .collect();
    let lengths: Vec<[usize; 2]> = pieces
        .par_iter()
        .map(|nodes| source.text_lengths(nodes.clone()))
        .collect();
    let columns: Vec<_> = pieces
        .into_iter()
        .zip(lengths)
        .filter_map(|(nodes, lengths)| {
            let columns = rest.split_off(source, nodes.clone(), lengths)?;
            Some((nodes, columns))
        })
        .collect();
    rest.ids.finish();
    rest.attributes.finish();
    columns
        .into_par_iter()
        .for_each(|(nodes, columns)| columns.write(source, nodes));
    radii
}

impl Source<'_> {
    /// The objects that a run of nodes owns, by their places in the file.
    fn own(&self, nodes: Range<usize>) -> Range<usize> {
        self.plan.own[nodes.start] as usize..self.plan.own[nodes.end] as usize
    }

    /// Bytes that their ids and attributes take.
    fn text_lengths(&self, nodes: Range<usize>) -> [usize; 2] {
        let objects = &self.plan.order[self.own(nodes)];
        [self.ids, self.attributes].map(|lengths| lengths.of_all(objects))
    }
}

impl<'a> Columns<'a> {
    /// The first of the columns, as far as they belong to a run of nodes.
    fn split_off(
        &mut self,
        source: &Source,
        nodes: Range<usize>,
        [id_bytes, attribute_bytes]: [usize; 2],
    ) -> Option<Columns<'a>> {
        let objects = source.own(nodes.clone()).len();
        let starts = &source.own_blocks.starts;
        let blocks = (starts[nodes.end] - starts[nodes.start]) as usize;
        Some(Columns {
            boxes: self.boxes.split_off_mut(..objects)?,
            classes: self.classes.split_off_mut(..objects)?,
            footprints: self.footprints.split_off_mut(..objects)?,
            triangles: self.triangles.split_off_mut(..objects)?,
            ids: self.ids.split_off(objects, id_bytes)?,
            attributes: self.attributes.split_off(objects, attribute_bytes)?,
            blocks: self.blocks.split_off_mut(..blocks)?,
            block_radii: self.block_radii.split_off_mut(..blocks)?,
            largest: self.largest.split_off_mut(..nodes.len())?,
            least: self.least.split_off_mut(..nodes.len())?,
        })
    }

    fn write(mut self, source: &Source, nodes: Range<usize>) {
        let mut blocks = self.blocks.iter_mut().zip(self.block_radii.iter_mut());
        let mut classes = ClassNumbers::new(source.meta);
        let mut at = 0;
        for (node, extremes) in nodes.zip(self.largest.iter_mut().zip(self.least.iter_mut())) {
            let own = &source.plan.order[source.own(node..node + 1)];
            for (group, (block, radii)) in own.chunks(8).zip(&mut blocks) {
                let first = at;
                for (&key, radius) in group.iter().zip(radii.iter_mut()) {
                    let object = source.objects[key as usize];
                    self.boxes[at] = object.bounds.to_array();
                    self.classes[at] = classes.of(&object.class);
                    self.footprints[at] = object.footprint_area;
                    self.triangles[at] = object.triangles;
                    self.ids.write(&Id, object, source.ids.of(key));
                    let attributes = source.attributes.of(key);
                    self.attributes.write(&Attributes, object, attributes);
                    *radius = stored_radius(object.bounds.radius());
                    *extremes.0 = extremes.0.max(*radius);
                    *extremes.1 = extremes.1.min(*radius);
                    at += 1;
                }
                blocks::place(source.origin, &self.boxes[first..at], block);
            }
        }
    }
}

/// Numbers of classes; neighbours are mostly of one kind.
struct ClassNumbers<'a> {
    meta: &'a Meta,
    last: Option<(&'a CompactString, u32)>,
}

impl<'a> ClassNumbers<'a> {
    fn new(meta: &'a Meta) -> Self {
        Self { meta, last: None }
    }

    fn of(&mut self, class: &CompactString) -> u32 {
        match self.last {
            Some((name, number)) if name == class => number,
            _ => {
                let number = self.meta.class_number(class);
                let name = self.meta.classes().get(number as usize);
                self.last = name.map(|name| (name, number));
                number
            }
        }
    }
}
