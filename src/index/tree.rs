//! The packed tree: what is queried, saved and mapped.

use std::borrow::Cow;
use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;

use compact_str::CompactString;

use super::Promotion;
use super::arrays::Arrays;
use super::error::FileError;
use super::file::{Damage, Section, VERSION};
use super::image::{Image, Refusal};
use super::lifts;
use super::meta::Meta;
use crate::file::{MapError, Mapped, Replacement};
use crate::geom::{Aabb, DVec3};
use crate::scene::Effects;

/// A 3D R-tree over the objects of a city, immutable, each object stored once.
///
/// Nodes and objects are numbered in level order, coarsest level first, in tree order within a
/// level. So the children of a node are neighbours, and a subtree is one range per level. An
/// object is stored at the highest level it is promoted to; what a node stores are its *own*
/// objects, and the union of these along a path from the root is Gong's set.
///
/// Reading never fails and never loops: where an unverified file is damaged, answers are wrong or
/// empty, no more.
#[derive(Debug)]
pub struct LodTree {
    image: Image,
    meta: Meta,
}

/// What is known of one object.
#[derive(Debug, Clone)]
pub struct Object<'a> {
    /// Its name.
    pub id: Cow<'a, str>,
    /// Its kind.
    pub class: &'a str,
    /// Exact bounds in scene coordinates.
    pub bounds: Aabb,
    /// Area of its convex hull on the ground, m².
    pub footprint_area: f64,
    /// Triangles it takes to draw.
    pub triangles: u32,
    /// Whether the source says how high it stands.
    pub base_known: bool,
    /// How far above its ground it begins, m, where the source says so of a part; else 0.
    pub lift_m: f64,
    /// The level it is stored at.
    pub level: u32,
    /// JSON object with whatever else the source said.
    pub attributes: Option<&'a str>,
}

impl LodTree {
    /// Whether what is kept of lifts can be relied on.
    pub(super) fn has_sound_lifts(&self) -> bool {
        lifts::are_sound(&self.image)
    }

    pub(super) fn from_image(image: Image, meta: Meta) -> Self {
        Self { image, meta }
    }

    /// Maps a file without reading it through: constant time, whatever its size. Header and
    /// section table are checked, contents are not; see [`LodTree::open_verified`].
    ///
    /// The file must not be changed in place while it is mapped. [`LodTree::save`] replaces
    /// files whole, so saving over an open one is safe.
    ///
    /// # Errors
    /// [`FileError`] when the file cannot be read, is none of ours, or is cut off.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let map = Mapped::open(path).map_err(|error| {
            let path = path.to_owned();
            match error {
                MapError::Empty => FileError::Empty { path },
                MapError::Io { action, source } => FileError::Io {
                    path,
                    action,
                    source,
                },
            }
        })?;
        let image = Image::mapped(map).map_err(|refusal| refused(path, refusal))?;
        let objects = image.header().objects;
        let meta = Meta::from_json(image.section(Section::Meta), objects).map_err(|reason| {
            let damage = Damage::new(Section::Meta.name(), reason);
            refused(path, Refusal::Damaged(damage))
        })?;
        Ok(Self { image, meta })
    }

    /// Opens a file and checks every byte of it against its checksums.
    ///
    /// # Errors
    /// [`FileError`], naming the damaged section.
    pub fn open_verified(path: &Path) -> Result<Self, FileError> {
        let tree = Self::open(path)?;
        match tree.image.verify() {
            Ok(()) => Ok(tree),
            Err(damage) => Err(refused(path, Refusal::Damaged(damage))),
        }
    }

    /// Whether the file that this is mapped from was written into since: then answers may be
    /// wrong, and where it became shorter, reading on may end the process. False where the file
    /// cannot tell, and for a tree in memory.
    pub fn is_written_into(&self) -> bool {
        self.image.is_written_into()
    }

    /// Writes the tree to a file, whole or not at all: under a temporary name beside it, synced,
    /// renamed.
    ///
    /// # Errors
    /// [`FileError::Io`]; what was at `path` before is then still there.
    pub fn save(&self, path: &Path) -> Result<(), FileError> {
        let saved = self.prepared(path).and_then(Replacement::finish);
        saved.map_err(|source| FileError::Io {
            path: path.to_owned(),
            action: "cannot write",
            source,
        })
    }

    /// The file that [`LodTree::save`] writes, but for its name.
    pub(crate) fn prepared(&self, path: &Path) -> io::Result<Replacement> {
        let mut new = Replacement::of(path)?;
        new.file().write_all(self.image.bytes())?;
        Ok(new)
    }

    /// Size of the tree in bytes, as a file and in memory.
    pub fn byte_len(&self) -> usize {
        self.image.bytes().len()
    }

    /// Tells contents apart: the same objects give the same revision.
    pub fn revision(&self) -> String {
        let header = self.image.header();
        format!("{VERSION}-{:08x}-{:x}", header.checksum, header.length)
    }

    /// Coordinate reference system, where the source named one.
    pub fn crs(&self) -> Option<&str> {
        self.meta.crs()
    }

    /// What the scene calls for beyond its objects.
    pub fn effects(&self) -> &Effects {
        self.meta.effects()
    }

    /// The same city with other effects declared.
    #[must_use]
    pub fn declaring(&self, effects: Effects) -> Self {
        let meta = self.meta.declaring(effects);
        let image = self.image.with_meta(&meta.to_json());
        Self { image, meta }
    }

    /// The kinds of object there are, sorted.
    pub fn classes(&self) -> &[CompactString] {
        self.meta.classes()
    }

    /// Of how many objects the source does not say how high they stand.
    pub fn base_unknown_count(&self) -> u32 {
        self.meta.base_unknown_count()
    }

    /// How representatives were chosen.
    pub fn promotion(&self) -> Promotion {
        match self.image.header().promotion {
            1 => Promotion::Footprint,
            2 => Promotion::Largest,
            _ => Promotion::Tallest,
        }
    }

    /// Number of objects.
    pub fn object_count(&self) -> u32 {
        self.image.header().objects
    }

    /// Number of nodes.
    pub fn node_count(&self) -> u32 {
        self.image.header().nodes
    }

    /// Number of levels, leaves included; 0 without objects.
    pub fn level_count(&self) -> u32 {
        self.image.header().levels
    }

    /// Where f32 boxes are relative to, scene coordinates.
    pub fn origin(&self) -> DVec3 {
        self.image.header().origin.into()
    }

    /// Box of all objects; empty without objects.
    pub fn bounds(&self) -> Aabb {
        Aabb::from_array(self.image.header().bounds).unwrap_or(Aabb::EMPTY)
    }

    /// The arrays a traversal reads.
    pub fn arrays(&self) -> Arrays<'_> {
        let levels: &[u32] = self.image.slice(Section::Levels);
        let (level_nodes, level_objects) = levels.split_at(levels.len() / 2);
        Arrays {
            children: self.image.slice(Section::Children),
            own: self.image.slice(Section::Own),
            level_nodes,
            level_objects,
            representatives: self.image.slice(Section::Representatives),
            hidden_radii: self.image.slice(Section::HiddenRadii),
            cut_radii: self.image.slice(Section::CutRadii),
            child_blocks: self.image.slice(Section::ChildBlocks),
            child_radii: self.image.slice(Section::ChildRadii),
            child_least_radii: self.image.slice(Section::ChildLeastRadii),
            child_block_starts: self.image.slice(Section::ChildBlockStarts),
            own_blocks: self.image.slice(Section::OwnBlocks),
            own_radii: self.image.slice(Section::OwnRadii),
            own_block_starts: self.image.slice(Section::OwnBlockStarts),
            node_boxes: self.image.slice(Section::NodeBoxes),
            object_boxes: self.image.slice(Section::ObjectBoxes),
        }
    }

    /// Ids of a range of objects as they stand in a JSON array: `"a","b",` with the last comma.
    pub fn ids_json(&self, objects: Range<u32>) -> &[u8] {
        let starts: &[u64] = self.image.slice(Section::IdStarts);
        let at = |i: u32| starts.get(i as usize).map(|&start| start as usize);
        match (at(objects.start), at(objects.end)) {
            (Some(start), Some(end)) => self
                .image
                .section(Section::Ids)
                .get(start..end)
                .unwrap_or_default(),
            _ => &[],
        }
    }

    /// Appends the ids of many ranges of objects, as [`LodTree::ids_json`] gives them.
    pub fn append_ids_json(&self, ranges: &[Range<u32>], out: &mut Vec<u8>) {
        let starts: &[u64] = self.image.slice(Section::IdStarts);
        let ids = self.image.section(Section::Ids);
        let mut next = 0;
        let texts = ranges.iter().filter_map(|range| {
            let start = *starts.get(range.start as usize)? as usize;
            let end = *starts.get(range.end as usize)? as usize;
            let text = ids.get(start.max(next)..end)?; // later only in a damaged file
            next = end;
            Some(text)
        });
        texts.for_each(|text| out.extend_from_slice(text));
    }

    /// The id of an object.
    pub fn id(&self, object: u32) -> Option<Cow<'_, str>> {
        let quoted = self
            .ids_json(object..object.checked_add(1)?)
            .strip_suffix(b",")?;
        let inner = quoted.strip_prefix(b"\"")?.strip_suffix(b"\"")?;
        if memchr::memchr(b'\\', inner).is_none() {
            std::str::from_utf8(inner).ok().map(Cow::Borrowed)
        } else {
            serde_json::from_slice(quoted).ok().map(Cow::Owned)
        }
    }

    /// The number of the object with this id, by binary search.
    pub fn find(&self, id: &str) -> Option<u32> {
        let order: &[u32] = self.image.slice(Section::IdOrder);
        order
            .binary_search_by(|&object| self.id(object).as_deref().unwrap_or("").cmp(id))
            .ok()
            .map(|place| order[place])
    }

    /// The place of an object's class in [`LodTree::classes`].
    pub fn class_number(&self, object: u32) -> Option<usize> {
        let classes: &[u32] = self.image.slice(Section::Classes);
        let class = *classes.get(object as usize)? as usize;
        (class < self.classes().len()).then_some(class)
    }

    /// Exact bounds of an object.
    pub fn bounds_of(&self, object: u32) -> Option<Aabb> {
        self.arrays()
            .object_boxes
            .get(object as usize)
            .copied()
            .map(|b| Aabb::from_array(b).unwrap_or(Aabb::EMPTY))
    }

    /// The level an object is stored at, 0 for leaves.
    pub fn level_of(&self, object: u32) -> u32 {
        let starts = self.arrays().level_objects;
        let coarser = starts.partition_point(|&start| start <= object) as u32;
        self.level_count().saturating_sub(coarser)
    }

    /// Everything known of an object; `None` past the last one.
    pub fn object(&self, object: u32) -> Option<Object<'_>> {
        let at = object as usize;
        let class = self.class_number(object)?;
        Some(Object {
            id: self.id(object)?,
            class: self.classes().get(class)?,
            bounds: self.bounds_of(object)?,
            footprint_area: *self.image.slice(Section::Footprints).get(at)?,
            triangles: *self.image.slice(Section::Triangles).get(at)?,
            base_known: self.meta.base_known(object),
            lift_m: lifts::lift_m(&self.image, object),
            level: self.level_of(object),
            attributes: self.attributes(object),
        })
    }

    fn attributes(&self, object: u32) -> Option<&str> {
        let starts: &[u64] = self.image.slice(Section::AttributeStarts);
        let start = *starts.get(object as usize)? as usize;
        let end = *starts.get(object as usize + 1)? as usize;
        let text = self.image.section(Section::Attributes).get(start..end)?;
        std::str::from_utf8(text)
            .ok()
            .filter(|text| !text.is_empty())
    }
}

fn refused(path: &Path, refusal: Refusal) -> FileError {
    let path = path.to_owned();
    match refusal {
        Refusal::Foreign => FileError::Foreign { path },
        Refusal::Version(found) => FileError::Version {
            path,
            found,
            expected: VERSION,
        },
        Refusal::Damaged(Damage { section, reason }) => FileError::Damaged {
            path,
            section,
            reason,
        },
    }
}
