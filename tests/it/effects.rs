use std::time::Duration;

use citylod::frame::{Active, Culling, Frame};
use citylod::geom::{DVec3, DepthRange, Orientation, Projection, SeparatingAxes, View};
use citylod::index::{self, LodTree, Promotion};
use citylod::lod::{BudgetLod, ErrorLod, Lod, RangeLod, Selection, select};
use citylod::scene::{
    CityParams, Effects, Haze, Motion, Occlusion, Scene, SceneObject, Terrain, generate,
};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::retrieval::{self, Made};
use crate::support::{self, Camera, look, object};
use crate::written;

fn frame(tree: &LodTree, view: &View, lod: &Lod, active: &Active) -> Frame {
    let mut frame = Frame::default();
    frame.work_out(tree, view, lod, active, || Duration::ZERO);
    frame
}

fn drawn(frame: &Frame) -> Vec<u32> {
    frame.selection().objects().collect()
}

fn selected(tree: &LodTree, view: &View, lod: &Lod) -> Vec<u32> {
    let mut selection = Selection::default();
    select(tree, view, lod, &mut selection);
    selection.objects().collect()
}

fn built(objects: Vec<SceneObject>) -> LodTree {
    let scene = Scene {
        objects,
        ..Scene::default()
    };
    index::build(&scene, Promotion::Largest).unwrap()
}

fn number(tree: &LodTree, id: &str) -> u32 {
    tree.find(id).unwrap()
}

#[test]
fn declarations_are_read_or_refused_with_the_place() {
    let all = r#"{"motion":{},"haze":{"visibility_m":900},"occlusion":{},"terrain":{}}"#;
    let effects = Effects::from_json(all).unwrap();
    assert_eq!(effects.haze.map(|h| h.visibility_m), Some(900.0));
    assert_eq!(effects.motion.map(|m| m.reference_speed_mps), Some(1.5));
    let occlusion = effects.occlusion.unwrap();
    assert_eq!((occlusion.width_px, occlusion.min_pixels), (512, 1));
    assert_eq!(effects.terrain, Some(Terrain::default()));
    assert!(Effects::from_json("{}").unwrap().is_empty());
    for (text, place) in [
        ("", "line 1 column 0"),
        ("[]", "line 1"),
        (r#"{"fog":{}}"#, "`fog`"),
        (r#"{"haze":{}}"#, "visibility_m"),
        (r#"{"haze":{"visibility_m":0}}"#, "/haze/visibility_m"),
        (r#"{"haze":{"visibility_m":-1}}"#, "/haze/visibility_m"),
        (r#"{"haze":{"visibility_m":1e999}}"#, "line 1"),
        (
            r#"{"motion":{"reference_speed_mps":0}}"#,
            "/motion/reference_speed_mps",
        ),
        (r#"{"occlusion":{"width_px":8}}"#, "/occlusion/width_px"),
        (r#"{"occlusion":{"width_px":9999}}"#, "/occlusion/width_px"),
        (r#"{"occlusion":{"min_pixels":0}}"#, "/occlusion/min_pixels"),
        (r#"{"terrain":{"criterion":"tallest"}}"#, "`tallest`"),
        (r#"{"terrain":{"max_error_px":0}}"#, "/terrain/max_error_px"),
        (
            r#"{"terrain":{"max_triangles":0}}"#,
            "/terrain/max_triangles",
        ),
    ] {
        let error = Effects::from_json(text).unwrap_err().to_string();
        assert!(error.contains(place), "{text}: {error}");
    }
}

#[test]
fn a_file_keeps_what_its_scene_declares() {
    let mut scene = generate(&CityParams {
        objects: 100,
        seed: 1,
    });
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("city.citylod");
    for text in ["{}", r#"{"haze":{"visibility_m":900},"occlusion":{}}"#] {
        scene.effects = Effects::from_json(text).unwrap();
        let tree = index::build(&scene, Promotion::default()).unwrap();
        tree.save(&path).unwrap();
        let opened = LodTree::open_verified(&path).unwrap();
        assert_eq!(opened.effects(), &scene.effects);
        let edited = index::CityTree::bulk_load(scene.clone(), Promotion::default()).unwrap();
        assert_eq!(edited.pack().unwrap().effects(), &scene.effects);
    }
}

#[test]
fn what_is_not_active_changes_nothing_and_says_so() {
    let tree = index::build(
        &generate(&CityParams {
            objects: 2_000,
            seed: 3,
        }),
        Promotion::default(),
    )
    .unwrap();
    let view = look(DVec3::new(0.0, -600.0, 150.0), DVec3::ZERO);
    for lod in [
        Lod::default(),
        Lod::Error(ErrorLod::new(20.0).unwrap()),
        Lod::Budget(BudgetLod::new(300)),
    ] {
        let frame = frame(&tree, &view, &lod, &Active::default());
        assert_eq!(drawn(&frame), selected(&tree, &view, &lod));
        assert_eq!(frame.effects(), &citylod::frame::Effects::default());
        assert_eq!(frame.lod(), &lod);
    }
}

#[test]
fn detail_falls_with_speed_beyond_the_reference() {
    let motion = Motion {
        reference_speed_mps: 2.0,
    };
    let at = |speed| Active {
        motion: Some((motion, speed)),
        ..Active::default()
    };
    let tree = built(vec![object("a", DVec3::ZERO, DVec3::ONE)]);
    let view = look(DVec3::new(0.0, -9.0, 1.0), DVec3::ZERO);
    let knobs = |lod: Lod, speed| *frame(&tree, &view, &lod, &at(speed)).lod();
    let far_dist = |speed| match knobs(Lod::default(), speed) {
        Lod::Range(lod) => lod.far_dist(),
        other => panic!("{other:?}"),
    };
    assert_eq!(
        [0.0, 2.0, 4.0, 20.0].map(far_dist),
        [500.0, 500.0, 250.0, 50.0]
    );
    let error = Lod::Error(ErrorLod::new(3.0).unwrap());
    assert_eq!(knobs(error, 4.0), Lod::Error(ErrorLod::new(6.0).unwrap()));
    let budget = Lod::Budget(BudgetLod::new(1_001));
    assert_eq!(knobs(budget, 4.0), Lod::Budget(BudgetLod::new(251)));
    assert_eq!(knobs(budget, f64::MAX), Lod::Budget(BudgetLod::new(1)));
    assert_eq!(knobs(error, 1.0), error);
}

#[test]
fn haze_leaves_exactly_what_lies_within_the_visibility_range() {
    let mut rng = support::rng(11);
    let mut removed = 0;
    for round in 0..1_500 {
        let scene = support::scene(&mut rng);
        let made = [Made::Bulk, Made::Inserted][round % 2];
        let tree = retrieval::tree(&scene, made, Promotion::Largest, &mut rng);
        if tree.object_count() == 0 {
            continue;
        }
        let view = Camera::random(&mut rng, &tree.bounds()).view();
        let any = rng.random_range(0..tree.object_count());
        let near = tree.bounds_of(any).unwrap().distance(view.eye());
        // Mostly the very distance of an object, which is still seen.
        let visibility_m = match rng.random_range(0..4) {
            0 => near * 1.5 + 1.0,
            _ => near.max(f64::MIN_POSITIVE),
        };
        let active = Active {
            haze: Some(Haze { visibility_m }),
            ..Active::default()
        };
        let within = |o: &u32| tree.bounds_of(*o).unwrap().distance(view.eye()) <= visibility_m;
        for lod in [
            Lod::Range(RangeLod::full_detail()),
            Lod::Range(retrieval::lod(&mut rng, near.max(1.0))),
            Lod::Error(ErrorLod::new(size(&mut rng)).unwrap()),
        ] {
            let frame = frame(&tree, &view, &lod, &active);
            let all = selected(&tree, &view, &lod);
            let wanted: Vec<u32> = all.iter().copied().filter(within).collect();
            assert_eq!(drawn(&frame), wanted, "{lod:?} {visibility_m}");
            removed += all.len() - wanted.len();
        }
        budget_is_spent_on_what_stays(&tree, &view, &active, within, &mut rng);
    }
    assert!(removed > 10_000, "haze had something to do: {removed}");
}

fn size(rng: &mut Pcg64Mcg) -> f64 {
    support::between(rng, 0.0, 40.0)
}

fn budget_is_spent_on_what_stays(
    tree: &LodTree,
    view: &View,
    active: &Active,
    within: impl Fn(&u32) -> bool,
    rng: &mut Pcg64Mcg,
) {
    let mut seen = selected(tree, view, &Lod::Range(RangeLod::full_detail()));
    seen.retain(within);
    let largest = |o: &u32| view.size_px(&tree.bounds_of(*o).unwrap());
    seen.sort_by(|a, b| largest(b).total_cmp(&largest(a)).then(a.cmp(b)));
    let budget = rng.random_range(0..=seen.len() as u32 + 1);
    seen.truncate(budget as usize);
    seen.sort_unstable();
    let lod = Lod::Budget(BudgetLod::new(budget));
    assert_eq!(drawn(&frame(tree, view, &lod, active)), seen);
}

/// As many asks as doublings, whatever haze takes out of what they give: here all but the last.
#[test]
fn a_budget_under_haze_asks_a_few_times() {
    const HIDDEN: u32 = 4_000;
    let mut objects: Vec<SceneObject> = (0..HIDDEN)
        .map(|n| {
            let corner = DVec3::new(50.0, 300.0 + f64::from(n) * 0.01, 0.0);
            object(format!("far-{n}"), corner, DVec3::splat(20.0))
        })
        .collect();
    objects.push(object(
        "near",
        DVec3::new(60.0, 0.0, 0.0),
        DVec3::splat(0.1),
    ));
    let tree = built(objects);
    let view = View::new(
        DVec3::ZERO,
        Orientation::LookAt {
            target: DVec3::X,
            up: DVec3::Z,
        },
        Projection::Perspective { fov_y_deg: 170.0 },
        DepthRange::default(),
        [1920, 1080],
    )
    .unwrap();
    let active = Active {
        haze: Some(Haze {
            visibility_m: 100.0,
        }),
        ..Active::default()
    };
    let everything = selected(&tree, &view, &Lod::Range(RangeLod::full_detail()));
    assert_eq!(
        everything.len(),
        HIDDEN as usize + 1,
        "all of it is in view"
    );
    let mut asked = 0;
    let mut frame = Frame::default();
    let lod = Lod::Budget(BudgetLod::new(1));
    frame.work_out(&tree, &view, &lod, &active, || {
        asked += 1;
        Duration::ZERO
    });
    assert_eq!(drawn(&frame), [number(&tree, "near")]);
    assert!(asked < 40, "the clock was looked at {asked} times");
}

#[test]
fn occlusion_that_takes_too_long_is_given_up() {
    let scene = generate(&CityParams {
        objects: 3_000,
        seed: 1,
    });
    let tree = index::build(&scene, Promotion::Largest).unwrap();
    let view = look(DVec3::new(0.0, -800.0, 60.0), DVec3::ZERO);
    let lod = Lod::Range(RangeLod::full_detail());
    let within = |patience| {
        let active = Active {
            patience,
            ..occluding(OCCLUSION)
        };
        let mut now = Duration::ZERO;
        let mut frame = Frame::default();
        frame.work_out(&tree, &view, &lod, &active, || {
            now += Duration::from_millis(1);
            now
        });
        frame
    };
    let whole = within(None);
    assert!(!whole.gave_up() && whole.effects().occlusion.unwrap().result > 0);
    let patient = within(Some(Duration::from_secs(1)));
    assert_eq!(drawn(&patient), drawn(&whole));
    let hasty = within(Some(Duration::from_millis(5)));
    assert!(hasty.gave_up());
    assert_eq!(hasty.effects().occlusion, None);
    assert!(hasty.visible_pixels().is_empty());
    assert_eq!(drawn(&hasty), selected(&tree, &view, &lod));
}

const OCCLUSION: Occlusion = Occlusion {
    width_px: 256,
    min_pixels: 1,
};

fn occluding(occlusion: Occlusion) -> Active {
    Active {
        occlusion: Some(occlusion),
        ..Active::default()
    }
}

#[test]
fn a_wall_hides_what_is_behind_it_and_nothing_else() {
    let tree = built(vec![
        object(
            "wall",
            DVec3::new(-10.0, 20.0, 0.0),
            DVec3::new(20.0, 1.0, 10.0),
        ),
        object(
            "hidden",
            DVec3::new(-5.0, 30.0, 0.0),
            DVec3::new(10.0, 10.0, 8.0),
        ),
        object(
            "tower",
            DVec3::new(-5.0, 60.0, 0.0),
            DVec3::new(10.0, 10.0, 200.0),
        ),
        object(
            "beside",
            DVec3::new(20.0, 30.0, 0.0),
            DVec3::new(10.0, 10.0, 8.0),
        ),
        object("behind the eye", DVec3::new(0.0, -50.0, 0.0), DVec3::ONE),
    ]);
    let view = look(DVec3::new(0.0, 0.0, 1.7), DVec3::new(0.0, 10.0, 1.7));
    let lod = Lod::Range(RangeLod::full_detail());
    let frame = frame(&tree, &view, &lod, &occluding(OCCLUSION));
    let mut wanted = ["wall", "tower", "beside"].map(|id| number(&tree, id));
    wanted.sort_unstable();
    assert_eq!(drawn(&frame), wanted);
    assert_eq!(frame.effects().occlusion.unwrap().result, 1);
    assert_eq!(frame.buffer_size(), [256, 144]);
    let counted: Vec<u32> = frame.visible_pixels().iter().map(|seen| seen.0).collect();
    assert_eq!(counted, wanted);
    // The wall is 20 m by 10 m at 20 m, the picture there 41.06 m by 23.09 m.
    let pixels = |id| {
        let seen = frame.visible_pixels();
        f64::from(seen.iter().find(|s| s.0 == number(&tree, id)).unwrap().1)
    };
    let expected = 256.0 * 20.0 / 41.06 * 144.0 * 10.0 / 23.09;
    assert!((pixels("wall") / expected - 1.0).abs() < 0.02);
    // What covers too little goes.
    let least = pixels("tower") as u32 + 1;
    let strict = Occlusion {
        min_pixels: least,
        ..OCCLUSION
    };
    let fewer = drawn(&self::frame(&tree, &view, &lod, &occluding(strict)));
    assert!(!fewer.contains(&number(&tree, "tower")));
}

#[test]
fn what_is_around_the_eye_hides_nothing_and_stays() {
    let tree = built(vec![
        object("room", DVec3::splat(-5.0), DVec3::splat(10.0)),
        object("outside", DVec3::new(-5.0, 30.0, -5.0), DVec3::splat(10.0)),
    ]);
    let view = look(DVec3::ZERO, DVec3::Y);
    let frame = frame(
        &tree,
        &view,
        &Lod::Range(RangeLod::full_detail()),
        &occluding(OCCLUSION),
    );
    assert_eq!(frame.selection().count(), 2);
    assert_eq!(frame.effects().occlusion.unwrap().result, 0);
}

/// Objects that only one of a buffer and one four times finer shows cover fewer pixels of the
/// finer one than this.
const MISSED_BELOW_PX: u32 = 400;

#[test]
fn a_finer_buffer_shows_the_same_but_for_slivers() {
    let scene = generate(&CityParams {
        objects: 23_951,
        seed: 1,
    });
    compare_resolutions(&scene, 0.0);
}

#[test]
fn a_finer_buffer_shows_the_same_of_a_real_city() {
    let Some(path) = written::real("geojson/tokyo-chiyoda-11581.geojson.gz") else {
        return;
    };
    let imported = written::import_one(&path, &citylod::import::Options::default()).unwrap();
    compare_resolutions(&imported.scene, 0.0);
}

fn compare_resolutions(scene: &Scene, ground: f64) {
    let tree = index::build(scene, Promotion::Largest).unwrap();
    let middle = tree.bounds().center().with_z(ground + 1.7);
    let mut places = 0;
    for step in 0..200 {
        let turn = f64::from(step) * 2.4;
        let eye = middle + DVec3::new(turn.cos(), turn.sin(), 0.0) * f64::from(step) * 4.0;
        let free = |o| tree.bounds_of(o).unwrap().distance(eye) > 2.0;
        if !(0..tree.object_count()).all(free) {
            continue;
        }
        places += 1;
        let view = look(eye, eye + DVec3::new(turn.sin(), turn.cos(), 0.0));
        let lod = Lod::Range(RangeLod::full_detail());
        let at = |width_px| {
            let occlusion = Occlusion {
                width_px,
                ..OCCLUSION
            };
            frame(&tree, &view, &lod, &occluding(occlusion))
        };
        let (coarse, fine) = (at(480), at(1920));
        let (seen, finer) = (drawn(&coarse), fine.visible_pixels());
        for (object, pixels) in finer {
            let missed = seen.binary_search(object).is_err();
            assert!(!missed || *pixels < MISSED_BELOW_PX, "{object}: {pixels}");
        }
        let is_sliver = |o: &&u32| finer.binary_search_by_key(*o, |s| s.0).is_err();
        let slivers = seen.iter().filter(is_sliver).count();
        assert!(
            slivers * 20 <= seen.len().max(20),
            "{slivers} of {}",
            seen.len()
        );
        if places == 6 {
            return;
        }
    }
    panic!("no six streets to stand in");
}

#[test]
fn exact_culling_keeps_what_meets_the_view_and_no_more() {
    let mut rng = support::rng(12);
    let mut dropped = 0;
    for _ in 0..1_500 {
        let scene = support::scene(&mut rng);
        let tree = retrieval::tree(&scene, Made::Bulk, Promotion::Largest, &mut rng);
        let view = Camera::random(&mut rng, &tree.bounds()).view();
        let axes = SeparatingAxes::new(view.frustum());
        let exact = Active {
            culling: Culling::Exact,
            ..Active::default()
        };
        let meets = |o: &u32| !axes.separate(&tree.bounds_of(*o).unwrap());
        let everything = Lod::Range(RangeLod::full_detail());
        for lod in [
            everything,
            Lod::Error(ErrorLod::new(size(&mut rng)).unwrap()),
        ] {
            let mut wanted = selected(&tree, &view, &lod);
            dropped += wanted.len();
            wanted.retain(meets);
            dropped -= wanted.len();
            assert_eq!(drawn(&frame(&tree, &view, &lod, &exact)), wanted);
        }
        budget_is_spent_on_what_stays(&tree, &view, &exact, meets, &mut rng);
    }
    assert!(
        dropped > 100,
        "planes keep some that do not meet the view: {dropped}"
    );
}
