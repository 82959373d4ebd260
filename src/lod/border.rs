//! Objects of about the size that is asked for: which of them are the largest.
//!
//! A walk lists here what is neither surely large enough nor too small, with radius and distance
//! in f32, and counts it by size. The counts tell between which two sizes the last one wanted
//! lies: those certainly larger are taken, those certainly smaller are not, and only the few of
//! which f32 is not certain are decided in f64. Where that leaves a doubt, all are.

use std::cmp::Ordering;

use super::lanes;
use crate::geom::{Aabb, EightDistances, Filter, Floats, Lanes, PixelScale, SizeThreshold, View};

/// Sizes told apart.
const BUCKETS: usize = 512;

/// Objects that may be wanted, in the order of their numbers.
#[derive(Debug, Clone, Default)]
pub(super) struct Border {
    listed: Vec<Listed>,
    /// How many there are of each size: of squared radius by squared distance, as bits from
    /// `lowest` on.
    counts: Vec<u32>,
    lowest: u32,
    bits: u32,
    /// Pixels of a radius as large as the distance.
    scale: f64,
    perspective: bool,
    /// Those taken by f32, in the order of their numbers.
    taken: Vec<u32>,
    /// Those taken that were decided in f64, in the order of their numbers.
    decided: Vec<SizedObject>,
}

#[derive(Debug, Clone, Copy)]
struct Listed {
    /// Rounded up, m.
    radius: f32,
    squared_distance: f32,
    object: u32,
}

/// An object of the frustum and its size, pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct SizedObject {
    pub(super) size: f64,
    pub(super) object: u32,
}

impl SizedObject {
    /// The larger first, of equals the one with the lower number.
    pub(super) fn order(&self, other: &Self) -> Ordering {
        let sizes = other.size.total_cmp(&self.size);
        sizes.then(self.object.cmp(&other.object))
    }
}

/// Where the objects taken end, pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cut {
    /// None taken is smaller.
    pub(super) smallest: f64,
    /// The largest that is not taken; none where all are.
    pub(super) left: Option<f64>,
}

impl Border {
    /// Forgets the objects; those to come have about these sizes, pixels.
    pub(super) fn clear(&mut self, view: &View, sizes: std::ops::Range<f64>) {
        let (perspective, scale) = match view.pixels() {
            PixelScale::PerRadian(scale) => (true, scale),
            PixelScale::PerMetre(scale) => (false, scale),
        };
        self.scale = 2.0 * scale;
        self.perspective = perspective;
        let bits = |px: f64| {
            let ratio = px / self.scale;
            ((ratio * ratio) as f32).to_bits()
        };
        self.lowest = bits(sizes.start);
        let width = bits(sizes.end).saturating_sub(self.lowest);
        let buckets = BUCKETS as u32 - 1;
        self.bits = (width / buckets + 1).next_power_of_two().trailing_zeros();
        self.listed.clear();
        self.counts.clear();
        self.counts.resize(BUCKETS, 0);
    }

    pub(super) fn len(&self) -> usize {
        self.listed.len()
    }

    /// Adds those of eight objects that are in `set`, counted from `first`.
    #[inline(always)]
    pub(super) fn push<F: Floats>(
        &mut self,
        first: u32,
        set: Lanes,
        radii: F,
        distances: &EightDistances<F>,
    ) {
        let distances = if self.perspective {
            distances.squared()
        } else {
            F::splat(1.0)
        };
        let sizes = (radii * radii / distances).to_array();
        let (radii, distances) = (radii.to_array(), distances.to_array());
        for lane in lanes::each(set) {
            let at = lane as usize & 7;
            let bucket = sizes[at].to_bits().saturating_sub(self.lowest) >> self.bits;
            self.counts[(bucket as usize).min(BUCKETS - 1)] += 1;
            self.listed.push(Listed {
                radius: radii[at],
                squared_distance: distances[at],
                object: first + lane,
            });
        }
    }

    /// Takes the `most` largest, of equals those with the lower number; all where there are fewer.
    /// `sizes` are those that must be told from others, pixels.
    pub(super) fn take(
        &mut self,
        filter: &Filter,
        view: &View,
        boxes: &[[f64; 6]],
        most: usize,
        sizes: std::ops::Range<f64>,
    ) -> Cut {
        // The last that is taken and the first that is left, so that both are known exactly.
        let last = self.bucket_of(most);
        let next = self.bucket_of(most.saturating_add(1));
        let around = next.start.min(sizes.end)..last.end.max(sizes.start);
        let tried = self.take_around(filter, view, boxes, most, &around);
        tried.unwrap_or_else(|| {
            // Now everything is decided in f64.
            let all = self.take_around(filter, view, boxes, most, &(0.0..f64::INFINITY));
            all.unwrap_or(Cut {
                smallest: f64::INFINITY,
                left: None,
            })
        })
    }

    /// The sizes between which the one of this rank lies, about, pixels.
    fn bucket_of(&self, rank: usize) -> std::ops::Range<f64> {
        let mut seen = 0;
        let bucket = (0..BUCKETS).rev().find(|&bucket| {
            seen += self.counts[bucket] as usize;
            seen >= rank
        });
        let bucket = bucket.unwrap_or(0) as u32;
        let px = |bucket: u32| {
            let squared = f32::from_bits(self.lowest.saturating_add(bucket << self.bits));
            f64::from(squared).sqrt() * self.scale
        };
        // The first bucket and the last hold whatever lies beyond, too.
        let start = if bucket == 0 { 0.0 } else { px(bucket) };
        let end = px(bucket + 1);
        if bucket + 1 == BUCKETS as u32 || end.is_nan() {
            start..f64::INFINITY
        } else {
            start..end
        }
    }

    /// Takes those certainly larger than `around`, and of those not certainly smaller as many as
    /// are missing. `None` where the outcome may be another.
    fn take_around(
        &mut self,
        filter: &Filter,
        view: &View,
        boxes: &[[f64; 6]],
        most: usize,
        around: &std::ops::Range<f64>,
    ) -> Option<Cut> {
        let threshold = |px| SizeThreshold::new(filter, view.pixels(), px);
        let (low, high) = (threshold(around.start), threshold(around.end));
        self.taken.resize(self.listed.len(), 0);
        self.decided.clear();
        let mut taken = 0;
        for &Listed {
            radius,
            squared_distance,
            object,
        } in &self.listed
        {
            // Nobody can foresee which are large enough: written down in any case, and written
            // over where it is not one of them.
            let is_taken = high.is_reached(radius, squared_distance);
            self.taken[taken] = object;
            taken += usize::from(is_taken);
            if !is_taken & !low.is_missed(radius, squared_distance) {
                // Without a box only in a damaged file.
                let exact = Aabb::nth(boxes, object);
                let size = exact.map_or(0.0, |exact| view.size_px(&exact));
                self.decided.push(SizedObject { size, object });
            }
        }
        self.taken.truncate(taken);
        let missing = most.checked_sub(taken)?;
        let smaller = self.listed.len() - self.taken.len() - self.decided.len();
        let mut left = None;
        if missing < self.decided.len() {
            let (_, first, _) = self
                .decided
                .select_nth_unstable_by(missing, SizedObject::order);
            left = Some(first.size);
            self.decided.truncate(missing);
        } else if smaller > 0 {
            return None;
        }
        let sizes = self.decided.iter().map(|sized| sized.size);
        let doubtful = sizes.reduce(f64::min);
        let certain = (taken == 0 || left.is_none_or(|px| px < around.end))
            && (smaller == 0 || left.is_some_and(|px| px >= around.start));
        self.decided.sort_unstable_by_key(|sized| sized.object);
        certain.then(|| Cut {
            smallest: doubtful.unwrap_or(around.end),
            left,
        })
    }

    /// The objects taken last, ascending.
    pub(super) fn taken(&self) -> impl Iterator<Item = u32> {
        let mut taken = self.taken.iter().copied().peekable();
        let mut decided = self.decided.iter().map(|sized| sized.object).peekable();
        std::iter::from_fn(move || match (taken.peek(), decided.peek()) {
            (Some(a), Some(b)) if b < a => decided.next(),
            (None, _) => decided.next(),
            _ => taken.next(),
        })
    }
}
