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
const FAR_DISTS: [f64; 18] = [
    100.0, 150.0, 200.0, 300.0, 400.0, 700.0, 1e3, 1.5e3, 2e3, 3e3, 4e3, 5e3, 7e3, 1e4, 1.5e4, 2e4,
    3e4, 5e4,
];
/// How far back from the densest part to stand, m, at least and at most; haze brings it nearer.
const BACK: [f64; 2] = [100.0, 900.0];
/// How high, by how far back.
const RISE: f64 = 0.3;

impl Overview {
    /// Of a city; `None` where it has no object. Haze that the city declares counts, occlusion
    /// does not.
    pub fn of(tree: &LodTree) -> Option<Self> {
        let mut frame = Frame::default();
        let visibility = (tree.effects().haze).map_or(f64::INFINITY, |haze| haze.visibility_m);
        let (middle, back) = place(tree, visibility)?;
        let target = rounded(middle, back);
        let (mut eye, mut view) = (target, None);
        for step in 1..=STEPS {
            eye = rounded(
                middle + DVec3::new(0.0, -back, RISE * back * f64::from(step)),
                back,
            );
            view = looking(eye, target);
            if view
                .as_ref()
                .is_some_and(|view| !is_shut_in(&mut frame, tree, view))
            {
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
        Some(Self {
            eye,
            target,
            far_dist: best.0,
        })
    }
}

/// What to look at, and from how far back: all of a small city, the densest part of others.
fn place(tree: &LodTree, visibility: f64) -> Option<(DVec3, f64)> {
    let (dense, bounds) = (densest(tree)?, tree.bounds());
    let size = bounds.size().truncate();
    let [nearest, farthest] = BACK;
    let whole = size.max_element().max(nearest);
    if tree.object_count() <= *ENOUGH.end() && visibility > 2.0 * whole {
        return Some((bounds.center().with_z(dense.z), whole));
    }
    let back = (size.min_element() * 0.2).clamp(nearest, farthest);
    Some((dense, back.min(visibility / 3.0)))
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
