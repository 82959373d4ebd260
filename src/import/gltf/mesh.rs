//! The vertices of a mesh that are drawn, split by feature, in the coordinates of the mesh.

use std::collections::BTreeMap;

use glam::DVec3;

use super::accessor::{Content, Reader, Values};
use super::document::Primitive;
use super::features::{Feature, Split};
use crate::import::ImportError;

pub(super) const TRIANGLES: u32 = 4;
const TRIANGLE_STRIP: u32 = 5;
const TRIANGLE_FAN: u32 = 6;

/// Vertices may be shared by meshes and meshes by nodes, so that a small file can ask for any
/// amount of work; past so many vertices and bytes of names and attributes it is refused.
const MAX_VISITS: u64 = 1 << 32;
/// A vertex takes more than a byte of a buffer, so a mesh with more vertices than bytes repeats
/// itself; it is refused where it also has more than this many.
const MAX_REPEATED_POINTS: usize = 1 << 20;

/// What becomes one object: a feature, or what of the mesh is of no feature.
#[derive(Default)]
pub(super) struct Part {
    pub(super) feature: Option<Feature>,
    pub(super) points: Vec<DVec3>,
    pub(super) triangles: u64,
}

/// Something about a mesh that every object made of it is to be warned of.
pub(super) struct Note {
    pub(super) place: String,
    pub(super) what: String,
}

/// The last mesh looked at; nodes that follow each other often share one.
#[derive(Default)]
pub(super) struct Gathered {
    mesh: Option<usize>,
    /// What is of no feature, then the features in order. A part may be empty.
    pub(super) parts: Vec<Part>,
    pub(super) notes: Vec<Note>,
    part_of: BTreeMap<Option<Feature>, usize>,
    /// The part that was asked for last.
    last: usize,
    /// A bit for each vertex of the primitive at hand.
    seen: Vec<u64>,
    /// At most so many points are in the parts.
    points: usize,
    visits: u64,
}

/// Where a primitive is in the file.
#[derive(Clone, Copy)]
pub(super) struct At {
    mesh: usize,
    primitive: usize,
}

impl At {
    pub(super) fn field(self, field: &str) -> String {
        let Self { mesh, primitive } = self;
        format!("/meshes/{mesh}/primitives/{primitive}{field}")
    }
}

/// Which vertices are drawn, in which order.
enum Order<'a> {
    All,
    /// By the accessor of this number.
    Indexed(usize, Values<'a>),
    /// So many indices that cannot be read.
    Unknown(usize),
}

impl Gathered {
    /// Looks at the mesh of a node.
    pub(super) fn gather(
        &mut self,
        reader: &Reader,
        mesh: usize,
        node: usize,
    ) -> Result<(), ImportError> {
        if self.mesh == Some(mesh) {
            return Ok(());
        }
        self.restart();
        let Some(found) = reader.document.meshes.get(mesh) else {
            let count = reader.document.meshes.len();
            let reason = format!("there is no mesh {mesh}; the file has {count}");
            return reader.fail(format!("/nodes/{node}/mesh"), reason);
        };
        for (index, primitive) in found.primitives.iter().enumerate() {
            let at = At {
                mesh,
                primitive: index,
            };
            self.primitive(reader, primitive, at)?;
        }
        self.parts.sort_unstable_by_key(|part| part.feature);
        self.mesh = Some(mesh);
        Ok(())
    }

    /// Forgets the last mesh, but keeps the room of its first part: most meshes have just one.
    fn restart(&mut self) {
        self.mesh = None;
        self.notes.clear();
        self.parts.truncate(1);
        match self.parts.first_mut() {
            Some(part) => {
                part.feature = None;
                part.points.clear();
                part.triangles = 0;
            }
            None => self.parts.push(Part::default()),
        }
        self.part_of.clear();
        self.part_of.insert(None, 0);
        self.last = 0;
        self.points = 0;
    }

    /// Counts work done for what stands at `place`.
    pub(super) fn visit(
        &mut self,
        reader: &Reader,
        amount: usize,
        place: impl FnOnce() -> String,
    ) -> Result<(), ImportError> {
        self.visits = self.visits.saturating_add(amount as u64);
        if self.visits > MAX_VISITS {
            let reason = "the file repeats its vertices or names beyond all bounds";
            return reader.fail(place(), reason);
        }
        Ok(())
    }

    /// Notes something once, however many primitives share it.
    fn note(&mut self, at: At, what: impl Into<String>) {
        let what = what.into();
        if self.notes.iter().all(|note| note.what != what) {
            let place = at.field("");
            self.notes.push(Note { place, what });
        }
    }

    fn part(&mut self, feature: Option<Feature>) -> &mut Part {
        if self.parts[self.last].feature != feature {
            let parts = &mut self.parts;
            self.last = *self.part_of.entry(feature).or_insert_with(|| {
                parts.push(Part {
                    feature,
                    ..Part::default()
                });
                parts.len() - 1
            });
        }
        &mut self.parts[self.last]
    }

    fn primitive(
        &mut self,
        reader: &Reader,
        primitive: &Primitive,
        at: At,
    ) -> Result<(), ImportError> {
        let Some(&position) = primitive.attributes.get("POSITION") else {
            self.note(at, "a primitive has no positions; left out");
            return Ok(());
        };
        let asked_by = || at.field("/attributes/POSITION");
        let accessor = reader.accessor(position, "VEC3", &asked_by)?;
        let is_packed = primitive.extensions.draco.is_some() && accessor.buffer_view.is_none();
        let content = if is_packed {
            Content::Missing
        } else {
            reader.values(position, "VEC3", &asked_by)?
        };
        let order = order(reader, primitive, at)?;
        let Content::Values(values) = content else {
            let triangles = triangle_count(primitive.mode, order.count(accessor.count));
            let why = reader.why_missing(is_packed, accessor);
            return self.span(reader, position, triangles, why, at);
        };
        let (mut split, unread) = Split::of(reader, primitive, values.count, at)?;
        if let Some(what) = unread {
            self.note(at, what);
        }
        if let Order::Unknown(_) = order {
            self.note(at, "its indices cannot be read; all vertices are taken");
            split = Split::No;
        }
        self.take(reader, &values, &order, &split, primitive.mode, at)
    }

    /// The vertices that are drawn, each once, to the parts they belong to.
    fn take(
        &mut self,
        reader: &Reader,
        values: &Values,
        order: &Order,
        split: &Split,
        mode: u32,
        at: At,
    ) -> Result<(), ImportError> {
        let count = order.readable(values.count);
        self.visit(reader, count, || at.field(""))?;
        self.points = self.points.saturating_add(count.min(values.count));
        if self.points > reader.buffers.total().max(MAX_REPEATED_POINTS) {
            let reason = "the mesh repeats its vertices beyond all bounds";
            return reader.fail(at.field(""), reason);
        }
        self.seen.clear();
        self.seen.resize(values.count / 64 + 1, 0);
        let is_split = !matches!(split, Split::No);
        for position in 0..count {
            let vertex = match order {
                Order::Indexed(_, indices) => indices.value(position, 0) as usize,
                Order::All | Order::Unknown(_) => position,
            };
            if vertex >= values.count {
                return out_of_range(reader, order, (position, vertex), values.count, at);
            }
            let (word, bit) = (vertex / 64, 1 << (vertex % 64));
            let is_new = self.seen[word] & bit == 0;
            let begins_triangle = is_split && begins_triangle(mode, position, count);
            if is_new || begins_triangle {
                let part = self.part(split.feature(vertex));
                part.triangles += u64::from(begins_triangle);
                if is_new {
                    part.points.push(DVec3::from_array(values.vector(vertex)));
                    self.seen[word] |= bit;
                }
            }
        }
        if !is_split {
            self.part(None).triangles += triangle_count(mode, order.count(values.count));
        }
        Ok(())
    }

    /// The corners of the range that the file states, where there are no vertices.
    fn span(
        &mut self,
        reader: &Reader,
        position: usize,
        triangles: u64,
        why: &str,
        at: At,
    ) -> Result<(), ImportError> {
        let Some([min, max]) = reader.range(position)? else {
            let what = format!("{why}, and the accessor states no minimum and maximum; left out");
            self.note(at, what);
            return Ok(());
        };
        let what = format!(
            "{why}; bounds and footprint are taken from the minimum and maximum of its accessor"
        );
        self.note(at, what);
        let part = self.part(None);
        part.triangles += triangles;
        for corner in 0..8 {
            let pick = |axis: usize| [min, max][corner >> axis & 1][axis];
            part.points.push(DVec3::new(pick(0), pick(1), pick(2)));
        }
        Ok(())
    }
}

impl Order<'_> {
    /// How many vertices are drawn, of a primitive with `vertices`.
    fn count(&self, vertices: usize) -> usize {
        match self {
            Self::All => vertices,
            Self::Indexed(_, indices) => indices.count,
            Self::Unknown(count) => *count,
        }
    }

    /// How many can be told one by one.
    fn readable(&self, vertices: usize) -> usize {
        match self {
            Self::Indexed(_, indices) => indices.count,
            Self::All | Self::Unknown(_) => vertices,
        }
    }
}

fn order<'a>(reader: &Reader<'a>, primitive: &Primitive, at: At) -> Result<Order<'a>, ImportError> {
    let Some(index) = primitive.indices else {
        return Ok(Order::All);
    };
    let asked_by = || at.field("/indices");
    let accessor = reader.accessor(index, "SCALAR", &asked_by)?;
    if !reader.is_index(index) {
        let place = format!("/accessors/{index}/componentType");
        return reader.fail(place, "an index is an unsigned integer");
    }
    if primitive.extensions.draco.is_some() && accessor.buffer_view.is_none() {
        return Ok(Order::Unknown(accessor.count));
    }
    Ok(match reader.values(index, "SCALAR", &asked_by)? {
        Content::Values(values) => Order::Indexed(index, values),
        Content::Missing => Order::Unknown(accessor.count),
    })
}

fn out_of_range(
    reader: &Reader,
    order: &Order,
    (position, vertex): (usize, usize),
    count: usize,
    at: At,
) -> Result<(), ImportError> {
    let place = match order {
        Order::Indexed(accessor, _) => format!("/accessors/{accessor}"),
        Order::All | Order::Unknown(_) => at.field(""),
    };
    let reason = format!("index {position} is vertex {vertex}, but there are {count}");
    reader.fail(place, reason)
}

fn triangle_count(mode: u32, indices: usize) -> u64 {
    match mode {
        TRIANGLES => indices as u64 / 3,
        TRIANGLE_STRIP | TRIANGLE_FAN => (indices as u64).saturating_sub(2),
        _ => 0,
    }
}

/// Whether the vertex drawn at `position` is the first of a triangle of its own.
fn begins_triangle(mode: u32, position: usize, count: usize) -> bool {
    match mode {
        TRIANGLES => position.is_multiple_of(3) && position + 2 < count,
        TRIANGLE_STRIP => position + 2 < count,
        TRIANGLE_FAN => position >= 1 && position + 1 < count,
        _ => false,
    }
}
