//! From a hierarchy to the bytes that are queried: level order, each object once.

use rayon::prelude::*;

use super::file::{Block, Counts, Header, MAGIC, Section, VERSION};
use super::hierarchy::{Canonical, Hierarchy};
use super::image::Draft;
use super::tree::Meta;
use super::{LodTree, Promotion};
use crate::geom::{Aabb, DVec3};
use crate::scene::SceneObject;

/// Packs a hierarchy of `objects`, which are in canonical order.
pub(super) fn pack(
    objects: &[&SceneObject],
    hierarchy: &Hierarchy,
    promotion: Promotion,
    crs: Option<&str>,
) -> LodTree {
    let plan = Plan::new(objects, hierarchy);
    let arranged: Vec<&SceneObject> = plan
        .order
        .par_iter()
        .map(|&key| objects[key as usize])
        .collect();
    let meta = Meta::of(&arranged, crs);
    let meta_json = meta.to_json();
    let inner_nodes = plan.children.len() - 1;
    let child_blocks = block_starts(1.min(plan.own.len() as u32 - 1), &plan.children);
    let own_blocks = block_starts(0, &plan.own);
    let ids = Texts::ids(&arranged);
    let attributes = Texts::attributes(&arranged);

    let counts = Counts {
        objects: objects.len() as u32,
        nodes: plan.own.len() as u32 - 1,
        levels: hierarchy.levels.len() as u32,
        inner_nodes: inner_nodes as u32,
    };
    let mut draft = Draft::new(&counts, |section| match section {
        Section::Meta => meta_json.len(),
        Section::ChildBlocks => blocks_length(&child_blocks),
        Section::OwnBlocks => blocks_length(&own_blocks),
        Section::Ids => ids.length(),
        Section::Attributes => attributes.length(),
        Section::AttributeStarts if attributes.length() > 0 => attributes.starts.len() * 8,
        _ => 0,
    });

    let bounds = hierarchy
        .levels
        .last()
        .and_then(|root| root.envelopes.first())
        .map_or((DVec3::INFINITY, DVec3::NEG_INFINITY), |root| {
            root.corners()
        });
    let origin = if objects.is_empty() {
        DVec3::ZERO
    } else {
        bounds.0 * 0.5 + bounds.1 * 0.5
    };

    draft.fill(Section::Meta).copy_from_slice(&meta_json);
    draft.fill(Section::Levels).copy_from_slice(&plan.levels);
    draft
        .fill(Section::Children)
        .copy_from_slice(&plan.children);
    draft.fill(Section::Own).copy_from_slice(&plan.own);

    // Canonical order is the order of ids, so where each one went is the order by id.
    let place_of = inverse(&plan.order);
    let nodes = || hierarchy.levels.iter().rev().flat_map(|l| &l.envelopes);
    for (place, node) in draft.fill(Section::Representatives).iter_mut().zip(nodes()) {
        *place = node.best().map_or(0, |best| place_of[best.key as usize]);
    }
    draft.fill(Section::IdOrder).copy_from_slice(&place_of);

    let hidden = plan.hidden_radii(&arranged);
    draft.fill::<f32>(Section::HiddenRadii)[..hidden.len()].copy_from_slice(&hidden);
    let node_boxes: Vec<[f64; 6]> = nodes()
        .map(|node| {
            let (min, max) = node.corners();
            [min.x, min.y, min.z, max.x, max.y, max.z]
        })
        .collect();
    let object_boxes: Vec<[f64; 6]> = arranged.par_iter().map(|o| o.bounds.to_array()).collect();
    draft.fill(Section::NodeBoxes).copy_from_slice(&node_boxes);
    draft
        .fill(Section::ObjectBoxes)
        .copy_from_slice(&object_boxes);
    let place = |boxes: &[[f64; 6]], out: &mut Block| place_boxes(origin, boxes, out);
    let (root, below) = draft
        .fill::<Block>(Section::ChildBlocks)
        .split_at_mut(usize::from(counts.nodes > 0));
    for root in root {
        place(&node_boxes[..1], root);
    }
    fill_blocks(below, &plan.children, &node_boxes, place);
    let own = draft.fill(Section::OwnBlocks);
    fill_blocks(own, &plan.own, &object_boxes, place);
    draft
        .fill(Section::ChildBlockStarts)
        .copy_from_slice(&child_blocks);
    draft
        .fill(Section::OwnBlockStarts)
        .copy_from_slice(&own_blocks);

    let each = |at: usize| arranged[at];
    let class = |o: &SceneObject| meta.class_number(&o.class);
    fill_by(draft.fill(Section::Classes), |at| class(each(at)));
    fill_by(draft.fill(Section::Footprints), |at| {
        each(at).footprint_area
    });
    fill_by(draft.fill(Section::Triangles), |at| each(at).triangles);
    draft.fill(Section::IdStarts).copy_from_slice(&ids.starts);
    ids.write(draft.fill(Section::Ids), |at, out| {
        let text = json_id(&each(at).id);
        out[..text.len()].copy_from_slice(text.as_bytes());
        out[text.len()] = b',';
    });
    if attributes.length() > 0 {
        draft
            .fill(Section::AttributeStarts)
            .copy_from_slice(&attributes.starts);
        attributes.write(draft.fill(Section::Attributes), |at, out| {
            out.copy_from_slice(attribute_text(each(at)).as_bytes());
        });
    }

    let (min, max) = bounds;
    LodTree::from_image(
        draft.finish(Header {
            magic: MAGIC,
            version: VERSION,
            checksum: 0,
            length: 0,
            objects: counts.objects,
            nodes: counts.nodes,
            levels: counts.levels,
            inner_nodes: counts.inner_nodes,
            origin: origin.to_array(),
            bounds: [min.x, min.y, min.z, max.x, max.y, max.z],
            promotion: promotion as u32,
            sections: 0,
            zero: 0,
        }),
        meta,
    )
}

/// Which object is stored where.
struct Plan {
    /// Objects in file order.
    order: Vec<Canonical>,
    /// First own object of each node, then the end.
    own: Vec<u32>,
    /// First child of each inner node, then the end.
    children: Vec<u32>,
    /// The `levels` section.
    levels: Vec<u32>,
}

impl Plan {
    fn new(objects: &[&SceneObject], hierarchy: &Hierarchy) -> Self {
        let stored_at = storage_levels(objects.len(), hierarchy);
        let root = hierarchy.levels.len().wrapping_sub(1);
        let mut plan = Self {
            order: Vec::with_capacity(objects.len()),
            own: vec![0],
            children: vec![],
            levels: vec![],
        };
        let mut first_objects = vec![0];
        let mut first_nodes = vec![0];
        let mut next_child = 1;
        for (k, level) in hierarchy.levels.iter().enumerate().rev() {
            let starts = level.child_starts();
            for node in starts.windows(2) {
                let children = node[0] as usize..node[1] as usize;
                if k == 0 {
                    let own = hierarchy.objects[children].iter().copied();
                    plan.order
                        .extend(own.filter(|&o| stored_at[o as usize] == 0));
                } else {
                    let below = &hierarchy.levels[k - 1].envelopes[children];
                    let own = below.iter().filter_map(|c| c.best().map(|best| best.key));
                    let own = own.filter(|&o| usize::from(stored_at[o as usize]) == k);
                    plan.order.extend(own);
                    plan.children.push(next_child);
                    next_child += node[1] - node[0];
                }
                plan.own.push(plan.order.len() as u32);
            }
            first_nodes.push(plan.own.len() as u32 - 1);
            first_objects.push(plan.order.len() as u32);
        }
        debug_assert!(root == usize::MAX || plan.order.len() == objects.len());
        plan.children
            .push(next_child.min(plan.own.len() as u32 - 1));
        plan.levels.extend(first_nodes);
        plan.levels.extend(first_objects);
        plan
    }

    /// Largest radius below each node that is not its own, rounded up.
    fn hidden_radii(&self, arranged: &[&SceneObject]) -> Vec<f32> {
        let nodes = self.own.len() - 1;
        let mut hidden = vec![0.0_f32; nodes];
        let radii: Vec<f32> = arranged
            .par_iter()
            .map(|o| round_up(o.bounds.radius()))
            .collect();
        for node in (0..self.children.len() - 1).rev() {
            let children = self.children[node] as usize..self.children[node + 1] as usize;
            hidden[node] = children
                .map(|child| {
                    let own = self.own[child] as usize..self.own[child + 1] as usize;
                    radii[own].iter().copied().fold(hidden[child], f32::max)
                })
                .fold(0.0, f32::max);
        }
        hidden
    }
}

/// The level each object is stored at: one above the highest node it stands for, the root at most.
fn storage_levels(objects: usize, hierarchy: &Hierarchy) -> Vec<u8> {
    let mut stored_at = vec![0_u8; objects];
    let inner = hierarchy.levels.len().saturating_sub(1);
    for (k, level) in hierarchy.levels[..inner].iter().enumerate() {
        for best in level.envelopes.iter().filter_map(|e| e.best()) {
            stored_at[best.key as usize] = k as u8 + 1;
        }
    }
    stored_at
}

fn inverse(order: &[Canonical]) -> Vec<u32> {
    let mut place_of = vec![0; order.len()];
    for (place, &key) in order.iter().enumerate() {
        place_of[key as usize] = place as u32;
    }
    place_of
}

fn fill_by<T: Send>(out: &mut [T], value: impl Fn(usize) -> T + Sync) {
    out.par_iter_mut()
        .enumerate()
        .for_each(|(at, slot)| *slot = value(at));
}

/// First block of each group that `starts` tells apart, then their number.
fn block_starts(first: u32, starts: &[u32]) -> Vec<u32> {
    let mut blocks = Vec::with_capacity(starts.len());
    let mut end = first;
    blocks.push(end);
    for group in starts.windows(2) {
        end += (group[1] - group[0]).div_ceil(8);
        blocks.push(end);
    }
    blocks
}

fn blocks_length(starts: &[u32]) -> usize {
    starts.last().map_or(0, |&blocks| blocks as usize) * size_of::<Block>()
}

/// Fills the blocks of each group that `starts` tells apart.
fn fill_blocks(
    blocks: &mut [Block],
    starts: &[u32],
    boxes: &[[f64; 6]],
    place: impl Fn(&[[f64; 6]], &mut Block) + Sync,
) {
    let groups = starts.windows(2).flat_map(|group| {
        let group = &boxes[group[0] as usize..group[1] as usize];
        group.chunks(8)
    });
    let jobs: Vec<(&[[f64; 6]], &mut Block)> = groups.zip(blocks).collect();
    jobs.into_par_iter()
        .for_each(|(group, block)| place(group, block));
}

/// Writes at most eight boxes into a block, relative to the origin and rounded outward.
fn place_boxes(origin: DVec3, boxes: &[[f64; 6]], block: &mut Block) {
    let origin = origin.to_array();
    for (at, corners) in boxes.iter().enumerate() {
        for lane in 0..6 {
            let round = if lane < 3 { round_down } else { round_up };
            block[lane][at] = round(corners[lane] - origin[lane % 3]);
        }
    }
}

/// The largest f32 not above `x`.
fn round_down(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x {
        near.next_down()
    } else {
        near
    }
}

/// The smallest f32 not below `x`.
fn round_up(x: f64) -> f32 {
    -round_down(-x)
}

/// One text per object, laid end to end.
struct Texts {
    starts: Vec<u64>,
}

impl Texts {
    fn ids(arranged: &[&SceneObject]) -> Self {
        Self::of(arranged, |o| json_id(&o.id).len() + 1)
    }

    fn attributes(arranged: &[&SceneObject]) -> Self {
        Self::of(arranged, |o| attribute_text(o).len())
    }

    fn of(arranged: &[&SceneObject], length: impl Fn(&SceneObject) -> usize + Sync) -> Self {
        let lengths: Vec<u64> = arranged.par_iter().map(|o| length(o) as u64).collect();
        let mut starts = Vec::with_capacity(lengths.len() + 1);
        let mut end = 0;
        starts.push(0);
        for length in lengths {
            end += length;
            starts.push(end);
        }
        Self { starts }
    }

    fn length(&self) -> usize {
        self.starts.last().copied().unwrap_or(0) as usize
    }

    fn write(&self, mut out: &mut [u8], write: impl Fn(usize, &mut [u8]) + Sync) {
        let mut slots = Vec::with_capacity(self.starts.len());
        for pair in self.starts.windows(2) {
            let (slot, rest) = out.split_at_mut((pair[1] - pair[0]) as usize);
            slots.push(slot);
            out = rest;
        }
        slots
            .into_par_iter()
            .enumerate()
            .for_each(|(at, slot)| write(at, slot));
    }
}

fn attribute_text(object: &SceneObject) -> &str {
    object.attributes.as_ref().map_or("", |raw| raw.get())
}

/// The id as a JSON string, quotes included.
fn json_id(id: &str) -> compact_str::CompactString {
    if id.bytes().all(|b| b >= b' ' && b != b'"' && b != b'\\') {
        compact_str::format_compact!("\"{id}\"")
    } else {
        serde_json::Value::from(id).to_string().into()
    }
}

/// Checks that a box made of stored corners is one.
pub(super) fn box_of([x0, y0, z0, x1, y1, z1]: [f64; 6]) -> Aabb {
    Aabb::new(DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1)).unwrap_or(Aabb::EMPTY)
}
