//! From a hierarchy to the bytes that are queried.

use rayon::prelude::*;

use super::blocks::{self, Blocks};
use super::file::{Block, Counts, Header, MAGIC, Radii, Section, VERSION};
use super::hierarchy::{Canonical, Hierarchy};
use super::image::Draft;
use super::meta::Meta;
use super::plan::Plan;
use super::texts::{self, Attributes, Id};
use super::{LodTree, Promotion, radii};
use crate::geom::DVec3;
use crate::scene::SceneObject;

/// Packs a hierarchy of `objects`, which are in canonical order. What `meta` says of
/// them is found here.
pub(super) fn pack(
    objects: &[&SceneObject],
    hierarchy: &Hierarchy,
    promotion: Promotion,
    meta: Meta,
) -> LodTree {
    let plan = Plan::new(objects, hierarchy);
    let arranged: Vec<&SceneObject> = plan
        .order
        .par_iter()
        .map(|&key| objects[key as usize])
        .collect();
    let meta = meta.with_objects(&arranged);
    let packer = Packer {
        child_blocks: Blocks::new(hierarchy.levels.len().min(1) as u32, &plan.children),
        own_blocks: Blocks::new(0, &plan.own),
        ids: texts::starts(&arranged, &Id),
        attributes: texts::starts(&arranged, &Attributes),
        bounds: bounds(hierarchy),
        objects: &arranged,
        plan: &plan,
        hierarchy,
        meta: &meta,
    };
    let image = packer.image(promotion);
    LodTree::from_image(image, meta)
}

/// Everything that goes into a file, worked out but not yet laid out.
struct Packer<'a> {
    /// In file order.
    objects: &'a [&'a SceneObject],
    plan: &'a Plan,
    hierarchy: &'a Hierarchy,
    meta: &'a Meta,
    child_blocks: Blocks<'a>,
    own_blocks: Blocks<'a>,
    ids: Vec<u64>,
    attributes: Vec<u64>,
    /// Lower and upper corner of all objects.
    bounds: (DVec3, DVec3),
}

impl Packer<'_> {
    fn image(&self, promotion: Promotion) -> super::image::Image {
        let counts = Counts {
            objects: self.objects.len() as u32,
            nodes: self.plan.own.len() as u32 - 1,
            levels: self.hierarchy.levels.len() as u32,
            inner_nodes: self.plan.children.len() as u32 - 1,
        };
        let meta = self.meta.to_json();
        let mut draft = Draft::new(&counts, |section| match section {
            Section::Meta => meta.len(),
            Section::ChildBlocks => self.child_blocks.count() * size_of::<Block>(),
            Section::ChildRadii | Section::ChildLeastRadii => {
                self.child_blocks.count() * size_of::<Radii>()
            }
            Section::OwnBlocks => self.own_blocks.count() * size_of::<Block>(),
            Section::OwnRadii => self.own_blocks.count() * size_of::<Radii>(),
            Section::Ids => end(&self.ids),
            Section::Attributes => end(&self.attributes),
            Section::AttributeStarts if end(&self.attributes) > 0 => self.attributes.len() * 8,
            _ => 0,
        });
        draft.fill(Section::Meta).copy_from_slice(&meta);
        self.fill_nodes(&mut draft);
        self.fill_boxes(&mut draft);
        self.fill_radii(&mut draft);
        self.fill_objects(&mut draft);
        let (min, max) = self.bounds;
        draft.finish(Header {
            magic: MAGIC,
            version: VERSION,
            checksum: 0,
            length: 0,
            objects: counts.objects,
            nodes: counts.nodes,
            levels: counts.levels,
            inner_nodes: counts.inner_nodes,
            origin: self.origin().to_array(),
            bounds: [min.x, min.y, min.z, max.x, max.y, max.z],
            promotion: promotion as u32,
            sections: 0,
            zero: 0,
        })
    }

    /// The middle of the city.
    fn origin(&self) -> DVec3 {
        if self.objects.is_empty() {
            DVec3::ZERO
        } else {
            self.bounds.0 * 0.5 + self.bounds.1 * 0.5
        }
    }

    fn fill_nodes(&self, draft: &mut Draft) {
        let plan = self.plan;
        draft.fill(Section::Levels).copy_from_slice(&plan.levels);
        draft
            .fill(Section::Children)
            .copy_from_slice(&plan.children);
        draft.fill(Section::Own).copy_from_slice(&plan.own);
        // Canonical order is the order of ids, so where each one went is the order by id.
        let place_of = inverse(&plan.order);
        let representatives = draft.fill(Section::Representatives).iter_mut();
        for (place, node) in representatives.zip(self.hierarchy.envelopes()) {
            *place = node.best().map_or(0, |best| place_of[best.key as usize]);
        }
        draft.fill(Section::IdOrder).copy_from_slice(&place_of);
    }

    fn fill_boxes(&self, draft: &mut Draft) {
        let origin = self.origin();
        let nodes: Vec<[f64; 6]> = self
            .hierarchy
            .envelopes()
            .map(|node| {
                let (min, max) = node.corners();
                [min.x, min.y, min.z, max.x, max.y, max.z]
            })
            .collect();
        let objects = self.objects.par_iter().map(|o| o.bounds.to_array());
        let objects: Vec<[f64; 6]> = objects.collect();
        draft.fill(Section::NodeBoxes).copy_from_slice(&nodes);
        draft.fill(Section::ObjectBoxes).copy_from_slice(&objects);

        let blocks: &mut [Block] = draft.fill(Section::ChildBlocks);
        let (root, below) = blocks.split_at_mut(nodes.len().min(1));
        for root in root {
            blocks::place(origin, &nodes[..1], root);
        }
        self.child_blocks.fill(origin, &nodes, below);
        self.own_blocks
            .fill(origin, &objects, draft.fill(Section::OwnBlocks));
        draft
            .fill(Section::ChildBlockStarts)
            .copy_from_slice(&self.child_blocks.starts);
        draft
            .fill(Section::OwnBlockStarts)
            .copy_from_slice(&self.own_blocks.starts);
    }

    fn fill_radii(&self, draft: &mut Draft) {
        let radii = radii::Radii::new(self.plan, self.objects);
        draft.fill(Section::HiddenRadii)[..radii.hidden.len()].copy_from_slice(&radii.hidden);
        let inner_nodes = self.plan.children.len() - 1;
        let cuts = draft.fill(Section::CutRadii);
        for (plane, cut) in cuts.chunks_exact_mut(inner_nodes.max(1)).zip(&radii.cuts) {
            plane.copy_from_slice(cut);
        }
        self.fill_child_radii(&radii.held, draft.fill(Section::ChildRadii));
        self.fill_child_radii(&radii.least, draft.fill(Section::ChildLeastRadii));
        self.own_blocks
            .fill_radii(&radii.own, draft.fill(Section::OwnRadii));
    }

    /// One radius a node, in the order of the blocks: the root's, then those of children.
    fn fill_child_radii(&self, radii: &[f32], blocks: &mut [Radii]) {
        let (root, below) = blocks.split_at_mut(radii.len().min(1));
        if let (Some(block), Some(&radius)) = (root.first_mut(), radii.first()) {
            block[0] = radius;
        }
        self.child_blocks.fill_radii(radii, below);
    }

    fn fill_objects(&self, draft: &mut Draft) {
        let objects = self.objects;
        fill_by(draft.fill(Section::Classes), |at| {
            self.meta.class_number(&objects[at].class)
        });
        fill_by(draft.fill(Section::Footprints), |at| {
            objects[at].footprint_area
        });
        fill_by(draft.fill(Section::Triangles), |at| objects[at].triangles);
        draft.fill(Section::IdStarts).copy_from_slice(&self.ids);
        texts::write(objects, &Id, &self.ids, draft.fill(Section::Ids));
        if end(&self.attributes) > 0 {
            draft
                .fill(Section::AttributeStarts)
                .copy_from_slice(&self.attributes);
            let out = draft.fill(Section::Attributes);
            texts::write(objects, &Attributes, &self.attributes, out);
        }
    }
}

fn bounds(hierarchy: &Hierarchy) -> (DVec3, DVec3) {
    let root = hierarchy.levels.last().and_then(|l| l.envelopes.first());
    root.map_or((DVec3::INFINITY, DVec3::NEG_INFINITY), |root| {
        root.corners()
    })
}

fn end(starts: &[u64]) -> usize {
    starts.last().map_or(0, |&end| end as usize)
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
