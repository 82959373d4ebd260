//! The `.citylod` format: what lies where in a file, and how it is checked.
//!
//! Little endian. Everything starts on a multiple of 64 bytes; gaps are zero.
//!
//! | offset | size | field |
//! |---|---|---|
//! | 0 | 8 | magic `89 43 4C 4F 44 0D 0A 1A` |
//! | 8 | 4 | format version |
//! | 12 | 4 | CRC-32 of the rest of the header and of the section table |
//! | 16 | 8 | length of the file |
//! | 24 | 4 | number of objects, n |
//! | 28 | 4 | number of nodes, m |
//! | 32 | 4 | number of levels, h |
//! | 36 | 4 | number of nodes above the leaves, i |
//! | 40 | 24 | origin that f32 boxes are relative to, 3 f64 |
//! | 64 | 48 | bounds of all objects, 6 f64 (+∞ … −∞ for none) |
//! | 112 | 4 | promotion: 0 tallest, 1 footprint, 2 largest |
//! | 116 | 4 | number of sections |
//! | 120 | 8 | zero |
//! | 128 | 32 each | section table: tag (8 bytes), offset u64, length u64, CRC-32 u32, zero u32 |
//!
//! A section's checksum covers it up to the start of the next one, gap included, so that every
//! byte of the file is under one. Nodes and objects are numbered in level order, coarsest level
//! first; see [`Section`] for what is kept of them.

use bytemuck::{Pod, Zeroable};

/// First bytes: not text, and damaged by anything that changes line ends.
pub(super) const MAGIC: [u8; 8] = *b"\x89CLOD\r\n\x1a";
/// Raised with every change that older programs would misread.
pub(super) const VERSION: u32 = 4;
pub(super) const ALIGNMENT: usize = 64;
/// Levels that a file may have; a tree of 2³² objects with two children a node has 32.
pub(super) const MOST_LEVELS: u32 = 64;
/// Radii that may be read past the last one, as they are read eight at a time.
const PADDING: u64 = 8;

/// Eight boxes: lanes of min x, y, z, max x, y, z. What is looked at together lies together.
pub(super) type Block = [[f32; 8]; 6];
/// Radii of eight boxes or of what they hold, m.
pub(super) type Radii = [f32; 8];

/// What a file holds, in the order it lies there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
pub(super) enum Section {
    /// JSON: `crs`, `effects` ([`crate::scene::Effects`]), `classes`, and, left out where there are
    /// none, `base_unknown`: ranges `[first, end]` of the objects of which the source does not say
    /// how high they stand.
    Meta,
    /// u32 × (h + 1): first node of each level, coarsest first, then m; the same again for
    /// objects and n.
    Levels,
    /// u32 × (i + 1): first child of each inner node, then m.
    Children,
    /// u32 × (m + 1): first of each node's own objects, then n.
    Own,
    /// u32 × m: the object that stands for each node in its parent.
    Representatives,
    /// f32 × (m + 8): largest radius of an object below the node that is not its own, m.
    HiddenRadii,
    /// f32 × ((h − 2)·i + 8): for each level c from 1 to h − 2 and each inner node, the largest
    /// radius of an object below the node that is stored at a level lower than c and is not the
    /// node's own, m.
    CutRadii,
    /// u32 × (i + 1): first block of each inner node in `ChildBlocks`, then their number.
    ChildBlockStarts,
    /// f32 × 48 a block: boxes of the root, then of the children of each inner node, eight to a
    /// block, the last one filled up with zeros. Lanes min x, y, z, max x, y, z, relative to the
    /// origin, rounded outward.
    ChildBlocks,
    /// f32 × 8 for each of `ChildBlocks`: largest radius of an object stored with the child or
    /// below it, m, rounded up; 0 where there is none. What a node holds, less what an ancestor
    /// stores.
    ChildRadii,
    /// As `ChildRadii`: the least radius instead; infinite where there is none.
    ChildLeastRadii,
    /// f64 × 6 × m: exact boxes of nodes.
    NodeBoxes,
    /// u32 × (m + 1): first block of each node in `OwnBlocks`, then their number.
    OwnBlockStarts,
    /// As `ChildBlocks`, of each node's own objects.
    OwnBlocks,
    /// f32 × 8 for each of `OwnBlocks`: radius of each object, m, rounded up.
    OwnRadii,
    /// f64 × 6 × n: exact boxes of objects.
    ObjectBoxes,
    /// u64 × (n + 1): first byte of each id in `Ids`, then its length.
    IdStarts,
    /// Ids ready for JSON: `"a","b",`.
    Ids,
    /// u32 × n: object numbers in the order of their ids.
    IdOrder,
    /// u32 × n: place of each object's class in `classes`.
    Classes,
    /// f64 × n: footprint areas, m².
    Footprints,
    /// u32 × n: triangle counts.
    Triangles,
    /// u64 × (n + 1): first byte of each object's attributes; empty when no object has any.
    AttributeStarts,
    /// JSON objects, one after another.
    Attributes,
    /// u32 × k: objects that begin above their ground, in order.
    Lifted,
    /// f64 × k: how far each of `Lifted` does, m, more than 0.
    Lifts,
}

impl Section {
    pub(super) const ALL: [Self; 26] = [
        Self::Meta,
        Self::Levels,
        Self::Children,
        Self::Own,
        Self::Representatives,
        Self::HiddenRadii,
        Self::CutRadii,
        Self::ChildBlockStarts,
        Self::ChildBlocks,
        Self::ChildRadii,
        Self::ChildLeastRadii,
        Self::NodeBoxes,
        Self::OwnBlockStarts,
        Self::OwnBlocks,
        Self::OwnRadii,
        Self::ObjectBoxes,
        Self::IdStarts,
        Self::Ids,
        Self::IdOrder,
        Self::Classes,
        Self::Footprints,
        Self::Triangles,
        Self::AttributeStarts,
        Self::Attributes,
        Self::Lifted,
        Self::Lifts,
    ];

    pub(super) const fn tag(self) -> [u8; 8] {
        *match self {
            Self::Meta => b"meta    ",
            Self::Levels => b"levels  ",
            Self::Children => b"children",
            Self::Own => b"own     ",
            Self::Representatives => b"represen",
            Self::HiddenRadii => b"hidden  ",
            Self::CutRadii => b"cutradii",
            Self::ChildBlockStarts => b"chldblks",
            Self::ChildBlocks => b"chldblk ",
            Self::ChildRadii => b"chldrad ",
            Self::ChildLeastRadii => b"chldlst ",
            Self::NodeBoxes => b"nodebox ",
            Self::OwnBlockStarts => b"ownblks ",
            Self::OwnBlocks => b"ownblk  ",
            Self::OwnRadii => b"ownrad  ",
            Self::ObjectBoxes => b"objbox  ",
            Self::IdStarts => b"idstart ",
            Self::Ids => b"ids     ",
            Self::IdOrder => b"idorder ",
            Self::Classes => b"classes ",
            Self::Footprints => b"footprnt",
            Self::Triangles => b"triangle",
            Self::AttributeStarts => b"attstart",
            Self::Attributes => b"attribut",
            Self::Lifted => b"lifted  ",
            Self::Lifts => b"lifts   ",
        }
    }

    /// The tag as people read it.
    pub(super) fn name(self) -> String {
        String::from_utf8_lossy(&self.tag()).trim_end().to_owned()
    }

    /// Length in bytes where the counts decide it.
    pub(super) fn length(self, counts: &Counts) -> Option<u64> {
        let n = u64::from(counts.objects);
        let m = u64::from(counts.nodes);
        Some(match self {
            Self::Meta
            | Self::ChildBlocks
            | Self::ChildRadii
            | Self::ChildLeastRadii
            | Self::OwnBlocks
            | Self::OwnRadii
            | Self::Ids
            | Self::Attributes
            | Self::AttributeStarts
            | Self::Lifted
            | Self::Lifts => return None,
            Self::Levels => (u64::from(counts.levels) + 1) * 8,
            Self::Children | Self::ChildBlockStarts => (u64::from(counts.inner_nodes) + 1) * 4,
            Self::Own | Self::OwnBlockStarts => (m + 1) * 4,
            Self::Representatives => m * 4,
            Self::HiddenRadii => (m + PADDING) * 4,
            Self::CutRadii => {
                let cuts = u64::from(counts.levels.saturating_sub(2));
                (cuts * u64::from(counts.inner_nodes) + PADDING) * 4
            }
            Self::NodeBoxes => m * 48,
            Self::ObjectBoxes => n * 48,
            Self::IdStarts => (n + 1) * 8,
            Self::IdOrder | Self::Classes | Self::Triangles => n * 4,
            Self::Footprints => n * 8,
        })
    }
}

/// How much of everything there is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Counts {
    pub objects: u32,
    pub nodes: u32,
    pub levels: u32,
    pub inner_nodes: u32,
}

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Header {
    pub magic: [u8; 8],
    pub version: u32,
    pub checksum: u32,
    pub length: u64,
    pub objects: u32,
    pub nodes: u32,
    pub levels: u32,
    pub inner_nodes: u32,
    pub origin: [f64; 3],
    pub bounds: [f64; 6],
    pub promotion: u32,
    pub sections: u32,
    pub zero: u64,
}

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct TableEntry {
    pub tag: [u8; 8],
    pub offset: u64,
    pub length: u64,
    pub checksum: u32,
    pub zero: u32,
}

/// Bytes before the first section.
pub(super) const HEAD: usize = (size_of::<Header>() + Section::ALL.len() * size_of::<TableEntry>())
    .next_multiple_of(ALIGNMENT);

/// What is wrong, and in which section.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Damage {
    pub section: String,
    pub reason: String,
}

impl Damage {
    pub(super) fn new(section: impl Into<String>, reason: impl Into<String>) -> Self {
        Self {
            section: section.into(),
            reason: reason.into(),
        }
    }
}
