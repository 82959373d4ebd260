//! Runs of siblings in a set of eight.

use crate::geom::{ALL_LANES, Lanes};

/// The first `count` lanes, at most eight.
#[inline]
pub(super) fn first(count: u32) -> Lanes {
    !(Lanes::MAX << count) & ALL_LANES
}

/// How many lanes of the set follow one another from `lane` on; 0 where that is not in it.
#[inline]
pub(super) fn run_length(set: Lanes, lane: u32) -> u32 {
    // The bit above the eighth ends every run.
    (!(set >> lane) | (1 << 8)).trailing_zeros()
}

/// The set without its lanes up to and including the run of `length` from `lane` on.
#[inline]
pub(super) fn after_run(set: Lanes, lane: u32, length: u32) -> Lanes {
    set & (Lanes::MAX << (lane + length))
}

/// Whether `lane` is in the set.
#[inline]
pub(super) fn has(set: Lanes, lane: u32) -> bool {
    (set >> lane) & 1 == 1
}

/// The lanes of the set, ascending.
#[inline]
pub(super) fn each(mut set: Lanes) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let lane = (set != 0).then(|| set.trailing_zeros());
        set &= set.wrapping_sub(1);
        lane
    })
}
