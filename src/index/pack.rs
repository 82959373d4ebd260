//! From a hierarchy to the bytes that are queried.

use super::blocks::{self, Blocks};
use super::columns::{self, OwnRadii, Source};
use super::file::{Block, Counts, Header, MAGIC, Radii, Section, VERSION};
use super::hierarchy::Hierarchy;
use super::image::{Draft, Image, Sections};
use super::lifts;
use super::meta::Meta;
use super::plan::Plan;
use super::radii;
use super::rows::Rows;
use super::{LodTree, Promotion};
use crate::geom::DVec3;

/// Packs a hierarchy of objects.
pub(super) fn pack(
    rows: &Rows,
    hierarchy: &Hierarchy,
    promotion: Promotion,
    meta: Meta,
) -> LodTree {
    let plan = Plan::new(rows.len(), hierarchy);
    let meta = meta.with_bases(&rows.base_known, &plan.order);
    let (lifted, lifts) = lifts::placed(&rows.lifts, &plan.order);
    let packer = Packer {
        child_blocks: Blocks::new(hierarchy.levels.len().min(1) as u32, &plan.children),
        own_blocks: Blocks::new(0, &plan.own),
        bounds: bounds(hierarchy),
        rows,
        plan: &plan,
        hierarchy,
        meta: &meta,
        lifted: &lifted,
        lifts: &lifts,
    };
    let image = packer.image(promotion);
    LodTree::from_image(image, meta)
}

/// Everything that goes into a file, worked out but not yet laid out.
struct Packer<'a> {
    rows: &'a Rows,
    plan: &'a Plan,
    hierarchy: &'a Hierarchy,
    meta: &'a Meta,
    /// Objects that begin above their ground, by their place in the file, and how far.
    lifted: &'a [u32],
    lifts: &'a [f64],
    child_blocks: Blocks<'a>,
    own_blocks: Blocks<'a>,
    /// Lower and upper corner of all objects.
    bounds: (DVec3, DVec3),
}

impl Packer<'_> {
    fn image(&self, promotion: Promotion) -> Image {
        let counts = Counts {
            objects: self.rows.len() as u32,
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
            Section::Lifted => size_of_val(self.lifted),
            Section::Lifts => size_of_val(self.lifts),
            Section::Ids => self.rows.ids.bytes().len(),
            Section::Attributes => self.rows.attributes.bytes().len(),
            Section::AttributeStarts if !self.rows.attributes.bytes().is_empty() => {
                (self.rows.len() + 1) * 8
            }
            _ => 0,
        });
        let mut sections = draft.sections();
        sections.fill(Section::Meta, &meta);
        sections.fill(Section::Lifted, self.lifted);
        sections.fill(Section::Lifts, self.lifts);
        self.fill_nodes(&mut sections);
        self.fill_order_and_boxes(&mut sections);
        let own = columns::fill(&self.source(), &mut sections);
        self.fill_radii(&own, &mut sections);
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

    fn source(&self) -> Source<'_> {
        Source {
            rows: self.rows,
            plan: self.plan,
            own_blocks: &self.own_blocks,
            origin: self.origin(),
        }
    }

    /// The middle of the city.
    fn origin(&self) -> DVec3 {
        if self.rows.len() == 0 {
            DVec3::ZERO
        } else {
            self.bounds.0 * 0.5 + self.bounds.1 * 0.5
        }
    }

    fn fill_nodes(&self, sections: &mut Sections) {
        let plan = self.plan;
        sections.fill(Section::Levels, &plan.levels);
        sections.fill(Section::Children, &plan.children);
        sections.fill(Section::Own, &plan.own);
        sections.fill(Section::ChildBlockStarts, &self.child_blocks.starts);
        sections.fill(Section::OwnBlockStarts, &self.own_blocks.starts);
    }

    fn fill_order_and_boxes(&self, sections: &mut Sections) {
        let place_of = sections.take(Section::IdOrder);
        let representatives = sections.take(Section::Representatives);
        let boxes = sections.take(Section::NodeBoxes);
        let blocks = sections.take(Section::ChildBlocks);
        rayon::join(
            || self.fill_order(place_of, representatives),
            || self.fill_boxes(boxes, blocks),
        );
    }

    fn fill_order(&self, place_of: &mut [u32], representatives: &mut [u32]) {
        // Canonical order is the order of ids, so where each one went is the order by id.
        for (place, &key) in (0..).zip(&self.plan.order) {
            place_of[key as usize] = place;
        }
        for (place, node) in representatives.iter_mut().zip(self.hierarchy.envelopes()) {
            *place = node.best().map_or(0, |best| place_of[best.key as usize]);
        }
    }

    fn fill_boxes(&self, nodes: &mut [[f64; 6]], blocks: &mut [Block]) {
        let origin = self.origin();
        for (corners, node) in nodes.iter_mut().zip(self.hierarchy.envelopes()) {
            let (min, max) = node.corners();
            *corners = [min.x, min.y, min.z, max.x, max.y, max.z];
        }
        let (root, below) = blocks.split_at_mut(nodes.len().min(1));
        for root in root {
            blocks::place(origin, &nodes[..1], root);
        }
        self.child_blocks.fill(origin, nodes, below);
    }

    fn fill_radii(&self, own: &OwnRadii, sections: &mut Sections) {
        let radii = radii::Radii::new(self.plan, own);
        let inner_nodes = self.plan.children.len() - 1;
        let hidden: &mut [f32] = sections.take(Section::HiddenRadii);
        hidden[..radii.hidden.len()].copy_from_slice(&radii.hidden);
        let cuts: &mut [f32] = sections.take(Section::CutRadii);
        for (plane, cut) in cuts.chunks_exact_mut(inner_nodes.max(1)).zip(&radii.cuts) {
            plane.copy_from_slice(cut);
        }
        self.fill_child_radii(&radii.held, sections.take(Section::ChildRadii));
        self.fill_child_radii(&radii.least, sections.take(Section::ChildLeastRadii));
    }

    /// One radius a node, in the order of the blocks: the root's, then those of children.
    fn fill_child_radii(&self, radii: &[f32], blocks: &mut [Radii]) {
        let (root, below) = blocks.split_at_mut(radii.len().min(1));
        if let (Some(block), Some(&radius)) = (root.first_mut(), radii.first()) {
            block[0] = radius;
        }
        self.child_blocks.fill_radii(radii, below);
    }
}

fn bounds(hierarchy: &Hierarchy) -> (DVec3, DVec3) {
    let root = hierarchy.levels.last().and_then(|l| l.envelopes.first());
    root.map_or((DVec3::INFINITY, DVec3::NEG_INFINITY), |root| {
        root.corners()
    })
}
