use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::elevation_files::{ASC, Tiff, picture, read_bytes, with};
use citylod::geom::DVec2;
use citylod::terrain::read::{Encoding, Options, Raster, Units, read};
use citylod::terrain::{Grid, HeightField, Interpolation};
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

/// Positions in national grids and the longitudes and latitudes that PROJ 9.5 gives for them.
const PLACES: [(&str, [f64; 2], [f64; 2]); 13] = [
    (
        "EPSG:28992",
        [84_879.0, 447_587.0],
        [4.365_801_2, 52.012_209_2],
    ),
    (
        "EPSG:28992",
        [155_000.0, 463_000.0],
        [5.387_203_5, 52.155_172_3],
    ),
    (
        "EPSG:28992",
        [250_000.0, 580_000.0],
        [6.808_813_9, 53.198_212_2],
    ),
    (
        "EPSG:7415",
        [84_879.0, 447_587.0],
        [4.365_801_2, 52.012_209_2],
    ),
    (
        "EPSG:2056",
        [2_683_500.0, 1_248_000.0],
        [8.544_310_3, 47.377_544_0],
    ),
    (
        "EPSG:2056",
        [2_600_000.0, 1_200_000.0],
        [7.438_632_4, 46.951_082_8],
    ),
    (
        "EPSG:31370",
        [150_000.0, 170_000.0],
        [4.368_752_1, 50.840_411_3],
    ),
    (
        "EPSG:27700",
        [530_000.0, 180_000.0],
        [-0.128_353_9, 51.503_990_8],
    ),
    (
        "EPSG:6677",
        [-7_000.0, -36_000.0],
        [139.756_004_6, 35.675_489_8],
    ),
    (
        "EPSG:2154",
        [652_000.0, 6_862_000.0],
        [2.345_812_0, 48.856_248_1],
    ),
    (
        "EPSG:25833",
        [390_000.0, 5_820_000.0],
        [13.378_811_8, 52.518_995_3],
    ),
    (
        "EPSG:3067",
        [385_000.0, 6_672_000.0],
        [24.927_457_7, 60.168_666_0],
    ),
    (
        "EPSG:5972",
        [600_000.0, 6_640_000.0],
        [10.786_801_1, 59.885_422_1],
    ),
];

/// Old datums are shifted by seven parameters, PROJ has grids for some of them.
const DATUM_M: f64 = 5.0;

/// A raster about a place whose heights tell how far east, or north, of it they are, degrees · 10⁵.
fn tells(axis: usize, at: [f64; 2]) -> Raster {
    let (step, half) = (2e-4, 20);
    let origin = DVec2::new(
        at[0] - step * f64::from(half),
        at[1] - step * f64::from(half),
    );
    let grid = Grid::new(41, 41, origin, DVec2::splat(step)).unwrap();
    let offset = |column: i32, row: i32| [column, row][axis] - half;
    let heights = (0..41).flat_map(|row| (0..41).map(move |column| (column, row)));
    let heights = heights.map(|(column, row)| (f64::from(offset(column, row)) * step * 1e5) as f32);
    Raster {
        field: HeightField::new(grid, heights.collect()).unwrap(),
        crs: Some("EPSG:4326".into()),
        units: Units::Degrees,
    }
}

#[test]
fn degrees_come_to_lie_where_national_grids_have_them() {
    for (system, [x, y], at) in PLACES {
        for (axis, metres) in [(0, 111_320.0 * at[1].to_radians().cos()), (1, 111_320.0)] {
            let raster = tells(axis, at)
                .to_metres(Path::new("a.tif"), Some(system))
                .unwrap();
            assert_eq!(raster.crs.as_deref(), Some(system));
            let off = raster
                .field
                .height_at(x, y, Interpolation::Bilinear)
                .unwrap();
            let off_m = off * 1e-5 * metres;
            assert!(
                off_m.abs() < DATUM_M,
                "{system}: {off_m} m off along axis {axis}"
            );
        }
    }
}

#[test]
fn one_plane_comes_to_lie_on_another() {
    // PROJ 9.5: EPSG:32631 600000, 5760000 is EPSG:28992 91034.06, 444105.51.
    let grid = Grid::new(
        41,
        41,
        DVec2::new(599_600.0, 5_759_600.0),
        DVec2::splat(20.0),
    )
    .unwrap();
    let raster = |axis: usize, crs: &str| {
        let heights = (0..41).flat_map(|row| (0..41).map(move |column| [column, row]));
        let heights = heights.map(|at| (at[axis] - 20) as f32 * 20.0).collect();
        Raster {
            field: HeightField::new(grid, heights).unwrap(),
            crs: Some(crs.into()),
            units: Units::Metres,
        }
    };
    let path = Path::new("a.tif");
    for axis in 0..2 {
        let there = raster(axis, "EPSG:32631")
            .to_metres(path, Some("EPSG:7415"))
            .unwrap();
        let off = there
            .field
            .height_at(91_034.06, 444_105.51, Interpolation::Bilinear);
        assert!(off.unwrap().abs() < DATUM_M, "{off:?}");
    }
    // The horizontal part of a compound system is that system: nothing is drawn anew.
    for (found, wanted) in [("EPSG:28992", "EPSG:7415"), ("EPSG:25832", "EPSG:5555")] {
        let same = raster(0, found).to_metres(path, Some(wanted)).unwrap();
        assert_eq!(same.field, raster(0, found).field);
        assert_eq!(same.crs.as_deref(), Some(found));
    }
    for (found, wanted, words) in [
        ("EPSG:99999", "EPSG:7415", "-t_srs '+proj=sterea"),
        ("EPSG:32631", "our own grid", "-t_srs 'our own grid'"),
        ("EPSG:32631", "EPSG:2263", "not in EPSG:2263"),
        (
            "EPSG:32613",
            "EPSG:28992",
            "too far from where EPSG:28992, the city's system, is good",
        ),
        (
            "EPSG:32631",
            "EPSG:6677",
            "at longitudes 4.45 to 4.46, too far from where EPSG:6677",
        ),
    ] {
        let error = raster(0, found)
            .to_metres(path, Some(wanted))
            .unwrap_err()
            .to_string();
        assert!(error.contains(words), "{found} in {wanted}: {error}");
        assert!(!error.contains("vunits"), "{error}");
    }
}

#[test]
fn a_coding_that_the_reds_speak_against_is_questioned() {
    for (pixels, said, way_out) in [
        (
            [128, 3, 128, 127, 255, 0],
            Encoding::TerrainRgb,
            "--encoding terrarium",
        ),
        (
            [1, 134, 160, 1, 134, 170],
            Encoding::Terrarium,
            "--encoding terrain-rgb",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        std::fs::write(&path, picture(2, 1, &pixels)).unwrap();
        let with = |encoding| Options {
            encoding,
            bounds: Some([0.0, 0.0, 100.0, 100.0]),
            ..Options::default()
        };
        let error = read(&path, &with(Some(said))).unwrap_err().to_string();
        assert!(error.contains(way_out), "{error}");
        assert!(read(&path, &with(None)).is_ok());
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
