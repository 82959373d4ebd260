use std::collections::BTreeSet;

use citylod::geom::{Aabb, DVec3, DepthRange, Orientation, Projection, View};
use citylod::index::{self, LodTree, Promotion};
use citylod::lod::{Beyond, RangeLod, Selection, retrieve};
use citylod::scene::{CityParams, Scene, generate};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::support::{self, between};

/// Coordinates and offsets in these units add without rounding up to 2⁴³ m.
const UNIT: f64 = 1.0 / 1024.0;

/// A national grid, with heights above the ellipsoid, and the surface of the earth from its
/// middle.
const OFFSETS: [DVec3; 3] = [
    DVec3::new(460_123.25, 5_412_345.5, 48.125),
    DVec3::new(-155_463.75, 463_554.0, -12.5),
    DVec3::new(4_014_743.25, 411_334.968_75, 4_922_395.0),
];

fn whole(v: DVec3) -> DVec3 {
    (v / UNIT).round() * UNIT
}

/// A city whose corners pass through `place`.
fn city(place: impl Fn(DVec3, DVec3) -> (DVec3, DVec3)) -> LodTree {
    let city = generate(&CityParams {
        objects: 4_000,
        seed: 6,
    });
    let mut objects = city.objects;
    for object in &mut objects {
        let (min, max) = place(object.bounds.min(), object.bounds.max());
        object.bounds = Aabb::new(min, max).unwrap();
    }
    let scene = Scene {
        objects,
        ..Scene::default()
    };
    index::build(&scene, Promotion::Tallest).unwrap()
}

/// A pose that is the same bits relative to any of the offsets.
fn pose(rng: &mut Pcg64Mcg, bounds: &Aabb) -> impl Fn(DVec3) -> View + use<> {
    let reach = bounds.size().x.max(bounds.size().y);
    let point = |rng: &mut Pcg64Mcg, spread: f64| {
        let off = support::point(rng, -1.0, 1.0) * reach * spread;
        whole((bounds.center() + off).with_z(between(rng, 1.0, 120.0)))
    };
    let (eye, target) = (point(rng, 0.5), point(rng, 0.4));
    let projection = match rng.random_range(0..4) {
        0 => Projection::Orthographic {
            height_m: between(rng, 0.1, 1.0) * reach,
        },
        1 => Projection::Perspective { fov_y_deg: 20.0 },
        _ => Projection::Perspective { fov_y_deg: 60.0 },
    };
    let far = rng.random_bool(0.3).then_some(reach * 0.4);
    move |offset| {
        let orientation = Orientation::LookAt {
            target: target + offset,
            up: DVec3::Z,
        };
        let depth = DepthRange { near: 0.5, far };
        View::new(eye + offset, orientation, projection, depth, [1920, 1080]).unwrap()
    }
}

fn settings(rng: &mut Pcg64Mcg) -> [RangeLod; 3] {
    let far = between(rng, 50.0, 900.0);
    [
        RangeLod::full_detail(),
        RangeLod::new(far, 2.5, 4, Beyond::Show).unwrap(),
        RangeLod::new(far, 2.0, 3, Beyond::Hide).unwrap(),
    ]
}

fn found(tree: &LodTree, view: &View, lod: &RangeLod) -> BTreeSet<String> {
    let mut selection = Selection::default();
    retrieve(tree, view, lod, &mut selection);
    let ids = selection.objects();
    ids.map(|o| tree.id(o).unwrap().into_owned()).collect()
}

/// Where no coordinate is rounded by moving the city, nothing changes (N6).
#[test]
fn a_city_moved_exactly_gives_the_same_ids() {
    let at_origin = city(|min, max| (whole(min), whole(max)));
    let moved = OFFSETS.map(|o| city(|min, max| (whole(min) + o, whole(max) + o)));
    let mut rng = support::rng(66);
    let (mut drawn, mut answers) = (0, 0);
    for _ in 0..400 {
        let pose = pose(&mut rng, &at_origin.bounds());
        for lod in settings(&mut rng) {
            let expected = found(&at_origin, &pose(DVec3::ZERO), &lod);
            for (tree, offset) in moved.iter().zip(OFFSETS) {
                assert_eq!(
                    found(tree, &pose(offset), &lod),
                    expected,
                    "at {offset}, {lod:?}"
                );
            }
            drawn += expected.len();
            answers += usize::from(!expected.is_empty());
        }
    }
    assert!(
        drawn > 100_000 && answers > 800,
        "{drawn} drawn in {answers} answers"
    );
}

/// Where corners are rounded by moving the city, outward, the boxes are larger by less than an
/// ulp of the offset, 1e-9 m. At full detail that only adds objects: those that lay beyond a
/// plane by less than that.
#[test]
fn a_city_moved_and_rounded_outward_loses_nothing() {
    const ULP_M: f64 = 1e-9;
    /// Less than an ulp of each offset, more than the slack of culling here. Corners this close
    /// to a border come up in a city only when put there.
    const GAP_M: f64 = 2.5e-11;
    let place = |offset: DVec3| {
        move |min: DVec3, max: DVec3| {
            let axes = |from: DVec3, direction: f64| {
                DVec3::from_array([0, 1, 2].map(|k| outward(from[k], offset[k], direction)))
            };
            (axes(min, -1.0), axes(max, 1.0))
        }
    };
    let view = |offset: DVec3| {
        let eye = whole(DVec3::new(0.0, 0.0, 50.0)) + offset;
        let orientation = Orientation::LookAt {
            target: eye + DVec3::X * 8.0,
            up: DVec3::Z,
        };
        let depth = DepthRange {
            near: 0.5,
            far: Some(300.0),
        };
        let projection = Projection::Orthographic { height_m: 512.0 };
        View::new(eye, orientation, projection, depth, [512, 512]).unwrap()
    };
    // Half of the objects lie just beyond a border: y = 256, y = -256 or x = 300.
    let generated = |offset: DVec3| {
        let n = std::cell::Cell::new(0);
        city(move |min, max| {
            n.set(n.get() + 1);
            let (mut min, mut max) = (
                min + DVec3::splat(1e-3 / 3.0),
                max + DVec3::splat(1e-3 / 3.0),
            );
            let size = max - min;
            match n.get() % 6 {
                0 => (min.y, max.y) = (256.0 + GAP_M, 256.0 + size.y),
                1 => (min.y, max.y) = (-256.0 - size.y, -256.0 - GAP_M),
                2 => (min.x, max.x) = (300.0 + GAP_M, 300.0 + size.x),
                _ => {}
            }
            place(offset)(min, max)
        })
    };
    let full = RangeLod::full_detail();
    let expected = found(&generated(DVec3::ZERO), &view(DVec3::ZERO), &full);
    assert!(expected.len() > 50, "{}", expected.len());
    for offset in OFFSETS {
        let tree = generated(offset);
        let found = found(&tree, &view(offset), &full);
        assert!(expected.is_subset(&found), "{:?} lost", &expected - &found);
        let added = &found - &expected;
        for id in &added {
            let b = tree.bounds_of(tree.find(id).unwrap()).unwrap();
            let (min, max) = (b.min() - offset, b.max() - offset);
            // Beyond by the gap before it was rounded, not beyond now.
            let at_border = [256.0 - min.y, max.y + 256.0, 300.0 - min.x];
            assert!(
                at_border.iter().any(|d| (-ULP_M..=ULP_M).contains(d)),
                "{id} added for another reason: {b:?}"
            );
        }
        println!("{offset}: {} of {} ids added", added.len(), found.len());
        assert!(!added.is_empty(), "the test is about something");
    }
}

/// The f64 nearest to `x + offset` that is not inside of it.
fn outward(x: f64, offset: f64, direction: f64) -> f64 {
    let sum = x + offset;
    // What was lost, exactly (Knuth, two-sum).
    let back = sum - x;
    let lost = (x - (sum - back)) + (offset - back);
    if lost * direction <= 0.0 {
        sum
    } else if direction > 0.0 {
        sum.next_up()
    } else {
        sum.next_down()
    }
}
