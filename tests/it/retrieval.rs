use std::collections::BTreeSet;

use citylod::index::{self, CityTree, LodTree, Promotion};
use citylod::lod::{Beyond, RangeLod, Selection, retrieve};
use citylod::scene::Scene;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::oracle::Gong;
use crate::support::{self, Camera};

/// Far beyond what f64 rounding can do to a plane test, far below what a scene shows.
const MARGIN: f64 = 1e-12;

#[derive(Debug, Clone, Copy)]
pub enum Made {
    Bulk,
    RstarBulk,
    Inserted,
    Removed,
}

pub fn tree(scene: &Scene, made: Made, promotion: Promotion, rng: &mut Pcg64Mcg) -> LodTree {
    let edited = match made {
        Made::Bulk => return index::build(scene, promotion).unwrap(),
        Made::RstarBulk => CityTree::bulk_load(scene.clone(), promotion).unwrap(),
        Made::Inserted => {
            let mut city = CityTree::bulk_load(Scene::default(), promotion).unwrap();
            for object in &scene.objects {
                city.insert(object.clone()).unwrap();
            }
            city
        }
        Made::Removed => {
            let mut city = CityTree::bulk_load(scene.clone(), promotion).unwrap();
            for object in &scene.objects {
                if rng.random_bool(0.4) {
                    city.remove(&object.id).unwrap();
                }
            }
            city
        }
    };
    edited.pack().unwrap()
}

pub fn lod(rng: &mut Pcg64Mcg, reach: f64) -> RangeLod {
    let far_dist = match rng.random_range(0..8) {
        0 => 0.0,
        1 => f64::INFINITY,
        2 => f64::MIN_POSITIVE,
        3 => 5.0 * f64::from(rng.random_range(1..40)), // met exactly by whole-metre scenes
        _ => reach * support::between(rng, 0.01, 1.5),
    };
    let dist_factor = match rng.random_range(0..6) {
        0 => 1.0,
        1 => 1.0 + f64::EPSILON,
        2 => 3.0,
        _ => support::between(rng, 1.0, 4.0),
    };
    let beyond = if rng.random_bool(0.4) {
        Beyond::Hide
    } else {
        Beyond::Show
    };
    RangeLod::new(far_dist, dist_factor, rng.random_range(1..7), beyond).unwrap()
}

/// Production retrieval equals the literal transcription of the seven steps, each id at most
/// once, over random scenes, views and parameters, however the tree was made; and nothing visible
/// that is left out is larger than `error_px`.
#[test]
fn retrieval_is_the_seven_steps() {
    const SCENES: u64 = 3_000;
    const VIEWS: u32 = 4;
    let mut selection = Selection::default();
    let mut ambiguous = 0;
    let mut drawn = 0;
    for seed in 0..SCENES {
        let mut rng = support::rng(seed);
        let scene = support::scene(&mut rng);
        let made = [Made::Bulk, Made::RstarBulk, Made::Inserted, Made::Removed][seed as usize % 4];
        let promotion =
            [Promotion::Tallest, Promotion::Footprint, Promotion::Largest][rng.random_range(0..3)];
        let tree = tree(&scene, made, promotion, &mut rng);
        assert_eq!(tree.validate(), [], "seed {seed}, {made:?}");
        let gong = Gong::of(&tree, |o| {
            let object = tree.object(o).unwrap();
            match promotion {
                Promotion::Tallest => object.bounds.size().z,
                Promotion::Footprint => object.footprint_area,
                Promotion::Largest => object.bounds.radius(),
            }
        });
        let reach = if tree.bounds().is_empty() {
            1.0
        } else {
            tree.bounds().radius()
        };
        for view in 0..VIEWS {
            let camera = Camera::random(&mut rng, &tree.bounds());
            let lod = lod(&mut rng, reach);
            let place = || format!("seed {seed}, view {view}, {made:?}: {camera:?}, {lod:?}");
            retrieve(&tree, &camera.view(), &lod, &mut selection);
            let ranges = selection.ranges();
            assert!(
                ranges.windows(2).all(|r| r[0].end < r[1].start)
                    && ranges.iter().all(|r| r.start < r.end),
                "ranges ascend without touching, {}",
                place()
            );
            let found: BTreeSet<u32> = selection.objects().collect();
            assert_eq!(found.len(), selection.count() as usize);
            let least = gong.retrieve(&camera, &lod, -MARGIN);
            let most = gong.retrieve(&camera, &lod, MARGIN);
            assert!(
                least.is_subset(&found),
                "lost {:?}, {}",
                &least - &found,
                place()
            );
            assert!(
                found.is_subset(&most),
                "added {:?}, {}",
                &found - &most,
                place()
            );
            ambiguous += u64::from(least != most);
            drawn += found.len();
            for object in 0..tree.object_count() {
                let bounds = tree.bounds_of(object).unwrap();
                if !found.contains(&object) && !camera.sees_nothing_of(&bounds, -MARGIN) {
                    let size = camera.size_px(&bounds);
                    assert!(
                        size <= selection.error_px() * (1.0 + 1e-12),
                        "object {object} of {size} px omitted, bound {}, {}",
                        selection.error_px(),
                        place()
                    );
                }
            }
        }
    }
    // The sandwich is an equality but where a plane is touched within rounding.
    assert!(
        ambiguous < SCENES * u64::from(VIEWS) / 20,
        "{ambiguous} ambiguous"
    );
    assert!(drawn > 100_000, "{drawn} drawn: the scenes are looked at");
}

/// At full detail the answer is what testing every object gives.
#[test]
fn full_detail_is_brute_force() {
    let mut selection = Selection::default();
    for seed in 0..1_500 {
        let mut rng = support::rng(1_000_000 + seed);
        let scene = support::scene(&mut rng);
        let tree = tree(&scene, Made::Bulk, Promotion::Tallest, &mut rng);
        let tree_levels = tree.level_count();
        let camera = Camera::random(&mut rng, &tree.bounds());
        retrieve(
            &tree,
            &camera.view(),
            &RangeLod::full_detail(),
            &mut selection,
        );
        let found: BTreeSet<u32> = selection.objects().collect();
        for object in 0..tree.object_count() {
            let bounds = tree.bounds_of(object).unwrap();
            if found.contains(&object) {
                assert!(
                    !camera.sees_nothing_of(&bounds, MARGIN),
                    "seed {seed}, {object} {bounds:?} {camera:?} {tree_levels}"
                );
            } else {
                assert!(
                    camera.sees_nothing_of(&bounds, -MARGIN),
                    "seed {seed}, {object} {bounds:?} {camera:?} {tree_levels}"
                );
            }
        }
        assert_eq!(selection.error_px(), 0.0, "nothing is left out");
    }
}
