use std::path::{Path, PathBuf};

use citylod::geom::DVec2;
use citylod::terrain::pyramid::{Pyramid, Tiling, write};
use citylod::terrain::{Block, Grid, Ground, HeightField, Layout, Node, child_number};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use tempfile::TempDir;

/// Hills with a hole, for any post.
fn height(column: u32, row: u32) -> f32 {
    let (x, y) = (f64::from(column), f64::from(row));
    if (30..50).contains(&column) && (10..25).contains(&row) {
        return f32::NAN;
    }
    (100.0 * (x / 17.0).sin() * (y / 29.0).cos() + 7.0 * (x * 0.9 + y * 1.3).sin()) as f32
}

fn grid(columns: u32, rows: u32) -> Grid {
    Grid::new(
        columns,
        rows,
        DVec2::new(385_000.0, 5_400_000.0),
        DVec2::new(10.0, 5.0),
    )
    .unwrap()
}

fn field(grid: Grid) -> HeightField {
    let posts = (0..grid.rows()).flat_map(|row| (0..grid.columns()).map(move |c| height(c, row)));
    HeightField::new(grid, posts.collect()).unwrap()
}

struct Made {
    folder: TempDir,
    pyramid: Pyramid,
}

impl Made {
    fn path(&self) -> PathBuf {
        self.folder.path().join("hills.terrain")
    }
}

fn made(tiling: &Tiling) -> Made {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hills.terrain");
    write(&path, tiling, Some("EPSG:32632"), height, &|_, _| {}).unwrap();
    Made {
        pyramid: Pyramid::open_verified(&path).unwrap(),
        folder,
    }
}

/// Sizes and depths: many blocks, one block, tiles as large as blocks, thin rasters.
fn tilings() -> Vec<Tiling> {
    [
        (150, 90, 6, 4),
        (150, 90, 5, 5),
        (70, 65, 7, 3),
        (33, 33, 5, 5),
        (2, 200, 4, 2),
        (3, 2, 1, 1),
    ]
    .map(|(columns, rows, levels, n)| {
        Tiling::with_levels(Layout::with_levels(grid(columns, rows), levels), n)
    })
    .to_vec()
}

fn bits(heights: &[f32]) -> Vec<u32> {
    heights.iter().map(|h| h.to_bits()).collect()
}

#[test]
fn every_tile_holds_the_posts_of_its_node() {
    for tiling in tilings() {
        let pyramid = made(&tiling).pyramid;
        let last = [
            tiling.layout().grid().columns() - 1,
            tiling.layout().grid().rows() - 1,
        ];
        let mut tiles = 0;
        for level in 0..=tiling.finest() {
            for node in tiling.tiles(level) {
                assert_eq!(tiling.tile_index(node), Some(tiles));
                tiles += 1;
                let (cells, stride) = (1 << tiling.tile_levels(), tiling.stride(level));
                let post = |at: u32, k: u32, last: u32| ((at * cells + k) * stride).min(last);
                let expected: Vec<f32> = (0..=cells)
                    .flat_map(|j| (0..=cells).map(move |i| (i, j)))
                    .map(|(i, j)| height(post(node.x, i, last[0]), post(node.y, j, last[1])))
                    .collect();
                assert_eq!(
                    bits(&pyramid.tile(node).unwrap().heights),
                    bits(&expected),
                    "{node:?}"
                );
            }
        }
        assert_eq!(tiles, tiling.tile_count());
        let beyond = Node {
            level: 0,
            x: tiling.layout().blocks()[0],
            y: 0,
        };
        assert!(pyramid.tile(beyond).is_err());
        let too_fine = Node {
            level: tiling.finest() + 1,
            x: 0,
            y: 0,
        };
        assert!(pyramid.tile(too_fine).is_err());
    }
}

/// What is written block by block is what cutting the whole field at once gives.
#[test]
fn blocks_come_back_as_they_are_cut() {
    for tiling in tilings() {
        let pyramid = made(&tiling).pyramid;
        let layout = *tiling.layout();
        let whole = field(*layout.grid());
        let ground = pyramid.ground().unwrap();
        for number in 0..layout.block_count() {
            let cut = Block::cut(&whole, &layout, layout.block(number));
            let read = ground.block(number).unwrap();
            assert_eq!(bits(read.heights()), bits(cut.heights()), "block {number}");
            assert_eq!(read.records(), cut.records(), "block {number}");
        }
        assert_eq!(pyramid.crs(), Some("EPSG:32632"));
        let heights = whole.heights().iter().copied().filter(|h| !h.is_nan());
        let range = heights.fold([f32::MAX, f32::MIN], |[l, h], z| [l.min(z), h.max(z)]);
        // Posts without an area around them are no ground.
        let [low, high] = pyramid.height_range().unwrap();
        assert!(range[0] <= low && high <= range[1]);
    }
}

#[test]
fn children_are_found_by_the_paper_s_equation() {
    let tiling = Tiling::with_levels(Layout::with_levels(grid(150, 90), 6), 3);
    let pyramid = made(&tiling).pyramid;
    for level in 0..tiling.finest() {
        for node in tiling.tiles(level) {
            let parent = pyramid.record(node);
            for (quarter, place) in citylod::terrain::QUARTERS.into_iter().enumerate() {
                let child = node.child(quarter);
                assert_eq!(child.number(), child_number(node.number(), level, place));
                let record = pyramid.record(child);
                assert!(record.low >= parent.low && record.high <= parent.high);
                assert!(record.error <= parent.error && record.deviation <= parent.deviation);
                assert!(record.vertex_error <= parent.vertex_error);
            }
        }
    }
}

#[test]
fn the_same_raster_gives_the_same_bytes() {
    let tiling = tilings()[0];
    let (a, b) = (made(&tiling), made(&tiling));
    assert_eq!(
        std::fs::read(a.path()).unwrap(),
        std::fs::read(b.path()).unwrap()
    );
}

#[test]
fn a_height_that_is_none_leaves_the_old_file() {
    let old = made(&tilings()[3]);
    let before = std::fs::read(old.path()).unwrap();
    let infinite = |column, row| {
        if (column, row) == (100, 50) {
            f32::INFINITY
        } else {
            0.0
        }
    };
    assert!(write(&old.path(), &tilings()[0], None, infinite, &|_, _| {}).is_err());
    assert_eq!(std::fs::read(old.path()).unwrap(), before);
    let files = std::fs::read_dir(old.folder.path()).unwrap().count();
    assert_eq!(files, 1, "a temporary file was left");
    let line = Tiling::new(grid(1, 500));
    let said = write(&old.path(), &line, None, height, &|_, _| {})
        .unwrap_err()
        .to_string();
    assert!(said.contains("1 x 500 posts"), "{said}");
}

/// What a ground holds, bit for bit.
fn contents(ground: &Ground) -> Vec<(Vec<u8>, Vec<u32>)> {
    let blocks = (0..ground.layout().block_count()).map(|number| ground.block(number).unwrap());
    let contents = blocks.map(|block| {
        let records = bytemuck::cast_slice(block.records()).to_vec();
        (records, bits(block.heights()))
    });
    contents.collect()
}

/// Opened without a look through the file and read, and opened with one. What is read where no
/// damage is reported must be what was written.
fn open_both(path: &Path, written: &Ground) -> Result<(), String> {
    if let Ok(pyramid) = Pyramid::open(path) {
        let _whatever = pyramid.height_range();
        if let Ok(ground) = pyramid.ground() {
            assert_eq!(
                contents(&ground),
                contents(written),
                "read and not reported"
            );
            assert_eq!(pyramid.crs(), Some("EPSG:32632"));
        }
    }
    Pyramid::open_verified(path)
        .map(|_| ())
        .map_err(|e| e.to_string())
}

#[test]
fn every_changed_byte_is_found() {
    let made = made(&Tiling::with_levels(Layout::with_levels(grid(9, 6), 3), 2));
    let path = made.folder.path().join("changed.terrain");
    let original = std::fs::read(made.path()).unwrap();
    let written = made.pyramid.ground().unwrap();
    for at in 0..original.len() {
        let mut bytes = original.clone();
        bytes[at] ^= 0x10;
        std::fs::write(&path, bytes).unwrap();
        assert!(
            open_both(&path, &written).is_err(),
            "byte {at} of {}",
            original.len()
        );
    }
    for length in (0..original.len()).step_by(61) {
        std::fs::write(&path, &original[..length]).unwrap();
        assert!(open_both(&path, &written).is_err(), "cut to {length}");
    }
}

/// Also where someone who forges a file makes its checksum right.
#[test]
fn forged_heads_are_refused_with_the_section() {
    let made = made(&Tiling::with_levels(Layout::with_levels(grid(9, 6), 3), 2));
    let path = made.folder.path().join("forged.terrain");
    let original = std::fs::read(made.path()).unwrap();
    let written = made.pyramid.ground().unwrap();
    let mut random = Pcg64Mcg::seed_from_u64(3);
    let mut forged = 0;
    for _ in 0..2000 {
        let mut bytes = original.clone();
        for _ in 0..random.random_range(1..3) {
            let at = random.random_range(16..224);
            bytes[at] = [0, 1, 0x7f, 0xff, random.random()][random.random_range(0..5)];
        }
        let sum = crc32fast::hash(&bytes[16..256]);
        bytes[12..16].copy_from_slice(&sum.to_le_bytes());
        std::fs::write(&path, &bytes).unwrap();
        // Forged with a right checksum: another ground perhaps, but no panic.
        if let Ok(pyramid) = Pyramid::open(&path) {
            forged += usize::from(pyramid.ground().is_ok());
        }
    }
    assert!(
        (1..2000).contains(&forged),
        "{forged} forged heads were taken"
    );
    for (at, word, says) in [
        (0, *b"citycity", "not a .terrain file"),
        (8, [9, 0, 0, 0, 0, 0, 0, 0], "format version 9"),
        (64, [200, 0, 0, 0, 2, 0, 0, 0], "impossible depths"),
        (24, [0xff; 8], "header"),
        (104, [0xff; 8], "section crs"),
        (144, [0xff; 8], "section records"),
    ] {
        let mut bytes = original.clone();
        bytes[at..at + 8].copy_from_slice(&word);
        let sum = crc32fast::hash(&bytes[16..256]);
        if at > 8 {
            bytes[12..16].copy_from_slice(&sum.to_le_bytes());
        }
        std::fs::write(&path, &bytes).unwrap();
        let said = open_both(&path, &written).unwrap_err();
        assert!(
            said.contains(says) && said.contains("forged.terrain"),
            "{said}"
        );
    }
}

/// A ground read from disk and one cut in memory are the same to whoever draws it.
#[test]
fn a_ground_from_disk_is_the_one_cut_in_memory() {
    let tiling = tilings()[0];
    let (read, cut) = (
        made(&tiling).pyramid.ground().unwrap(),
        Ground::cut(&field(*tiling.layout().grid()), tiling.layout()),
    );
    for level in 0..=tiling.layout().levels() {
        for node in tiling.tiles(level.min(tiling.finest())) {
            assert_eq!(read.record(node), cut.record(node));
        }
    }
}
