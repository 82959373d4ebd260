//! A file as it lies on disk: what format it is, and its bytes, unpacked where it is gzipped.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;

use super::ImportError;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    /// glTF 2.0, as JSON or as GLB.
    Gltf,
    Obj,
    /// A `CityJSON` document or a `CityJSONSeq` stream.
    CityJson,
    /// A feature collection or one feature a line.
    GeoJson,
}

pub(super) struct Source {
    path: PathBuf,
    size: u64,
    format: Format,
}

const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];
/// How much of the content is looked at to tell the format where the name does not.
const SNIFF_BYTES: usize = 64 * 1024;

impl Source {
    pub(super) fn open(path: &Path) -> Result<Self, ImportError> {
        let io = |source| ImportError::Io {
            path: path.to_owned(),
            source,
        };
        let metadata = path.metadata().map_err(io)?;
        if metadata.is_dir() {
            return Err(io(io::Error::from(io::ErrorKind::IsADirectory)));
        }
        let mut source = Self {
            path: path.to_owned(),
            size: metadata.len(),
            format: Format::GeoJson,
        };
        let mut head = Vec::new();
        source
            .reader(&|_| {})?
            .take(SNIFF_BYTES as u64)
            .read_to_end(&mut head)
            .map_err(io)?;
        source.format = format_of(path, &head).ok_or_else(|| ImportError::UnknownFormat {
            path: path.to_owned(),
        })?;
        Ok(source)
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn size_on_disk(&self) -> u64 {
        self.size
    }

    pub(super) fn format(&self) -> Format {
        self.format
    }

    pub(super) fn io_error(&self, source: io::Error) -> ImportError {
        ImportError::Io {
            path: self.path.clone(),
            source,
        }
    }

    /// The content, unpacked on the way; `report` is called with the bytes taken from disk.
    pub(super) fn reader<'a>(
        &self,
        report: &'a dyn Fn(u64),
    ) -> Result<Box<dyn Read + 'a>, ImportError> {
        let open = || File::open(&self.path).map_err(|e| self.io_error(e));
        let mut magic = [0; 2];
        let gzipped = open()?.read_exact(&mut magic).is_ok() && magic == GZIP_MAGIC;
        let counted = Counted {
            inner: open()?,
            read: 0,
            report,
        };
        Ok(if gzipped {
            Box::new(MultiGzDecoder::new(BufReader::with_capacity(
                1 << 16,
                counted,
            )))
        } else {
            Box::new(counted)
        })
    }

    /// The whole content, unpacked.
    pub(super) fn bytes(&self, report: &dyn Fn(u64)) -> Result<Vec<u8>, ImportError> {
        let mut bytes = Vec::new();
        self.reader(report)?
            .read_to_end(&mut bytes)
            .map_err(|e| self.io_error(e))?;
        Ok(bytes)
    }
}

struct Counted<'a, R> {
    inner: R,
    read: u64,
    report: &'a dyn Fn(u64),
}

impl<R: Read> Read for Counted<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.read += n as u64;
        (self.report)(self.read);
        Ok(n)
    }
}

/// The format by name; `.json` and `.jsonl` by what the content says it is.
fn format_of(path: &Path, head: &[u8]) -> Option<Format> {
    let name = path.file_name()?.to_string_lossy().to_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    let (_, extension) = name.rsplit_once('.')?;
    match extension {
        "gltf" | "glb" => Some(Format::Gltf),
        "obj" => Some(Format::Obj),
        "geojson" | "geojsonl" | "ndjson" | "geojsons" => Some(Format::GeoJson),
        "json" | "jsonl" => {
            let says = |word: &str| memchr::memmem::find(head, word.as_bytes()).is_some();
            if says("CityJSON") || says("CityObjects") {
                Some(Format::CityJson)
            } else if says("Feature") || says("Polygon") {
                Some(Format::GeoJson)
            } else if says("\"asset\"") {
                Some(Format::Gltf)
            } else {
                // Nothing to go by: CityJSON is what `.json` means for cities.
                Some(Format::CityJson)
            }
        }
        _ => None,
    }
}
