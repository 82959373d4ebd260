//! From a view and knobs to what to draw.

use std::time::Duration;

use super::active::{Active, Culling, Effects, Ran};
use crate::effects::occlusion::Occluder;
use crate::effects::terrain::{Land, Surface};
use crate::effects::{haze, motion};
use crate::geom::{Aabb, SeparatingAxes, View};
use crate::index::LodTree;
use crate::lod::{self, BudgetLod, Lod, Selection};

/// The answer to a frame. Kept and used again, it allocates little.
#[derive(Debug, Default)]
pub struct Frame {
    selection: Selection,
    lod: Lod,
    occluder: Occluder,
    surface: Surface,
    effects: Effects,
    retrieval: Duration,
    gave_up: bool,
}

impl Frame {
    /// Works out what to draw of a city without ground.
    ///
    /// `clock` tells the time since any fixed moment; `|| Duration::ZERO` where nobody asks what
    /// things took. Total, as retrieval is. Not inlined, so that its instructions can be counted.
    #[inline(never)]
    pub fn work_out(
        &mut self,
        tree: &LodTree,
        view: &View,
        lod: &Lod,
        active: &Active,
        clock: impl FnMut() -> Duration,
    ) {
        self.work((tree, None), view, lod, active, clock);
    }

    /// Works out what to draw of a city and, where that is active, of its ground.
    #[inline(never)]
    pub fn work_out_on(
        &mut self,
        land: &Land,
        tree: &LodTree,
        view: &View,
        lod: &Lod,
        active: &Active,
        clock: impl FnMut() -> Duration,
    ) {
        self.work((tree, Some(land)), view, lod, active, clock);
    }

    #[inline]
    fn work(
        &mut self,
        (tree, land): (&LodTree, Option<&Land>),
        view: &View,
        lod: &Lod,
        active: &Active,
        clock: impl FnMut() -> Duration,
    ) {
        self.effects = Effects::default();
        self.gave_up = false;
        self.lod = *lod;
        let mut watch = Watch::new(clock);
        if *active == Active::default() {
            lod::select(tree, view, lod, &mut self.selection);
            self.retrieval = watch.lap();
        } else {
            self.with_effects((tree, land), view, active, &mut watch);
        }
    }

    fn with_effects(
        &mut self,
        (tree, land): (&LodTree, Option<&Land>),
        view: &View,
        active: &Active,
        watch: &mut Watch<impl FnMut() -> Duration>,
    ) {
        if let Some((declared, speed_mps)) = &active.motion {
            let result = motion::slowdown(declared, *speed_mps);
            self.lod = self.lod.coarsened(result);
            let took = watch.lap();
            self.effects.motion = Some(Ran { result, took });
        }
        self.retrieve(tree, view, active, watch);
        let boxes = tree.arrays().object_boxes;
        let land = land.filter(|_| active.terrain.is_some());
        if let (Some(declared), Some(land)) = (&active.terrain, land) {
            let shortened = active.haze.map(|haze| haze::shortened(haze, view));
            let view = shortened.as_ref().unwrap_or(view);
            let slowdown = self.effects.motion.map_or(1.0, |motion| motion.result);
            let result = self.surface.choose(declared, land, view, slowdown);
            let took = watch.lap();
            self.effects.terrain = Some(Ran { result, took });
        }
        if let Some(declared) = &active.occlusion {
            let goes_on = || active.patience.is_none_or(|most| watch.running() <= most);
            let selection = &mut self.selection;
            // Ground that is too coarse may stand where there is none, and hide what is seen.
            let land = land.filter(|_| self.surface.is_whole());
            let (corners, triangles) = land.map(|land| self.surface.mesh(land)).unwrap_or_default();
            let ground = (&corners[..], &triangles[..]);
            let occluder = &mut self.occluder;
            let hidden = occluder.hide(declared, view, boxes, ground, selection, goes_on);
            let took = watch.lap();
            self.effects.occlusion = hidden.map(|result| Ran { result, took });
            self.gave_up = hidden.is_none();
        }
    }

    /// Retrieval, within the visibility range and by exact culling where asked. A budget is not
    /// spent on what these take out: more is asked for until enough is left, and the largest of
    /// that are kept. From the third time on at least twice as much is asked for, so that all
    /// of it takes about as long as the last time, whatever they take out.
    fn retrieve(
        &mut self,
        tree: &LodTree,
        view: &View,
        active: &Active,
        watch: &mut Watch<impl FnMut() -> Duration>,
    ) {
        let boxes = tree.arrays().object_boxes;
        let shortened = active.haze.map(|haze| haze::shortened(haze, view));
        let mut clearing = watch.lap();
        let axes = (active.culling == Culling::Exact).then(|| SeparatingAxes::new(view.frustum()));
        let mut lod = self.lod;
        self.retrieval = Duration::ZERO;
        for least_growth in [SLACK, SLACK].into_iter().chain(std::iter::repeat(2.0)) {
            let seen = shortened.as_ref().unwrap_or(view);
            lod::select(tree, seen, &lod, &mut self.selection);
            let mut removed = 0;
            if let Some(axes) = &axes {
                removed += self
                    .selection
                    .retain(|object| Aabb::nth(boxes, object).is_some_and(|b| !axes.separate(&b)));
            }
            self.retrieval += watch.lap();
            if let Some(declared) = active.haze {
                let result = haze::clear(declared, view, boxes, &mut self.selection);
                clearing += watch.lap();
                let took = clearing;
                self.effects.haze = Some(Ran { result, took });
                removed += result;
            }
            let (Lod::Budget(asked), Lod::Budget(spent)) = (self.lod, lod) else {
                return;
            };
            let (wanted, kept) = (asked.max_objects(), self.selection.count());
            let is_all = kept + removed < spent.max_objects();
            if kept >= wanted || is_all {
                lod::keep_largest(tree, view, wanted, &mut self.selection);
                self.retrieval += watch.lap();
                return;
            }
            let growth = SLACK * f64::from(wanted) / f64::from(kept.max(1));
            let growth = growth.clamp(least_growth, MOST_GROWTH);
            // Saturates where no tree has as many.
            let most = (f64::from(spent.max_objects()) * growth).ceil() as u32;
            lod = Lod::Budget(BudgetLod::new(most));
        }
    }

    /// The objects to draw.
    pub fn selection(&self) -> &Selection {
        &self.selection
    }

    /// The knobs they were selected with: those asked for, less what motion took.
    pub fn lod(&self) -> &Lod {
        &self.lod
    }

    /// What the effects did.
    pub fn effects(&self) -> &Effects {
        &self.effects
    }

    /// Whether occlusion was given up, as it took too long ([`Active::patience`]).
    pub fn gave_up(&self) -> bool {
        self.gave_up
    }

    /// What retrieval took.
    pub fn retrieval(&self) -> Duration {
        self.retrieval
    }

    /// Where occlusion ran: the objects to draw, ascending, each with the pixels it covers in an
    /// id-buffer of [`Frame::buffer_size`]. Empty where it did not.
    pub fn visible_pixels(&self) -> &[(u32, u32)] {
        match self.effects.occlusion {
            Some(_) => self.occluder.seen(),
            None => &[],
        }
    }

    /// Where terrain ran: what is drawn of the ground.
    pub fn surface(&self) -> Option<&Surface> {
        self.effects.terrain.map(|_| &self.surface)
    }

    /// Width × height of the id-buffer that occlusion was found with.
    pub fn buffer_size(&self) -> [u32; 2] {
        self.occluder.size()
    }
}

/// What a budget is raised by beyond what the share that was left says.
const SLACK: f64 = 1.05;
/// What a budget is raised by at most: where next to nothing is left, that share says little.
const MOST_GROWTH: f64 = 8.0;

/// Tells how long each step took.
struct Watch<C> {
    clock: C,
    last: Duration,
}

impl<C: FnMut() -> Duration> Watch<C> {
    fn new(mut clock: C) -> Self {
        let last = clock();
        Self { clock, last }
    }

    /// Time since the last step.
    fn running(&mut self) -> Duration {
        (self.clock)().saturating_sub(self.last)
    }

    fn lap(&mut self) -> Duration {
        let now = (self.clock)();
        let took = now.saturating_sub(self.last);
        self.last = now;
        took
    }
}
