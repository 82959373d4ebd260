//! What to draw of the ground for a view, and how wrong it is.

use super::bound::error_px;
use super::criterion::{Criterion, KnobError, Knobs};
use super::cut::Cut;
use super::fan::Facet;
use super::ground::Ground;
use super::judge::Judge;
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
    /// holes need are always drawn.
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
/// The smallest share that is tried.
const LEAST_SHARE: f64 = 1e-9;

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
    let with_share = |share: f64| {
        let judge = judge.with_share(share);
        let mut cut = judge.refine(workers);
        stitch(&judge, detail.subdivide_within, &mut cut);
        spare_midpoints(&judge, &mut cut);
        Selection::of(ground, view, cut, share)
    };
    let whole = with_share(1.0);
    match detail.max_triangles {
        Some(most) if whole.triangles > most => Ok(within_budget(most, with_share)),
        _ => Ok(whole),
    }
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

/// The largest share found whose triangles are no more than `most`; the smallest one tried where
/// even that has more.
fn within_budget(most: usize, with_share: impl Fn(f64) -> Selection) -> Selection {
    let (mut low, mut high) = (LEAST_SHARE.ln(), 0.0);
    let mut best = with_share(LEAST_SHARE);
    if best.triangles > most {
        return best;
    }
    // The count need not rise with the share everywhere, but what is kept is always within.
    for _ in 0..BISECTIONS + 5 {
        let middle = f64::midpoint(low, high);
        let tried = with_share(middle.exp());
        if tried.triangles <= most {
            (low, best) = (middle, tried);
        } else {
            high = middle;
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

    /// The share of the detail asked for that the budget allowed; 1 where all of it is drawn.
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
