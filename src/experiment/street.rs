//! Views from the street.

use super::{ReportError, city};
use crate::geom::{Aabb, DVec3, DepthRange, Orientation, Projection, View};
use crate::index::LodTree;

/// Somebody who stands in a street and looks along the ground.
pub(super) struct Street {
    pub(super) eye: DVec3,
    pub(super) target: DVec3,
    pub(super) view: View,
}

/// Height of the eye above the ground, m.
const EYE_M: f64 = 1.7;
/// Free space around the eye, m.
const ELBOW_ROOM_M: f64 = 2.0;

/// Views from outdoor places about the densest part, at most `count`.
pub(super) fn views(tree: &LodTree, count: usize) -> Result<Vec<Street>, ReportError> {
    const PLACES: u32 = 4096;
    let middle = city::densest(tree);
    let reach = tree.bounds().size().x.min(tree.bounds().size().y) * 0.1;
    let boxes = tree.arrays().object_boxes;
    let bounds = |corners: &[f64; 6]| Aabb::from_array(*corners).unwrap_or(Aabb::EMPTY);
    let mut streets = Vec::new();
    for place in 0..PLACES {
        if streets.len() == count {
            break;
        }
        let turn = f64::from(place) * city::GOLDEN_ANGLE;
        let out = reach * (f64::from(place) / f64::from(PLACES)).sqrt();
        let beside = middle + DVec3::new(turn.cos() * out, turn.sin() * out, 0.0);
        let Some(ground) = ground_near(boxes, beside) else {
            break;
        };
        let eye = beside.with_z(ground + EYE_M);
        let free = |corners: &[f64; 6]| bounds(corners).distance(eye) > ELBOW_ROOM_M;
        if !boxes.iter().all(free) {
            continue;
        }
        let target = eye + DVec3::new(turn.sin(), turn.cos(), 0.02) * 100.0;
        let view = View::new(
            eye,
            Orientation::LookAt {
                target,
                up: DVec3::Z,
            },
            Projection::Perspective { fov_y_deg: 60.0 },
            DepthRange::default(),
            [1920, 1080],
        )?;
        streets.push(Street { eye, target, view });
    }
    Ok(streets)
}

/// The foot of the object nearest on the map.
fn ground_near(boxes: &[[f64; 6]], place: DVec3) -> Option<f64> {
    let apart = |b: &[f64; 6]| {
        let middle = DVec3::new(b[0].midpoint(b[3]), b[1].midpoint(b[4]), 0.0);
        middle.with_z(0.0).distance_squared(place.with_z(0.0))
    };
    let nearest = boxes.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
    nearest.map(|b| b[2])
}
