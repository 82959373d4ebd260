//! From a view and knobs to what to draw.

use std::time::Duration;

use super::active::{Active, Culling, Effects, Ran};
use crate::effects::occlusion::Occluder;
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
    effects: Effects,
    retrieval: Duration,
}

impl Frame {
    /// Works out what to draw.
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
        self.effects = Effects::default();
        self.lod = *lod;
        let mut watch = Watch::new(clock);
        if *active == Active::default() {
            lod::select(tree, view, lod, &mut self.selection);
            self.retrieval = watch.lap();
        } else {
            self.with_effects(tree, view, active, &mut watch);
        }
    }

    fn with_effects(
        &mut self,
        tree: &LodTree,
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
        if let Some(declared) = &active.occlusion {
            let selection = &mut self.selection;
            let result = self.occluder.hide(declared, view, boxes, selection);
            let took = watch.lap();
            self.effects.occlusion = Some(Ran { result, took });
        }
    }

    /// Retrieval, within the visibility range and by exact culling where asked. A budget is not
    /// spent on what these take out: so much more is asked for until it is met; what they take
    /// out only grows with it, so this ends, at the latest when nothing is left out.
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
        loop {
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
            let needed = asked.max_objects().saturating_add(removed);
            if needed <= spent.max_objects() {
                return;
            }
            lod = Lod::Budget(BudgetLod::new(needed));
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

    /// Width × height of the id-buffer that occlusion was found with.
    pub fn buffer_size(&self) -> [u32; 2] {
        self.occluder.size()
    }
}

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

    fn lap(&mut self) -> Duration {
        let now = (self.clock)();
        let took = now.saturating_sub(self.last);
        self.last = now;
        took
    }
}
