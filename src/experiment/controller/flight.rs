//! A camera that flies from the suburb through the middle of a generated city and out again, with
//! the frame time of what retrieval finds.

use std::time::Duration;

use super::super::{ReportError, city};
use super::rivals::{Controller, Rule};
use super::scenario::{Run, TARGET_MS, run};
use crate::control::Params;
use crate::frame::{Active, Frame};
use crate::geom::{DVec3, DepthRange, Orientation, Projection, View};
use crate::index::LodTree;
use crate::lod::{Lod, RangeLod};

pub(super) const FLIGHT_FRAMES: usize = 600;
const OBJECTS: u32 = 200_000;
/// Frames until the first is known.
const DELAY: usize = 1;
/// What a frame takes whatever is drawn, and for each object, ms.
const BASE_MS: f64 = 4.0;
const OBJECT_MS: f64 = 0.01;

/// The same flight under each rule.
pub(super) fn flights(params: &Params) -> Result<Vec<(Rule, Run)>, ReportError> {
    let tree = city::generated(OBJECTS)?;
    let views = views(&tree)?;
    let flown = |rule| (rule, fly(&tree, &views, rule, params));
    Ok(Rule::ALL.map(flown).into())
}

fn fly(tree: &LodTree, views: &[View], rule: Rule, params: &Params) -> Run {
    let mut frame = Frame::default();
    let controller = Controller::new(rule, *params, 500.0);
    run(controller, DELAY, views.len(), |number, far_dist| {
        let lod = Lod::Range(RangeLod::default().with_far_dist(far_dist));
        frame.work_out(tree, &views[number], &lod, &Active::default(), || {
            Duration::ZERO
        });
        BASE_MS + OBJECT_MS * f64::from(frame.selection().count())
    })
}

fn views(tree: &LodTree) -> Result<Vec<View>, ReportError> {
    let (middle, size) = (city::densest(tree), tree.bounds().size());
    let ground = tree.bounds().min().z;
    let views = (0..FLIGHT_FRAMES).map(|number| {
        let along = number as f64 / (FLIGHT_FRAMES - 1) as f64 - 0.5;
        let side = 0.05 * size.y * (along * 9.0).sin();
        let eye = middle + DVec3::new(0.9 * size.x * along, side, 0.0);
        let eye = eye.with_z(ground + 120.0);
        let target = eye + DVec3::new(300.0, 120.0 * (along * 23.0).sin(), -30.0);
        View::new(
            eye,
            Orientation::LookAt {
                target,
                up: DVec3::Z,
            },
            Projection::Perspective { fov_y_deg: 60.0 },
            DepthRange::default(),
            [1920, 1080],
        )
    });
    Ok(views.collect::<Result<_, _>>()?)
}

/// Median distance of the frame time from the target, %, after the first 60 frames; and the share
/// of frames more than a tenth slower than it, %.
pub(super) fn held(run: &Run) -> (f64, f64) {
    let off = run.times_ms[60..]
        .iter()
        .map(|ms| 100.0 * (ms / TARGET_MS - 1.0));
    let late = off.clone().filter(|off| *off > 10.0).count() as f64;
    let count = off.len() as f64;
    (
        super::super::timing::median(off.map(f64::abs).collect()),
        100.0 * late / count,
    )
}
