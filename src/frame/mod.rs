//! One frame: a view and knobs → what to draw; and from the time that it takes, the knobs of the
//! next ([`Feedback`]).
//!
//! knobs → motion → view → haze → [`lod::select`] → haze → terrain → occlusion →
//! [`Frame::selection`]. An effect that is not active is a branch not taken.
//!
//! Reads no clock: durations come in through an argument.

mod feedback;
mod overview;

use std::time::Duration;

pub use feedback::Feedback;
pub use overview::{Overview, densest};

use crate::effects::occlusion::Occluder;
use crate::effects::terrain::{Drawn, Land, Surface};
use crate::effects::{haze, motion};
use crate::geom::{Aabb, SeparatingAxes, View};
use crate::index::LodTree;
use crate::lod::{self, BudgetLod, Lod, Selection};
use crate::scene;

/// How objects at the border of the frustum are told from those outside.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Culling {
    /// By the planes of the frustum: keeps some boxes near its corners that do not meet it.
    #[default]
    Fast,
    /// By separating axes too ([`SeparatingAxes`]): keeps only boxes that meet it.
    Exact,
}

/// What one frame takes beside its knobs: of the effects that the scene declares, the ones not
/// switched off, and how it culls.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Active {
    /// How it culls.
    pub culling: Culling,
    /// Detail falls with the camera's speed, m/s.
    pub motion: Option<(scene::Motion, f64)>,
    /// Nothing beyond the visibility range.
    pub haze: Option<scene::Haze>,
    /// Nothing that is hidden.
    pub occlusion: Option<scene::Occlusion>,
    /// The ground too; [`Frame::work_out_on`] says which.
    pub terrain: Option<scene::Terrain>,
    /// Longest time that occlusion may take, by the clock of the frame; `None` for as long as it
    /// takes. Where it takes longer, nothing is taken out ([`Frame::gave_up`]).
    pub patience: Option<Duration>,
}

impl Active {
    /// All that a scene declares, for a camera that moves at `speed_mps`, ≥ 0.
    pub fn all(declared: &scene::Effects, speed_mps: f64) -> Self {
        Self {
            motion: declared.motion.map(|motion| (motion, speed_mps)),
            haze: declared.haze,
            occlusion: declared.occlusion,
            terrain: declared.terrain,
            ..Self::default()
        }
    }
}

/// What an effect did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ran<T> {
    /// What came of it.
    pub result: T,
    /// What it took.
    pub took: Duration,
}

/// What the effects of one frame did; `None` did not run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Effects {
    /// How many times less detail there is.
    pub motion: Option<Ran<f64>>,
    /// How many selected objects it took out.
    pub haze: Option<Ran<u32>>,
    /// How many selected objects it took out.
    pub occlusion: Option<Ran<u32>>,
    /// What is drawn of the ground.
    pub terrain: Option<Ran<Drawn>>,
}

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
