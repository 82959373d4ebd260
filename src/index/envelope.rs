//! The envelope that carries a representative along with the box.

use rstar::{AABB, Envelope, Point, RTreeObject};

use crate::geom::{Aabb, DVec3};

/// An object that may stand for others.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate<K> {
    /// What the promotion rule says of it: the higher, the better.
    pub score: f64,
    /// Its id; ties go to the lower one.
    pub key: K,
}

impl<K: Ord> Candidate<K> {
    /// Whether this one stands for both.
    fn beats(&self, other: &Self) -> bool {
        self.score
            .total_cmp(&other.score)
            .then_with(|| other.key.cmp(&self.key))
            .is_gt()
    }
}

/// Box + best representative; `merge` = union + the better of the two.
///
/// As an `rstar` envelope it keeps every node's representative right through bulk load, insertion
/// and removal, with no code beside `merge`: rstar asks for nothing else when a node changes.
#[derive(Debug, Clone, PartialEq)]
pub struct LodEnvelope<K> {
    bounds: AABB<[f64; 3]>,
    best: Option<Candidate<K>>,
}

impl<K: Ord + Clone> LodEnvelope<K> {
    /// The envelope of one object.
    pub fn of(bounds: &Aabb, best: Candidate<K>) -> Self {
        Self {
            bounds: AABB::from_corners(bounds.min().to_array(), bounds.max().to_array()),
            best: Some(best),
        }
    }

    /// Around nothing, represented by nothing.
    pub fn nothing() -> Self {
        Self {
            bounds: AABB::new_empty(),
            best: None,
        }
    }

    /// Grows to cover `other`; the better representative stays.
    pub fn absorb(&mut self, other: &Self) {
        self.bounds.merge(&other.bounds);
        if let Some(candidate) = &other.best
            && self.best.as_ref().is_none_or(|best| candidate.beats(best))
        {
            self.best = Some(candidate.clone());
        }
    }

    /// Lower and upper corner; lower above upper for nothing.
    pub fn corners(&self) -> (DVec3, DVec3) {
        (self.bounds.lower().into(), self.bounds.upper().into())
    }

    /// The same with the representative under another key of the same order.
    pub fn map_key<L>(&self, map: impl Fn(&K) -> L) -> LodEnvelope<L> {
        LodEnvelope {
            bounds: self.bounds,
            best: self.best.as_ref().map(|best| Candidate {
                score: best.score,
                key: map(&best.key),
            }),
        }
    }

    /// The best representative of all that was merged.
    pub fn best(&self) -> Option<&Candidate<K>> {
        self.best.as_ref()
    }
}

impl<K: Ord + Clone + std::fmt::Debug> Envelope for LodEnvelope<K> {
    type Point = [f64; 3];

    fn new_empty() -> Self {
        Self::nothing()
    }

    fn contains_point(&self, point: &[f64; 3]) -> bool {
        self.bounds.contains_point(point)
    }

    fn contains_envelope(&self, other: &Self) -> bool {
        self.bounds.contains_envelope(&other.bounds)
    }

    fn merge(&mut self, other: &Self) {
        self.absorb(other);
    }

    fn merged(&self, other: &Self) -> Self {
        let mut merged = self.clone();
        merged.absorb(other);
        merged
    }

    fn intersects(&self, other: &Self) -> bool {
        self.bounds.intersects(&other.bounds)
    }

    fn intersection_area(&self, other: &Self) -> f64 {
        self.bounds.intersection_area(&other.bounds)
    }

    fn area(&self) -> f64 {
        self.bounds.area()
    }

    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        self.bounds.distance_2(point)
    }

    fn min_max_dist_2(&self, point: &[f64; 3]) -> f64 {
        self.bounds.min_max_dist_2(point)
    }

    fn center(&self) -> [f64; 3] {
        self.bounds.center()
    }

    fn perimeter_value(&self) -> f64 {
        self.bounds.perimeter_value()
    }

    fn sort_envelopes<T: RTreeObject<Envelope = Self>>(axis: usize, envelopes: &mut [T]) {
        envelopes.sort_by(|a, b| {
            let lower = |t: &T| t.envelope().bounds.lower().nth(axis);
            lower(a).total_cmp(&lower(b))
        });
    }

    /// Cities are flat: where rstar would split along z, this splits along the wider of x and y.
    fn partition_envelopes<T: RTreeObject<Envelope = Self>>(
        axis: usize,
        envelopes: &mut [T],
        selection_size: usize,
    ) {
        let axis = if axis == 2 {
            wider_of_x_and_y(envelopes)
        } else {
            axis
        };
        envelopes.select_nth_unstable_by(selection_size, |a, b| {
            let center = |t: &T| t.envelope().bounds.center().nth(axis);
            center(a).total_cmp(&center(b))
        });
    }
}

fn wider_of_x_and_y<K, T>(envelopes: &[T]) -> usize
where
    K: Ord + Clone + std::fmt::Debug,
    T: RTreeObject<Envelope = LodEnvelope<K>>,
{
    let mut all = AABB::new_empty();
    for envelope in envelopes {
        all.merge(&AABB::from_point(envelope.envelope().bounds.center()));
    }
    usize::from(all.upper()[1] - all.lower()[1] > all.upper()[0] - all.lower()[0])
}
