use citylod::geom::{Aabb, DVec3, DepthRange, Orientation, Projection, View};
use citylod::index::{self, LodTree, Promotion};
use citylod::lod::{Beyond, RangeLod, Selection, retrieve};
use citylod::scene::{Scene, SceneObject};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use serde_json::value::RawValue;

use crate::support::{self, object};

/// Saved and opened again.
fn reopened(scene: &Scene) -> LodTree {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("city.citylod");
    let built = index::build(scene, Promotion::Tallest).unwrap();
    built.save(&path).unwrap();
    let opened = LodTree::open_verified(&path).unwrap();
    assert_eq!(built.revision(), opened.revision());
    assert_eq!(opened.validate(), []);
    opened
}

fn assert_holds(tree: &LodTree, scene: &Scene) {
    assert_eq!(tree.object_count() as usize, scene.objects.len());
    assert_eq!(tree.crs(), scene.crs.as_deref());
    for expected in &scene.objects {
        let id = expected.id.as_str();
        let number = tree
            .find(id)
            .unwrap_or_else(|| panic!("{id:.40?} not found"));
        let found = tree.object(number).unwrap();
        assert_eq!(found.id, id);
        assert_eq!(tree.id(number).unwrap(), id);
        assert_eq!(found.class, expected.class);
        let bits = |b: &Aabb| b.to_array().map(f64::to_bits);
        assert_eq!(bits(&found.bounds), bits(&expected.bounds));
        assert_eq!(
            found.footprint_area.to_bits(),
            expected.footprint_area.to_bits()
        );
        assert_eq!(found.triangles, expected.triangles);
        assert_eq!(found.base_known, expected.base_known);
        assert_eq!(found.lift_m, expected.lift_m);
        assert_eq!(
            found.attributes,
            expected.attributes.as_deref().map(RawValue::get)
        );
        assert_eq!(found.level, tree.level_of(number));
        assert!(found.level < tree.level_count());
        let json = tree.ids_json(number..number + 1);
        let quoted = json.strip_suffix(b",").unwrap();
        assert_eq!(serde_json::from_slice::<String>(quoted).unwrap(), id);
    }
    let all = [b"[", tree.ids_json(0..tree.object_count())].concat();
    let all = [all.strip_suffix(b",").unwrap_or(&all), b"]"].concat();
    let ids: Vec<String> = serde_json::from_slice(&all).unwrap();
    assert_eq!(ids.len(), scene.objects.len());
    assert_eq!(tree.object(tree.object_count()).map(|o| o.level), None);
}

fn any_text(rng: &mut Pcg64Mcg) -> String {
    let length = rng.random_range(0..12);
    (0..length)
        .map(|_| match rng.random_range(0..6) {
            0 => ['"', '\\', '/', '\u{0}', '\n', '\u{7f}', '\u{2028}'][rng.random_range(0..7)],
            1 => char::from_u32(rng.random_range(0..0x20)).unwrap(),
            2 => char::from_u32(rng.random_range(0x4e00..0x9fff)).unwrap(),
            3 => char::from_u32(rng.random_range(0x1_f300..0x1_f5ff)).unwrap(),
            _ => char::from(rng.random_range(b' '..b'~')),
        })
        .collect()
}

#[test]
fn every_field_comes_back() {
    for seed in 0..60 {
        let mut rng = support::rng(seed);
        let mut scene = support::scene(&mut rng);
        scene.crs = rng.random_bool(0.5).then(|| any_text(&mut rng));
        for object in &mut scene.objects {
            object.id = any_text(&mut rng).into();
            object.class = any_text(&mut rng).into();
            object.footprint_area = support::between(&mut rng, 0.0, 1e6);
            object.triangles = rng.random();
            object.base_known = rng.random_bool(0.7);
            if rng.random_bool(0.3) {
                object.lift_m = support::between(&mut rng, 0.1, 90.0);
            }
            object.attributes = rng.random_bool(0.5).then(|| {
                let text = serde_json::json!({ any_text(&mut rng): any_text(&mut rng) });
                serde_json::value::to_raw_value(&text).unwrap()
            });
        }
        scene.canonicalize();
        let tree = reopened(&scene);
        assert_holds(&tree, &scene);
        let unknown = scene.objects.iter().filter(|o| !o.base_known).count();
        assert_eq!(tree.base_unknown_count() as usize, unknown);
        let again = index::build(&tree.scene(), Promotion::Tallest).unwrap();
        assert_eq!(again.revision(), tree.revision());
    }
}

#[test]
fn ids_of_any_kind_come_back() {
    let long = "長".repeat(10_000);
    let controls: String = (0..0x20).filter_map(char::from_u32).collect();
    let ids = [
        "",
        "a",
        "\"",
        "\\",
        "a\\\"b",
        "\u{0}",
        &controls,
        &long,
        "東京都/千代田区~1",
        "مبنى",
        "🏙️",
        "\u{feff}",
        " ",
        "{\"a\":1}",
        "a,b",
        "\u{10ffff}",
    ];
    let objects = ids.iter().enumerate().map(|(i, id)| {
        let min = DVec3::new(6_000_000.1 + i as f64, -5_500_000.7, 0.3);
        object(*id, min, DVec3::new(1.0 / 3.0, 1e-9, 0.0))
    });
    let scene = Scene {
        crs: Some("EPSG:25832".into()),
        objects: objects.collect(),
        ..Scene::default()
    };
    assert_holds(&reopened(&scene), &scene);
}

#[test]
fn a_repeated_id_is_refused_by_name() {
    let scene = Scene {
        objects: ["x", "tw\"in", "tw\"in"]
            .map(|id| object(id, DVec3::ZERO, DVec3::ONE))
            .to_vec(),
        ..Scene::default()
    };
    let error = index::build(&scene, Promotion::Tallest).unwrap_err();
    assert!(error.to_string().contains(r#""tw\"in""#), "{error}");
}

#[test]
fn no_object_and_one_object() {
    let none = Scene::default();
    let tree = reopened(&none);
    assert_holds(&tree, &none);
    assert_eq!((tree.node_count(), tree.level_count()), (0, 0));
    assert!(tree.bounds().is_empty());
    assert_eq!(tree.find(""), None);

    let one = Scene {
        objects: vec![object("only", DVec3::ONE, DVec3::ZERO)],
        ..Scene::default()
    };
    let tree = reopened(&one);
    assert_holds(&tree, &one);
    assert_eq!((tree.node_count(), tree.level_count()), (1, 1));

    let mut selection = Selection::default();
    let full = RangeLod::full_detail();
    retrieve(&reopened(&none), &view(), &full, &mut selection);
    assert_eq!((selection.count(), selection.error_px()), (0, 0.0));
    retrieve(&tree, &view(), &full, &mut selection);
    assert!(selection.objects().eq([0]));
}

/// From afar towards the origin.
fn view() -> View {
    View::new(
        DVec3::new(100.0, 0.0, 0.0),
        Orientation::LookAt {
            target: DVec3::ZERO,
            up: DVec3::Z,
        },
        Projection::Perspective { fov_y_deg: 60.0 },
        DepthRange::default(),
        [800, 600],
    )
    .unwrap()
}

/// The whole answer is one range: each object once.
#[test]
fn many_identical_boxes_are_each_found_once() {
    let count = 200_000;
    let twin = |i: u32| -> SceneObject { object(format!("{i:06}"), DVec3::ZERO, DVec3::ONE) };
    let scene = Scene {
        objects: (0..count).map(twin).collect(),
        ..Scene::default()
    };
    let tree = index::build(&scene, Promotion::Largest).unwrap();
    assert_eq!(tree.validate(), []);
    let mut selection = Selection::default();
    for lod in [
        RangeLod::full_detail(),
        RangeLod::new(200.0, 2.0, 9, Beyond::Show).unwrap(),
    ] {
        retrieve(&tree, &view(), &lod, &mut selection);
        assert_eq!(selection.ranges().len(), 1);
        assert_eq!(selection.ranges()[0], 0..count);
    }
    let lod = RangeLod::new(1.0, 2.0, 2, Beyond::Show).unwrap();
    retrieve(&tree, &view(), &lod, &mut selection);
    assert!((1..count / 3).contains(&selection.count()));
    assert!(selection.error_px() > 0.0);
}
