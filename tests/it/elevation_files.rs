use std::io::Write as _;

use citylod::terrain::read::{Options, Raster, read};

/// A little-endian TIFF: entries of tag, type and values; strip or tile data after it.
pub struct Tiff {
    entries: Vec<(u16, u16, Vec<u8>, u32)>,
    pub data: Vec<u8>,
}

pub const SHORT: u16 = 3;
pub const LONG: u16 = 4;
pub const DOUBLE: u16 = 12;
pub const ASCII: u16 = 2;

impl Tiff {
    /// Three columns, two rows of int16 in one strip, 10 m apart in EPSG:32632.
    pub fn small() -> Self {
        let mut tiff = Self {
            entries: vec![],
            data: [1_i16, 2, 3, 4, 5, -9]
                .iter()
                .flat_map(|h| h.to_le_bytes())
                .collect(),
        };
        for (tag, value) in [
            (256, 3),
            (257, 2),
            (258, 16),
            (259, 1),
            (262, 1),
            (277, 1),
            (278, 2),
            (339, 2),
        ] {
            tiff.short(tag, &[value]);
        }
        tiff.long(273, &[8]);
        tiff.long(279, &[12]);
        tiff.double(33550, &[10.0, 10.0, 0.0]);
        tiff.double(33922, &[0.0, 0.0, 0.0, 500.0, 900.0, 0.0]);
        tiff.short(34735, &[1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32632]);
        tiff.put(42113, ASCII, b"-9\0", 3);
        tiff
    }

    pub fn put(&mut self, tag: u16, kind: u16, bytes: &[u8], count: u32) -> &mut Self {
        self.entries.retain(|entry| entry.0 != tag);
        self.entries.push((tag, kind, bytes.to_vec(), count));
        self
    }

    pub fn without(&mut self, tag: u16) -> &mut Self {
        self.entries.retain(|entry| entry.0 != tag);
        self
    }

    pub fn holding(&mut self, data: &[u8]) -> &mut Self {
        self.data = data.to_vec();
        self
    }

    pub fn short(&mut self, tag: u16, values: &[u16]) -> &mut Self {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.put(tag, SHORT, &bytes, values.len() as u32)
    }

    pub fn long(&mut self, tag: u16, values: &[u32]) -> &mut Self {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.put(tag, LONG, &bytes, values.len() as u32)
    }

    pub fn double(&mut self, tag: u16, values: &[f64]) -> &mut Self {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.put(tag, DOUBLE, &bytes, values.len() as u32)
    }

    pub fn bytes(&self) -> Vec<u8> {
        let mut entries = self.entries.clone();
        entries.sort_by_key(|entry| entry.0);
        let directory = 8 + self.data.len().next_multiple_of(2);
        let mut free = directory + 2 + entries.len() * 12 + 4;
        let mut out = vec![b'I', b'I', 42, 0];
        out.extend((directory as u32).to_le_bytes());
        out.extend(&self.data);
        out.resize(directory, 0);
        out.extend((entries.len() as u16).to_le_bytes());
        let mut tail: Vec<u8> = Vec::new();
        for (tag, kind, bytes, count) in &entries {
            out.extend(tag.to_le_bytes());
            out.extend(kind.to_le_bytes());
            out.extend(count.to_le_bytes());
            if bytes.len() <= 4 {
                let mut inline = bytes.clone();
                inline.resize(4, 0);
                out.extend(inline);
            } else {
                out.extend((free as u32).to_le_bytes());
                free += bytes.len();
                tail.extend(bytes);
            }
        }
        out.extend([0; 4]);
        out.extend(tail);
        out
    }
}

pub fn with(change: impl FnOnce(&mut Tiff) -> &mut Tiff) -> Vec<u8> {
    let mut tiff = Tiff::small();
    change(&mut tiff);
    tiff.bytes()
}

/// Makes tiles of the strip, `side` posts a side.
pub fn tiled(tiff: &mut Tiff, side: u32) -> &mut Tiff {
    let length = tiff.data.len() as u32;
    tiff.without(273).without(278).without(279);
    tiff.long(322, &[side]).long(323, &[side]);
    tiff.long(324, &[8]).long(325, &[length])
}

/// A raster of so many rows and columns whose only strip is left out.
pub fn empty_tiff(side: u32) -> Vec<u8> {
    with(|t| {
        t.long(256, &[side]).long(257, &[side]);
        t.long(278, &[side]).long(279, &[0])
    })
}

pub fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

/// 600 kB that unpack to 256,000,000 heights: 160 strips that share one deflated run of zeros.
pub fn deflate_bomb() -> Vec<u8> {
    let strip = deflated(&vec![0; 16_000 * 100 * 2]);
    let mut data = strip.clone();
    data.resize(600_000, 0);
    with(|t| {
        t.long(256, &[16_000]).long(257, &[16_000]);
        t.long(278, &[100]).short(259, &[8]);
        t.long(273, &[8; 160]).long(279, &[strip.len() as u32; 160]);
        t.holding(&data)
    })
}

/// Three by two heights whose strip goes on for 400 MB.
pub fn endless_strip() -> Vec<u8> {
    let strip = deflated(&vec![0; 400_000_000]);
    with(|t| {
        t.short(259, &[8]).long(279, &[strip.len() as u32]);
        t.holding(&strip)
    })
}

/// An 8-bit RGB picture.
pub fn picture(width: u32, height: u32, pixels: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder
        .write_header()
        .unwrap()
        .write_image_data(pixels)
        .unwrap();
    out
}

pub const ASC: &str = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n1 2 3\n4 -1 6.5\n";

pub fn read_bytes(name: &str, bytes: &[u8]) -> Result<Raster, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let options = Options {
        bounds: Some([0.0, 0.0, 100.0, 100.0]),
        ..Options::default()
    };
    read(&path, &options).map_err(|error| {
        let text = error.to_string();
        assert!(text.contains(name), "{text} does not name the file {name}");
        text
    })
}
