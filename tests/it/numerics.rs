use citylod::geom::{Aabb, DMat4, DVec3, DepthRange, Orientation, Projection, View, ViewError};
use citylod::index::{self, Promotion};
use citylod::lod::{RangeLod, Selection, retrieve};
use citylod::scene::{Scene, SceneObject};

use crate::support::object;

const DEPTH: DepthRange = DepthRange {
    near: 0.1,
    far: None,
};

fn found(objects: Vec<SceneObject>, view: &View) -> Vec<String> {
    let mut scene = Scene {
        objects,
        ..Scene::default()
    };
    scene.canonicalize();
    let tree = index::build(&scene, Promotion::Tallest).unwrap();
    let mut selection = Selection::default();
    retrieve(&tree, view, &RangeLod::full_detail(), &mut selection);
    let ids = selection
        .objects()
        .map(|o| tree.id(o).unwrap().into_owned());
    let mut ids: Vec<String> = ids.collect();
    ids.sort();
    ids
}

/// Where `up` is nearly along the line of sight the planes themselves are uncertain; f32 may not
/// cull what f64 would keep.
#[test]
fn f32_culls_nothing_that_f64_keeps() {
    let view = View::new(
        DVec3::new(0.0, 0.0, 1000.0),
        Orientation::LookAt {
            target: DVec3::new(0.0, 0.001, 0.0),
            up: DVec3::Z,
        },
        Projection::Orthographic { height_m: 5.0 },
        DEPTH,
        [100, 100],
    )
    .unwrap();
    let mut objects = vec![object(
        "far end",
        DVec3::new(-10.0, 100_000.0, 0.0),
        DVec3::ONE,
    )];
    for i in 0..400 {
        let x = 2.5 + f64::from(i - 200) * 1e-6;
        let min = DVec3::new(x, -100_000.0 + f64::from(i) * 500.0, 0.0);
        objects.push(object(format!("{i:03}"), min, DVec3::new(1.0, 400.0, 1.0)));
    }
    let kept: Vec<String> = objects
        .iter()
        .filter(|o| !view.frustum().is_outside(&o.bounds))
        .map(|o| o.id.to_string())
        .collect();
    let found = found(objects, &view);
    assert!(
        kept.iter().all(|id| found.contains(id)),
        "{kept:?} against {found:?}"
    );
}

/// Products that underflow prove nothing.
#[test]
fn denormal_points_are_not_lost() {
    let tiny = DVec3::splat(5e-324);
    let view = View::new(
        DVec3::ZERO,
        Orientation::LookAt {
            target: DVec3::new(1.0, 1.0, -1.5),
            up: DVec3::Z,
        },
        Projection::Orthographic { height_m: 1.0 },
        DepthRange {
            near: 0.0,
            far: None,
        },
        [100, 100],
    )
    .unwrap();
    assert_eq!(
        found(vec![object("point", tiny, DVec3::ZERO)], &view),
        ["point"]
    );
}

/// A matrix stands for the same half-spaces and sizes whatever it is multiplied with.
#[test]
fn matrices_of_any_scale_see_the_same() {
    // Looks along −z; left 0, right 1, bottom 0, top 1 at distance 1; near 1, no far plane.
    let matrix = DMat4::from_cols_array(&[
        2.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 1.0, -1.0, -1.0, 0.0, 0.0, -2.0, 0.0,
    ]);
    let off_axis = View::new(
        DVec3::ZERO,
        Orientation::LookAt {
            target: DVec3::NEG_Z,
            up: DVec3::Y,
        },
        Projection::OffAxis {
            left: 0.0,
            right: 1.0,
            bottom: 0.0,
            top: 1.0,
        },
        DepthRange {
            near: 1.0,
            far: None,
        },
        [640, 480],
    )
    .unwrap();
    let boxes: Vec<SceneObject> = (0..200)
        .map(|i| {
            let at = |k: u32| f64::from(i * k % 41) - 20.0;
            object(
                format!("{i:03}"),
                DVec3::new(at(7), at(11), at(13)),
                DVec3::splat(0.5),
            )
        })
        .collect();
    let expected = found(boxes.clone(), &off_axis);
    assert!(
        expected.len() > 3 && expected.len() < 150,
        "{}",
        expected.len()
    );
    for scale in [1.0, 1e-42, 1e-300, 1e-315, 1e30, 1e300] {
        let view = View::from_matrix(matrix * scale, DVec3::ZERO, [640, 480]).unwrap();
        assert_eq!(found(boxes.clone(), &view), expected, "scale {scale:e}");
    }
    let matrix = View::from_matrix(matrix, DVec3::ZERO, [640, 480]).unwrap();
    assert_eq!(matrix.pixels(), off_axis.pixels());
}

/// A view that cannot be is refused with the field at fault (N1).
#[test]
fn impossible_views_name_their_field() {
    let look = |target, up| Orientation::LookAt { target, up };
    let perspective = |fov_y_deg| Projection::Perspective { fov_y_deg };
    let good = (
        DVec3::ZERO,
        look(DVec3::X, DVec3::Z),
        perspective(60.0),
        DEPTH,
        [8, 8],
    );
    let view = |(eye, orientation, projection, depth, viewport): (_, _, _, _, _)| {
        View::new(eye, orientation, projection, depth, viewport)
    };
    assert!(view(good).is_ok());
    let depth = |near, far| DepthRange { near, far };
    let off = |left, right| Projection::OffAxis {
        left,
        right,
        bottom: 0.0,
        top: 1.0,
    };
    let nan = DVec3::new(f64::NAN, 0.0, 0.0);
    let cases: Vec<(Result<View, ViewError>, &str)> = vec![
        (view((nan, good.1, good.2, good.3, good.4)), "eye"),
        (
            view((
                good.0,
                look(DVec3::INFINITY, DVec3::Z),
                good.2,
                good.3,
                good.4,
            )),
            "target",
        ),
        (
            view((good.0, look(DVec3::ZERO, DVec3::Z), good.2, good.3, good.4)),
            "target",
        ),
        (
            view((good.0, look(DVec3::X, DVec3::ZERO), good.2, good.3, good.4)),
            "up",
        ),
        (
            view((good.0, look(DVec3::X, DVec3::NEG_X), good.2, good.3, good.4)),
            "up",
        ),
        (
            view((good.0, good.1, perspective(0.0), good.3, good.4)),
            "fov_y_deg",
        ),
        (
            view((good.0, good.1, perspective(180.0), good.3, good.4)),
            "fov_y_deg",
        ),
        (
            view((good.0, good.1, perspective(f64::NAN), good.3, good.4)),
            "fov_y_deg",
        ),
        (
            view((good.0, good.1, off(1.0, 1.0), good.3, good.4)),
            "left",
        ),
        (
            view((good.0, good.1, good.2, depth(0.0, None), good.4)),
            "near",
        ),
        (
            view((good.0, good.1, good.2, depth(1.0, Some(1.0)), good.4)),
            "far",
        ),
        (
            view((good.0, good.1, good.2, depth(1.0, Some(f64::NAN)), good.4)),
            "far",
        ),
        (view((good.0, good.1, good.2, good.3, [0, 8])), "viewport"),
        (
            View::from_matrix(DMat4::ZERO, DVec3::ZERO, [8, 8]),
            "view_projection",
        ),
        (
            View::from_matrix(DMat4::NAN, DVec3::ZERO, [8, 8]),
            "view_projection",
        ),
    ];
    for (result, field) in cases {
        assert_eq!(result.unwrap_err().field, field);
    }
    let inverted = Aabb::new(DVec3::ONE, DVec3::ZERO);
    assert!(inverted.is_err() && Aabb::new(nan, nan).is_err());
}

/// A matrix of one camera in every form gives the same scale; hard views see what they should.
#[test]
fn hard_views_see_what_is_before_them() {
    let city = || {
        (0..50).map(|i| {
            let min = DVec3::new(f64::from(i % 10) * 30.0, f64::from(i / 10) * 30.0, 0.0);
            object(format!("{i:02}"), min, DVec3::new(10.0, 10.0, 40.0))
        })
    };
    let view = |eye, fov_y_deg, near| {
        View::new(
            eye,
            Orientation::LookAt {
                target: DVec3::new(140.0, 65.0, 20.0),
                up: DVec3::Z,
            },
            Projection::Perspective { fov_y_deg },
            DepthRange { near, far: None },
            [1000, 1000],
        )
        .unwrap()
    };
    let far_off = DVec3::new(140.0 - 1e7, 65.0, 20.0);
    assert_eq!(
        found(city().collect(), &view(far_off, 0.01, 1e-6)).len(),
        50
    );
    let above = DVec3::new(140.0, 64.0, 1e4);
    assert_eq!(found(city().collect(), &view(above, 179.9, 1e-6)).len(), 50);
    let around = object("around", DVec3::splat(-1e9), DVec3::splat(2e9));
    assert_eq!(found(vec![around], &view(above, 60.0, 0.1)), ["around"]);
}
