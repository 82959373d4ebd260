use std::collections::BTreeSet;
use std::path::Path;

use citylod::geom::{DVec3, DepthRange, Orientation, Projection, View};
use citylod::index::{self, LodTree, Promotion};
use citylod::lod::{Beyond, BudgetLod, ErrorLod, Lod, RangeLod, Selection, retrieve, select};
use citylod::scene::{CityParams, Scene, SceneObject, generate};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::support::{self, object};

fn saved(scene: &Scene, promotion: Promotion) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("city.citylod");
    index::build(scene, promotion).unwrap().save(&path).unwrap();
    std::fs::read(&path).unwrap()
}

fn attributes(json: &str) -> Box<serde_json::value::RawValue> {
    serde_json::from_str(json).unwrap()
}

/// A dozen objects with everything a file can hold.
fn small() -> Scene {
    let ids = [
        "a",
        "b\"q\\",
        "千代田",
        "é\n",
        "",
        "f",
        "g~2",
        "h",
        "i",
        "j",
        "k",
        "🏙",
    ];
    let objects = ids.iter().enumerate().map(|(i, id)| {
        let at = i as f64 * 7.0;
        let mut object = object(
            *id,
            DVec3::new(at, -at, 0.5),
            DVec3::new(5.0, 4.0, 3.0 + at),
        );
        object.class = if i % 3 == 0 { "Road" } else { "Building" }.into();
        object.attributes = (i % 2 == 0).then(|| attributes(r#"{"名":"x","n":[1,2.5]}"#));
        object.lift_m = if i % 5 == 0 { 0.5 + at } else { 0.0 };
        object
    });
    Scene {
        crs: Some("EPSG:6677".into()),
        objects: objects.collect(),
        ..Scene::default()
    }
}

fn shuffle<T>(items: &mut [T], rng: &mut Pcg64Mcg) {
    for i in (1..items.len()).rev() {
        items.swap(i, rng.random_range(0..=i));
    }
}

/// Names, offsets and lengths as the section table states them.
fn sections(bytes: &[u8]) -> Vec<(String, usize, usize)> {
    let number = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
    let count = u32::from_le_bytes(bytes[116..120].try_into().unwrap()) as usize;
    let entries = (0..count).map(|i| 128 + 32 * i);
    entries
        .map(|at| {
            let tag = String::from_utf8(bytes[at..at + 8].to_vec()).unwrap();
            (tag.trim_end().to_owned(), number(at + 8), number(at + 16))
        })
        .collect()
}

#[test]
fn same_objects_in_any_order_give_the_same_bytes() {
    let mut rng = support::rng(1);
    let mut objects: Vec<SceneObject> = (0..400)
        .map(|i| {
            // Ids and boxes come several times, together and apart; heights tie.
            let id = format!("{}", i % 130);
            let min = DVec3::new(f64::from(i % 11) * 10.0, f64::from(i % 7) * 10.0, 0.0);
            let mut object = object(id, min, DVec3::new(4.0, 4.0, f64::from(i % 5)));
            object.triangles = (i % 3) as u32;
            object.class = ["Building", "Road"][i as usize % 2].into();
            object.attributes = (i % 4 == 0).then(|| attributes("{\"a\":1}"));
            object
        })
        .collect();
    for promotion in [Promotion::Tallest, Promotion::Footprint, Promotion::Largest] {
        let mut first = None;
        for _ in 0..8 {
            shuffle(&mut objects, &mut rng);
            let mut scene = Scene {
                objects: objects.clone(),
                ..Scene::default()
            };
            assert_eq!(scene.canonicalize().len(), 400 - 130);
            let bytes = saved(&scene, promotion);
            shuffle(&mut scene.objects, &mut rng); // a build takes any order
            assert!(saved(&scene, promotion) == bytes);
            assert!(first.get_or_insert_with(|| bytes.clone()) == &bytes);
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let scene = generate(&CityParams {
        objects: 40_000,
        seed: 3,
    });
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| saved(&scene, Promotion::Tallest))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(5));
}

#[test]
fn any_changed_byte_is_refused_by_name() {
    let whole = saved(&small(), Promotion::Tallest);
    let names: Vec<String> = sections(&whole).into_iter().map(|s| s.0).collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.citylod");
    let mut named = BTreeSet::new();
    for at in 0..whole.len() {
        for mask in [0x01, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] ^= mask;
            std::fs::write(&path, &bytes).unwrap();
            let text = LodTree::open_verified(&path).unwrap_err().to_string();
            assert!(text.contains("damaged.citylod"), "{text}");
            let place = names
                .iter()
                .find(|name| text.contains(&format!("section `{name}`")));
            assert!(
                place.is_some() || text.contains("header"),
                "byte {at}: {text}"
            );
            named.extend(place);
        }
    }
    assert_eq!(
        named.len(),
        names.len(),
        "every section is named: {named:?}"
    );
    std::fs::write(&path, &whole).unwrap();
    assert_eq!(LodTree::open_verified(&path).unwrap().validate(), []);
}

#[test]
fn any_other_length_is_refused() {
    let whole = saved(&small(), Promotion::Tallest);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.citylod");
    let refused = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        for opened in [LodTree::open(&path), LodTree::open_verified(&path)] {
            let text = opened.unwrap_err().to_string();
            assert!(
                text.contains("header") || text.contains("section"),
                "{text}"
            );
        }
    };
    for length in 0..whole.len() {
        refused(&whole[..length]);
    }
    for more in [1, 7, 64, 4096] {
        refused(&[&whole[..], &vec![0; more]].concat());
    }
    refused(b"v 0 0 0\nv 1 0 0\nf 1 2 1\n");
    refused(&vec![0; whole.len()]);
}

/// Asks everything a reader can ask; what is damaged may be answered wrongly, no more.
fn read_all(tree: &LodTree, views: &[View], lods: &[RangeLod], selection: &mut Selection) {
    for view in views {
        for lod in lods {
            retrieve(tree, view, lod, selection);
            assert!(selection.stats().nodes_visited <= tree.node_count());
            assert!(
                selection
                    .ranges()
                    .iter()
                    .all(|r| r.end <= tree.object_count())
            );
            for range in selection.ranges() {
                std::hint::black_box(tree.ids_json(range.clone()).len());
            }
            std::hint::black_box((selection.count(), selection.error_px()));
        }
        for lod in [
            Lod::Error(ErrorLod::new(40.0).unwrap()),
            Lod::Budget(BudgetLod::new(3)),
            Lod::Budget(BudgetLod::new(150)),
        ] {
            select(tree, view, &lod, selection);
            let ranges = selection.ranges();
            assert!(ranges.iter().all(|r| r.end <= tree.object_count()));
        }
    }
    for number in (0..tree.object_count()).chain([tree.object_count(), u32::MAX]) {
        let id = tree.id(number);
        std::hint::black_box(id.and_then(|id| tree.find(&id)));
        std::hint::black_box(tree.object(number).map(|o| o.attributes.map(str::len)));
        std::hint::black_box((tree.bounds_of(number), tree.level_of(number)));
        std::hint::black_box(tree.class_number(number));
    }
    std::hint::black_box((tree.classes().len(), tree.crs(), tree.promotion()));
    assert_eq!(tree.find("no such id"), None);
    std::hint::black_box(tree.validate().len());
}

fn views_and_lods() -> (Vec<View>, Vec<RangeLod>) {
    let view = |eye: DVec3, target: DVec3, projection| {
        let depth = DepthRange::default();
        let up = DVec3::Z;
        View::new(
            eye,
            Orientation::LookAt { target, up },
            projection,
            depth,
            [640, 480],
        )
        .unwrap()
    };
    let wide = Projection::Perspective { fov_y_deg: 90.0 };
    let views = vec![
        view(DVec3::new(-90.0, 60.0, 40.0), DVec3::ZERO, wide),
        view(
            DVec3::new(20.0, -20.0, 2.0),
            DVec3::new(90.0, 5.0, 0.0),
            wide,
        ),
        view(
            DVec3::new(-9.0, 1e4, 1e4),
            DVec3::ZERO,
            Projection::Orthographic { height_m: 80.0 },
        ),
    ];
    let lod = |far_dist, levels, beyond| RangeLod::new(far_dist, 2.5, levels, beyond).unwrap();
    let lods = vec![
        RangeLod::full_detail(),
        lod(20.0, 1, Beyond::Show),
        lod(30.0, 4, Beyond::Hide),
        lod(0.0, 2, Beyond::Show),
    ];
    (views, lods)
}

#[test]
fn an_unverified_file_with_any_byte_changed_can_be_read() {
    let whole = saved(&small(), Promotion::Tallest);
    let (views, lods) = views_and_lods();
    let mut selection = Selection::default();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.citylod");
    let mut opened = 0;
    for at in 0..whole.len() {
        for mask in [0x01, 0x10, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] ^= mask;
            std::fs::write(&path, &bytes).unwrap();
            if let Ok(tree) = LodTree::open(&path) {
                read_all(&tree, &views, &lods, &mut selection);
                opened += 1;
            }
        }
    }
    assert!(opened > whole.len(), "{opened}: contents are not looked at");
}

#[test]
fn garbage_in_an_unverified_file_can_be_read() {
    let mut scene = support::scene(&mut support::rng(2));
    while scene.objects.len() < 200 {
        let i = scene.objects.len();
        let min = DVec3::new((i % 20) as f64 * 9.0, (i / 20) as f64 * 9.0, 0.0);
        scene
            .objects
            .push(object(format!("more {i}"), min, DVec3::splat(6.0)));
    }
    let whole = saved(&scene, Promotion::Largest);
    let sections = sections(&whole);
    let count = |at: usize| u32::from_le_bytes(whole[at..at + 4].try_into().unwrap());
    let (objects, nodes) = (count(24), count(28));
    let (views, lods) = views_and_lods();
    let mut selection = Selection::default();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("garbage.citylod");
    let mut opened = 0;
    for seed in 0..4_000 {
        let mut rng = support::rng(seed);
        let mut bytes = whole.clone();
        for _ in 0..rng.random_range(1..4) {
            let (_, start, length) = &sections[rng.random_range(1..sections.len())];
            let words = length / 4;
            let all = rng.random_bool(0.3);
            for word in 0..words {
                if !all && rng.random_range(0..words) > 3 {
                    continue;
                }
                let value = match rng.random_range(0..7) {
                    0 => 0,
                    1 => u32::MAX,
                    2 => rng.random(),
                    3 => objects + rng.random_range(0..3) - 1,
                    4 => nodes + rng.random_range(0..3) - 1,
                    5 => f32::NAN.to_bits(),
                    _ => rng.random_range(0..objects),
                };
                let at = start + 4 * word;
                bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
            }
        }
        for _ in 0..rng.random_range(0..9) {
            let at = rng.random_range(832..bytes.len());
            bytes[at] = rng.random();
        }
        std::fs::write(&path, &bytes).unwrap();
        if let Ok(tree) = LodTree::open(&path) {
            read_all(&tree, &views, &lods, &mut selection);
            opened += 1;
        }
    }
    assert!(opened > 2_000, "{opened}: contents are not looked at");
}

fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn saving_replaces_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("city.citylod");
    let build = |scene: &Scene| index::build(scene, Promotion::Tallest).unwrap();
    let (old, new) = (build(&small()), build(&Scene::default()));
    old.save(&path).unwrap();
    let mapped = LodTree::open(&path).unwrap();
    new.save(&path).unwrap();
    assert_eq!(mapped.validate(), [], "the old file stays mapped");
    assert_eq!(mapped.find("千代田"), old.find("千代田"));
    assert_eq!(mapped.revision(), old.revision());
    assert_eq!(LodTree::open(&path).unwrap().revision(), new.revision());
    assert_eq!(files(folder.path()), ["city.citylod"]);

    let missing = folder.path().join("no/such/city.citylod");
    let text = old.save(&missing).unwrap_err().to_string();
    assert!(text.contains("city.citylod: cannot write"), "{text}");

    let taken = folder.path().join("taken.citylod");
    std::fs::create_dir(&taken).unwrap();
    std::fs::write(taken.join("inside"), "kept").unwrap();
    old.save(&taken).unwrap_err();
    assert_eq!(files(&taken), ["inside"]);
    assert_eq!(files(folder.path()), ["city.citylod", "taken.citylod"]);

    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let bytes = std::fs::read(&path).unwrap();
        let mode = |mode| {
            let permissions = std::fs::Permissions::from_mode(mode);
            std::fs::set_permissions(folder.path(), permissions).unwrap();
        };
        mode(0o555);
        // Whoever may write everywhere is not held back by a folder's mode.
        let held_back = std::fs::write(folder.path().join("try"), "").is_err();
        let result = old.save(&path);
        mode(0o755);
        assert_eq!(result.is_err(), held_back);
        if held_back {
            assert!(std::fs::read(&path).unwrap() == bytes);
            assert_eq!(files(folder.path()), ["city.citylod", "taken.citylod"]);
        }
    }
}
