//! What a view shows when everything is drawn, and what of it an answer misses.

use geo::{ConvexHull, MultiPoint};

use super::viewpoint::VIEWPORT;
use crate::geom::{Aabb, DVec3, PixelScale, View};
use crate::index::LodTree;
use crate::lod::{RangeLod, Selection, retrieve};
use crate::raster::{IdBuffer, NONE, Projector};

/// Side of a district on the map, m.
pub(super) const DISTRICT_M: f64 = 250.0;
/// Districts whose middle is farther than this from the eye are far, m.
pub(super) const FAR_M: f64 = 1000.0;

/// Coverage is decided on corners snapped to 1/4096 pixel, so each end of an extent may lie half
/// a step farther out along both axes than the object does.
const SNAPPED_PX: f64 = 2.0 * std::f64::consts::SQRT_2 / 8192.0;

/// A view with every object drawn: what answers are held against.
pub(super) struct FullDetail<'a> {
    tree: &'a LodTree,
    projector: Projector,
    /// Size in pixels and number of each object of the frustum, the largest first, of equals the
    /// lower number.
    pub(super) ranked: Vec<(f64, u32)>,
    picture: IdBuffer,
    /// Pixels that show the city.
    covered: u32,
    /// Objects that are seen, by number.
    seen: Vec<Seen>,
    districts: Districts,
    answer: IdBuffer,
    drawn: Vec<bool>,
}

struct Seen {
    object: u32,
    pixels: u32,
    extent_px: f64,
}

/// What an answer misses of what full detail shows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Missed {
    /// Of the pixels that show the city, those that show another object or none, percent.
    pub(super) px_pct: f64,
    /// Of these pixels, those that show none, percent. An answer covers none besides: it is a
    /// part of the city.
    pub(super) coverage_pct: f64,
    /// Largest extent of what is seen of an object that is not drawn, pixels.
    pub(super) worst_px: f64,
    /// Largest size of an object of the frustum that is not drawn, pixels.
    pub(super) largest_px: f64,
    /// Far districts of which an object is drawn.
    pub(super) far_districts_kept: usize,
}

impl<'a> FullDetail<'a> {
    pub(super) fn new(tree: &'a LodTree, view: &View) -> Self {
        let projector = Projector::new(view, VIEWPORT);
        let ranked = ranked(tree, view);
        let mut picture = IdBuffer::new(VIEWPORT[0], VIEWPORT[1]);
        for &(_, object) in &ranked {
            picture.draw_box(&projector, &bounds(tree, object), object);
        }
        let covered = picture.ids().iter().filter(|&&id| id != NONE).count();
        Self {
            seen: seen(&picture, &projector, view.pixels()),
            districts: Districts::new(tree, view.eye(), &ranked),
            covered: covered as u32,
            tree,
            projector,
            ranked,
            picture,
            answer: IdBuffer::new(VIEWPORT[0], VIEWPORT[1]),
            drawn: vec![false; tree.object_count() as usize],
        }
    }

    /// Draws an answer and compares the pictures.
    pub(super) fn missed_by(&mut self, answer: &[u32]) -> Missed {
        self.answer.clear();
        for &object in answer {
            let bounds = bounds(self.tree, object);
            self.answer.draw_box(&self.projector, &bounds, object);
        }
        let (mut missed, mut uncovered) = (0_u32, 0_u32);
        for (&full, &here) in self.picture.ids().iter().zip(self.answer.ids()) {
            missed += u32::from(full != here);
            uncovered += u32::from(full != NONE && here == NONE);
        }
        self.mark(answer, true);
        let worst = self.seen.iter().filter(|seen| !self.is_drawn(seen.object));
        let worst_px = worst.map(|seen| seen.extent_px).fold(0.0, f64::max);
        let largest = self
            .ranked
            .iter()
            .find(|(_, object)| !self.is_drawn(*object));
        let largest_px = largest.map_or(0.0, |(size, _)| *size);
        let far_districts_kept = self.districts.kept(&self.drawn);
        self.mark(answer, false);
        Missed {
            px_pct: self.percent(missed),
            coverage_pct: self.percent(uncovered),
            worst_px,
            largest_px,
            far_districts_kept,
        }
    }

    /// [`Missed::px_pct`] without a picture: where full detail shows an object that is drawn, it
    /// is the nearest here too.
    pub(super) fn missed_px_pct(&mut self, answer: &[u32]) -> f64 {
        self.mark(answer, true);
        let missed = self.seen.iter().filter(|seen| !self.is_drawn(seen.object));
        let missed = missed.map(|seen| seen.pixels).sum();
        self.mark(answer, false);
        self.percent(missed)
    }

    /// Far districts that hold an object of the frustum.
    pub(super) fn far_districts(&self) -> usize {
        self.districts.count
    }

    fn is_drawn(&self, object: u32) -> bool {
        self.drawn[object as usize]
    }

    fn mark(&mut self, answer: &[u32], drawn: bool) {
        for &object in answer {
            self.drawn[object as usize] = drawn;
        }
    }

    fn percent(&self, pixels: u32) -> f64 {
        100.0 * f64::from(pixels) / f64::from(self.covered.max(1))
    }
}

/// Size and number of each object of the frustum, the largest first, of equals the lower number.
pub(super) fn ranked(tree: &LodTree, view: &View) -> Vec<(f64, u32)> {
    let mut all = Selection::default();
    retrieve(tree, view, &RangeLod::full_detail(), &mut all);
    let sized = |object| (view.size_px(&bounds(tree, object)), object);
    let mut ranked: Vec<(f64, u32)> = all.objects().map(sized).collect();
    ranked.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    ranked
}

fn bounds(tree: &LodTree, object: u32) -> Aabb {
    tree.bounds_of(object).unwrap_or(Aabb::EMPTY)
}

/// Objects that are seen, with the extent of what is seen of them.
///
/// The extent is measured as sizes are ([`View::size_px`]): in a perspective the distance between
/// directions of unit length times the pixels of a radian. With p and q two points of a box that
/// is d away and of diagonal e, |p/|p| − q/|q|| ≤ |p − q|/d ≤ e/d, as drawing points in to the
/// sphere of radius d moves none away from another. So an extent is at most the size, and may be
/// held against the bound; of pixels on the screen, which stretch towards the border, this would
/// not hold.
fn seen(picture: &IdBuffer, projector: &Projector, pixels: PixelScale) -> Vec<Seen> {
    let width = VIEWPORT[0] as usize;
    // The ends of each run of pixels: (object, column, row).
    let mut ends: Vec<(u32, u32, u32)> = Vec::new();
    for (row, ids) in (0..).zip(picture.ids().chunks(width)) {
        let mut column = 0;
        for run in ids.chunk_by(|a, b| a == b) {
            let last = column + run.len() as u32 - 1;
            if run[0] != NONE {
                ends.extend([(run[0], column, row), (run[0], last, row)]);
            }
            column = last + 1;
        }
    }
    ends.sort_unstable();
    let objects = ends.chunk_by(|a, b| a.0 == b.0);
    let counts = picture.visible_pixels();
    objects
        .zip(counts)
        .map(|(ends, (object, pixels_seen))| Seen {
            object,
            pixels: pixels_seen,
            extent_px: extent_px(ends, projector, pixels),
        })
        .collect()
}

/// Of corners of the convex hull only: what is within some angle of a direction is a cone, which
/// the picture cuts in a convex figure.
fn extent_px(ends: &[(u32, u32, u32)], projector: &Projector, pixels: PixelScale) -> f64 {
    let centres = ends
        .iter()
        .map(|&(_, column, row)| (f64::from(column) + 0.5, f64::from(row) + 0.5));
    let hull = centres.collect::<MultiPoint>().convex_hull();
    let place = |column: f64, row: f64| match pixels {
        PixelScale::PerRadian(scale) => {
            projector.ray(column, row).direction.normalize_or_zero() * scale
        }
        PixelScale::PerMetre(_) => DVec3::new(column, row, 0.0),
    };
    let corners: Vec<DVec3> = hull.exterior().coords().map(|c| place(c.x, c.y)).collect();
    let mut longest = 0.0_f64;
    for (i, a) in corners.iter().enumerate() {
        for b in &corners[..i] {
            longest = longest.max(a.distance_squared(*b));
        }
    }
    (longest.sqrt() - SNAPPED_PX).max(0.0)
}

/// Districts of the far field that hold objects of the frustum.
struct Districts {
    /// Each object of a far district with the number of its district.
    objects: Vec<(u32, u32)>,
    count: usize,
}

impl Districts {
    fn new(tree: &LodTree, eye: DVec3, in_view: &[(f64, u32)]) -> Self {
        let mut far: Vec<([i64; 2], u32)> = Vec::new();
        for &(_, object) in in_view {
            let middle = bounds(tree, object).center();
            let place = (middle.truncate() / DISTRICT_M).floor();
            let district_middle = (place + 0.5) * DISTRICT_M;
            if district_middle.distance(eye.truncate()) > FAR_M {
                far.push(([place.x as i64, place.y as i64], object));
            }
        }
        far.sort_unstable();
        let mut objects = Vec::new();
        let mut count = 0;
        for district in far.chunk_by(|a, b| a.0 == b.0) {
            objects.extend(district.iter().map(|&(_, object)| (object, count)));
            count += 1;
        }
        Self {
            objects,
            count: count as usize,
        }
    }

    fn kept(&self, drawn: &[bool]) -> usize {
        let mut kept = vec![false; self.count];
        for &(object, district) in &self.objects {
            kept[district as usize] |= drawn[object as usize];
        }
        kept.into_iter().filter(|&kept| kept).count()
    }
}

#[cfg(test)]
mod tests {
    use super::super::viewpoint::viewpoints;
    use super::*;
    use crate::experiment::city::generated_scene;
    use crate::index::{Promotion, build};

    /// What an answer misses is the same by comparing pictures and by counting the pixels of what
    /// is not drawn; and no extent exceeds the size of its object.
    #[test]
    fn pictures_and_counts_agree_and_extents_keep_to_sizes()
    -> Result<(), Box<dyn std::error::Error>> {
        let tree = build(&generated_scene(3_000), Promotion::Largest)?;
        let (mut answers, mut wide) = (0, 0);
        for viewpoint in viewpoints(&tree)? {
            let mut full = FullDetail::new(&tree, &viewpoint.view);
            for every in [2, 3, 7] {
                let all = full.ranked.iter().map(|ranked| ranked.1);
                let some: Vec<u32> = all.filter(|object| object % every == 0).collect();
                let missed = full.missed_by(&some);
                assert_eq!(
                    missed.px_pct,
                    full.missed_px_pct(&some),
                    "{}",
                    viewpoint.name
                );
                assert!(missed.worst_px <= missed.largest_px);
                answers += usize::from(missed.px_pct > 0.0);
            }
            for seen in &full.seen {
                let size = viewpoint.view.size_px(&bounds(&tree, seen.object));
                assert!(seen.extent_px <= size, "{} of {size}", seen.extent_px);
                wide += usize::from(seen.extent_px > 0.5 * size);
            }
        }
        assert!(answers > 15, "{answers} answers miss something");
        assert!(wide > 300, "{wide} objects are seen from end to end");
        Ok(())
    }
}
