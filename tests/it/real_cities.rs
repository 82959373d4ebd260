use std::collections::BTreeSet;
use std::path::PathBuf;

use citylod::geom::{DQuat, DVec3};
use citylod::import::{Options, import};
use citylod::index::{self, LodTree, Promotion};
use citylod::lod::{Beyond, RangeLod, Selection, retrieve};

use crate::oracle::Gong;
use crate::support::{Camera, Form, Window};
use crate::written::real;

/// Far beyond what f64 rounding can do to a plane test, far below what a city shows.
const MARGIN: f64 = 1e-12;

/// Imports files as one city, expects so many objects, and builds a sound tree of them.
fn city(files: &[&str], objects: u32) -> Option<LodTree> {
    let files: Option<Vec<PathBuf>> = files.iter().map(|f| real(f)).collect();
    let imported = import(&files?, &Options::default(), &|_, _| {}).unwrap();
    assert_eq!(imported.scene.objects.len(), objects as usize);
    let tree = index::build(&imported.scene, Promotion::Tallest).unwrap();
    assert_eq!(tree.object_count(), objects);
    assert_eq!(tree.validate(), []);
    for object in &imported.scene.objects {
        let found = tree.object(tree.find(&object.id).unwrap()).unwrap();
        assert_eq!(found.bounds, object.bounds, "{}", object.id);
    }
    Some(tree)
}

#[test]
fn cityjson_cities_become_sound_trees() {
    for (name, objects) in [
        ("delft.json", 570),
        ("zurich_subset_lod2.json", 49), // buildings; their 161 parts are folded into them
        ("multi_lod.json", 10),
        ("vienna.city.jsonl", 149),
        ("railway.city.jsonl", 2),
        ("geomtemplate.city.jsonl", 1),
        ("rotterdam_subset.json", 16),
        ("multisurface_with_material.json", 1),
        ("DH_01_subs.city.json", 4),
    ] {
        if city(&[&format!("cityjson/{name}")], objects).is_none() {
            return;
        }
    }
}

#[test]
fn chiyoda_is_as_large_in_every_format() {
    for name in [
        "geojson/tokyo-chiyoda-11581.geojson.gz",
        "obj/tokyo-chiyoda-11581.obj",
        "glb/tokyo-chiyoda-11581.glb",
    ] {
        if city(&[name], 11_581).is_none() {
            return;
        }
    }
}

#[test]
fn minato_footprints_become_a_sound_tree() {
    city(&["geojson/tokyo-minato-28106.geojson.gz"], 28_106);
}

#[test]
fn katsushika_footprints_become_a_sound_tree() {
    city(&["geojson/tokyo-katsushika-106807.geojson.gz"], 106_807);
}

#[test]
fn tiles_of_sibbe_make_one_city() {
    let tiles = ["1_1_0", "2_2_3", "2_3_2"].map(|t| format!("glb/3dbag-sibbe/content/{t}.glb"));
    let Some(tree) = city(&tiles.each_ref().map(String::as_str), 23 + 220 + 171) else {
        return;
    };
    assert!(tree.bounds().radius() < 5e3);
}

/// A camera with axes of its own, so that it may look straight down.
fn camera(eye: DVec3, forward: DVec3, up: DVec3) -> Camera {
    let forward = forward.normalize();
    let right = forward.cross(up).normalize();
    let up = right.cross(forward);
    let (fov_y_deg, viewport) = (60.0_f64, [1920, 1080]);
    let top = (fov_y_deg.to_radians() / 2.0).tan();
    let side = top * f64::from(viewport[0]) / f64::from(viewport[1]);
    let q = DQuat::from_mat3(&glam::DMat3::from_cols(right, up, -forward));
    Camera {
        eye,
        right,
        up,
        forward,
        window: Window::Tangents {
            left: -side,
            right: side,
            bottom: -top,
            top,
        },
        near: 0.1,
        far: None,
        viewport,
        form: Form::Quaternion { q, fov_y_deg },
    }
}

#[test]
fn views_of_minato_are_brute_force_and_the_seven_steps() {
    let Some(tree) = city(&["cityjson/tokyo-minato-23951.city.json.gz"], 23_951) else {
        return;
    };
    let height = |o: u32| tree.bounds_of(o).unwrap().size().z;
    let gong = Gong::of(&tree, height);
    let tallest = (0..tree.object_count())
        .max_by(|&a, &b| height(a).total_cmp(&height(b)))
        .unwrap();
    let tower = tree.bounds_of(tallest).unwrap();
    let street = (tower.center() + DVec3::new(400.0, 300.0, 0.0)).with_z(1.7);
    let oblique = tower.center() + DVec3::new(-900.0, -700.0, 600.0);
    let above = tower.center().with_z(2_500.0);
    let poses = [
        (
            "street",
            camera(street, DVec3::new(-4.0, -3.0, 0.0), DVec3::Z),
            2_000,
        ),
        (
            "oblique",
            camera(oblique, tower.center() - oblique, DVec3::Z),
            5_000,
        ),
        ("top-down", camera(above, DVec3::NEG_Z, DVec3::Y), 5_000),
    ];
    let mut selection = Selection::default();
    for (name, camera, at_least) in &poses {
        retrieve(
            &tree,
            &camera.view(),
            &RangeLod::full_detail(),
            &mut selection,
        );
        let found: BTreeSet<u32> = selection.objects().collect();
        let sees = |margin: f64| -> BTreeSet<u32> {
            (0..tree.object_count())
                .filter(|&o| !camera.sees_nothing_of(&tree.bounds_of(o).unwrap(), margin))
                .collect()
        };
        let least = sees(-MARGIN);
        assert_eq!(found, least, "{name} at full detail");
        assert_eq!(least, sees(MARGIN), "{name}: no box touches a plane");
        assert!(
            found.contains(&tallest) && found.len() >= *at_least,
            "{name}: {}",
            found.len()
        );
        for (far_dist, levels, beyond) in [
            (200.0, 4, Beyond::Show),
            (450.0, 3, Beyond::Show),
            (1_500.0, 6, Beyond::Show),
            (300.0, 2, Beyond::Hide),
        ] {
            let lod = RangeLod::new(far_dist, 3.0, levels, beyond).unwrap();
            retrieve(&tree, &camera.view(), &lod, &mut selection);
            let drawn: BTreeSet<u32> = selection.objects().collect();
            let expected = gong.retrieve(camera, &lod, -MARGIN);
            assert_eq!(drawn, expected, "{name}, {lod:?}");
            assert!(drawn.is_subset(&found), "{name}, {lod:?}");
            for omitted in &found - &drawn {
                let size = camera.size_px(&tree.bounds_of(omitted).unwrap());
                assert!(
                    size <= selection.error_px() * (1.0 + 1e-12),
                    "{name}: {omitted}"
                );
            }
        }
    }
}
