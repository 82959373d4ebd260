//! What every generated city keeps, whatever its seed.

use super::plan::Line;
use super::quad::Quad;
use super::*;

fn city(objects: u32, seed: u64) -> Scene {
    generate(&CityParams { objects, seed })
}

fn of_class<'a>(scene: &'a Scene, class: &str) -> Vec<&'a SceneObject> {
    scene.objects.iter().filter(|o| o.class == class).collect()
}

fn contains(quad: &Quad, p: DVec2) -> bool {
    let [a, b, c, d] = quad.0;
    [(a, b), (b, c), (c, d), (d, a)]
        .iter()
        .all(|&(from, to)| (to - from).perp_dot(p - from) > 0.0)
}

fn ground_corners(bounds: &Aabb) -> [DVec2; 4] {
    let (min, max) = (bounds.min().truncate(), bounds.max().truncate());
    [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)]
}

#[test]
fn has_exactly_as_many_objects_as_asked() {
    for objects in [0, 1, 2, 99, 2_000, 23_951] {
        assert_eq!(city(objects, 7).objects.len(), objects as usize);
    }
}

#[test]
fn same_seed_same_bits_and_another_seed_another_city() {
    let bits = |seed| -> Vec<_> {
        let scene = city(3_000, seed);
        let bits = scene.objects.iter().map(|o| {
            let bounds = o.bounds.to_array().map(f64::to_bits);
            (o.id.clone(), o.class.clone(), bounds)
        });
        bits.collect()
    };
    assert_eq!(bits(1), bits(1));
    assert_ne!(bits(1), bits(2));
}

/// Fails when a draw, a constant or a dependency changes the demo city, which published figures
/// are about.
#[test]
fn the_demo_city_is_pinned() {
    let mut crc = crc32fast::Hasher::new();
    for object in city(23_951, 1).objects {
        for coordinate in object.bounds.to_array() {
            crc.update(&coordinate.to_le_bytes());
        }
    }
    assert_eq!(crc.finalize(), 4_092_272_381);
}

#[test]
fn ids_are_sorted_and_unique() {
    let scene = city(23_951, 1);
    assert!(scene.objects.is_sorted_by(|a, b| a.id < b.id));
    assert_eq!(of_class(&scene, "Building")[0].id, "b-0000001");
}

#[test]
fn a_smaller_city_is_the_heart_of_a_larger_one() {
    for seed in 0..4 {
        let boxes = |objects| {
            let scene = city(objects, seed);
            let mut bits: Vec<_> = scene.objects.iter().map(|o| o.bounds.to_array()).collect();
            bits.sort_unstable_by(|a, b| a.partial_cmp(b).expect("finite"));
            bits
        };
        let large = boxes(60_000);
        for small in boxes(9_000) {
            assert!(
                large
                    .binary_search_by(|b| b.partial_cmp(&small).expect("finite"))
                    .is_ok()
            );
        }
    }
}

#[test]
fn bounds_are_finite_and_stand_on_the_ground() {
    for object in city(20_000, 3).objects {
        let (min, size) = (object.bounds.min(), object.bounds.size());
        assert!(min.is_finite() && size.is_finite() && size.min_element() > 0.0);
        assert!(min.z == 0.0 || object.class == "Bridge");
        assert!(object.height() < 320.0);
        assert_eq!(object.footprint_area, size.x * size.y);
    }
}

#[test]
fn buildings_do_not_overlap() {
    for seed in 0..5 {
        let scene = city(5_000, seed);
        let mut buildings: Vec<Aabb> = of_class(&scene, "Building")
            .iter()
            .map(|o| o.bounds)
            .collect();
        buildings.sort_unstable_by(|a, b| a.min().x.total_cmp(&b.min().x));
        for (n, a) in buildings.iter().enumerate() {
            let reached = buildings[n + 1..]
                .iter()
                .take_while(|b| b.min().x <= a.max().x);
            for b in reached {
                let apart = a.max().y < b.min().y || b.max().y < a.min().y;
                assert!(apart, "seed {seed}: {a:?} and {b:?}");
            }
        }
    }
}

#[test]
fn buildings_stand_inside_one_block_and_blocks_leave_room_for_streets() {
    let plan = Plan::new(5);
    for (i, j) in [(0, 0), (-4, 3), (17, -30), (200, 150)] {
        let ground = plan.quarter(i, j);
        let mut rng = plan.quarter_rng(i, j);
        let blocks = quarter::blocks(&ground, &mut rng);
        assert!(blocks.len() > 4);
        let mut items = Vec::new();
        for block in &blocks {
            let from = items.len();
            quarter::build(
                block,
                plan.urbanity(block.at(0.5, 0.5)),
                &mut rng,
                &mut items,
            );
            for item in items[from..].iter().filter(|i| i.kind == Kind::Building) {
                for corner in ground_corners(&item.bounds) {
                    assert!(contains(block, corner) && contains(&ground, corner));
                }
            }
        }
        // Streets are at least 6 m wide: no point 3 m around a block's corner is in another.
        for (n, block) in blocks.iter().enumerate() {
            let around = block.0.iter().flat_map(|&p| {
                [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y].map(|way| p + way * 3.0)
            });
            for p in around {
                let elsewhere = blocks.iter().enumerate().filter(|&(m, _)| m != n);
                assert!(elsewhere.into_iter().all(|(_, other)| !contains(other, p)));
            }
        }
    }
}

#[test]
fn no_building_stands_on_a_line_of_the_lattice() {
    let scene = city(5_000, 2);
    let buildings = of_class(&scene, "Building");
    let plan = Plan::new(2);
    for (i, j) in (-4..5).flat_map(|i| (-4..5).map(move |j| (i, j))) {
        let [from, east, _, north] = plan.cell(i, j).0;
        for (to, line) in [(east, Plan::row(j)), (north, Plan::column(i))] {
            // A square of this size fits on the line whichever way the line runs.
            let half = DVec2::splat(line.half_width() * 0.6);
            for step in 0..=40 {
                let p = from.lerp(to, f64::from(step) / 40.0);
                let road = Aabb::around([(p - half).extend(0.0), (p + half).extend(0.0)]);
                assert!(buildings.iter().all(|b| {
                    let (a, b) = (road, b.bounds);
                    a.max().x < b.min().x
                        || b.max().x < a.min().x
                        || a.max().y < b.min().y
                        || b.max().y < a.min().y
                }));
            }
        }
    }
}

#[test]
fn quarters_are_convex_wherever_they_lie() {
    for seed in 0..3 {
        let plan = Plan::new(seed);
        for (i, j) in (-120..120).flat_map(|i| (-120..120).map(move |j| (i, j))) {
            for quad in [plan.cell(i, j), plan.quarter(i, j)] {
                let [a, b, c, d] = quad.0;
                let turns = [(a, b, c), (b, c, d), (c, d, a), (d, a, b)];
                assert!(turns.iter().all(|&(p, q, r)| (q - p).perp_dot(r - q) > 0.0));
            }
            let place = DVec2::new(f64::from(i), f64::from(j)) * QUARTER;
            assert!(plan.crossing(i, j).distance(place) < DISPLACEMENT + QUARTER);
        }
    }
}

#[test]
fn towers_stand_downtown_and_houses_in_the_suburbs() {
    for seed in 0..5 {
        let scene = city(100_000, seed);
        let mean_height = |from: f64, to: f64| {
            let heights: Vec<f64> = of_class(&scene, "Building")
                .iter()
                .filter(|o| (from..to).contains(&o.bounds.center().truncate().length()))
                .map(|o| o.height())
                .collect();
            heights.iter().sum::<f64>() / heights.len() as f64
        };
        let (downtown, inner, suburb) = (
            mean_height(0.0, 500.0),
            mean_height(1_000.0, 2_000.0),
            mean_height(3_500.0, 5_000.0),
        );
        assert!(
            downtown > 1.8 * inner && inner > 1.2 * suburb,
            "{downtown} {inner} {suburb}"
        );
        let tallest = scene
            .objects
            .iter()
            .map(SceneObject::height)
            .fold(0.0, f64::max);
        assert!((150.0..320.0).contains(&tallest), "seed {seed}: {tallest}");
    }
}

#[test]
fn as_dense_and_as_green_as_a_real_city() {
    for seed in 0..3 {
        let scene = city(50_000, seed);
        let trees = of_class(&scene, "SolitaryVegetationObject").len() as f64;
        let share = trees / scene.objects.len() as f64;
        assert!((0.15..0.5).contains(&share), "{share}");
        let extent = scene
            .objects
            .iter()
            .fold(Aabb::EMPTY, |b, o| b.union(&o.bounds))
            .size();
        assert!(extent.x / extent.y > 0.9 && extent.x / extent.y < 1.1);
        let km2 = std::f64::consts::FRAC_PI_4 * extent.x * extent.y / 1e6;
        let density = scene.objects.len() as f64 / km2;
        assert!((1_000.0..2_500.0).contains(&density), "{density} per km²");
    }
}

#[test]
fn a_river_is_crossed_by_bridges() {
    let scene = city(23_951, 1);
    assert!(!of_class(&scene, "Bridge").is_empty());
    assert_eq!(Plan::row(-2), Line::River);
}
