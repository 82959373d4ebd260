//! The bytes of a packed tree, in memory or mapped from a file: one form for both.

use std::ops::Range;

use bytemuck::{AnyBitPattern, NoUninit, Pod, Zeroable};
use crc32fast::Hasher;
use rayon::prelude::*;

use super::file::{
    ALIGNMENT, Block, Counts, Damage, HEAD, Header, MAGIC, MOST_LEVELS, Radii, Section, TableEntry,
    VERSION,
};
use crate::file::Mapped;

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([u8; ALIGNMENT]);

#[derive(Debug)]
enum Storage {
    Memory(Vec<Line>),
    Mapped(Mapped),
}

impl Storage {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::Memory(lines) => bytemuck::cast_slice(lines),
            Self::Mapped(map) => map,
        }
    }
}

/// A whole `.citylod` file whose header and section table hold together. What the sections say is
/// not checked here: see [`Image::verify`].
#[derive(Debug)]
pub(super) struct Image {
    storage: Storage,
    header: Header,
    sections: [Range<usize>; Section::ALL.len()],
}

/// Why bytes are no image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Refusal {
    Foreign,
    Version(u32),
    Damaged(Damage),
}

impl Image {
    pub(super) fn mapped(map: Mapped) -> Result<Self, Refusal> {
        let (header, sections) = parse(&map)?;
        Ok(Self {
            storage: Storage::Mapped(map),
            header,
            sections,
        })
    }

    pub(super) fn bytes(&self) -> &[u8] {
        self.storage.bytes()
    }

    /// Whether length or time of the mapped file are not what they were.
    pub(super) fn is_written_into(&self) -> bool {
        matches!(&self.storage, Storage::Mapped(map) if map.is_written_into())
    }

    pub(super) fn header(&self) -> &Header {
        &self.header
    }

    pub(super) fn section(&self, section: Section) -> &[u8] {
        self.bytes()
            .get(self.sections[section as usize].clone())
            .unwrap_or_default()
    }

    /// A section as numbers; empty where its length is no multiple of their size.
    pub(super) fn slice<T: AnyBitPattern>(&self, section: Section) -> &[T] {
        bytemuck::try_cast_slice(self.section(section)).unwrap_or_default()
    }

    /// The same with another meta section.
    pub(super) fn with_meta(&self, meta: &[u8]) -> Self {
        let of = |section| match section {
            Section::Meta => meta,
            other => self.section(other),
        };
        let mut draft = Draft::new(&counts(&self.header), |section| of(section).len());
        let mut sections = draft.sections();
        for section in Section::ALL {
            sections.fill(section, of(section));
        }
        draft.finish(self.header)
    }

    /// Compares every checksum: every byte of the file is under one.
    pub(super) fn verify(&self) -> Result<(), Damage> {
        let bytes = self.bytes();
        let table = bytemuck::cast_slice::<u8, TableEntry>(&bytes[table_range()]);
        let extents = extents(&self.sections, bytes.len());
        Section::ALL.par_iter().try_for_each(|&section| {
            let extent = extents[section as usize].clone();
            if checksum(&bytes[extent]) == table[section as usize].checksum {
                Ok(())
            } else {
                Err(Damage::new(section.name(), "its checksum does not match"))
            }
        })
    }
}

/// CRC-32 of many bytes, in parallel.
fn checksum(bytes: &[u8]) -> u32 {
    const PIECE: usize = 4 << 20;
    let hashed = |piece| {
        let mut hasher = Hasher::new();
        hasher.update(piece);
        hasher
    };
    let joined = |mut before: Hasher, after: Hasher| {
        before.combine(&after);
        before
    };
    let pieces = bytes.par_chunks(PIECE).map(hashed);
    pieces.reduce(Hasher::new, joined).finalize()
}

fn table_range() -> Range<usize> {
    let start = size_of::<Header>();
    start..start + Section::ALL.len() * size_of::<TableEntry>()
}

/// Everything of the head but the magic, the version and the checksum itself.
fn header_checksum(bytes: &[u8]) -> u32 {
    let covered = std::mem::offset_of!(Header, length)..HEAD;
    crc32fast::hash(&bytes[covered])
}

/// Sections with the gaps behind them.
fn extents(
    sections: &[Range<usize>; Section::ALL.len()],
    end: usize,
) -> [Range<usize>; Section::ALL.len()] {
    std::array::from_fn(|i| sections[i].start..sections.get(i + 1).map_or(end, |next| next.start))
}

type Parsed = (Header, [Range<usize>; Section::ALL.len()]);

fn parse(bytes: &[u8]) -> Result<Parsed, Refusal> {
    let damaged = |section: &str, reason: String| Refusal::Damaged(Damage::new(section, reason));
    let known = bytes.len().min(MAGIC.len());
    if bytes.is_empty() || bytes[..known] != MAGIC[..known] {
        return Err(Refusal::Foreign);
    }
    if bytes.len() < HEAD {
        let reason = format!("cut off at {} of {HEAD} bytes", bytes.len());
        return Err(damaged("header", reason));
    }
    let header: Header = bytemuck::pod_read_unaligned(&bytes[..size_of::<Header>()]);
    if header.version != VERSION {
        return Err(Refusal::Version(header.version));
    }
    if header_checksum(bytes) != header.checksum {
        return Err(damaged("header", "its checksum does not match".into()));
    }
    if header.sections as usize != Section::ALL.len() || header.levels > MOST_LEVELS {
        return Err(damaged("header", "impossible counts".into()));
    }
    let counts = counts(&header);
    let mut sections = std::array::from_fn(|_| 0..0);
    let mut free = HEAD as u64;
    for (section, entry) in Section::ALL
        .into_iter()
        .zip(bytes[table_range()].chunks_exact(size_of::<TableEntry>()))
    {
        let entry: TableEntry = bytemuck::pod_read_unaligned(entry);
        let damaged = |reason: &str| damaged(&section.name(), reason.to_owned());
        if entry.tag != section.tag() || entry.offset != free {
            return Err(damaged("not where the section table should have it"));
        }
        let allowed = match (section, section.length(&counts)) {
            (_, Some(length)) => entry.length == length,
            (Section::AttributeStarts, None) => {
                entry.length == 0 || entry.length == (u64::from(counts.objects) + 1) * 8
            }
            (Section::ChildBlocks | Section::OwnBlocks, None) => {
                entry.length.is_multiple_of(size_of::<Block>() as u64)
            }
            (Section::ChildRadii | Section::ChildLeastRadii | Section::OwnRadii, None) => {
                entry.length.is_multiple_of(size_of::<Radii>() as u64)
            }
            (Section::Lifted, None) => {
                entry.length.is_multiple_of(4) && entry.length <= u64::from(counts.objects) * 4
            }
            (Section::Lifts, None) => {
                let lifted: &Range<usize> = &sections[Section::Lifted as usize];
                entry.length == lifted.len() as u64 * 2
            }
            (_, None) => true,
        };
        if !allowed {
            return Err(damaged("its length does not fit the number of objects"));
        }
        let end = entry.offset.checked_add(entry.length);
        let end = end.filter(|&end| end <= bytes.len() as u64);
        let Some(end) = end else {
            return Err(damaged("reaches beyond the end of the file"));
        };
        sections[section as usize] = entry.offset as usize..end as usize;
        free = end.next_multiple_of(ALIGNMENT as u64);
    }
    if header.length != bytes.len() as u64 || free != header.length {
        let reason = format!("{} bytes long instead of {free}", bytes.len());
        return Err(damaged("header", reason));
    }
    let levels = &bytes[sections[Section::Levels as usize].clone()];
    if !levels_hold_together(levels, &counts) {
        let reason = "levels are not ranges of nodes and objects".into();
        return Err(damaged(&Section::Levels.name(), reason));
    }
    Ok((header, sections))
}

/// Whether nodes and objects fall into ranges by level, the first node into one of its own. So
/// that a walk that keeps to them ends, whatever else is damaged.
fn levels_hold_together(levels: &[u8], counts: &Counts) -> bool {
    let starts: Vec<u32> = levels
        .chunks_exact(size_of::<u32>())
        .map(bytemuck::pod_read_unaligned)
        .collect();
    let (nodes, objects) = starts.split_at(starts.len() / 2);
    let ranges = |starts: &[u32], count| {
        starts.is_sorted() && starts.first() == Some(&0) && starts.last() == Some(&count)
    };
    ranges(nodes, counts.nodes)
        && ranges(objects, counts.objects)
        && nodes.get(1).is_none_or(|&end| end == 1)
}

pub(super) fn counts(header: &Header) -> Counts {
    Counts {
        objects: header.objects,
        nodes: header.nodes,
        levels: header.levels,
        inner_nodes: header.inner_nodes,
    }
}

/// An image in the making: sections are allocated first, then filled in parallel.
pub(super) struct Draft {
    lines: Vec<Line>,
    sections: [Range<usize>; Section::ALL.len()],
}

impl Draft {
    /// `lengths` are those of the sections that the counts do not decide.
    pub(super) fn new(counts: &Counts, lengths: impl Fn(Section) -> usize) -> Self {
        let mut end = HEAD;
        let sections = Section::ALL.map(|section| {
            let length = section
                .length(counts)
                .map_or_else(|| lengths(section), |length| length as usize);
            let start = end;
            end = (start + length).next_multiple_of(ALIGNMENT);
            start..start + length
        });
        Self {
            lines: bytemuck::zeroed_vec(end / ALIGNMENT),
            sections,
        }
    }

    /// All sections, to be filled.
    pub(super) fn sections(&mut self) -> Sections<'_> {
        let mut rest: &mut [u8] = bytemuck::cast_slice_mut(&mut self.lines);
        let mut end = 0;
        Sections(self.sections.clone().map(|range| {
            let from = range.start - end;
            end = range.end;
            let (section, after) = std::mem::take(&mut rest)[from..].split_at_mut(range.len());
            rest = after;
            section
        }))
    }

    /// Adds header, section table and checksums.
    pub(super) fn finish(mut self, mut header: Header) -> Image {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut self.lines);
        header.length = bytes.len() as u64;
        header.sections = Section::ALL.len() as u32;
        let extents = extents(&self.sections, bytes.len());
        let table: Vec<TableEntry> = Section::ALL
            .par_iter()
            .map(|&section| TableEntry {
                tag: section.tag(),
                offset: self.sections[section as usize].start as u64,
                length: self.sections[section as usize].len() as u64,
                checksum: checksum(&bytes[extents[section as usize].clone()]),
                zero: 0,
            })
            .collect();
        bytes[table_range()].copy_from_slice(bytemuck::cast_slice(&table));
        bytes[..size_of::<Header>()].copy_from_slice(bytemuck::bytes_of(&header));
        header.checksum = header_checksum(bytes);
        bytes[..size_of::<Header>()].copy_from_slice(bytemuck::bytes_of(&header));
        Image {
            storage: Storage::Memory(self.lines),
            header,
            sections: self.sections,
        }
    }
}

/// The sections of an image in the making, side by side.
pub(super) struct Sections<'a>([&'a mut [u8]; Section::ALL.len()]);

impl<'a> Sections<'a> {
    /// A section, once: afterwards it is empty.
    pub(super) fn take<T: NoUninit + AnyBitPattern>(&mut self, section: Section) -> &'a mut [T] {
        bytemuck::cast_slice_mut(std::mem::take(&mut self.0[section as usize]))
    }

    /// Fills a section that is as long as `content`.
    pub(super) fn fill<T: NoUninit + AnyBitPattern>(&mut self, section: Section, content: &[T]) {
        self.take(section).copy_from_slice(content);
    }
}
