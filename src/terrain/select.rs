//! What to draw of the ground for a view, and how wrong it is.

use super::bound::error_px;
use super::criterion::{Criterion, KnobError, Knobs};
use super::cut::Cut;
use super::fan::Facet;
use super::ground::Ground;
use super::judge::{Allowance, Judge};
use super::refine::Workers;
use super::spare::spare_midpoints;
use super::stitch::stitch;
use crate::geom::View;

/// How much of the ground's detail to draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detail {
    /// Which paper decides.
    pub criterion: Criterion,
    /// What its equation is tuned by.
    pub knobs: Knobs,
    /// B's m: up to this distance (m) neighbours that are too coarse are subdivided, beyond it
    /// nodes that are too fine are reduced. 0 is A's rule, infinity makes every node as fine as
    /// its criterion asks.
    pub subdivide_within: f64,
    /// Triangles that may be drawn, if there is a limit. Two for each block in view and what
    /// holes need are always drawn. Where `subdivide_within` is infinite this bounds the work too.
    pub max_triangles: Option<usize>,
}

/// What a view shows of the ground.
#[derive(Debug, Clone)]
pub struct Selection {
    cut: Cut,
    triangles: usize,
    error_px: f64,
    share: f64,
}

impl Detail {
    /// What a criterion gives with its own knobs: as fine as it asks for, without a limit.
    pub fn of(criterion: Criterion) -> Self {
        Self {
            criterion,
            knobs: criterion.knobs(),
            subdivide_within: f64::INFINITY,
            max_triangles: None,
        }
    }
}

/// How close the share of detail under a budget comes to the largest possible one: 2⁻¹⁰ of it.
const BISECTIONS: u32 = 10;
/// The smallest share that is tried but for none.
const LEAST_SHARE: f64 = 1e-9;
/// A try under a budget is given up once it splits more than this many nodes a triangle and
/// these besides: so a budget bounds the work too, whatever the view. Each node that is split and
/// in view comes to more than a triangle; the rest is for those that are, but not their quarters.
const SPLITS_A_TRIANGLE: usize = 4;
const SPLITS: usize = 4096;

/// What to draw of the ground. Nothing that may be in view is left out.
///
/// # Errors
/// [`KnobError`] for knobs that cannot be, `subdivide_within` below 0 or NaN included.
pub fn select(
    ground: &Ground,
    view: &View,
    detail: &Detail,
    workers: Workers,
) -> Result<Selection, KnobError> {
    select_within(ground, view, detail, f64::INFINITY, workers)
}

/// As [`select`], and besides what the criterion splits everything is split that would err by more
/// than `max_error_px` on the screen.
///
/// Law: where all is drawn that was asked for ([`Selection::share`] 1) and `subdivide_within` is
/// infinite, [`Selection::error_px`] is no more than `max_error_px`.
///
/// # Errors
/// As [`select`], and for a `max_error_px` that is not above 0.
pub fn select_within(
    ground: &Ground,
    view: &View,
    detail: &Detail,
    max_error_px: f64,
    workers: Workers,
) -> Result<Selection, KnobError> {
    if max_error_px.is_nan() || max_error_px <= 0.0 {
        return Err(KnobError {
            knob: "max_error_px",
            least: "above 0",
            value: max_error_px,
        });
    }
    let judge = Judge {
        max_error_px,
        ..Judge::new(ground, view, detail)?
    };
    let with_share = |share: f64, allowance: Option<&Allowance>| {
        let judge = Judge {
            allowance,
            ..judge.with_share(share)
        };
        let mut cut = judge.refine(workers);
        stitch(&judge, detail.subdivide_within, &mut cut);
        spare_midpoints(&judge, &mut cut);
        Selection::of(ground, view, cut, share)
    };
    let Some(most) = detail.max_triangles else {
        return Ok(with_share(1.0, None));
    };
    // What will be reduced is split without being drawn, and says nothing of the triangles.
    let is_limited = detail.subdivide_within == f64::INFINITY;
    let splits = most
        .saturating_mul(SPLITS_A_TRIANGLE)
        .saturating_add(SPLITS);
    let within = |share: f64| {
        let allowance = is_limited.then(|| Allowance::new(splits));
        let tried = with_share(share, allowance.as_ref());
        let is_whole = !allowance.is_some_and(|allowance| allowance.is_exceeded());
        (is_whole && tried.triangles <= most).then_some(tried)
    };
    if let Some(whole) = within(1.0) {
        return Ok(whole);
    }
    let least = with_share(0.0, None);
    if least.triangles > most {
        return Ok(least);
    }
    Ok(largest(within).unwrap_or(least))
}

/// What the criterion alone asks for, neighbours differing by any number of levels: the first
/// half of [`select`], which may be shared among threads. Drawn as it is it has cracks.
///
/// # Errors
/// As [`select`].
pub fn refine(
    ground: &Ground,
    view: &View,
    detail: &Detail,
    workers: Workers,
) -> Result<Cut, KnobError> {
    Ok(Judge::new(ground, view, detail)?.refine(workers))
}

/// What the largest share gives that is found to be within the budget; `None` where even the
/// smallest ones are not.
fn largest(within: impl Fn(f64) -> Option<Selection>) -> Option<Selection> {
    let (mut low, mut high) = (LEAST_SHARE.ln(), 0.0);
    let mut best = None;
    // The count need not rise with the share everywhere, but what is kept is always within.
    for _ in 0..BISECTIONS + 5 {
        let middle = f64::midpoint(low, high);
        match within(middle.exp()) {
            Some(tried) => (low, best) = (middle, Some(tried)),
            None => high = middle,
        }
    }
    best
}

impl Selection {
    fn of(ground: &Ground, view: &View, cut: Cut, share: f64) -> Self {
        let (mut triangles, mut error_px) = (0, 0.0_f64);
        cut.facets(ground, |facet| {
            triangles += 1;
            error_px = error_px.max(facet_error_px(ground, view, &facet));
        });
        Self {
            cut,
            triangles,
            error_px,
            share,
        }
    }

    /// Which nodes are split and which are drawn.
    pub fn cut(&self) -> &Cut {
        &self.cut
    }

    /// How many triangles are drawn.
    pub fn triangles(&self) -> usize {
        self.triangles
    }

    /// No post in a triangle that is drawn is farther above or below it than this on the screen;
    /// a length e at distance d covers e/d times the pixels per radian. Infinite where the eye
    /// is so close that no bound can be given.
    pub fn error_px(&self) -> f64 {
        self.error_px
    }

    /// The share of the detail asked for that the budget allowed; 1 where all of it is drawn, 0
    /// where only what is always drawn.
    pub fn share(&self) -> f64 {
        self.share
    }

    /// How many nodes are split.
    pub fn splits(&self) -> usize {
        let levels = self.cut.levels();
        levels.map(|level| self.cut.splits(level).count()).sum()
    }
}

/// Bound of the error of a facet on the screen.
fn facet_error_px(ground: &Ground, view: &View, facet: &Facet) -> f64 {
    let (node, side) = match facet.quarters {
        Some([a, b]) if a == b => (facet.node.child(a), None),
        Some([side, _]) => (facet.node, Some(side)),
        None => (facet.node, None),
    };
    let record = ground.record(node);
    let error = side.map_or(record.whole, |side| record.skipped[side]);
    let distance = ground.bounds(node, &record).distance(view.eye());
    error_px(f64::from(error), distance, view)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{DVec2, DVec3, DepthRange, Orientation, Projection};
    use crate::terrain::{Grid, HeightField, Layout};

    /// What would be split in thousands of places is not, once that is more than may be.
    #[test]
    fn an_allowance_bounds_the_work() {
        let grid = Grid::new(129, 129, DVec2::ZERO, DVec2::splat(10.0)).unwrap();
        let rough = (0..129 * 129_u32).map(|at| (at.wrapping_mul(2_654_435_761) >> 24) as f32);
        let field = HeightField::new(grid, rough.collect()).unwrap();
        let ground = Ground::cut(&field, &Layout::new(grid));
        let view = View::new(
            DVec3::new(640.0, 640.0, 5_000.0),
            Orientation::LookAt {
                target: DVec3::new(640.0, 640.0, 0.0),
                up: DVec3::Y,
            },
            Projection::Perspective { fov_y_deg: 60.0 },
            DepthRange::default(),
            [u32::MAX; 2],
        )
        .unwrap();
        let judge = Judge {
            max_error_px: 1.0,
            ..Judge::new(&ground, &view, &Detail::of(Criterion::Error)).unwrap()
        };
        let splits = |cut: &Cut| cut.levels().flat_map(|level| cut.splits(level)).count();
        let all = splits(&judge.refine(Workers::One));
        assert!(all > 5_000, "{all}");
        for workers in [Workers::One, Workers::Pool] {
            let allowance = Allowance::new(100);
            let judge = Judge {
                allowance: Some(&allowance),
                ..judge
            };
            let cut = judge.refine(workers);
            assert!(allowance.is_exceeded());
            assert_eq!(splits(&cut), 100);
        }
    }
}
