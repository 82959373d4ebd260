//! Where among the sizes of a view the n-th largest lies: a search by attempts.
//!
//! The number of objects of at least a size p grows about like p^−s as p falls: s is near 2 where
//! a city is flat and wide, and differs from view to view. So each attempt tells where the next
//! one should look: the secant method on logarithms.
//!
//! The answer does not depend on where the search looks, only the time it takes does.

use super::sweep::Wanted;

/// A size in pixels, and how many objects of a view are at least as large.
#[derive(Debug, Clone, Copy)]
struct Found {
    px: f64,
    count: u32,
}

/// What keeps an attempt from being the last.
#[derive(Debug, Clone, Copy)]
pub(super) enum Miss {
    /// So many objects are at least as large as [`Wanted::sure`]: more than are wanted.
    Many {
        /// How many.
        sure: u32,
    },
    /// So many are at least as large as [`Wanted::least`]: no more than are wanted, so that the
    /// largest left is not known.
    Few {
        /// How many.
        found: u32,
    },
}

/// Where the n-th largest object is known to lie.
#[derive(Debug)]
pub(super) struct Search {
    rank: u32,
    attempts: u32,
    /// Sizes that too few objects have, the smallest of them last, with one known before it.
    few: [Found; 2],
    /// The largest size known that too many have.
    many: Option<Found>,
    /// Where the next attempt looks, and how far to either side of it, as a ratio.
    next: f64,
    width: f64,
}

/// The least ratio looked at to either side in a second attempt; each further one takes the square
/// of what it would be, so that there are but a few.
const CLOSEST: f64 = 1.01;
/// A number that is off by a factor f tells a size that strays by f to this power.
const STRAY: f64 = 0.12;
/// How far to look from a size already known, where the guess lies beyond it.
const CLAMPED: f64 = 1.1;
/// Where to go on from infinity, pixels.
const LARGEST: f64 = 1e6;
/// After so many attempts all that is left is listed.
const PATIENCE: u32 = 5;

impl Search {
    /// For the `rank`-th largest object, which should be within a ratio of `width` of `px`.
    pub(super) fn new(rank: u32, px: f64, width: f64) -> Self {
        Self {
            rank,
            attempts: 0,
            few: [Found {
                px: f64::INFINITY,
                count: 0,
            }; 2],
            many: None,
            next: px,
            width,
        }
    }

    /// The two sizes between which it is looked for next.
    pub(super) fn wanted(&self) -> Wanted {
        let many = self.many.map_or(0.0, |many| many.px);
        if self.attempts >= PATIENCE {
            return Wanted {
                sure: self.few[1].px,
                least: many,
            };
        }
        Wanted {
            sure: (self.next * self.width).min(self.few[1].px),
            least: (self.next / self.width).max(many),
        }
    }

    /// Takes an attempt into account. Returns whether the search goes on: not after all was
    /// listed, as in a damaged file numbers may contradict each other.
    pub(super) fn goes_on(&mut self, wanted: Wanted, missed: Miss) -> bool {
        let listed = self.attempts >= PATIENCE;
        self.attempts += 1;
        match missed {
            Miss::Many { sure } => {
                let many = Found {
                    px: wanted.sure,
                    count: sure,
                };
                self.many = Some(many);
                let few = self.few[1];
                self.guess(many, slope(few, many));
            }
            Miss::Few { found } => {
                let few = Found {
                    px: wanted.least,
                    count: found,
                };
                self.few = [self.few[1], few];
                let [before, few] = self.few;
                self.guess(few, slope(before, few));
            }
        }
        !listed
    }

    /// Looks next where the number should be `rank`, if from `known` on it grows with this slope.
    fn guess(&mut self, known: Found, slope: f64) {
        let rank = f64::from(self.rank.max(1));
        let factor = rank / f64::from(known.count.max(1));
        let off = factor.max(1.0 / factor);
        let unlucky = f64::from(1 << self.attempts.min(PATIENCE));
        self.width = (off.powf(STRAY).max(CLOSEST) + 2.0 / rank).powf(unlucky / 2.0);
        let px = known.px.min(LARGEST) * factor.powf(-1.0 / slope);
        let least = self.many.map_or(0.0, |many| many.px);
        self.next = px.max(least).min(self.few[1].px);
        if self.next != px {
            self.width = self.width.max(CLAMPED);
        }
        if px == 0.0 {
            self.attempts = PATIENCE; // from there no factor leads anywhere
        }
    }
}

/// How fast numbers grow as sizes fall, as far as two of them tell.
fn slope(few: Found, many: Found) -> f64 {
    let ratio = f64::from(many.count.max(1)) / f64::from(few.count.max(1));
    let slope = ratio.ln() / (few.px / many.px).ln();
    if few.count > 0 && slope.is_finite() {
        slope.clamp(1.0, 4.0)
    } else {
        2.0
    }
}
