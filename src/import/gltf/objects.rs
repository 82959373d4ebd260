//! From placed meshes to the objects of the scene.

use compact_str::{CompactString, format_compact};
use glam::DMat4;
use serde::Deserialize;
use serde_json::Value;
use serde_json::value::{RawValue, to_raw_value};

use super::accessor::Reader;
use super::document::Node;
use super::graph::Placed;
use super::instances::Instances;
use super::mesh::{Gathered, Part};
use super::metadata::{Row, Tables};
use crate::geom::DVec3;
use crate::import::collector::Collector;
use crate::import::placing::Placing;
use crate::import::shape::Shape;
use crate::import::{ImportError, Place};

const CLASS: CompactString = CompactString::const_new("Building");
/// Every instance may repeat every feature of a mesh, so that a small file can ask for any number
/// of objects; past this many it is refused.
const MAX_OBJECTS: u64 = 1 << 26;
/// What the objects of one node repeat of it, name and extras, is cut off beyond this many bytes:
/// a million instances would each carry it.
const MAX_REPEATED: usize = 4096;

pub(super) struct Objects<'a, 'c> {
    reader: Reader<'a>,
    collector: &'c mut Collector,
    gathered: Gathered,
    tables: Tables<'a>,
    placing: Placing,
    /// Of one part, in scene coordinates.
    positions: Vec<DVec3>,
    shape: Shape,
    count: u64,
}

/// What the objects of one node have in common.
struct Common {
    name: CompactString,
    class: Option<CompactString>,
    attributes: Option<Box<RawValue>>,
    place: String,
}

impl<'a, 'c> Objects<'a, 'c> {
    pub(super) fn new(reader: Reader<'a>, placing: Placing, collector: &'c mut Collector) -> Self {
        Self {
            reader,
            collector,
            gathered: Gathered::default(),
            tables: Tables::default(),
            placing,
            positions: Vec::new(),
            shape: Shape::default(),
            count: 0,
        }
    }

    /// Hands over what a node draws.
    pub(super) fn node(&mut self, placed: &Placed) -> Result<(), ImportError> {
        let node = &self.reader.document.nodes[placed.node];
        let Some(mesh) = node.mesh else {
            return Ok(());
        };
        self.gathered.gather(&self.reader, mesh, placed.node)?;
        let mut common = self.common(node, placed.node, mesh);
        let Some(instancing) = &node.extensions.instancing else {
            return self.copy(&mut common, None, placed.transform);
        };
        let Some(instances) = Instances::open(&self.reader, instancing, placed.node)? else {
            let place = Place::Pointer(common.place);
            let what = "where its instances lie cannot be read; left out";
            self.collector.warn(Some(&common.name), place, what);
            self.collector
                .left_out("object", "places of its instances cannot be read");
            return Ok(());
        };
        for index in 0..instances.count {
            if let Some(local) = instances.transform(index) {
                self.copy(&mut common, Some(index), placed.transform * local)?;
                continue;
            }
            let place = Place::Pointer(common.place.clone());
            let what = format!("instance {index} has a rotation of length zero; left out");
            self.collector.warn(Some(&common.name), place, what);
            self.collector
                .left_out("instance", "a rotation of length zero");
        }
        Ok(())
    }

    fn common(&self, node: &Node, index: usize, mesh: usize) -> Common {
        let given = |name: &Option<CompactString>| name.clone().filter(|name| !name.is_empty());
        let mesh = self.reader.document.meshes.get(mesh);
        let name = given(&node.name).or_else(|| mesh.and_then(|mesh| given(&mesh.name)));
        Common {
            name: name.unwrap_or_else(|| format_compact!("node-{index}")),
            class: node.extras.and_then(class),
            attributes: node.extras.and_then(attributes),
            place: format!("/nodes/{index}"),
        }
    }

    /// One copy of the mesh that was gathered last.
    fn copy(
        &mut self,
        common: &mut Common,
        instance: Option<usize>,
        transform: DMat4,
    ) -> Result<(), ImportError> {
        let is_split = self.gathered.parts.iter().any(|p| p.feature.is_some());
        let points = self.gathered.parts.iter().map(|p| p.points.len()).sum();
        self.gathered
            .visit(&self.reader, points, || common.place.clone())?;
        self.count += self.gathered.parts.len() as u64;
        if self.count > MAX_OBJECTS {
            let reason = format!("the file has more than {MAX_OBJECTS} objects up to here");
            return self.reader.fail(common.place.clone(), reason);
        }
        let name = match instance {
            None if !is_split => std::mem::take(&mut common.name),
            None => shortened(&common.name).into(),
            Some(index) => format_compact!("{}/{index}", shortened(&common.name)),
        };
        for note in &self.gathered.notes {
            let place = Place::Pointer(note.place.clone());
            self.collector.warn(Some(&name), place, note.what.as_str());
        }
        let attributes = if instance.is_none() && !is_split {
            common.attributes.take()
        } else {
            let short = common.attributes.as_ref();
            short.filter(|a| a.get().len() <= MAX_REPEATED).cloned()
        };
        let repeated = name.len() + attributes.as_ref().map_or(0, |a| a.get().len());
        let repeated = repeated.saturating_mul(self.gathered.parts.len());
        let place = || common.place.clone();
        self.gathered.visit(&self.reader, repeated, place)?;
        for part in 0..self.gathered.parts.len() {
            // What is of no feature counts only where there is no feature at all or it draws.
            let has_geometry = !self.gathered.parts[part].points.is_empty();
            if has_geometry || !is_split {
                let row = self.row(part, &name)?;
                self.part(part, row, &name, common, attributes.clone(), transform)?;
            }
        }
        Ok(())
    }

    /// What the file says of the feature of a part.
    fn row(&mut self, part: usize, name: &str) -> Result<Row, ImportError> {
        let Some(feature) = self.gathered.parts[part].feature else {
            return Ok(Row::default());
        };
        let Some(table) = feature.table else {
            return Ok(Row::default());
        };
        let place = format!("/extensions/EXT_structural_metadata/propertyTables/{table}");
        let asked = (table, feature.id);
        if let Some(row) = self.tables.row(&self.reader, asked, self.collector)? {
            let length = row.attributes.as_ref().map_or(0, |a| a.get().len());
            self.gathered.visit(&self.reader, length, || place)?;
            return Ok(row);
        }
        let what = "the property table says nothing of it";
        let id = format!("{name}/{}", feature.id);
        self.collector.warn(Some(&id), Place::Pointer(place), what);
        Ok(Row::default())
    }

    fn part(
        &mut self,
        part: usize,
        row: Row,
        name: &CompactString,
        common: &Common,
        attributes: Option<Box<RawValue>>,
        transform: DMat4,
    ) -> Result<(), ImportError> {
        let Part {
            feature,
            points,
            triangles,
        } = &self.gathered.parts[part];
        self.shape.clear();
        self.shape.triangles(*triangles);
        self.positions.clear();
        let placed = points
            .iter()
            .map(|&point| transform.transform_point3(point));
        self.positions.extend(placed);
        self.placing.place(&mut self.positions, self.collector)?;
        for &position in &self.positions {
            self.shape.vertex(position);
        }
        let id = row.id.unwrap_or_else(|| match feature {
            Some(feature) => format_compact!("{name}/{}", feature.id),
            None => name.clone(),
        });
        let class = row.class.or_else(|| common.class.clone()).unwrap_or(CLASS);
        let attributes = row.attributes.or(attributes);
        let not_finite = self.shape.not_finite();
        let object = self.shape.object(id.clone(), class, attributes);
        if object.is_none() {
            self.collector
                .left_out("object", "no vertex that can be used");
        }
        let what = match (&object, not_finite) {
            (Some(_), 0) => None,
            (Some(_), _) => Some(format!(
                "{not_finite} vertices that are {} are left out",
                self.placing.fault()
            )),
            (None, 0) => Some("has no vertices; left out".to_owned()),
            (None, _) => Some(format!(
                "all its vertices are {}; left out",
                self.placing.fault()
            )),
        };
        if let Some(what) = what {
            let place = Place::Pointer(common.place.clone());
            self.collector.warn(Some(&id), place, what);
        }
        if let Some(object) = object {
            self.collector.object(object);
        }
        Ok(())
    }
}

fn shortened(name: &str) -> &str {
    let end = (0..=MAX_REPEATED.min(name.len())).rev();
    &name[..end
        .into_iter()
        .find(|at| name.is_char_boundary(*at))
        .unwrap_or(0)]
}

/// `class` of the extras of a node.
fn class(extras: &RawValue) -> Option<CompactString> {
    #[derive(Deserialize)]
    struct Extras {
        class: Option<Value>,
    }
    // Most extras have no class; looking for the word is much cheaper than parsing.
    memchr::memmem::find(extras.get().as_bytes(), b"\"class\"")?;
    let extras: Extras = serde_json::from_str(extras.get()).ok()?;
    let class = extras.class?;
    let class = class.as_str().filter(|class| !class.is_empty())?;
    Some(CompactString::from(class))
}

/// Attributes are an object; extras may be anything.
fn attributes(extras: &RawValue) -> Option<Box<RawValue>> {
    match extras.get().as_bytes().first()? {
        b'{' => Some(extras.to_owned()),
        b'n' => None,
        _ => to_raw_value(
            &[("extras", extras)]
                .into_iter()
                .collect::<std::collections::BTreeMap<_, _>>(),
        )
        .ok(),
    }
}
