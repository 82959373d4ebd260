//! What a file keeps of each object and of the objects of each node, written in one pass.
//!
//! Rows lie in the order of ids and are stored in the order of the tree, so a look at one mostly
//! misses the caches: here each is looked at once, for all that is kept of it.

use std::ops::Range;

use rayon::prelude::*;

use super::blocks::{self, Blocks};
use super::file::{Block, Radii, Section};
use super::image::Sections;
use super::outward::stored_radius;
use super::plan::Plan;
use super::rows::Rows;
use super::texts::TextsMut;
use crate::geom::DVec3;

/// Nodes that are written together.
const PIECE: usize = 1024;

/// What the columns are made from.
pub(super) struct Source<'a> {
    pub(super) rows: &'a Rows,
    pub(super) plan: &'a Plan,
    pub(super) own_blocks: &'a Blocks<'a>,
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
    ids: TextsMut<'a>,
    attributes: TextsMut<'a>,
    blocks: &'a mut [Block],
    block_radii: &'a mut [Radii],
    largest: &'a mut [f32],
    least: &'a mut [f32],
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
        ids: TextsMut::new(
            sections.take(Section::IdStarts),
            sections.take(Section::Ids),
        ),
        attributes: TextsMut::new(
            sections.take(Section::AttributeStarts),
            sections.take(Section::Attributes),
        ),
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
        .map(|(nodes, lengths)| (nodes.clone(), rest.split_off(source, nodes, lengths)))
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
        [&self.rows.ids, &self.rows.attributes].map(|texts| texts.length_of(objects))
    }
}

impl<'a> Columns<'a> {
    /// The first of the columns, as far as they belong to a run of nodes.
    fn split_off(
        &mut self,
        source: &Source,
        nodes: Range<usize>,
        [id_bytes, attribute_bytes]: [usize; 2],
    ) -> Columns<'a> {
        let objects = source.own(nodes.clone()).len();
        let starts = &source.own_blocks.starts;
        let blocks = (starts[nodes.end] - starts[nodes.start]) as usize;
        Columns {
            boxes: first(&mut self.boxes, objects),
            classes: first(&mut self.classes, objects),
            footprints: first(&mut self.footprints, objects),
            triangles: first(&mut self.triangles, objects),
            ids: self.ids.split_off(objects, id_bytes),
            attributes: self.attributes.split_off(objects, attribute_bytes),
            blocks: first(&mut self.blocks, blocks),
            block_radii: first(&mut self.block_radii, blocks),
            largest: first(&mut self.largest, nodes.len()),
            least: first(&mut self.least, nodes.len()),
        }
    }

    fn write(mut self, source: &Source, nodes: Range<usize>) {
        let mut blocks = self.blocks.iter_mut().zip(self.block_radii.iter_mut());
        let mut at = 0;
        for (node, extremes) in nodes.zip(self.largest.iter_mut().zip(self.least.iter_mut())) {
            let own = &source.plan.order[source.own(node..node + 1)];
            for (group, (block, radii)) in own.chunks(8).zip(&mut blocks) {
                let first = at;
                let rows = source.rows.of(group);
                for (row, radius) in rows[..group.len()].iter().zip(radii.iter_mut()) {
                    let bounds = row.bounds();
                    self.boxes[at] = bounds.to_array();
                    self.classes[at] = row.class;
                    self.footprints[at] = row.footprint_area;
                    self.triangles[at] = row.triangles;
                    *radius = stored_radius(bounds.radius());
                    *extremes.0 = extremes.0.max(*radius);
                    *extremes.1 = extremes.1.min(*radius);
                    at += 1;
                }
                self.ids.copy(&source.rows.ids, group);
                self.attributes.copy(&source.rows.attributes, group);
                blocks::place(source.origin, &self.boxes[first..at], block);
            }
        }
    }
}

/// Takes the first so many of what is still to be written.
#[expect(
    clippy::mut_mut,
    reason = "a slice that gets shorter, as in the standard library's own"
)]
fn first<'a, T>(rest: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (first, after) = std::mem::take(rest).split_at_mut(count);
    *rest = after;
    first
}
