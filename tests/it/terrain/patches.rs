use std::collections::BTreeMap;

use citylod::geom::View;
use citylod::terrain::pyramid::{Pyramid, Tiling, write};
use citylod::terrain::{
    Criterion, Detail, Ground, HeightField, Layout, Mesh, Patch, Selection, Workers, select_within,
};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::examine::examine;
use super::places::{between, from_above, made_up, real_grounds, rng, view};

/// Rounding of the certified error, which is rounded up.
const ROUNDING: f64 = 1.0 + 1e-12;

/// A pyramid of a field with blocks and tiles of random depths.
fn pyramid(rng: &mut Pcg64Mcg, field: &HeightField, folder: &std::path::Path) -> Pyramid {
    let levels = rng.random_range(2..=7);
    let tile_levels = rng.random_range(1..=levels.min(5));
    let layout = Layout::with_levels(*field.grid(), levels);
    let tiling = Tiling::with_levels(layout, tile_levels);
    let path = folder.join("a.terrain");
    let heights = |column, row| field.height(column, row);
    write(&path, &tiling, None, heights, &|_, _| {}).unwrap();
    Pyramid::open_verified(&path).unwrap()
}

type Post = [u32; 2];
/// A post and the bits of its height.
pub type Corner = (Post, u32);

/// The triangles of patches, drawn as the API describes them, from tiles alone.
pub fn drawn(pyramid: &Pyramid, patches: &[Patch]) -> Vec<[Corner; 3]> {
    let tiling = pyramid.tiling();
    let (h, n) = (tiling.layout().levels(), tiling.tile_levels());
    let grid = tiling.layout().grid();
    let last = [grid.columns() - 1, grid.rows() - 1];
    let mut found = Vec::new();
    for Patch { tile, fans } in patches {
        let heights = pyramid.tile(*tile).unwrap().heights;
        let side = (1_u32 << n) + 1;
        let stride = 1_u64 << (h - n - tile.level);
        // By place in the tile: which post of the raster, and how high.
        let corner = |[i, j]: [u32; 2]| -> Corner {
            let post = |tile: u32, at: u32, last: u32| {
                let column = ((u64::from(tile) << n) + u64::from(at)) * stride;
                column.min(u64::from(last)) as u32
            };
            let z = heights[(j * side + i) as usize];
            (
                [post(tile.x, i, last[0]), post(tile.y, j, last[1])],
                z.to_bits(),
            )
        };
        let mut draw = |places: [[u32; 2]; 3]| {
            let triangle = places.map(corner);
            let [a, b, c] = triangle.map(|(post, _)| post.map(i64::from));
            if (b[0] - a[0]) * (c[1] - a[1]) != (b[1] - a[1]) * (c[0] - a[0]) {
                found.push(triangle);
            }
        };
        let all = 1 << n;
        if fans.is_empty() {
            draw([[0, 0], [all, 0], [all, all]]);
            draw([[0, 0], [all, all], [0, all]]);
        }
        for fan in fans {
            let (mut index, mut down) = (fan >> 8, 0);
            while index >= 1 << (2 * down) {
                index -= 1 << (2 * down);
                down += 1;
            }
            let size = all >> down;
            let (x, y) = (index % (1 << down) * size, index / (1 << down) * size);
            let (half, end) = (size / 2, size);
            let at = |dx, dy| [x + dx, y + dy];
            let corners = [at(0, 0), at(end, 0), at(end, end), at(0, end)];
            let middles = [at(half, 0), at(end, half), at(half, end), at(0, half)];
            for k in 0..4 {
                let next = (k + 1) % 4;
                let quarter = |k: usize| fan >> k & 1 == 1;
                if fan >> (4 + k) & 1 == 1 {
                    if quarter(k) {
                        draw([at(half, half), corners[k], middles[k]]);
                    }
                    if quarter(next) {
                        draw([at(half, half), middles[k], corners[next]]);
                    }
                } else if quarter(k) || quarter(next) {
                    draw([at(half, half), corners[k], corners[next]]);
                }
            }
        }
    }
    found
}

/// Triangles in an order of their own, each from its least corner on.
pub fn sorted(mut triangles: Vec<[Corner; 3]>) -> Vec<[Corner; 3]> {
    for triangle in &mut triangles {
        let least = (0..3).min_by_key(|&k| triangle[k]).unwrap();
        triangle.rotate_left(least);
    }
    triangles.sort_unstable();
    triangles
}

fn of_mesh(mesh: &Mesh) -> Vec<[Corner; 3]> {
    let corner = |vertex: u32| {
        let at = vertex as usize;
        (mesh.posts[at], mesh.heights[at].to_bits())
    };
    mesh.triangles.iter().map(|t| t.map(corner)).collect()
}

fn chosen(
    rng: &mut Pcg64Mcg,
    pyramid: &Pyramid,
    view: &View,
    max_error_px: f64,
    most: Option<usize>,
) -> (Ground, Selection) {
    let ground = pyramid.ground().unwrap();
    let criterion = Criterion::ALL[rng.random_range(0..4)];
    let share = 10.0_f64.powf(between(rng, -9.0, 1.0));
    let usual = Detail::of(criterion);
    let detail = Detail {
        knobs: criterion.share(&usual.knobs, share),
        max_triangles: most,
        ..usual
    };
    let selection = select_within(&ground, view, &detail, max_error_px, Workers::One).unwrap();
    (ground, selection)
}

/// What is drawn from tiles and patches is the mesh of the selection, triangle by triangle.
#[test]
fn patches_and_tiles_make_the_mesh() {
    let mut rng = rng(71);
    let folder = tempfile::tempdir().unwrap();
    let (mut triangles, mut whole, mut spared) = (0, 0, 0);
    for round in 0..600 {
        let field = made_up(&mut rng);
        let pyramid = pyramid(&mut rng, &field, folder.path());
        let view = view(&mut rng, &field);
        let error = [0.1, 1.0, 20.0, f64::INFINITY][round % 4];
        let most = [None, Some(50)][rng.random_range(0..2)];
        let (ground, selection) = chosen(&mut rng, &pyramid, &view, error, most);
        let mesh = selection.mesh(&ground);
        let patches = selection.patches(&ground, pyramid.tiling().tile_levels());
        let tiles: Vec<_> = patches.iter().map(|patch| patch.tile).collect();
        assert!(tiles.is_sorted(), "{tiles:?}");
        let made = drawn(&pyramid, &patches);
        assert_eq!(made.len(), selection.triangles());
        assert_eq!(sorted(made), sorted(of_mesh(&mesh)), "round {round}");
        triangles += mesh.triangles.len();
        whole += patches.iter().filter(|p| p.fans.is_empty()).count();
        let fans = patches.iter().flat_map(|p| &p.fans);
        spared += fans.filter(|&&fan| fan >> 4 & 15 != 15).count();
    }
    assert!(
        triangles > 50_000 && whole > 20 && spared > 1_000,
        "{triangles} {whole} {spared}"
    );
}

/// Unless triangles run out, nothing errs by more than it may, and what is drawn has no cracks.
#[test]
fn no_error_is_larger_than_it_may_be() {
    let mut rng = rng(72);
    let folder = tempfile::tempdir().unwrap();
    let grounds: Vec<HeightField> = (0..400)
        .map(|_| made_up(&mut rng))
        .chain(real_grounds().into_iter().map(|(_, field)| field))
        .collect();
    let (mut tight, mut counts) = (0, BTreeMap::new());
    for (round, field) in grounds.iter().enumerate() {
        let pyramid = pyramid(&mut rng, field, folder.path());
        let view = view(&mut rng, field);
        let error = 10.0_f64.powf(between(&mut rng, -1.0, 2.0));
        let (ground, selection) = chosen(&mut rng, &pyramid, &view, error, None);
        assert!(
            selection.error_px() <= error * ROUNDING,
            "{} for {error} in round {round}",
            selection.error_px()
        );
        tight += usize::from(selection.error_px() > error * 0.3);
        examine(field, &selection.mesh(&ground), Some(&view));
        if round % 4 == 0 {
            let most = selection.triangles() / 2 + 8;
            let (_, fewer) = chosen(&mut rng, &pyramid, &view, error, Some(most));
            *counts.entry(fewer.triangles() <= most).or_insert(0) += 1;
            assert!(fewer.share() < 1.0 || fewer.error_px() <= error * ROUNDING);
        }
    }
    assert!(tight > 50, "the bound is of use: {tight}");
    assert!(counts[&true] > 50, "{counts:?}");
}

/// From far away a coarse ground is enough, and what is asked for cannot be nothing.
#[test]
fn a_looser_bound_draws_no_more() {
    let mut rng = rng(73);
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..60 {
        let field = made_up(&mut rng);
        let pyramid = pyramid(&mut rng, &field, folder.path());
        let ground = pyramid.ground().unwrap();
        let view = from_above(&field, 2.0);
        let detail = Detail {
            knobs: Criterion::Error.share(&Criterion::Error.knobs(), 1e-9),
            ..Detail::of(Criterion::Error)
        };
        let with = |px| select_within(&ground, &view, &detail, px, Workers::One);
        let counts = [0.5, 2.0, 8.0, 32.0].map(|px| with(px).unwrap().triangles());
        assert!(counts.is_sorted_by(|a, b| a >= b), "{counts:?}");
        for px in [0.0, -1.0, f64::NAN] {
            assert_eq!(with(px).unwrap_err().knob, "max_error_px");
        }
    }
}
