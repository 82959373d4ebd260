//! How objects are chosen, and the one way to ask for them.

use super::{BudgetLod, ErrorLod, RangeLod, Selection, budget, error, retrieve};
use crate::geom::View;
use crate::index::LodTree;

/// The three ways to choose objects, each with its knobs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lod {
    /// By distance, each level over its range: every district keeps its representatives.
    Range(RangeLod),
    /// All that are large enough on the screen.
    Error(ErrorLod),
    /// So many, the largest on the screen.
    Budget(BudgetLod),
}

impl Lod {
    /// The same with detail so many times less, `factor` ≥ 1: distances shorter, sizes larger, and
    /// as many objects as a circle of a shorter radius holds.
    #[must_use]
    pub fn coarsened(&self, factor: f64) -> Self {
        match self {
            Self::Range(lod) => Self::Range(lod.coarsened(factor)),
            Self::Error(lod) => Self::Error(lod.coarsened(factor)),
            Self::Budget(lod) => Self::Budget(lod.coarsened(factor)),
        }
    }
}

impl Default for Lod {
    fn default() -> Self {
        Self::Range(RangeLod::default())
    }
}

/// Finds what a view calls for, into `selection`, whose memory is used again.
///
/// Total: answers for every view and every setting.
pub fn select(tree: &LodTree, view: &View, lod: &Lod, selection: &mut Selection) {
    match lod {
        Lod::Range(lod) => retrieve(tree, view, lod, selection),
        Lod::Error(lod) => error::select(tree, view, *lod, selection),
        Lod::Budget(lod) => budget::select(tree, view, *lod, selection),
    }
}
