use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::elevation_files::{ASC, Tiff, picture, read_bytes, with};
use citylod::geom::DVec2;
use citylod::terrain::read::{Options, Raster, Units, read};
use citylod::terrain::{Grid, HeightField};
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
        let formats = ["tif", "asc", "hgt", "png"].map(std::ffi::OsStr::new);
        let mut files: Vec<_> = files
            .filter(|f| f.extension().is_some_and(|e| formats.contains(&e)))
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
    assert!(lines.len() >= 16, "{}", lines.len());
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

/// Posts so close that metres do not tell them apart are refused, not counted to infinity.
#[test]
fn degrees_too_fine_for_metres_are_refused() {
    let grid = Grid::new(1 << 20, 1, DVec2::ZERO, DVec2::splat(1e-16)).unwrap();
    let raster = Raster {
        field: HeightField::new(grid, vec![0.0; 1 << 20]).unwrap(),
        crs: None,
        units: Units::Degrees,
    };
    let refused = raster.to_metres(Path::new("fine.tif"), None).unwrap_err();
    assert!(refused.to_string().contains("fine.tif"), "{refused}");
}
