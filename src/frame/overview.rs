//! Where to look at a city from, and how far in full detail, to see some thousand objects of it.

use std::time::Duration;

use super::{Active, Frame};
use crate::geom::{DVec3, DepthRange, Orientation, Projection, View};
use crate::index::LodTree;
use crate::lod::{ErrorLod, Lod, RangeLod};

/// A view of a city from the south, over the roofs, and the far distance that goes with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overview {
    /// Where to stand, scene coordinates.
    pub eye: DVec3,
    /// Where to look: the ground in the densest part.
    pub target: DVec3,
    /// Farthest distance of the finest level, m; the usual one ([`RangeLod::default`]) where it
    /// does as well as another.
    pub far_dist: f64,
}

/// What makes a good picture, objects.
const ENOUGH: std::ops::RangeInclusive<u32> = 500..=2_000;
/// What is aimed at where the usual far distance does not do, objects.
const AIM: f64 = 1_000.0;
/// Far distances that are tried, m.
const FAR_DISTS: [f64; 24] = [
    100.0, 150.0, 200.0, 300.0, 400.0, 700.0, 1e3, 1.5e3, 2e3, 3e3, 4e3, 5e3, 7e3, 1e4, 1.5e4, 2e4,
    3e4, 5e4, 1e5, 2e5, 5e5, 1e6, 3e6, 1e7,
];
/// How far back from the densest part to stand, m, at least and at most; haze brings it nearer.
const BACK: [f64; 2] = [100.0, 900.0];
/// The same for all of a city, however small, at least.
const NEAREST_M: f64 = 1.0;
/// How high, by how far back.
const RISE: f64 = 0.3;

impl Overview {
    /// Of a city; `None` where it has no object. Haze that the city declares counts, occlusion
    /// does not.
    pub fn of(tree: &LodTree) -> Option<Self> {
        let mut frame = Frame::default();
        let visibility = (tree.effects().haze).map_or(f64::INFINITY, |haze| haze.visibility_m);
        let all = tree.object_count();
        let off = |count: u32| {
            (f64::from(count.max(1)) / AIM.min(f64::from(all)))
                .ln()
                .abs()
        };
        let mut best: Option<(u32, Self)> = None;
        for look in [Look::Usual, Look::AtObject, Look::Whole] {
            let Some((middle, back)) = look.place(tree, visibility) else {
                continue;
            };
            let Some((count, overview)) = from(&mut frame, tree, middle, back) else {
                continue;
            };
            if best.is_none_or(|(least, _)| off(count) < off(least)) {
                best = Some((count, overview));
            }
            if count >= all.div_ceil(2).min(*ENOUGH.start()) {
                break;
            }
        }
        best.map(|(_, overview)| overview)
    }
}

/// The view of a place from so far back, with the far distance that suits it, and how many
/// objects it draws.
fn from(frame: &mut Frame, tree: &LodTree, middle: DVec3, back: f64) -> Option<(u32, Overview)> {
    let target = rounded(middle, back);
    let (mut eye, mut view) = (target, None);
    for step in 1..=STEPS {
        let rise = RISE * back * f64::from(step);
        eye = rounded(middle + DVec3::new(0.0, -back, rise), back);
        view = looking(eye, target);
        let free = |view: &View| !is_shut_in(frame, tree, view);
        if view.as_ref().is_some_and(free) {
            break;
        }
    }
    let view = view?;
    let active = Active {
        occlusion: None,
        ..Active::all(tree.effects(), 0.0)
    };
    let mut count = |far_dist| {
        let lod = Lod::Range(RangeLod::default().with_far_dist(far_dist));
        frame.work_out(tree, &view, &lod, &active, || Duration::ZERO);
        frame.selection().count()
    };
    let usual = RangeLod::default().far_dist();
    let mut best = (usual, count(usual));
    if !ENOUGH.contains(&best.1) {
        let off = |count: u32| (f64::from(count.max(1)) / AIM).ln().abs();
        for far_dist in FAR_DISTS {
            let counted = count(far_dist);
            if off(counted) < off(best.1) {
                best = (far_dist, counted);
            }
            if counted > *ENOUGH.end() {
                break;
            }
        }
    }
    let (far_dist, count) = best;
    let overview = Overview {
        eye,
        target,
        far_dist,
    };
    Some((count, overview))
}

/// Where to look, the better for most cities first.
#[derive(Clone, Copy)]
enum Look {
    /// At all of a small city, at the densest part of others.
    Usual,
    /// At the object nearest to there: the middle of several towns may lie in none of them.
    AtObject,
    /// At all of a city, however far it reaches: one object may be far from the next.
    Whole,
}

impl Look {
    /// What to look at, and from how far back.
    fn place(self, tree: &LodTree, visibility: f64) -> Option<(DVec3, f64)> {
        let (dense, bounds) = (densest(tree)?, tree.bounds());
        let size = bounds.size().truncate();
        let [nearest, farthest] = BACK;
        let whole = bounds.size().max_element().max(NEAREST_M);
        let is_small = tree.object_count() <= *ENOUGH.end();
        let sees_all = visibility > 2.0 * whole;
        let back = (size.min_element() * 0.2).clamp(nearest, farthest);
        let back = back.min(visibility / 3.0);
        match self {
            Self::Usual if is_small && sees_all => Some((bounds.center().with_z(dense.z), whole)),
            Self::Usual => Some((dense, back)),
            Self::AtObject => Some((nearest_object(tree, dense)?, back)),
            Self::Whole => sees_all.then(|| (bounds.center().with_z(dense.z), whole)),
        }
    }
}

/// The ground under the object that is nearest to a place on the map, the first of several.
fn nearest_object(tree: &LodTree, place: DVec3) -> Option<DVec3> {
    let boxes = tree.arrays().object_boxes.iter();
    let grounds = boxes.map(|b| DVec3::new(b[0].midpoint(b[3]), b[1].midpoint(b[4]), b[2]));
    let apart = |ground: &DVec3| (*ground - place).truncate().length_squared();
    grounds.min_by(|a, b| apart(a).total_cmp(&apart(b)))
}

/// Times that the eye is raised out of what it stands in.
const STEPS: u32 = 16;

/// Whether something lies around the eye.
fn is_shut_in(frame: &mut Frame, tree: &LodTree, view: &View) -> bool {
    // Nothing else is as large on the screen.
    let Ok(lod) = ErrorLod::new(f64::MAX) else {
        return false;
    };
    frame.work_out(tree, view, &Lod::Error(lod), &Active::default(), || {
        Duration::ZERO
    });
    frame.selection().count() > 0
}

fn looking(eye: DVec3, target: DVec3) -> Option<View> {
    let up = DVec3::Z;
    let depth = DepthRange::default();
    let projection = Projection::Perspective { fov_y_deg: 60.0 };
    let orientation = Orientation::LookAt { target, up };
    View::new(eye, orientation, projection, depth, [1920, 1080]).ok()
}

/// To the metre, or to the decimetre where that is much.
fn rounded(point: DVec3, back: f64) -> DVec3 {
    let parts = if back < BACK[0] { 10.0 } else { 1.0 };
    (point * parts).round() / parts
}

/// The ground under the median midpoint of the objects: a few far-off ones do not move it.
/// `None` where there is no object.
pub fn densest(tree: &LodTree) -> Option<DVec3> {
    const LOOKED_AT: usize = 100_000;
    let boxes = tree.arrays().object_boxes;
    let step = boxes.len().div_ceil(LOOKED_AT).max(1);
    let median = |of: fn(&[f64; 6]) -> f64| {
        let mut values: Vec<f64> = boxes.iter().step_by(step).map(of).collect();
        let middle = values.len().checked_sub(1)? / 2;
        let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
        Some(*median)
    };
    Some(DVec3::new(
        median(|b| b[0].midpoint(b[3]))?,
        median(|b| b[1].midpoint(b[4]))?,
        median(|b| b[2])?,
    ))
}
