use citylod::geom::DVec2;
use citylod::terrain::{Ground, HeightField, Interpolation, Layout};
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
