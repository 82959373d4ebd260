//! A glTF file taken apart: the JSON and, in a GLB, the binary chunk.
//!
//! Source: glTF 2.0 specification, section 4 "GLB File Format Specification".

use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::error::Category;
use serde_path_to_error::Segment;

use super::document::{Asset, Document};
use crate::import::{ImportError, Place};

const MAGIC: &[u8; 4] = b"glTF";
const JSON_CHUNK: u32 = 0x4e4f_534a;
const BIN_CHUNK: u32 = 0x004e_4942;
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

pub(super) struct Container<'a> {
    json: &'a [u8],
    /// Where the JSON begins in a GLB; `None` in a file that is all JSON.
    json_offset: Option<usize>,
    pub(super) binary: Option<&'a [u8]>,
}

impl<'a> Container<'a> {
    pub(super) fn open(bytes: &'a [u8], path: &Path) -> Result<Self, ImportError> {
        if bytes.is_empty() {
            let reason = "the file is empty; expected glTF JSON or a GLB";
            return Err(ImportError::malformed(path, Place::Byte(0), reason));
        }
        if bytes.starts_with(MAGIC) {
            return Self::glb(bytes, path);
        }
        let text = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        if !text.trim_ascii_start().starts_with(b"{") {
            let reason = "is neither a GLB, which begins with `glTF`, nor glTF JSON";
            return Err(ImportError::malformed(path, Place::Byte(0), reason));
        }
        if is_tileset(text) {
            return Err(ImportError::Unsupported {
                path: path.to_owned(),
                feature: "a reader of 3D Tiles tilesets".to_owned(),
                way_out: "import the .glb contents it names".to_owned(),
            });
        }
        Ok(Self {
            json: bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes),
            json_offset: None,
            binary: None,
        })
    }

    fn glb(bytes: &'a [u8], path: &Path) -> Result<Self, ImportError> {
        let fail = |offset: usize, reason: String| {
            ImportError::malformed(path, Place::Byte(offset as u64), reason)
        };
        let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
            let reason = "the file ends within the GLB header".to_owned();
            return Err(fail(bytes.len(), reason));
        };
        if version != 2 {
            return Err(ImportError::Unsupported {
                path: path.to_owned(),
                feature: format!("GLB version {version}"),
                way_out: "convert the file to glTF 2.0".to_owned(),
            });
        }
        let Some(bytes) = bytes.get(..length as usize) else {
            let reason = format!(
                "the file ends here, but its header says it has {length} bytes; fetch it again"
            );
            return Err(fail(bytes.len(), reason));
        };
        let (kind, json) = chunk(bytes, HEADER).map_err(|(at, reason)| fail(at, reason))?;
        if kind != JSON_CHUNK {
            return Err(fail(HEADER + 4, "the first chunk is not JSON".to_owned()));
        }
        let mut offset = json.end;
        let mut binary = None;
        // Chunks of unknown kind are to be ignored; so is padding too short for a chunk.
        while binary.is_none() && offset + CHUNK_HEADER <= bytes.len() {
            let (kind, range) = chunk(bytes, offset).map_err(|(at, reason)| fail(at, reason))?;
            offset = range.end;
            binary = (kind == BIN_CHUNK).then(|| &bytes[range]);
        }
        Ok(Self {
            json_offset: Some(json.start),
            json: &bytes[json],
            binary,
        })
    }

    pub(super) fn document(&self, path: &Path) -> Result<Document<'a>, ImportError> {
        serde_json::from_slice(self.json).map_err(|error| {
            let place = match error.classify() {
                Category::Data => self.pointer(),
                Category::Io | Category::Syntax | Category::Eof => None,
            };
            let place = place.unwrap_or_else(|| self.position(&error));
            ImportError::malformed(path, place, error.to_string())
        })
    }

    /// Where a value is not of the kind the specification asks for.
    fn pointer(&self) -> Option<Place> {
        let mut reader = serde_json::Deserializer::from_slice(self.json);
        let error = serde_path_to_error::deserialize::<_, Document>(&mut reader).err()?;
        let mut pointer = String::new();
        for segment in error.path() {
            pointer.push('/');
            match segment {
                Segment::Seq { index } => pointer.push_str(&index.to_string()),
                Segment::Map { key } | Segment::Enum { variant: key } => {
                    pointer.push_str(&escaped(key));
                }
                Segment::Unknown => pointer.push('?'),
            }
        }
        Some(Place::Pointer(pointer))
    }

    /// Where the text is not JSON.
    fn position(&self, error: &serde_json::Error) -> Place {
        let Some(json_offset) = self.json_offset else {
            return Place::Line(error.line(), error.column().max(1));
        };
        let line_start = match error.line() {
            0 | 1 => 0,
            line => memchr::memchr_iter(b'\n', self.json)
                .nth(line - 2)
                .map_or(0, |newline| newline + 1),
        };
        Place::Byte((json_offset + line_start + error.column().saturating_sub(1)) as u64)
    }
}

/// A key as it stands in a JSON pointer.
pub(super) fn escaped(key: &str) -> String {
    key.replace('~', "~0").replace('/', "~1")
}

/// Whether the text is a 3D Tiles tileset: it too has an `asset`, and a `root` and no glTF version.
fn is_tileset(text: &[u8]) -> bool {
    #[derive(Deserialize)]
    struct Tileset {
        asset: Asset,
        #[allow(dead_code, reason = "that it is there is what counts")]
        root: IgnoredAny,
    }
    serde_json::from_slice(text).is_ok_and(|t: Tileset| !t.asset.version.starts_with("2."))
}

fn word(bytes: &[u8], offset: usize) -> Option<u32> {
    let bytes = bytes.get(offset..)?.first_chunk()?;
    Some(u32::from_le_bytes(*bytes))
}

/// Kind and content of the chunk at `offset`, or where it is broken and how.
fn chunk(bytes: &[u8], offset: usize) -> Result<(u32, Range<usize>), (usize, String)> {
    let (Some(length), Some(kind)) = (word(bytes, offset), word(bytes, offset + 4)) else {
        return Err((offset, "the file ends before this chunk".to_owned()));
    };
    let start = offset + CHUNK_HEADER;
    let left = bytes.len().saturating_sub(start);
    if length as usize > left {
        let reason = format!("the chunk says it has {length} bytes, but {left} are left");
        return Err((offset, reason));
    }
    Ok((kind, start..start + length as usize))
}
