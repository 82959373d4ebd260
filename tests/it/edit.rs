use std::collections::{BTreeMap, BTreeSet};

use citylod::index::{self, BuildError, CityTree, LodTree, Promotion};
use citylod::lod::{RangeLod, Selection, retrieve};
use citylod::scene::{Scene, SceneObject};
use rand::RngExt;

use crate::support::{self, Camera};

type Model = BTreeMap<String, SceneObject>;

fn scene_of(model: &Model) -> Scene {
    Scene {
        crs: Some("EPSG:28992".into()),
        objects: model.values().cloned().collect(),
        ..Scene::default()
    }
}

/// Representatives found by looking at every object below every node.
fn assert_representatives(tree: &LodTree, model: &Model, promotion: Promotion, place: &str) {
    let a = tree.arrays();
    let count = tree.node_count() as usize;
    let mut below: Vec<Vec<u32>> = vec![Vec::new(); count];
    for node in (0..count).rev() {
        if node + 1 < a.children.len() {
            for child in a.children[node]..a.children[node + 1] {
                let part = below[child as usize].clone();
                below[node].extend(part);
            }
        } else {
            below[node].extend(a.own[node]..a.own[node + 1]);
            below[node].push(a.representatives[node]);
            below[node].dedup();
        }
        let score = |o: u32| promotion.score(&model[&*tree.id(o).unwrap()]);
        let best = below[node].iter().copied().reduce(|best, o| {
            let better = score(o) > score(best)
                || score(o) == score(best) && tree.id(o).unwrap() < tree.id(best).unwrap();
            if better { o } else { best }
        });
        assert_eq!(
            best,
            Some(a.representatives[node]),
            "{place}: node {node} of {count}"
        );
    }
}

fn ids(tree: &LodTree, camera: &Camera) -> BTreeSet<String> {
    let mut selection = Selection::default();
    retrieve(
        tree,
        &camera.view(),
        &RangeLod::full_detail(),
        &mut selection,
    );
    selection
        .objects()
        .map(|o| tree.id(o).unwrap().into_owned())
        .collect()
}

/// Any sequence of insertions and removals leaves a sound tree with the best representatives,
/// that holds what it should and answers as a tree built at once does.
#[test]
fn edited_trees_keep_every_law() {
    for seed in 0..120 {
        let mut rng = support::rng(40_000 + seed);
        let promotion =
            [Promotion::Tallest, Promotion::Footprint, Promotion::Largest][seed as usize % 3];
        let mut pool = support::scene(&mut rng).objects;
        let mut model = Model::new();
        let start = pool.split_off(pool.len() / 2);
        for object in start {
            model.insert(object.id.to_string(), object);
        }
        let mut city = CityTree::bulk_load(scene_of(&model), promotion).unwrap();
        for step in 0..=120 {
            if step % 40 == 0 {
                let place = format!("seed {seed}, step {step}");
                let tree = city.pack().unwrap();
                assert_eq!(tree.validate(), [], "{place}");
                assert_eq!(
                    (tree.object_count() as usize, city.len()),
                    (model.len(), model.len())
                );
                assert_eq!(city.is_empty(), model.is_empty());
                assert_representatives(&tree, &model, promotion, &place);
            }
            if rng.random_bool(0.5) && !pool.is_empty() {
                let object = pool.swap_remove(rng.random_range(0..pool.len()));
                city.insert(object.clone()).unwrap();
                model.insert(object.id.to_string(), object);
            } else if !model.is_empty() {
                let at = rng.random_range(0..model.len());
                let id = model.keys().nth(at).unwrap().clone();
                let expected = model.remove(&id).unwrap();
                let removed = city.remove(&id).unwrap();
                assert_eq!(
                    (&removed.id, removed.bounds),
                    (&expected.id, expected.bounds)
                );
                pool.push(removed);
            }
        }
        let edited = city.pack().unwrap();
        let built = index::build(&scene_of(&model), promotion).unwrap();
        assert_eq!(edited.crs(), built.crs());
        for _ in 0..4 {
            let camera = Camera::random(&mut rng, &built.bounds());
            let (one, other) = (ids(&edited, &camera), ids(&built, &camera));
            for id in &one ^ &other {
                // Only what touches a plane within rounding may be told differently.
                let bounds = model[&id].bounds;
                assert!(
                    !camera.sees_nothing_of(&bounds, 1e-12)
                        && camera.sees_nothing_of(&bounds, -1e-12),
                    "seed {seed}: {id}, {camera:?}"
                );
            }
        }
    }
}

#[test]
fn taken_ids_are_refused_and_unknown_ones_not_found() {
    let mut rng = support::rng(7);
    let object = |id: &str, rng: &mut _| {
        support::object(
            id,
            support::point(rng, 0.0, 9.0),
            support::point(rng, 1.0, 2.0),
        )
    };
    let scene = Scene {
        objects: vec![object("a", &mut rng), object("b", &mut rng)],
        ..Scene::default()
    };
    let mut city = CityTree::bulk_load(scene, Promotion::Tallest).unwrap();
    let before = city.pack().unwrap().revision();
    let refused = city.insert(object("a", &mut rng)).unwrap_err();
    assert!(matches!(refused, BuildError::DuplicateId { id } if id == "a"));
    assert!(city.remove("c").is_none());
    assert_eq!(
        city.pack().unwrap().revision(),
        before,
        "nothing has changed"
    );

    assert_eq!(city.remove("a").unwrap().id, "a");
    assert!(city.remove("a").is_none());
    city.insert(object("a", &mut rng)).unwrap();
    assert_eq!(city.len(), 2);
    for id in ["a", "b"] {
        assert!(city.remove(id).is_some());
    }
    assert!(city.is_empty());
    let empty = city.pack().unwrap();
    assert_eq!((empty.object_count(), empty.validate()), (0, vec![]));

    let twins = Scene {
        objects: vec![object("t", &mut rng), object("t", &mut rng)],
        ..Scene::default()
    };
    let refused = CityTree::bulk_load(twins, Promotion::Tallest).unwrap_err();
    assert!(matches!(refused, BuildError::DuplicateId { id } if id == "t"));
}
