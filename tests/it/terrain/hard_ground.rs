use citylod::geom::{DVec2, DVec3, DepthRange, Orientation, Projection, View};
use citylod::terrain::{
    Criterion, Detail, FieldError, Grid, Ground, HeightField, Knobs, Layout, Workers, select,
};

use super::examine::{examine, measure};
use super::places::{extent, field, from_above};

/// Selects with each criterion from many places, and examines what is drawn.
fn examined(field: &HeightField) {
    let (middle, reach) = extent(field);
    let mut views = vec![from_above(field, 1.5), from_above(field, 1e5)];
    let eyes = [
        middle,
        middle - DVec3::Z * reach * 2.0,
        middle + DVec3::new(0.3, 0.1, -0.2) * reach,
        middle + DVec3::X * reach * 100.0,
    ];
    views.extend(eyes.into_iter().map(|eye| {
        let target = eye + DVec3::new(-1.0, 0.2, 0.1);
        let orientation = Orientation::LookAt {
            target,
            up: DVec3::Z,
        };
        let projection = Projection::Perspective { fov_y_deg: 100.0 };
        let depth = DepthRange {
            near: 1e-3,
            far: None,
        };
        View::new(eye, orientation, projection, depth, [1280, 720]).unwrap()
    }));
    let ground = Ground::cut(field, &Layout::new(*field.grid()));
    for (n, view) in views.iter().enumerate() {
        for criterion in Criterion::ALL {
            for subdivide_within in [0.0, reach * 0.5, f64::INFINITY] {
                let detail = Detail {
                    criterion,
                    subdivide_within,
                    ..Detail::of(criterion)
                };
                let selection = select(&ground, view, &detail, Workers::One).unwrap();
                let mesh = selection.mesh(&ground);
                examine(field, &mesh, (n >= 2).then_some(view));
                assert!(
                    measure(field, &mesh, view).error_px <= selection.error_px() * (1.0 + 1e-12)
                );
                assert!(!selection.error_px().is_nan());
                let again = select(&ground, view, &detail, Workers::Pool).unwrap();
                assert_eq!(again.mesh(&ground), mesh);
            }
        }
    }
}

const METRE: DVec2 = DVec2::ONE;

#[test]
fn rasters_without_area_draw_nothing() {
    for size in [[1, 1], [1, 40], [300, 1]] {
        let field = field(size, DVec2::ZERO, METRE, |x, y| (x * 3 + y) as f32);
        assert_eq!(Layout::new(*field.grid()).block_count(), 0);
        examined(&field);
    }
}

#[test]
fn single_cells_and_narrow_strips_are_drawn() {
    for size in [[2, 2], [2, 40], [300, 2], [3, 17], [17, 130]] {
        examined(&field(size, DVec2::ZERO, METRE, |x, y| {
            (x * 7 % 5 + y * y % 3) as f32
        }));
    }
}

#[test]
fn holes_are_left_open() {
    let holes: [fn(u32, u32) -> bool; 7] = [
        |x, y| x == 20 && y == 20,
        |x, y| (10..30).contains(&x) && (15..18).contains(&y),
        |x, y| x == y,
        |x, y| (x + y) % 2 == 0,
        |x, y| x % 5 == 0 || y % 7 == 0,
        |x, y| x.abs_diff(24).pow(2) + y.abs_diff(24).pow(2) > 400,
        |_, _| true,
    ];
    for hole in holes {
        let bumpy = |x: u32, y: u32| ((x * x + 3 * y) % 11) as f32;
        let height = |x, y| if hole(x, y) { f32::NAN } else { bumpy(x, y) };
        examined(&field([49, 49], DVec2::ZERO, METRE, height));
    }
}

#[test]
fn cliffs_flats_and_extreme_heights_are_drawn() {
    let heights: [fn(u32, u32) -> f32; 5] = [
        |x, _| if x > 16 { 3_000.0 } else { 0.0 },
        |_, _| -17.25,
        |x, y| if (x + y) % 2 == 0 { 1e6 } else { -1e6 },
        |x, y| 1e6 + (x * y % 7) as f32 * 0.0625,
        |x, y| {
            if x == 7 && y == 9 {
                1e9
            } else {
                f32::MIN_POSITIVE
            }
        },
    ];
    for height in heights {
        examined(&field([35, 33], DVec2::ZERO, METRE, height));
    }
}

/// The same ground here and in a national grid gives the same triangles.
#[test]
fn far_coordinates_lose_nothing() {
    let height = |x: u32, y: u32| ((x * 13 + y * 29) % 17) as f32;
    let at = |origin: DVec2| field([70, 50], origin, DVec2::splat(0.5), height);
    let (near, far) = (at(DVec2::ZERO), at(DVec2::new(6_000_000.0, -4_000_000.0)));
    examined(&far);
    let [a, b] = [&near, &far].map(|field| {
        let ground = Ground::cut(field, &Layout::new(*field.grid()));
        let knobs = Knobs {
            c1: 4.0,
            c2: 4.0,
            ..Criterion::Error.knobs()
        };
        let detail = Detail {
            knobs,
            ..Detail::of(Criterion::Error)
        };
        let view = from_above(field, 3.0);
        select(&ground, &view, &detail, Workers::One)
            .unwrap()
            .mesh(&ground)
    });
    assert_eq!(a, b);
}

#[test]
fn a_missing_block_is_a_border() {
    let field = field([49, 49], DVec2::ZERO, METRE, |x, y| {
        ((x * x + y * 5) % 13) as f32
    });
    let layout = Layout::with_levels(*field.grid(), 4);
    let whole = Ground::cut(&field, &layout);
    let blocks = (0..layout.block_count()).map(|n| whole.block(n).filter(|_| n != 4).cloned());
    let ground = Ground::new(layout, blocks.collect()).unwrap();
    // The same as if the block's cells were unknown.
    let holed = super::places::field([49, 49], DVec2::ZERO, METRE, |x, y| {
        let inside = |c: u32| (17..32).contains(&c);
        if inside(x) && inside(y) {
            f32::NAN
        } else {
            field.height(x, y)
        }
    });
    for criterion in Criterion::ALL {
        let detail = Detail::of(criterion);
        let view = from_above(&field, 2.0);
        let mesh = select(&ground, &view, &detail, Workers::One)
            .unwrap()
            .mesh(&ground);
        assert!(mesh.triangles.len() > 100);
        examine(&holed, &mesh, None);
    }
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let grid = |columns, rows, origin, spacing| Grid::new(columns, rows, origin, spacing);
    let size = grid(0, 5, DVec2::ZERO, METRE);
    assert!(matches!(
        size,
        Err(FieldError::Size {
            columns: 0,
            rows: 5
        })
    ));
    for spacing in [
        DVec2::ZERO,
        -METRE,
        DVec2::new(1.0, f64::NAN),
        DVec2::splat(f64::INFINITY),
    ] {
        let refused = grid(3, 3, DVec2::ZERO, spacing);
        assert!(
            matches!(refused, Err(FieldError::Spacing { .. })),
            "{spacing}"
        );
    }
    let too_close = grid(3, 3, DVec2::splat(6e6), DVec2::splat(1e-12));
    assert!(matches!(too_close, Err(FieldError::Spacing { .. })));
    let nowhere = grid(3, 3, DVec2::new(f64::NAN, 0.0), METRE);
    assert!(matches!(nowhere, Err(FieldError::Origin { .. })));
    let two = grid(2, 1, DVec2::ZERO, METRE).unwrap();
    let short = HeightField::new(two, vec![0.0]);
    assert!(matches!(
        short,
        Err(FieldError::Count {
            given: 1,
            expected: 2
        })
    ));
    for height in [f32::INFINITY, f32::MIN, -1.1e9] {
        let refused = HeightField::new(two, vec![0.0, height]);
        assert!(matches!(
            refused,
            Err(FieldError::Height {
                column: 1,
                row: 0,
                ..
            })
        ));
    }
    for (knob, knobs) in [
        (
            "c1",
            Knobs {
                c1: 0.0,
                ..Criterion::Error.knobs()
            },
        ),
        (
            "c2",
            Knobs {
                c2: f64::NAN,
                ..Criterion::Error.knobs()
            },
        ),
        (
            "threshold",
            Knobs {
                threshold: f64::INFINITY,
                ..Criterion::Error.knobs()
            },
        ),
        (
            "speed_mps",
            Knobs {
                speed_mps: -1.0,
                ..Criterion::Error.knobs()
            },
        ),
    ] {
        assert_eq!(knobs.checked().unwrap_err().knob, knob);
    }
}
