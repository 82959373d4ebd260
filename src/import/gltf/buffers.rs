//! The bytes that buffers and buffer views stand for.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::alphabet;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use super::document::{Buffer, Document};
use crate::import::collector::Collector;
use crate::import::{ImportError, Place};

/// Both with and without padding: writers differ.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The buffers of a file, by index; `None` where a buffer is missing.
pub(super) struct Buffers<'a> {
    bytes: Vec<Option<Cow<'a, [u8]>>>,
    total: usize,
}

impl<'a> Buffers<'a> {
    pub(super) fn open(
        document: &Document,
        binary: Option<&'a [u8]>,
        path: &Path,
        collector: &mut Collector,
    ) -> Result<Self, ImportError> {
        let open = |(index, buffer): (usize, &Buffer)| {
            let bytes = match buffer.uri {
                Some(uri) => resolve(uri.get(), index, buffer.byte_length, path, collector)?,
                // The first buffer without a URI is the binary chunk; any other is a placeholder
                // for what an extension unpacks.
                None if index == 0 => binary.map(Cow::Borrowed),
                None => None,
            };
            if let Some(found) = bytes.as_ref().map(|b| b.len())
                && found < buffer.byte_length
            {
                let place = Place::Pointer(format!("/buffers/{index}/byteLength"));
                let reason = format!(
                    "the buffer should have {} bytes, but has {found}",
                    buffer.byte_length
                );
                return Err(ImportError::malformed(path, place, reason));
            }
            Ok(bytes)
        };
        let bytes = document.buffers.iter().enumerate().map(open);
        let bytes: Vec<Option<Cow<[u8]>>> = bytes.collect::<Result<_, _>>()?;
        let total = bytes.iter().flatten().map(|bytes| bytes.len()).sum();
        Ok(Self { bytes, total })
    }

    /// Bytes of all buffers together.
    pub(super) fn total(&self) -> usize {
        self.total
    }

    pub(super) fn get(&self, index: usize) -> Option<&[u8]> {
        self.bytes.get(index)?.as_deref()
    }

    /// The bytes of a buffer view; `None` where its buffer is missing.
    pub(super) fn view(
        &self,
        document: &Document,
        index: usize,
        asked_by: &str,
        path: &Path,
    ) -> Result<Option<&[u8]>, ImportError> {
        let fail = |pointer: String, reason: String| {
            Err(ImportError::malformed(
                path,
                Place::Pointer(pointer),
                reason,
            ))
        };
        let Some(view) = document.buffer_views.get(index) else {
            let count = document.buffer_views.len();
            let reason = format!("there is no buffer view {index}; the file has {count}");
            return fail(asked_by.to_owned(), reason);
        };
        let Some(buffer) = document.buffers.get(view.buffer) else {
            let count = document.buffers.len();
            let reason = format!("there is no buffer {}; the file has {count}", view.buffer);
            return fail(format!("/bufferViews/{index}/buffer"), reason);
        };
        let end = view.byte_offset.checked_add(view.byte_length);
        let Some(end) = end.filter(|end| *end <= buffer.byte_length) else {
            let reason = format!(
                "{} bytes from byte {} do not fit into the {} bytes of buffer {}",
                view.byte_length, view.byte_offset, buffer.byte_length, view.buffer
            );
            return fail(format!("/bufferViews/{index}/byteLength"), reason);
        };
        let bytes = self.get(view.buffer);
        Ok(bytes.and_then(|bytes| bytes.get(view.byte_offset..end)))
    }
}

/// What a URI stands for; `None`, with a warning, where there is no such file.
fn resolve(
    raw: &str,
    index: usize,
    length: usize,
    path: &Path,
    collector: &mut Collector,
) -> Result<Option<Cow<'static, [u8]>>, ImportError> {
    let place = || Place::Pointer(format!("/buffers/{index}/uri"));
    let uri: String = serde_json::from_str(raw)
        .map_err(|error| ImportError::malformed(path, place(), error.to_string()))?;
    if let Some(data) = uri.strip_prefix("data:") {
        let bytes = decode(data).map_err(|r| ImportError::malformed(path, place(), r))?;
        return Ok(Some(Cow::Owned(bytes)));
    }
    let relative = relative(&uri).map_err(|r| ImportError::malformed(path, place(), r))?;
    let outside = |what: &str| {
        let reason = format!("{uri:?} {what}; put the buffer beside the glTF file");
        ImportError::malformed(path, place(), reason)
    };
    match inside(path, &relative).and_then(|file| file.map(|f| bytes_of(&f, length)).transpose()) {
        Ok(Some(bytes)) => Ok(Some(Cow::Owned(bytes))),
        Ok(None) => Err(outside("leads out of the folder of the file")),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let what = format!("the buffer file {uri:?} does not exist");
            collector.warn(None, place(), what);
            Ok(None)
        }
        Err(error) if error.kind() == io::ErrorKind::InvalidInput => {
            Err(outside("is not a file that can be read"))
        }
        Err(source) => Err(ImportError::Io {
            path: path.parent().unwrap_or(path).join(relative),
            source,
        }),
    }
}

fn decode(data: &str) -> Result<Vec<u8>, String> {
    let (kind, content) = data.split_once(',').ok_or("the data URI has no comma")?;
    if !kind.ends_with(";base64") {
        return Err("the data URI is not base64".to_owned());
    }
    BASE64
        .decode(content)
        .map_err(|error| format!("the data URI is broken: {error}"))
}

/// A path below the folder, judged after percent decoding so that nothing hides in the encoding.
fn relative(uri: &str) -> Result<PathBuf, String> {
    let refuse = |why: &str| {
        Err(format!(
            "{uri:?} {why}; only files in the folder of the glTF file or below are read"
        ))
    };
    let Ok(decoded) = percent_decode_str(uri).decode_utf8() else {
        return refuse("is not UTF-8");
    };
    if let Some((scheme, _)) = decoded.split_once(':')
        && scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.'))
    {
        return refuse("has a scheme");
    }
    if decoded.contains(['\\', '\0']) {
        return refuse("has a character that no path in a URI has");
    }
    let relative = PathBuf::from(decoded.as_ref());
    for component in relative.components() {
        match component {
            Component::Normal(_) | Component::CurDir => {}
            Component::ParentDir => return refuse("goes up a folder"),
            Component::RootDir | Component::Prefix(_) => return refuse("is an absolute path"),
        }
    }
    Ok(relative)
}

/// The file with all links followed; `None` where it lies outside the folder of `path`.
fn inside(path: &Path, relative: &Path) -> io::Result<Option<PathBuf>> {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let folder = folder.canonicalize()?;
    let file = folder.join(relative).canonicalize()?;
    Ok(file.starts_with(&folder).then_some(file))
}

fn bytes_of(file: &Path, length: usize) -> io::Result<Vec<u8>> {
    // A pipe or a device could be read forever.
    if !file.metadata()?.is_file() {
        return Err(io::Error::from(io::ErrorKind::InvalidInput));
    }
    let mut bytes = Vec::new();
    File::open(file)?
        .take(length as u64)
        .read_to_end(&mut bytes)?;
    Ok(bytes)
}
