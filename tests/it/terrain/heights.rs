use citylod::geom::{Aabb, DVec2, DVec3};
use citylod::terrain::{Ground, HeightField, Interpolation, Layout, ground_under};
use rand::RngExt;

use super::places::{between, field, made_up, rng};

const ALL: [Interpolation; 4] = [
    Interpolation::Bilinear,
    Interpolation::Bicubic,
    Interpolation::ByVariance { threshold: 1.0 },
    Interpolation::ByVariance { threshold: 0.01 },
];

/// Posts of 9 × 7 whose heights are those of `surface` at whole columns and rows.
fn sampled(surface: impl Fn(f64, f64) -> f64) -> HeightField {
    let height = |x: u32, y: u32| surface(f64::from(x), f64::from(y)) as f32;
    field(
        [9, 7],
        DVec2::new(1000.0, -500.0),
        DVec2::new(4.0, 2.0),
        height,
    )
}

fn at(field: &HeightField, column: f64, row: f64, how: Interpolation) -> Option<f64> {
    field.height_at(1000.0 + 4.0 * column, -500.0 + 2.0 * row, how)
}

#[test]
fn posts_keep_their_heights() {
    for seed in 0..40 {
        let field = made_up(&mut rng(seed + 40_000));
        let grid = field.grid();
        for (row, column) in (0..grid.rows()).flat_map(|r| (0..grid.columns()).map(move |c| (r, c)))
        {
            let z = field.height(column, row);
            for how in ALL {
                let found = field.height_at(grid.x(column), grid.y(row), how);
                assert_eq!(found, Some(f64::from(z)).filter(|z| !z.is_nan()), "{how:?}");
            }
        }
    }
}

/// Planes by all, x·y by bilinear too, parabolas by bicubic away from the border.
#[test]
fn surfaces_of_their_degree_come_out_exactly() {
    let plane = |x: f64, y: f64| 3.0 + 2.0 * x - 0.5 * y;
    let twisted = |x: f64, y: f64| 1.0 + x * y;
    let parabola = |x: f64, y: f64| x * x - 3.0 * x * y + 2.0 * y * y;
    let mut rng = rng(50_000);
    for _ in 0..500 {
        let (x, y) = (between(&mut rng, 0.0, 8.0), between(&mut rng, 0.0, 6.0));
        let near = |found: Option<f64>, expected: f64| (found.unwrap() - expected).abs() < 1e-9;
        for how in ALL {
            assert!(near(at(&sampled(plane), x, y, how), plane(x, y)), "{how:?}");
        }
        assert!(near(
            at(&sampled(twisted), x, y, Interpolation::Bilinear),
            twisted(x, y)
        ));
        if (1.0..7.0).contains(&x) && (1.0..5.0).contains(&y) {
            let smooth = at(&sampled(parabola), x, y, Interpolation::Bicubic);
            assert!(near(smooth, parabola(x, y)), "{smooth:?} at {x}, {y}");
        }
    }
}

/// Four posts of which one is 8 and three are 0 deviate by √12.
#[test]
fn the_variance_of_a_cell_decides_which_it_is() {
    let field = sampled(|x, y| if x == 4.0 && y == 3.0 { 8.0 } else { 0.0 });
    let deviation = 12.0_f64.sqrt();
    let by = |threshold| at(&field, 3.3, 2.6, Interpolation::ByVariance { threshold });
    let (flat, smooth) = (
        at(&field, 3.3, 2.6, Interpolation::Bilinear),
        at(&field, 3.3, 2.6, Interpolation::Bicubic),
    );
    assert_ne!(flat, smooth);
    assert_eq!(by(deviation * 1.001), flat);
    assert_eq!(by(deviation * 0.999), smooth);
    assert_eq!(by(0.0), smooth);
}

#[test]
fn there_is_no_height_beyond_the_posts_or_in_a_hole() {
    let field = field([4, 4], DVec2::ZERO, DVec2::ONE, |x, y| {
        if [x, y] == [1, 1] { f32::NAN } else { 5.0 }
    });
    for how in ALL {
        for [x, y] in [
            [-0.01, 2.0],
            [3.01, 2.0],
            [2.0, f64::NAN],
            [0.5, 0.5],
            [1.0, 1.0],
            [1.0, 1.5],
        ] {
            assert_eq!(field.height_at(x, y, how), None, "{how:?} at {x}, {y}");
        }
        // Beside the hole: the unknown post has no weight, or is replaced.
        for [x, y] in [[0.0, 0.5], [2.0, 1.5], [2.5, 1.5], [3.0, 3.0]] {
            assert_eq!(field.height_at(x, y, how), Some(5.0), "{how:?} at {x}, {y}");
        }
    }
    let line = super::places::field([5, 1], DVec2::ZERO, DVec2::ONE, |x, _| x as f32);
    assert_eq!(
        line.height_at(2.25, 0.0, Interpolation::Bilinear),
        Some(2.25)
    );
    assert_eq!(line.height_at(2.25, 0.1, Interpolation::Bilinear), None);
}

/// A vertical line meets the ground where the raster has it, whatever the blocks.
#[test]
fn rays_meet_the_ground_at_the_heights_of_the_field() {
    for seed in 0..60 {
        let mut rng = rng(seed + 60_000);
        let field = made_up(&mut rng);
        let grid = field.grid();
        let layout = Layout::with_levels(*grid, rng.random_range(1..=7));
        let ground = Ground::cut(&field, &layout);
        let far = [grid.x(grid.columns() - 1), grid.y(grid.rows() - 1)];
        for _ in 0..200 {
            let x = between(&mut rng, grid.origin().x, far[0]);
            let y = between(&mut rng, grid.origin().y, far[1]);
            for how in ALL {
                assert_eq!(ground.raycast(x, y, how), field.height_at(x, y, how));
            }
        }
    }
}

/// What is bilinear is lowest and highest where sides of the box and of cells meet: nothing that is
/// looked up in between lies beyond.
#[test]
fn the_range_of_ground_under_a_box_is_that_of_all_its_points() {
    /// Heights of points in between round, m.
    const TOLERANCE_M: f64 = 1e-6;
    let mut rng = rng(23);
    for _ in 0..300 {
        let field = made_up(&mut rng);
        let grid = field.grid();
        let far = DVec2::new(grid.x(grid.columns() - 1), grid.y(grid.rows() - 1));
        let size = far - grid.origin();
        let mut along = |axis: usize| {
            let mut ends =
                [0, 1].map(|_| grid.origin()[axis] + between(&mut rng, -0.1, 1.1) * size[axis]);
            ends.sort_by(f64::total_cmp);
            ends
        };
        let ([west, east], [south, north]) = (along(0), along(1));
        let bounds = Aabb::new(DVec3::new(west, south, 0.0), DVec3::new(east, north, 9.0)).unwrap();
        let range = ground_under(&field, &bounds);
        let mut sampled: Option<[f64; 2]> = None;
        for step in 0..40 * 40 {
            let part = |at: i32, from: f64, to: f64| from + (to - from) * f64::from(at) / 39.0;
            let (x, y) = (part(step % 40, west, east), part(step / 40, south, north));
            if let Some(height) = field.height_at(x, y, Interpolation::Bilinear) {
                let [low, high] = sampled.unwrap_or([height; 2]);
                sampled = Some([low.min(height), high.max(height)]);
            }
        }
        match (range, sampled) {
            (Some([low, high]), Some([least, most])) => {
                assert!(low <= least + TOLERANCE_M && most - TOLERANCE_M <= high);
            }
            (None, Some(_)) => panic!("ground at a point, none under the box"),
            (_, None) => {}
        }
    }
}

/// A saddle has its extremes under corners; a ridge between posts of a narrow box under its sides.
#[test]
fn ground_under_a_box_is_exact() {
    let field = field([3, 3], DVec2::ZERO, DVec2::splat(10.0), |column, row| {
        if column == 1 { 40.0 } else { row as f32 }
    });
    let under = |west: f64, south: f64, east: f64, north: f64| {
        let (min, max) = (DVec3::new(west, south, 5.0), DVec3::new(east, north, 6.0));
        let range = ground_under(&field, &Aabb::new(min, max).unwrap());
        // To the micrometre, as heights between posts round.
        range.map(|range| range.map(|height| (height * 1e6).round() / 1e6))
    };
    // No post lies in it, and its corners are all as high as each other.
    assert_eq!(under(5.0, 4.0, 15.0, 4.0), Some([20.2, 40.0]));
    assert_eq!(under(0.0, 0.0, 20.0, 20.0), Some([0.0, 40.0]));
    assert_eq!(under(2.5, 5.0, 2.5, 5.0), Some([10.375, 10.375]));
    assert_eq!(under(-9.0, 3.0, 0.0, 5.0), Some([0.3, 0.5]));
    assert_eq!(under(-9.0, 3.0, -1.0, 5.0), None);
    assert_eq!(ground_under(&field, &Aabb::EMPTY), None);
}
