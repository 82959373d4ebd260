//! Where a city is looked at from: the street, its roofs, the air, far off, and as a map.

use crate::experiment::{ReportError, city};
use crate::geom::{DVec3, DepthRange, Orientation, Projection, View};
use crate::index::LodTree;

/// Pixels of every picture.
pub(super) const VIEWPORT: [u32; 2] = [1280, 720];

/// A view with its name in tables.
pub(super) struct Viewpoint {
    pub(super) name: &'static str,
    pub(super) view: View,
    /// What is seen frame after frame from there on, [`FRAME_M`] to the side each time.
    pub(super) path: Vec<View>,
}

/// How far a camera moves from frame to frame, m: 30 m/s at 60 frames a second.
const FRAME_M: f64 = 0.5;
/// Frames of a path: too many for the processor to know by heart.
const FRAMES: u32 = 64;

/// Height of eyes above the street, m.
const EYE_LEVEL_M: f64 = 1.7;
/// So far from the nearest wall a street view stands at least, m.
const CLEAR_M: f64 = 3.0;
/// Places tried for a street view.
const PLACES: u32 = 400;
const HEADINGS: u32 = 16;

/// Eight views about the densest part of a city.
pub(super) fn viewpoints(tree: &LodTree) -> Result<Vec<Viewpoint>, ReportError> {
    let boxes = tree.arrays().object_boxes;
    let middle = city::densest(tree);
    let size = tree.bounds().size();
    let across = size.x.min(size.y);
    let ground = ground_at(boxes, middle);
    let mut found = Vec::new();
    let streets = streets(boxes, middle.with_z(ground + EYE_LEVEL_M), 0.08 * across);
    for (name, eye) in ["street 1", "street 2"].into_iter().zip(&streets) {
        found.push(level(name, *eye, longest_sight(boxes, *eye))?);
    }
    for (name, place) in ["roof 1", "roof 2"].into_iter().zip(&streets) {
        let eye = highest_roof(boxes, *place, 0.04 * across) + DVec3::Z * 2.0;
        let down = DVec3::Z * -0.12;
        found.push(level(name, eye, longest_sight(boxes, *place) + down)?);
    }
    let at = |back: f64, up: f64, turn: f64| {
        middle.with_z(ground) + DVec3::new(turn.cos() * back, turn.sin() * back, up)
    };
    let perspective = Projection::Perspective { fov_y_deg: 60.0 };
    let map = Projection::Orthographic { height_m: 1500.0 };
    let target = middle.with_z(ground);
    for (name, eye, up, projection) in [
        ("bird's eye 1", at(500.0, 350.0, 4.0), DVec3::Z, perspective),
        (
            "bird's eye 2",
            at(1500.0, 900.0, 1.0),
            DVec3::Z,
            perspective,
        ),
        ("far", at(0.6 * across, 200.0, 2.5), DVec3::Z, perspective),
        ("map", at(0.0, 2000.0, 0.0), DVec3::Y, map),
    ] {
        found.push(viewpoint(name, eye, (target, up), projection)?);
    }
    Ok(found)
}

fn level(name: &'static str, eye: DVec3, ahead: DVec3) -> Result<Viewpoint, ReportError> {
    let projection = Projection::Perspective { fov_y_deg: 60.0 };
    viewpoint(name, eye, (eye + ahead, DVec3::Z), projection)
}

fn viewpoint(
    name: &'static str,
    eye: DVec3,
    (target, up): (DVec3, DVec3),
    projection: Projection,
) -> Result<Viewpoint, ReportError> {
    let moved = |frame: u32| {
        let by = DVec3::X * FRAME_M * f64::from(frame);
        let orientation = Orientation::LookAt {
            target: target + by,
            up,
        };
        let depth = DepthRange::default();
        View::new(eye + by, orientation, projection, depth, VIEWPORT)
    };
    Ok(Viewpoint {
        name,
        view: moved(0)?,
        path: (1..=FRAMES).map(moved).collect::<Result<_, _>>()?,
    })
}

/// Lowest point of the object nearest to a place on the map.
fn ground_at(boxes: &[[f64; 6]], place: DVec3) -> f64 {
    let nearest = boxes
        .iter()
        .min_by(|a, b| off(a, place, 2).total_cmp(&off(b, place, 2)));
    nearest.map_or(0.0, |b| b[2])
}

/// Squared distance of a box from a place, by its first `axes` coordinates.
fn off(b: &[f64; 6], place: DVec3, axes: usize) -> f64 {
    let gap = |axis: usize| {
        let at = place[axis];
        (b[axis] - at).max(at - b[axis + 3]).max(0.0)
    };
    (0..axes).map(|axis| gap(axis).powi(2)).sum()
}

/// Places on the ground near `middle` with nothing within reach, at least a third of `spread`
/// apart; the middle itself where there is none.
fn streets(boxes: &[[f64; 6]], middle: DVec3, spread: f64) -> [DVec3; 2] {
    let near: Vec<&[f64; 6]> = boxes
        .iter()
        .filter(|b| off(b, middle, 2) < (2.0 * spread).powi(2))
        .collect();
    let mut clear = city::spiral(middle, spread, PLACES)
        .filter(|&place| near.iter().all(|b| off(b, place, 3) >= CLEAR_M.powi(2)));
    let first = clear.next().unwrap_or(middle);
    let second = clear.find(|place| place.distance(first) > spread / 3.0);
    [first, second.unwrap_or(first)]
}

/// The level direction in which the next thing is farthest.
fn longest_sight(boxes: &[[f64; 6]], eye: DVec3) -> DVec3 {
    let mut longest = (0.0, DVec3::X);
    for heading in 0..HEADINGS {
        let turn = f64::from(heading) / f64::from(HEADINGS) * std::f64::consts::TAU;
        let ahead = DVec3::new(turn.cos(), turn.sin(), 0.0);
        let sight = boxes
            .iter()
            .filter_map(|b| hit(b, eye, ahead))
            .fold(f64::INFINITY, f64::min);
        if sight > longest.0 && sight < f64::INFINITY {
            longest = (sight, ahead);
        }
    }
    longest.1
}

/// Where a ray enters a box, m along it.
fn hit(b: &[f64; 6], eye: DVec3, ahead: DVec3) -> Option<f64> {
    let (mut from, mut to) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let [low, high] = [b[axis], b[axis + 3]].map(|at| (at - eye[axis]) / ahead[axis]);
        if ahead[axis] == 0.0 {
            if b[axis] > eye[axis] || b[axis + 3] < eye[axis] {
                return None;
            }
        } else {
            from = from.max(low.min(high));
            to = to.min(low.max(high));
        }
    }
    (from <= to).then_some(from)
}

/// The middle of the highest roof within reach of a place.
fn highest_roof(boxes: &[[f64; 6]], place: DVec3, reach: f64) -> DVec3 {
    let near = boxes.iter().filter(|b| off(b, place, 2) <= reach.powi(2));
    let highest = near.max_by(|a, b| a[5].total_cmp(&b[5]));
    highest.map_or(place, |b| {
        DVec3::new(b[0].midpoint(b[3]), b[1].midpoint(b[4]), b[5])
    })
}
