use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use citylod::geom::DVec2;
use citylod::terrain::HeightField;
use citylod::terrain::read::{Options, Raster, Units, read};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const BOUNDS: [f64; 4] = [1000.0, 2000.0, 3560.0, 4560.0];
const POINTS: usize = 1000;

/// A python that has rasterio: from the environment, from `.venv`, or from the path.
fn python() -> Option<PathBuf> {
    let candidates = [
        std::env::var_os("RASTERIO_PYTHON").map(PathBuf::from),
        Some(Path::new(env!("CARGO_MANIFEST_DIR")).join(".venv/bin/python")),
        Some(PathBuf::from("python3")),
    ];
    candidates.into_iter().flatten().find(|python| {
        let import = Command::new(python)
            .args(["-c", "import rasterio"])
            .output();
        import.is_ok_and(|output| output.status.success())
    })
}

fn oracle() -> PathBuf {
    Path::new(file!()).with_file_name("elevation.py")
}

fn position(field: &HeightField, column: f64, row: f64) -> [f64; 2] {
    let grid = field.grid();
    (grid.origin() + DVec2::new(column, row) * grid.spacing()).to_array()
}

/// A line for the oracle: random points of a raster and the heights found there.
fn report(file: &Path, raster: &Raster, on_plane: bool, random: &mut Pcg64Mcg) -> String {
    let field = &raster.field;
    let points = (0..POINTS).map(|_| {
        let column = random.random_range(0..field.grid().columns());
        let row = random.random_range(0..field.grid().rows());
        // Anywhere in the post's cell, or on the post itself.
        let mut aside = || {
            if on_plane {
                0.0
            } else {
                random.random_range(-0.499..0.499)
            }
        };
        let [x, y] = position(field, f64::from(column) + aside(), f64::from(row) + aside());
        let height = field.height(column, row);
        (x, y, (!height.is_nan()).then_some(height))
    });
    let is_png = file.extension().is_some_and(|e| e == "png");
    serde_json::json!({
        "file": file,
        "points": points.collect::<Vec<_>>(),
        "bounds": is_png.then_some(BOUNDS),
        "plane": on_plane.then(|| raster.crs.clone()),
    })
    .to_string()
}

fn options(file: &Path) -> Options {
    let is_png = file.extension().is_some_and(|e| e == "png");
    Options {
        bounds: is_png.then_some(BOUNDS),
        ..Options::default()
    }
}

/// Heights at 1,000 random points of each file, of every format, are those that rasterio reads,
/// and on the plane those that PROJ and bilinear interpolation give.
#[test]
fn heights_are_those_that_rasterio_reads() {
    let Some(python) = python() else {
        println!("skipped: no python with rasterio; set RASTERIO_PYTHON to one");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let wrote = Command::new(&python)
        .arg(oracle())
        .arg("write")
        .arg(folder.path())
        .output()
        .unwrap();
    assert!(
        wrote.status.success(),
        "{}",
        String::from_utf8_lossy(&wrote.stderr)
    );
    let mut folders = vec![folder.path().to_owned()];
    match std::env::var("CITYLOD_DATA") {
        Ok(data) => folders.push(Path::new(&data).join("dem")),
        Err(_) => println!("skipped for real elevation: CITYLOD_DATA is not set"),
    }
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut lines = Vec::new();
    for folder in folders {
        let files = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path());
        let mut files: Vec<_> = files
            .filter(|f| !f.to_string_lossy().ends_with(".xml"))
            .collect();
        files.sort();
        for file in files {
            let raster = read(&file, &options(&file)).unwrap();
            lines.push(report(&file, &raster, false, &mut random));
            if raster.units == Units::Degrees {
                let metric = raster.to_metres(&file, None).unwrap();
                assert_eq!(metric.units, Units::Metres);
                lines.push(report(&file, &metric, true, &mut random));
            }
        }
    }
    assert!(lines.len() >= 13, "{}", lines.len());
    let mut judge = Command::new(&python)
        .arg(oracle())
        .arg("judge")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = judge.stdin.take().unwrap();
    stdin.write_all(lines.join("\n").as_bytes()).unwrap();
    drop(stdin);
    let judged = judge.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&judged.stderr);
    assert!(judged.status.success(), "{said}");
    print!("{}", String::from_utf8_lossy(&judged.stdout));
}

/// A little-endian TIFF: entries of tag, type and values; strip or tile data after it.
struct Tiff {
    entries: Vec<(u16, u16, Vec<u8>, u32)>,
    data: Vec<u8>,
}

const SHORT: u16 = 3;
const LONG: u16 = 4;
const DOUBLE: u16 = 12;
const ASCII: u16 = 2;

impl Tiff {
    /// Three columns, two rows of int16 in one strip, 10 m apart in EPSG:32632.
    fn small() -> Self {
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

    fn put(&mut self, tag: u16, kind: u16, bytes: &[u8], count: u32) -> &mut Self {
        self.entries.retain(|entry| entry.0 != tag);
        self.entries.push((tag, kind, bytes.to_vec(), count));
        self
    }

    fn without(&mut self, tag: u16) -> &mut Self {
        self.entries.retain(|entry| entry.0 != tag);
        self
    }

    fn holding(&mut self, data: &[u8]) -> &mut Self {
        self.data = data.to_vec();
        self
    }

    fn short(&mut self, tag: u16, values: &[u16]) -> &mut Self {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.put(tag, SHORT, &bytes, values.len() as u32)
    }

    fn long(&mut self, tag: u16, values: &[u32]) -> &mut Self {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.put(tag, LONG, &bytes, values.len() as u32)
    }

    fn double(&mut self, tag: u16, values: &[f64]) -> &mut Self {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.put(tag, DOUBLE, &bytes, values.len() as u32)
    }

    fn bytes(&self) -> Vec<u8> {
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

fn with(change: impl FnOnce(&mut Tiff) -> &mut Tiff) -> Vec<u8> {
    let mut tiff = Tiff::small();
    change(&mut tiff);
    tiff.bytes()
}

/// A raster of so many rows and columns whose only strip is left out.
pub fn empty_tiff(side: u32) -> Vec<u8> {
    with(|t| {
        t.long(256, &[side]).long(257, &[side]);
        t.long(278, &[side]).long(279, &[0])
    })
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

/// An 8-bit RGB picture.
fn picture(width: u32, height: u32, pixels: &[u8]) -> Vec<u8> {
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

const ASC: &str = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n1 2 3\n4 -1 6.5\n";

fn read_bytes(name: &str, bytes: &[u8]) -> Result<Raster, String> {
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

#[test]
fn small_files_come_to_the_posts_they_state() {
    let none = f32::NAN;
    let hgt: Vec<u8> = [1_i16, 2, 3, 4, -32768, 6, 7, 8, 9]
        .iter()
        .flat_map(|h| h.to_be_bytes())
        .collect();
    let rgb = [1, 134, 160, 1, 134, 170]; // 0 m and 1 m
    for (name, bytes, origin, spacing, heights) in [
        (
            "a.tif",
            Tiff::small().bytes(),
            [505.0, 885.0],
            [10.0, 10.0],
            vec![4.0, 5.0, none, 1.0, 2.0, 3.0],
        ),
        // Rows from the south, by a matrix.
        (
            "b.tif",
            with(|t| {
                t.without(33550).without(33922);
                let mut matrix = [0.0; 16];
                (matrix[0], matrix[3], matrix[5], matrix[7], matrix[15]) =
                    (10.0, 500.0, 20.0, 900.0, 1.0);
                t.double(34264, &matrix)
            }),
            [505.0, 910.0],
            [10.0, 20.0],
            vec![1.0, 2.0, 3.0, 4.0, 5.0, none],
        ),
        // Cells are points; the tie point is not the first cell.
        (
            "c.tif",
            with(|t| {
                t.short(34735, &[1, 1, 0, 2, 1024, 0, 1, 1, 1025, 0, 1, 2]);
                t.double(33922, &[1.0, 1.0, 0.0, 500.0, 900.0, 0.0])
            }),
            [490.0, 900.0],
            [10.0, 10.0],
            vec![4.0, 5.0, none, 1.0, 2.0, 3.0],
        ),
        (
            "a.asc",
            ASC.into(),
            [105.0, 205.0],
            [10.0, 10.0],
            vec![4.0, none, 6.5, 1.0, 2.0, 3.0],
        ),
        (
            "b.asc",
            ASC.replace("corner", "center")
                .replace('\n', "\r\n")
                .to_uppercase()
                .into(),
            [100.0, 200.0],
            [10.0, 10.0],
            vec![4.0, none, 6.5, 1.0, 2.0, 3.0],
        ),
        (
            "s02w003.hgt",
            hgt,
            [-3.0, -2.0],
            [0.5, 0.5],
            vec![7.0, 8.0, 9.0, 4.0, none, 6.0, 1.0, 2.0, 3.0],
        ),
        (
            "a.png",
            picture(2, 1, &rgb),
            [25.0, 50.0],
            [50.0, 100.0],
            vec![0.0, 1.0],
        ),
        (
            "b.png",
            picture(2, 1, &[128, 3, 128, 127, 255, 0]),
            [25.0, 50.0],
            [50.0, 100.0],
            vec![3.5, -1.0],
        ),
    ] {
        let raster = read_bytes(name, &bytes).unwrap();
        let grid = raster.field.grid();
        assert_eq!(
            (grid.origin().to_array(), grid.spacing().to_array()),
            (origin, spacing),
            "{name}"
        );
        let bits = |h: &[f32]| h.iter().map(|h| h.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(raster.field.heights()), bits(&heights), "{name}");
    }
}

#[test]
fn broken_files_are_refused_with_the_place() {
    let mut wrong = Vec::new();
    let bomb = deflated(&vec![0; 40_000_000]);
    fn tiled(t: &mut Tiff, side: u32) -> &mut Tiff {
        t.without(273).without(278).without(279);
        t.long(322, &[side])
            .long(323, &[side])
            .long(324, &[8])
            .long(325, &[12])
    }
    for (name, bytes, words) in [
        ("a.tif", b"no raster".to_vec(), &["signature"][..]),
        ("b.tif", vec![], &["signature"]),
        ("c.tif", Tiff::small().bytes()[..30].to_vec(), &["cut off"]),
        (
            "d.tif",
            with(|t| {
                t.long(256, &[60_000])
                    .long(257, &[60_000])
                    .long(278, &[60_000])
            }),
            &["60000 x 60000 posts", "coarser"],
        ),
        (
            "e.tif",
            with(|t| {
                t.long(256, &[10_000])
                    .long(257, &[10_000])
                    .long(278, &[10_000])
            }),
            &["do not fit"],
        ),
        (
            "f.tif",
            with(|t| t.long(256, &[0])),
            &["no readable TIFF", "0x2"],
        ),
        (
            "g.tif",
            with(|t| t.long(273, &[4_000_000_000])),
            &["strip or tile 0", "cut off"],
        ),
        (
            "h.tif",
            with(|t| t.long(279, &[4_000_000_000])),
            &["strip or tile 0"],
        ),
        ("i.tif", with(|t| t.short(278, &[0])), &["no readable TIFF"]),
        ("j.tif", with(|t| t.short(277, &[3])), &["gdal_translate"]),
        (
            "k.tif",
            with(|t| t.short(259, &[50_000])),
            &["not supported", "COMPRESS=DEFLATE"],
        ),
        (
            "l.tif",
            with(|t| t.without(33922)),
            &["does not say where it lies"],
        ),
        (
            "m.tif",
            with(|t| t.double(33550, &[0.0, 0.0, 0.0])),
            &["spacing must be positive"],
        ),
        (
            "n.tif",
            with(|t| t.double(33550, &[f64::NAN, 1.0, 0.0])),
            &["origin must be finite"],
        ),
        (
            "o.tif",
            with(|t| t.short(34735, &[1, 1, 0, 900, 1024, 0, 1, 1])),
            &["GeoKeyDirectory"],
        ),
        (
            "p.tif",
            with(|t| t.short(34735, &[1, 1, 0, 1, 1024, 0, 1, 3])),
            &["model type 3", "gdalwarp"],
        ),
        (
            "q.tif",
            with(|t| t.short(34735, &[1, 1, 0, 1, 4099, 0, 1, 9002])),
            &["heights in unit EPSG:9002"],
        ),
        (
            "r.tif",
            with(|t| t.put(42113, ASCII, b"hole\0", 5)),
            &["GDAL_NODATA", "hole"],
        ),
        ("s.tif", with(|t| tiled(t, 3_000_000_000)), &["do not fit"]),
        ("t.tif", with(|t| tiled(t, 0)), &["t.tif"]),
        (
            "u.tif",
            with(|t| t.short(259, &[8]).holding(b"no deflate")),
            &["strip or tile 0"],
        ),
        ("w.tif", empty_tiff(16_000), &["do not fit"]),
        (
            "v.tif",
            with(|t| {
                t.short(259, &[8])
                    .long(279, &[bomb.len() as u32])
                    .long(256, &[10_000])
                    .long(257, &[20_000]);
                t.long(278, &[20_000]).holding(&bomb) // 40 MB of the 400 MB that the raster takes
            }),
            &["v.tif"],
        ),
        (
            "a.asc",
            b"ncols 3\nnrows\n".to_vec(),
            &["line 3", "number after \"nrows\""],
        ),
        (
            "b.asc",
            ASC.replace("6.5", "six").into(),
            &["line 8", "\"six\""],
        ),
        (
            "c.asc",
            ASC.replace("6.5", "").into(),
            &["line 8", "5 of 6 heights"],
        ),
        (
            "d.asc",
            ASC.replace("6.5", "6.5 7").into(),
            &["line 8", "more than the 6"],
        ),
        (
            "e.asc",
            ASC.replace("ncols 3", "ncols 30000").into(),
            &["60000 heights", "room for"],
        ),
        (
            "f.asc",
            ASC.replace("ncols 3", "ncols 99999999999").into(),
            &["99999999999 x 2 posts"],
        ),
        (
            "g.asc",
            ASC.replace("ncols 3", "ncols 2.5").into(),
            &["ncols"],
        ),
        (
            "h.asc",
            ASC.replace("cellsize 10", "cellsize -10").into(),
            &["cellsize"],
        ),
        (
            "i.asc",
            ASC.replace("cellsize 10", "cellsize inf").into(),
            &["line 5"],
        ),
        (
            "j.asc",
            ASC.replace("cellsize", "celsize").into(),
            &["line 5", "celsize"],
        ),
        ("k.asc", vec![b'7'; 5_000_000], &["line 1", "no ASCII grid"]),
        ("l.asc", vec![0xff; 100], &["line 1"]),
        ("m.asc", ASC.replace("6.5", "1e99").into(), &["from zero"]),
        ("n.asc", vec![], &["no usable ncols"]),
        ("hill.hgt", vec![0; 8], &["N40W106"]),
        ("N40W190.hgt", vec![0; 8], &["corner"]),
        ("N40W106.hgt", vec![0; 10], &["10 bytes"]),
        ("N41W106.hgt", vec![0; 2], &["2 bytes"]),
        ("N42W106.hgt", vec![0; 9], &["9 bytes"]),
        ("a.png", b"no picture".to_vec(), &["a.png"]),
        (
            "b.png",
            picture(2, 1, &[10, 0, 0, 10, 0, 0]),
            &["--encoding"],
        ),
        ("c.png", picture(2, 1, &[1; 6])[..50].to_vec(), &["c.png"]),
        (
            "d.png",
            picture(4000, 4000, &vec![1; 48_000_000])[..9000].to_vec(),
            &["d.png"],
        ),
        ("a.dem", vec![], &[".asc"]),
    ] {
        match read_bytes(name, &bytes) {
            Ok(_) => wrong.push(format!("{name} was taken")),
            Err(said) if words.iter().all(|word| said.contains(word)) => {}
            Err(said) => wrong.push(format!("{name}: {words:?} are not in {said:?}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Whatever happens to its bytes, a file is read or refused.
#[test]
fn damaged_files_never_panic() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let mut tiled = Tiff::small();
    tiled.without(273).without(278).without(279);
    tiled.data = deflated(&[7; 512]);
    tiled.short(259, &[8]).short(317, &[2]);
    let length = tiled.data.len() as u32;
    tiled
        .long(322, &[16])
        .long(323, &[16])
        .long(324, &[8])
        .long(325, &[length]);
    let originals = [
        ("a.tif", Tiff::small().bytes()),
        ("b.tif", tiled.bytes()),
        ("a.asc", ASC.into()),
        ("N01E001.hgt", vec![1; 18]),
        ("a.png", picture(2, 3, &[1; 18])),
    ];
    let folder = tempfile::tempdir().unwrap();
    let (mut taken, mut refused) = (0, 0);
    for (name, original) in &originals {
        let path = folder.path().join(name);
        assert!(read_bytes(name, original).is_ok(), "{name}");
        for _ in 0..1500 {
            let mut bytes = original.clone();
            for _ in 0..random.random_range(1..4) {
                let at = random.random_range(0..bytes.len());
                match random.random_range(0..5) {
                    0 => bytes.truncate(at.max(1)),
                    1 => bytes[at] ^= 1 << random.random_range(0..8),
                    2 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][random.random_range(0..5)],
                    3 => drop(bytes.remove(at)),
                    _ => bytes.insert(at, random.random()),
                }
                if bytes.is_empty() {
                    bytes.push(0);
                }
            }
            std::fs::write(&path, &bytes).unwrap();
            let options = Options {
                bounds: Some([0.0, 0.0, 100.0, 100.0]),
                ..Options::default()
            };
            match read(&path, &options) {
                Ok(raster) => {
                    taken += 1;
                    assert!(raster.field.grid().count() <= 1 << 20, "{name}");
                }
                Err(_) => refused += 1,
            }
        }
    }
    assert!(
        taken > 500 && refused > 500,
        "{taken} taken, {refused} refused"
    );
}
