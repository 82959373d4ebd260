use citylod::geom::{DVec2, DVec3, DepthRange, Orientation, Projection, View};
use citylod::terrain::{
    Criterion, Detail, Grid, Ground, HeightField, Knobs, Layout, Mesh, Workers, select,
    select_within,
};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::examine::{examine, measure};
use super::places::{between, extent, field, flat, from_above, made_up, real_grounds, rng, view};

/// What f64 rounding may do to an error computed in two ways.
const PIXEL_ROUNDING: f64 = 1.0 + 1e-12;

/// Random knobs, from everything split to nothing.
fn detail(rng: &mut Pcg64Mcg, criterion: Criterion, reach: f64) -> Detail {
    let scale = 10.0_f64.powf(between(rng, -1.0, 4.0));
    let fineness = scale.sqrt();
    let motion = criterion == Criterion::Motion;
    Detail {
        criterion,
        knobs: Knobs {
            c1: if motion {
                1.0 / (reach * scale)
            } else {
                fineness
            },
            c2: if motion { 0.1 } else { fineness },
            speed_mps: [0.0, 3.0, 50.0][rng.random_range(0..3)],
            threshold: scale,
        },
        subdivide_within: [0.0, reach * 0.3, reach, f64::INFINITY][rng.random_range(0..4)],
        max_triangles: None,
    }
}

fn cut(rng: &mut Pcg64Mcg, field: &HeightField) -> Ground {
    let levels = if rng.random_bool(0.5) {
        rng.random_range(1..=7)
    } else {
        5
    };
    Ground::cut(field, &Layout::with_levels(*field.grid(), levels))
}

/// Every law of a selection, for each criterion in one view.
fn laws_hold(rng: &mut Pcg64Mcg, field: &HeightField, ground: &Ground) {
    let (_, reach) = extent(field);
    let whole = rng.random_bool(0.3);
    let view = if whole {
        let radii = between(rng, 1.5, 20.0);
        from_above(field, radii)
    } else {
        view(rng, field)
    };
    for criterion in Criterion::ALL {
        let detail = detail(rng, criterion, reach);
        let selection = select(ground, &view, &detail, Workers::One).unwrap();
        let mesh = selection.mesh(ground);
        assert_eq!(mesh.triangles.len(), selection.triangles());
        examine(field, &mesh, (!whole).then_some(&view));
        let found = measure(field, &mesh, &view);
        let (measured, certified) = (found.error_px, selection.error_px());
        assert!(
            measured <= certified * PIXEL_ROUNDING,
            "{criterion:?}: {measured} px is more than the certified {certified}"
        );
        let parallel = select(ground, &view, &detail, Workers::Pool).unwrap();
        assert_eq!(parallel.cut(), selection.cut(), "threads change the cut");
    }
}

#[test]
fn made_up_ground_is_watertight_covered_once_and_as_wrong_as_certified() {
    (0..1_000_u64).into_par_iter().for_each(|seed| {
        let mut rng = rng(seed);
        let field = made_up(&mut rng);
        let ground = cut(&mut rng, &field);
        laws_hold(&mut rng, &field, &ground);
    });
}

#[test]
fn real_ground_is_watertight_covered_once_and_as_wrong_as_certified() {
    real_grounds().into_par_iter().for_each(|(name, field)| {
        println!("{name}");
        let grounds =
            [5, 6, 7].map(|n| Ground::cut(&field, &Layout::with_levels(*field.grid(), n)));
        (0..60_u64).into_par_iter().for_each(|seed| {
            let mut rng = rng(seed + 1_000_000);
            laws_hold(&mut rng, &field, &grounds[seed as usize % 3]);
        });
    });
}

/// Level ground and slopes, which are as flat.
#[test]
fn flat_ground_is_two_triangles_a_block() {
    let slope = |size| {
        field(size, DVec2::ZERO, DVec2::splat(10.0), |x, y| {
            x as f32 * 0.5 - y as f32 * 0.25
        })
    };
    let sizes = [[2, 2], [17, 17], [65, 33], [100, 100], [130, 257]];
    for field in sizes.map(flat).into_iter().chain(sizes.map(slope)) {
        for levels in 4..=7 {
            let ground = Ground::cut(&field, &Layout::with_levels(*field.grid(), levels));
            for criterion in Criterion::ALL {
                let detail = Detail::of(criterion);
                let selection =
                    select(&ground, &from_above(&field, 2.0), &detail, Workers::One).unwrap();
                assert_eq!(selection.triangles(), 2 * ground.layout().block_count());
                assert_eq!(selection.error_px(), 0.0);
            }
        }
    }
}

/// Fewer triangles as a knob asks for less, or the eye goes up.
#[test]
fn selections_shrink_with_the_knobs_and_with_distance() {
    let mut fields: Vec<HeightField> = (0..40)
        .map(|seed| made_up(&mut rng(seed + 5_000)))
        .collect();
    fields.extend(real_grounds().into_iter().map(|(_, field)| field));
    fields.par_iter().enumerate().for_each(|(seed, field)| {
        let mut rng = rng(seed as u64 + 6_000);
        let ground = cut(&mut rng, field);
        let (_, reach) = extent(field);
        for criterion in Criterion::ALL {
            let mut start = detail(&mut rng, criterion, reach);
            let triangles = |detail: &Detail, radii: f64| {
                let view = from_above(field, radii);
                select(&ground, &view, detail, Workers::One)
                    .unwrap()
                    .triangles()
            };
            let fewer = |change: &dyn Fn(&mut Knobs)| {
                let (mut now, mut last) = (start, usize::MAX);
                for _ in 0..8 {
                    let count = triangles(&now, 2.0);
                    assert!(count <= last, "{criterion:?}: {last} became {count}");
                    last = count;
                    change(&mut now.knobs);
                }
            };
            match criterion {
                Criterion::Roughness | Criterion::Error => {
                    fewer(&|knobs| knobs.c1 /= 2.0);
                    fewer(&|knobs| knobs.c2 /= 2.0);
                }
                // Here C1, C2 and the speed stand in the denominator.
                Criterion::Motion => {
                    fewer(&|knobs| knobs.c1 *= 2.0);
                    fewer(&|knobs| knobs.c2 *= 2.0);
                    fewer(&|knobs| knobs.speed_mps = (knobs.speed_mps * 2.0).max(1.0));
                    fewer(&|knobs| knobs.threshold /= 2.0);
                }
                Criterion::Vertex => {
                    fewer(&|knobs| knobs.threshold /= 2.0);
                }
            }
            // B's rule changes with distance by itself: it may only be compared at one reach.
            for reach in [0.0, f64::INFINITY] {
                start.subdivide_within = reach;
                let mut last = usize::MAX;
                for radii in [1.5, 3.0, 6.0, 12.0, 50.0, 1e6] {
                    let count = triangles(&start, radii);
                    assert!(
                        count <= last,
                        "{criterion:?} at {radii}: {last} became {count}"
                    );
                    last = count;
                }
            }
        }
    });
}

/// Hills with a step.
fn hills(size: [u32; 2]) -> HeightField {
    field(size, DVec2::ZERO, DVec2::splat(10.0), |x, y| {
        let (fx, fy) = (x as f32, y as f32);
        let step = if x > 50 && y < 20 { 40.0 } else { 0.0 };
        ((fx * 0.2).sin() + (fy * 0.13).cos()) * 20.0 + step
    })
}

#[test]
fn knobs_change_what_is_drawn() {
    let field = hills([65, 65]);
    let ground = Ground::cut(&field, &Layout::with_levels(*field.grid(), 6));
    let view = from_above(&field, 3.0);
    for criterion in Criterion::ALL {
        let select = |share: f64, subdivide_within| {
            let detail = Detail {
                knobs: criterion.share(&criterion.knobs(), share),
                subdivide_within,
                ..Detail::of(criterion)
            };
            select(&ground, &view, &detail, Workers::One).unwrap()
        };
        let (most, least) = (select(1e9, 0.0), select(1e-9, 0.0));
        assert_eq!(least.triangles(), 2 * ground.layout().block_count());
        assert!(
            most.triangles() > 1_000 && most.error_px() == 0.0,
            "{criterion:?}"
        );
        assert!(least.error_px() > 0.0, "{criterion:?}");
        // B's m: the farther it reaches, the more is subdivided.
        let (mut last, mut counts) = (0, Vec::new());
        for radii in [0.0, 2.9, 3.0, 3.1, f64::INFINITY] {
            let reach = extent(&field).1 * radii;
            let count = select(0.3, reach).triangles();
            assert!(count >= last, "{criterion:?}: {last} became {count}");
            last = count;
            counts.push(count);
        }
        assert!(counts[0] < last, "{criterion:?}: {counts:?}");
    }
}

/// The examination itself: what is wrong with a mesh does not pass.
#[test]
fn cracks_are_seen() {
    let field = hills([80, 70]);
    let ground = Ground::cut(&field, &Layout::with_levels(*field.grid(), 9));
    let detail = Detail::of(Criterion::Error);
    let view = from_above(&field, 3.0);
    let selection = select(&ground, &view, &detail, Workers::One).unwrap();
    let mesh = selection.mesh(&ground);
    examine(&field, &mesh, None);
    let passes = |spoil: &dyn Fn(&mut Mesh)| {
        let mut spoilt = mesh.clone();
        spoil(&mut spoilt);
        let looked = || examine(&field, &spoilt, None);
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(looked)).is_ok()
    };
    assert!(passes(&|_| {}));
    assert!(!passes(&|mesh| mesh.triangles.truncate(100)));
    assert!(!passes(&|mesh| mesh.triangles[9].swap(0, 1)));
    assert!(!passes(&|mesh| mesh.triangles.push(mesh.triangles[9])));
    assert!(!passes(&|mesh| mesh.heights[5] += 0.25));
    // A midpoint more on a side that the neighbour does not have.
    assert!(!passes(&|mesh| {
        let long = |t: &[u32; 3]| {
            let [a, b] = [1, 2].map(|k| mesh.posts[t[k] as usize]);
            a[1] == b[1] && a[0] + 1 < b[0] && a[1] > 0
        };
        let at = mesh.triangles.iter().position(long).unwrap();
        let [c, a, b] = mesh.triangles[at];
        let [x, y] = mesh.posts[a as usize];
        let middle = [x.midpoint(mesh.posts[b as usize][0]), y];
        mesh.posts.push(middle);
        mesh.heights.push(field.height(middle[0], middle[1]));
        let m = mesh.posts.len() as u32 - 1;
        mesh.triangles[at] = [c, a, m];
        mesh.triangles.push([c, m, b]);
    }));
}

/// However sharp the eye, a budget is kept, and used.
#[test]
fn a_budget_is_kept_by_the_sharpest_eye() {
    let field = HeightField::new(
        Grid::new(513, 513, DVec2::ZERO, DVec2::splat(10.0)).unwrap(),
        (0..513 * 513_u32)
            .map(|at| (at.wrapping_mul(2_654_435_761) >> 24) as f32)
            .collect(),
    )
    .unwrap();
    let ground = Ground::cut(&field, &Layout::new(*field.grid()));
    let view = View::new(
        DVec3::new(2_560.0, -500.0, 900.0),
        Orientation::LookAt {
            target: DVec3::new(2_560.0, 2_560.0, 0.0),
            up: DVec3::Z,
        },
        Projection::Perspective { fov_y_deg: 60.0 },
        DepthRange::default(),
        [u32::MAX, u32::MAX],
    )
    .unwrap();
    for criterion in Criterion::ALL {
        for most in [100, 3_000] {
            let detail = Detail {
                max_triangles: Some(most),
                ..Detail::of(criterion)
            };
            let chosen = select_within(&ground, &view, &detail, 1.5, Workers::One).unwrap();
            assert!(
                chosen.triangles() <= most,
                "{criterion:?} {most}: {}",
                chosen.triangles()
            );
            assert!(chosen.share() < 1.0);
            if most == 3_000 {
                assert!(
                    chosen.triangles() > most / 2,
                    "{criterion:?}: {}",
                    chosen.triangles()
                );
            }
        }
    }
}

#[test]
fn a_budget_is_kept_and_used() {
    (0..60_u64).into_par_iter().for_each(|seed| {
        let mut rng = rng(seed + 9_000);
        let field = made_up(&mut rng);
        let ground = cut(&mut rng, &field);
        let (_, reach) = extent(&field);
        let view = view(&mut rng, &field);
        for criterion in Criterion::ALL {
            let unbounded = detail(&mut rng, criterion, reach);
            let count = |max_triangles| {
                let detail = Detail {
                    max_triangles,
                    ..unbounded
                };
                let selection = select(&ground, &view, &detail, Workers::One).unwrap();
                examine(&field, &selection.mesh(&ground), Some(&view));
                selection.triangles()
            };
            let (all, least) = (count(None), count(Some(0)));
            for most in [all, all / 2, all / 7] {
                let kept = count(Some(most));
                assert!(kept <= most.max(least), "{kept} triangles of {most}");
            }
            assert_eq!(count(Some(all)), all);
        }
    });
}
