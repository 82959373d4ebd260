//! Gong's three parameters and the ranges they give to levels.

use serde::{Deserialize, Serialize};

/// What happens past the last level's far distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Beyond {
    /// The last level reaches to infinity: every district keeps its representatives.
    #[default]
    Show,
    /// Nothing is drawn there.
    Hide,
}

/// Knobs of range mode (Gong, section 2.1): level 0 is drawn over [0, `far_dist`), level k over
/// [`far_dist`·f^(k−1), `far_dist`·f^k).
///
/// The objects drawn grow with `far_dist`². √4 < `dist_factor` < √9 keeps their number stable
/// from view to view; a larger factor draws more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeLod {
    far_dist: f64,
    dist_factor: f64,
    level_count: u32,
    beyond: Beyond,
}

/// A knob out of its range; field names are those of the JSON form.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{field}: {reason}")]
pub struct LodError {
    /// The field at fault.
    pub field: &'static str,
    /// What is wrong with it.
    pub reason: String,
}

impl Default for RangeLod {
    fn default() -> Self {
        Self {
            far_dist: 500.0,
            dist_factor: 2.5,
            level_count: 4,
            beyond: Beyond::Show,
        }
    }
}

impl RangeLod {
    /// `far_dist` in metres, 0 to infinity; `dist_factor` at least 1, finite; `level_count` at
    /// least 1.
    ///
    /// # Errors
    /// [`LodError`] naming the knob that is out of range.
    pub fn new(
        far_dist: f64,
        dist_factor: f64,
        level_count: u32,
        beyond: Beyond,
    ) -> Result<Self, LodError> {
        let error = |field, reason| Err(LodError { field, reason });
        if far_dist.is_nan() || far_dist < 0.0 {
            return error("far_dist_m", format!("must be 0 or more, is {far_dist}"));
        }
        if !(dist_factor >= 1.0 && dist_factor.is_finite()) {
            let reason = format!("must be 1 or more and finite, is {dist_factor}");
            return error("dist_factor", reason);
        }
        if level_count == 0 {
            return error("levels", "must be 1 or more, is 0".into());
        }
        Ok(Self {
            far_dist: far_dist + 0.0,
            dist_factor,
            level_count,
            beyond,
        })
    }

    /// Every object of the frustum: the finest level reaches to infinity.
    pub fn full_detail() -> Self {
        Self {
            far_dist: f64::INFINITY,
            level_count: 1,
            ..Self::default()
        }
    }

    /// The same with another far distance, m; 0 for what is negative or no number.
    #[must_use]
    pub fn with_far_dist(self, far_dist: f64) -> Self {
        Self {
            far_dist: far_dist.max(0.0) + 0.0,
            ..self
        }
    }

    pub(super) fn coarsened(self, factor: f64) -> Self {
        Self {
            far_dist: self.far_dist / factor,
            ..self
        }
    }

    /// Farthest distance of the finest level, m.
    pub fn far_dist(&self) -> f64 {
        self.far_dist
    }

    /// Ratio of the far distances of neighbouring levels.
    pub fn dist_factor(&self) -> f64 {
        self.dist_factor
    }

    /// Levels that have a range.
    pub fn level_count(&self) -> u32 {
        self.level_count
    }

    /// What happens past the last of them.
    pub fn beyond(&self) -> Beyond {
        self.beyond
    }

    /// Far distance of each level that has a range in a tree of `tree_levels`, level 0 first.
    /// Where the tree has fewer levels than asked for, its root is the last.
    pub(super) fn far_dists(&self, tree_levels: u32) -> impl Iterator<Item = f64> {
        let levels = self.level_count.min(tree_levels);
        let Self {
            far_dist,
            dist_factor,
            beyond,
            ..
        } = *self;
        // Step by step: 0·∞ cannot come up.
        let steps = std::iter::successors(Some(far_dist), move |far| Some(far * dist_factor));
        (0..levels).zip(steps).map(move |(level, far)| {
            if beyond == Beyond::Show && level + 1 == levels {
                f64::INFINITY
            } else {
                far
            }
        })
    }
}
