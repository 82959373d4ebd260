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
    gzipped: bool,
}

/// What a gzipped file may unpack to where it must be in memory as a whole. A few megabytes of
/// gzip can hold thousands of times as much; who means it unpacks the file first.
const LARGEST_UNPACKED_BYTES: u64 = 4 << 30;
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
        if !metadata.is_file() {
            let what =
                "it is a pipe or a device, and it takes a second look; save it to a file first";
            return Err(io(io::Error::other(what)));
        }
        let mut source = Self {
            path: path.to_owned(),
            size: metadata.len(),
            format: Format::GeoJson,
            gzipped: is_gzipped(path).map_err(io)?,
        };
        let mut head = Vec::new();
        source
            .reader(&|_| {})?
            .take(SNIFF_BYTES as u64)
            .read_to_end(&mut head)
            .map_err(io)?;
        source.format = format_of(path, &head).ok_or_else(|| {
            let path = path.to_owned();
            match path.extension() {
                Some(extension) if extension == "citylod" => ImportError::AlreadyCity { path },
                _ => ImportError::UnknownFormat { path },
            }
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
        let counted = Counted {
            inner: File::open(&self.path).map_err(|e| self.io_error(e))?,
            read: 0,
            report,
        };
        Ok(if self.gzipped {
            Box::new(MultiGzDecoder::new(BufReader::with_capacity(
                1 << 16,
                counted,
            )))
        } else {
            Box::new(counted)
        })
    }

    /// The most bytes that one value of the content may take in memory.
    pub(super) fn largest_value(&self) -> usize {
        if self.gzipped {
            usize::try_from(LARGEST_UNPACKED_BYTES).unwrap_or(usize::MAX)
        } else {
            usize::MAX
        }
    }

    /// The whole content, unpacked.
    pub(super) fn bytes(&self, report: &dyn Fn(u64)) -> Result<Vec<u8>, ImportError> {
        self.bytes_within(LARGEST_UNPACKED_BYTES, report)
    }

    /// The whole content, of which no more than `limit` bytes may be unpacked.
    fn bytes_within(&self, limit: u64, report: &dyn Fn(u64)) -> Result<Vec<u8>, ImportError> {
        let limit = if self.gzipped { limit } else { u64::MAX - 1 };
        let mut bytes = Vec::new();
        self.reader(report)?
            .take(limit + 1)
            .read_to_end(&mut bytes)
            .map_err(|e| self.io_error(e))?;
        if bytes.len() as u64 > limit {
            return Err(ImportError::Unsupported {
                path: self.path.clone(),
                feature: format!("more than {limit} bytes unpacked"),
                way_out: "unpack it beforehand, or split it".into(),
            });
        }
        Ok(bytes)
    }
}

fn is_gzipped(path: &Path) -> io::Result<bool> {
    let mut magic = [0; 2];
    Ok(File::open(path)?.read_exact(&mut magic).is_ok() && magic == GZIP_MAGIC)
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
                // A 3D Tiles tileset also begins so, and is told there.
                Some(Format::Gltf)
            } else {
                // Nothing to go by: CityJSON is what `.json` means for cities.
                Some(Format::CityJson)
            }
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::*;

    #[test]
    fn only_what_is_gzipped_has_a_largest_size() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
        packed.write_all(&[b' '; 1000]).expect("room");
        let packed = packed.finish().expect("room");
        for (name, content, limit, fits) in [
            ("a.obj.gz", packed.as_slice(), 1000, true),
            ("b.obj.gz", packed.as_slice(), 999, false),
            ("c.obj", &[b' '; 1000], 10, true),
        ] {
            let path = folder.path().join(name);
            std::fs::write(&path, content).expect("a file");
            let source = Source::open(&path).expect("a source");
            match source.bytes_within(limit, &|_| {}) {
                Ok(bytes) => assert!(fits && bytes.len() == 1000, "{name}"),
                Err(error) => {
                    assert!(!fits, "{name}: {error}");
                    assert!(error.to_string().contains("999 bytes unpacked"), "{error}");
                }
            }
        }
    }
}
