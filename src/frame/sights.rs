//! What a person wants to see of a city: what stands, tall rather than broad, and buildings rather
//! than anything else; in want of that, all there is.

use crate::geom::{Aabb, DVec3};
use crate::index::LodTree;
use crate::scene::{is_building, is_cover};

/// Of more objects only every so many are looked at.
const LOOKED_AT: usize = 100_000;
/// How much more a building counts than another thing of its size.
const BUILDING: f64 = 10.0;
/// Share of the interest at either end that is left out of where most lies.
const FRINGE: f64 = 0.02;

/// The objects worth seeing.
#[derive(Debug)]
pub(super) struct Sights {
    /// How much each is worth, and its box; only those that are worth anything.
    of: Vec<(f64, Aabb)>,
    /// Whether nothing stands: then all count.
    all: bool,
    /// About how many there are.
    pub(super) count: u32,
    /// The ground under the median of them: a few far-off ones do not move it.
    pub(super) middle: DVec3,
    /// Where most of them lie, those at the fringe left out.
    pub(super) bounds: Aabb,
}

impl Sights {
    /// Of a city; `None` where it has no object.
    pub(super) fn of(tree: &LodTree) -> Option<Self> {
        let step = tree.arrays().object_boxes.len().div_ceil(LOOKED_AT).max(1);
        let objects = || (0..tree.object_count()).step_by(step);
        let bounds = |object| tree.bounds_of(object).map(|bounds| (object, bounds));
        let boxes = || objects().filter_map(bounds);
        let mut of: Vec<(f64, Aabb)> = boxes()
            .map(|(object, bounds)| (worth(tree, object, &bounds), bounds))
            .filter(|sight| sight.0 > 0.0)
            .collect();
        let all = of.is_empty();
        if all {
            of = boxes().map(|(_, bounds)| (1.0, bounds)).collect();
        }
        let at = |share: f64, place: fn(&Aabb) -> DVec3| {
            let along = |axis: usize| quantile(&of, share, |bounds| place(bounds)[axis]);
            Some(DVec3::new(along(0)?, along(1)?, along(2)?))
        };
        let ground = |bounds: &Aabb| bounds.center().with_z(bounds.min().z);
        let (low, high) = (at(FRINGE, Aabb::min)?, at(1.0 - FRINGE, Aabb::max)?);
        Some(Self {
            all,
            count: (of.len() * step).min(tree.object_count() as usize) as u32,
            middle: at(0.5, ground)?,
            bounds: Aabb::new(low.min(high), low.max(high)).ok()?,
            of,
        })
    }

    /// Whether an object is one of them.
    pub(super) fn is_one(&self, tree: &LodTree, object: u32, bounds: &Aabb) -> bool {
        self.all || worth(tree, object, bounds) > 0.0
    }

    /// The one that is nearest to a place on the map, the first of several.
    pub(super) fn nearest(&self, place: DVec3) -> Option<&Aabb> {
        let apart = |bounds: &Aabb| (bounds.center() - place).truncate().length_squared();
        let boxes = self.of.iter().map(|(_, bounds)| bounds);
        boxes.min_by(|a, b| apart(a).total_cmp(&apart(b)))
    }

    /// The box about those with their middle up to so far east, west, south and north of a place.
    pub(super) fn about(&self, place: DVec3, reach: f64) -> Aabb {
        let is_near = |bounds: &&Aabb| {
            let apart = (bounds.center() - place).truncate().abs();
            apart.max_element() <= reach
        };
        let boxes = self.of.iter().map(|(_, bounds)| bounds);
        boxes
            .filter(is_near)
            .fold(Aabb::EMPTY, |all, bounds| all.union(bounds))
    }
}

/// How much there is to see of an object: its height, less where it is broad; nothing of what
/// covers the ground or is flat.
fn worth(tree: &LodTree, object: u32, bounds: &Aabb) -> f64 {
    let class = tree.class_number(object).map(|at| &tree.classes()[at]);
    let class = class.map_or("", |class| class.as_str());
    if is_cover(class, bounds) {
        return 0.0;
    }
    let size = bounds.size();
    let side = (size.x * size.y).sqrt();
    let slender = if side > size.z { size.z / side } else { 1.0 };
    let kind = if is_building(class) { BUILDING } else { 1.0 };
    kind * size.z * slender
}

/// The value below which this share of the worth lies.
fn quantile(sights: &[(f64, Aabb)], share: f64, of: impl Fn(&Aabb) -> f64) -> Option<f64> {
    let mut values: Vec<(f64, f64)> = sights.iter().map(|(worth, b)| (of(b), *worth)).collect();
    values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let all: f64 = values.iter().map(|value| value.1).sum();
    let mut before = 0.0;
    let reached = |value: &&(f64, f64)| {
        before += value.1;
        before >= share * all
    };
    let found = values.iter().find(reached).or(values.last());
    found.map(|value| value.0)
}
