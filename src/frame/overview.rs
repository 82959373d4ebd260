//! Where to look at a city from, and how far in full detail, to see some thousand objects of it.

use std::time::Duration;

use super::sights::Sights;
use super::{Active, Frame};
use crate::geom::{Aabb, DVec3, DepthRange, Orientation, Projection, View};
use crate::index::LodTree;
use crate::lod::{ErrorLod, Lod, RangeLod};

/// A view of a city from the south, over the roofs, and the far distance that goes with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overview {
    /// Where to stand, scene coordinates.
    pub eye: DVec3,
    /// Where to look: the ground among what stands there.
    pub target: DVec3,
    /// Farthest distance of the finest level, m; the usual one ([`RangeLod::default`]) where it
    /// does as well as another.
    pub far_dist: f64,
    /// About what is looked at, for a picture of another shape; never empty.
    pub bounds: Aabb,
}

/// Height of the ground at a place on the map, m; `None` where it is not known.
pub type GroundAt<'a> = &'a dyn Fn(f64, f64) -> Option<f64>;

/// What makes a good picture, objects.
const ENOUGH: std::ops::RangeInclusive<u32> = 500..=2_000;
/// What is aimed at where the usual far distance does not do, objects.
const AIM: f64 = 1_000.0;
/// Far distances that are tried, m.
const FAR_DISTS: [f64; 24] = [
    100.0, 150.0, 200.0, 300.0, 400.0, 700.0, 1e3, 1.5e3, 2e3, 3e3, 4e3, 5e3, 7e3, 1e4, 1.5e4, 2e4,
    3e4, 5e4, 1e5, 2e5, 5e5, 1e6, 3e6, 1e7,
];
/// From this size on an object is seen well, pixels; a smaller one counts for less.
const SEEN_WELL_PX: f64 = 15.0;
/// A smaller object is not seen, pixels.
const SEEN_PX: f64 = 4.0;
/// A picture that shows as much as so many objects seen well is as good as any.
const SHOWS_ENOUGH: f64 = 200.0;
/// A look that comes later has to show so many times as much.
const CLEARLY: f64 = 1.5;
/// How far back from the densest part to stand, m, at least and at most; haze brings it nearer.
const BACK: [f64; 2] = [100.0, 900.0];
/// How far back from one object, by its diagonal.
const BACK_FROM_ONE: f64 = 3.0;
/// How far back at least, m.
const NEAREST_M: f64 = 1.0;
/// How high, by how far back.
const RISE: f64 = 0.3;

impl Overview {
    /// Of a city without ground; `None` where it has no object. Haze that the city declares counts,
    /// occlusion does not.
    pub fn of(tree: &LodTree) -> Option<Self> {
        Self::on(tree, &|_, _| None)
    }

    /// The same of a city with ground, which hides nothing of what is looked at.
    pub fn on(tree: &LodTree, ground: GroundAt<'_>) -> Option<Self> {
        let visibility = (tree.effects().haze).map_or(f64::INFINITY, |haze| haze.visibility_m);
        let mut stand = Stand {
            tree,
            ground,
            frame: Frame::default(),
            sights: Sights::of(tree)?,
        };
        let mut best: Option<(f64, Self)> = None;
        for look in [Look::Usual, Look::AtObject, Look::Whole, Look::Near] {
            let Some((shown, overview)) = stand.look(look, visibility) else {
                continue;
            };
            if best.is_none_or(|(most, _)| shown > CLEARLY * most) {
                best = Some((shown, overview));
            }
            if shown >= SHOWS_ENOUGH {
                break;
            }
        }
        best.map(|(_, overview)| overview)
    }
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
    /// At that object from near by: of one far from all others nothing is seen from farther away.
    Near,
}

impl Look {
    /// What to look at, and from how far back.
    fn place(self, sights: &Sights, visibility: f64) -> Option<(DVec3, f64)> {
        let (dense, bounds) = (sights.middle, sights.bounds);
        let size = bounds.size().truncate();
        let [nearest, farthest] = BACK;
        let whole = bounds.size().max_element().max(NEAREST_M);
        let is_small = sights.count <= *ENOUGH.end();
        let sees_all = visibility > 2.0 * whole;
        let back = (size.min_element() * 0.2).clamp(nearest, farthest);
        let back = back.min(visibility / 3.0);
        let object = || {
            let object = sights.nearest(dense)?;
            Some((
                object.center().with_z(object.min().z),
                2.0 * object.radius(),
            ))
        };
        match self {
            Self::Usual if is_small && sees_all => Some((bounds.center().with_z(dense.z), whole)),
            Self::Usual => Some((dense, back)),
            Self::AtObject => Some((object()?.0, back)),
            Self::Whole => sees_all.then(|| (bounds.center().with_z(dense.z), whole)),
            Self::Near => {
                let (place, diagonal) = object()?;
                let near = (BACK_FROM_ONE * diagonal).max(NEAREST_M);
                Some((place, near.min(visibility / 3.0)))
            }
        }
    }
}

/// What it takes to look at a city.
struct Stand<'a> {
    tree: &'a LodTree,
    ground: GroundAt<'a>,
    frame: Frame,
    sights: Sights,
}

impl Stand<'_> {
    /// A view, and how much it shows: as much as so many objects seen well.
    fn look(&mut self, look: Look, visibility: f64) -> Option<(f64, Overview)> {
        let (middle, back) = look.place(&self.sights, visibility)?;
        let (eye, target, view) = self.free_view(middle, back)?;
        let far_dist = self.far_dist(&view);
        let shown = self.shown(&view);
        let mut bounds = self.sights.about(middle, back);
        let is_part = matches!(look, Look::Usual | Look::AtObject);
        if bounds.is_empty() || (is_part && !self.is_all(&bounds)) {
            let aside = DVec3::new(back / 2.0, back / 2.0, 0.0);
            bounds = bounds.union(&Aabb::new(target - aside, target + aside).ok()?);
        }
        let overview = Overview {
            eye,
            target,
            far_dist,
            bounds,
        };
        Some((shown, overview))
    }

    /// Whether all that is worth seeing, but for the fringe, lies in a box on the map.
    fn is_all(&self, bounds: &Aabb) -> bool {
        let (all, has) = (self.sights.bounds, bounds);
        let low = has.min().truncate().cmple(all.min().truncate());
        let high = has.max().truncate().cmpge(all.max().truncate());
        low.all() && high.all()
    }

    /// From so far back, and so high that nothing is around the eye and no ground before it.
    fn free_view(&mut self, middle: DVec3, back: f64) -> Option<(DVec3, DVec3, View)> {
        let target = rounded(middle, back);
        let mut found = None;
        for step in 1..=STEPS {
            let rise = RISE * back * f64::from(step);
            let eye = rounded(middle + DVec3::new(0.0, -back, rise), back);
            let Some(view) = looking(eye, target) else {
                continue;
            };
            let is_free = !self.is_buried(eye, target) && !self.is_shut_in(&view);
            found = Some((eye, target, view));
            if is_free {
                break;
            }
        }
        found
    }

    /// Whether ground lies around the eye, or between it and what it looks at.
    fn is_buried(&self, eye: DVec3, target: DVec3) -> bool {
        const LOOKS: u32 = 32;
        // The last of the way is along the ground.
        (0..LOOKS * 7 / 8).any(|at| {
            let place = eye.lerp(target, f64::from(at) / f64::from(LOOKS));
            (self.ground)(place.x, place.y).is_some_and(|height| height >= place.z)
        })
    }

    /// Whether something lies around the eye.
    fn is_shut_in(&mut self, view: &View) -> bool {
        // Nothing else is as large on the screen.
        let Ok(lod) = ErrorLod::new(f64::MAX) else {
            return false;
        };
        let (lod, none) = (Lod::Error(lod), Active::default());
        (self.frame).work_out(self.tree, view, &lod, &none, || Duration::ZERO);
        self.frame.selection().count() > 0
    }

    /// What suits a view, m; the frame is left as drawn with it.
    fn far_dist(&mut self, view: &View) -> f64 {
        let off = |count: u32| (f64::from(count.max(1)) / AIM).ln().abs();
        let usual = RangeLod::default().far_dist();
        let mut best = (usual, self.count(view, usual));
        if !ENOUGH.contains(&best.1) {
            for far_dist in FAR_DISTS {
                let counted = self.count(view, far_dist);
                if off(counted) < off(best.1) {
                    best = (far_dist, counted);
                }
                if counted > *ENOUGH.end() {
                    break;
                }
            }
            self.count(view, best.0);
        }
        best.0
    }

    /// How many objects a frame draws.
    fn count(&mut self, view: &View, far_dist: f64) -> u32 {
        let active = Active {
            occlusion: None,
            ..Active::all(self.tree.effects(), 0.0)
        };
        let lod = Lod::Range(RangeLod::default().with_far_dist(far_dist));
        (self.frame).work_out(self.tree, view, &lod, &active, || Duration::ZERO);
        self.frame.selection().count()
    }

    /// Of what the frame draws, what is worth seeing.
    fn shown(&self, view: &View) -> f64 {
        let ranges = self.frame.selection().ranges();
        let drawn = ranges.iter().cloned().flatten();
        let boxes = drawn.filter_map(|object| Some((object, self.tree.bounds_of(object)?)));
        let sights = boxes.filter(|(object, b)| self.sights.is_one(self.tree, *object, b));
        let sizes = sights.map(|(_, bounds)| view.size_px(&bounds));
        let seen = sizes.filter(|&px| px >= SEEN_PX);
        seen.map(|px| (px / SEEN_WELL_PX).min(1.0)).sum()
    }
}

/// Times that the eye is raised out of what it stands in.
const STEPS: u32 = 16;

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
