//! Wavefront OBJ: vertices, faces, lines and points of each `o`, or of each `g` where no `o` is.
//!
//! Two passes over the text: the first takes the vertices and finds out whether the file has `o`,
//! the second takes what is made of them. So an element may name a vertex further down.
//!
//! Source: Wavefront, *Advanced Visualizer Manual*, appendix B1, "Object Files (.obj)", 3.0.

mod lines;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use compact_str::{CompactString, format_compact};

use super::collector::Collector;
use super::placing::Placing;
use super::shape::Shape;
use super::source::Source;
use super::{ImportError, Options, Place, Up};
use crate::geom::DVec3;

use lines::{Line, lines};

const CLASS: CompactString = CompactString::const_new("Building");

const REPROJECT: &str = "reproject the file to a system in metres";

/// Statements that say nothing of where an object lies.
const IGNORED: [&[u8]; 17] = [
    b"vt",
    b"vn",
    b"vp",
    b"s",
    b"mg",
    b"usemtl",
    b"mtllib",
    b"usemap",
    b"maplib",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"call",
    b"g",
];

pub(super) fn read(
    source: &Source,
    options: &Options,
    collector: &mut Collector,
    report: &dyn Fn(u64),
) -> Result<(), ImportError> {
    let text = source.bytes(report)?;
    let mut survey = Survey::of(&text, options.up.unwrap_or(Up::Z), source.path())?;
    if survey.vertices.is_empty() {
        let reason = "holds no vertex (`v x y z`)";
        return Err(ImportError::malformed(source.path(), Place::File, reason));
    }
    let mut placing = Placing::of(None, Place::File, REPROJECT, collector)?;
    placing.place(&mut survey.vertices, collector)?;
    let mut objects = Objects::new(&survey.vertices, placing.fault(), collector);
    for line in lines(&text) {
        objects.line(&line, survey.separator)?;
    }
    objects.end(true);
    Ok(())
}

/// What must be known before the first object can be made.
struct Survey {
    vertices: Vec<DVec3>,
    /// The statement that begins an object.
    separator: &'static [u8],
}

impl Survey {
    fn of(text: &[u8], up: Up, path: &Path) -> Result<Self, ImportError> {
        let mut survey = Self {
            vertices: Vec::new(),
            separator: b"g",
        };
        for line in lines(text) {
            match line.keyword() {
                b"v" => survey.vertices.push(turned(vertex(&line, path)?, up)),
                b"o" => survey.separator = b"o",
                _ => {}
            }
        }
        Ok(survey)
    }
}

/// `v x y z`, with a weight or a colour after it that says nothing of the place.
fn vertex(line: &Line, path: &Path) -> Result<DVec3, ImportError> {
    let mut words = line.words();
    let mut coordinate = |axis: &str| {
        let Some(word) = words.next() else {
            let reason = format!("the vertex has no {axis}; expected `v x y z`");
            return Err(ImportError::malformed(path, line.end(), reason));
        };
        number(word).ok_or_else(|| {
            let found = String::from_utf8_lossy(word);
            let reason = format!("{found:?} is not a number; expected the {axis} of a vertex");
            ImportError::malformed(path, line.place(word), reason)
        })
    };
    Ok(DVec3::new(
        coordinate("x")?,
        coordinate("y")?,
        coordinate("z")?,
    ))
}

fn number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

fn turned(v: DVec3, up: Up) -> DVec3 {
    match up {
        Up::Y => DVec3::new(v.x, -v.z, v.y),
        Up::Z => v,
    }
}

/// The second pass: one object after the other.
struct Objects<'a> {
    vertices: &'a [DVec3],
    path: PathBuf,
    /// What is wrong with vertices that are left out.
    fault: String,
    collector: &'a mut Collector,
    shape: Shape,
    /// How many vertices lie above the current line: what negative indices count from.
    above: usize,
    /// For each vertex the number of the last object that took it.
    taken_by: Vec<u32>,
    number: u32,
    /// Name and place of the current object; `None` before the first has begun.
    begun: Option<(CompactString, Place)>,
    has_elements: bool,
    unknown: BTreeSet<Vec<u8>>,
}

impl<'a> Objects<'a> {
    fn new(vertices: &'a [DVec3], fault: String, collector: &'a mut Collector) -> Self {
        Self {
            vertices,
            path: collector.path().to_owned(),
            fault,
            collector,
            shape: Shape::default(),
            above: 0,
            taken_by: vec![0; vertices.len()],
            number: 1,
            begun: None,
            has_elements: false,
            unknown: BTreeSet::new(),
        }
    }

    fn line(&mut self, line: &Line, separator: &[u8]) -> Result<(), ImportError> {
        match line.keyword() {
            b"v" => self.above += 1,
            b"f" => self.element(line, 3)?,
            b"l" => self.element(line, 2)?,
            b"p" => self.element(line, 1)?,
            word if word == separator => self.begin(line),
            word if word.is_empty() || IGNORED.contains(&word) => {}
            word => self.unknown(word, line),
        }
        Ok(())
    }

    /// `f`, `l` or `p`: takes the vertices it names; a face adds its triangles.
    fn element(&mut self, line: &Line, at_least: usize) -> Result<(), ImportError> {
        let mut count = 0;
        for word in line.words() {
            let index = self
                .index(word)
                .map_err(|reason| ImportError::malformed(&self.path, line.place(word), reason))?;
            if self.taken_by[index] != self.number {
                self.taken_by[index] = self.number;
                self.shape.vertex(self.vertices[index]);
            }
            count += 1;
        }
        if count < at_least {
            let what = String::from_utf8_lossy(line.keyword());
            let reason = format!("`{what}` names {count} vertices; expected at least {at_least}");
            return Err(ImportError::malformed(&self.path, line.end(), reason));
        }
        if at_least == 3 {
            self.shape.triangles(count as u64 - 2);
        }
        self.has_elements = true;
        Ok(())
    }

    /// Vertex number from `7`, `7/1`, `7//2`, `7/1/2` or, counted back from here, `-1`.
    fn index(&self, word: &[u8]) -> Result<usize, String> {
        let digits = &word[..memchr::memchr(b'/', word).unwrap_or(word.len())];
        let count = self.vertices.len();
        let position = match digits.strip_prefix(b"-") {
            None => unsigned(digits).map(|n| n.checked_sub(1)),
            Some(back) => unsigned(back).map(|n| self.above.checked_sub(n).filter(|_| n > 0)),
        };
        let shown = || String::from_utf8_lossy(digits).into_owned();
        match position {
            None => Err(format!("{:?} is not a vertex index", shown())),
            Some(Some(index)) if index < count => Ok(index),
            Some(_) => Err(format!(
                "there is no vertex {}; the file has {count}, of which {} are above this line",
                shown(),
                self.above
            )),
        }
    }

    fn begin(&mut self, line: &Line) {
        self.end(false);
        let name = line.rest();
        let name = if name.is_empty() {
            format_compact!("object-{}", self.number)
        } else {
            CompactString::from_utf8_lossy(name)
        };
        self.begun = Some((name, line.start()));
    }

    /// Hands the current object over; a file without any is itself one.
    fn end(&mut self, is_last: bool) {
        let has_elements = std::mem::take(&mut self.has_elements);
        let (id, place) = match self.begun.take() {
            Some(begun) => begun,
            // What lies before the first object is one only if there is something to draw.
            None if has_elements || (is_last && self.number == 1) => (self.stem(), Place::File),
            None => return,
        };
        self.number += 1;
        self.hand_over(&id, place, has_elements);
        self.shape.clear();
    }

    fn hand_over(&mut self, id: &CompactString, place: Place, has_elements: bool) {
        let not_finite = self.shape.not_finite();
        let object = self.shape.object(id.clone(), CLASS, None);
        if object.is_none() {
            let reason = if has_elements {
                "no vertex that can be used"
            } else {
                "no face, line or point"
            };
            self.collector.left_out("object", reason);
        }
        let what = match (&object, not_finite) {
            (Some(_), 0) => None,
            (Some(_), _) => Some(format!(
                "{not_finite} vertices that are {} are left out",
                self.fault
            )),
            (None, _) if has_elements => {
                Some(format!("all its vertices are {}; left out", self.fault))
            }
            (None, _) => Some("has no face, line or point; left out".into()),
        };
        if let Some(what) = what {
            self.collector.warn(Some(id), place, what);
        }
        if let Some(object) = object {
            self.collector.object(object);
        }
    }

    /// What an object without a name is called: the file name without its endings.
    fn stem(&self) -> CompactString {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        let name = name.strip_suffix(".gz").unwrap_or(&name);
        CompactString::from(name.rsplit_once('.').map_or(name, |(stem, _)| stem))
    }

    fn unknown(&mut self, word: &[u8], line: &Line) {
        if !self.unknown.contains(word) && self.unknown.len() < MAX_UNKNOWN {
            self.unknown.insert(word.to_vec());
            let what = format!(
                "statement {:?} is not read; such lines are left out",
                String::from_utf8_lossy(&word[..word.len().min(32)])
            );
            self.collector.warn(None, line.start(), what);
        }
    }
}

/// More kinds of unknown statements than this are not told one by one.
const MAX_UNKNOWN: usize = 16;

/// Decimal digits only; a number beyond `usize` is as good as the largest.
fn unsigned(digits: &[u8]) -> Option<usize> {
    if digits.is_empty() {
        return None;
    }
    digits.iter().try_fold(0_usize, |n, byte| {
        let digit = byte.wrapping_sub(b'0');
        (digit < 10).then(|| n.saturating_mul(10).saturating_add(usize::from(digit)))
    })
}
