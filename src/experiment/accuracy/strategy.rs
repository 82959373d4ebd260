//! Ways to choose objects.

use serde::Serialize;

/// A way to choose objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Strategy {
    /// By distance, districts represented by their tallest object.
    RangeTallest,
    /// The same by the one of the largest footprint.
    RangeFootprint,
    /// Of a size or larger.
    Error,
    /// So many of the largest.
    Budget,
    /// The same as error mode without a tree: every object is looked at.
    Oracle,
    /// Any objects of the frustum.
    Random,
    /// Objects of a radius or larger at whatever distance, without a tree.
    GlobalSize,
}

impl Strategy {
    pub(super) const ALL: [Self; 7] = [
        Self::RangeTallest,
        Self::RangeFootprint,
        Self::Error,
        Self::Budget,
        Self::Oracle,
        Self::Random,
        Self::GlobalSize,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::RangeTallest => "range-tallest",
            Self::RangeFootprint => "range-footprint",
            Self::Error => "error",
            Self::Budget => "budget",
            Self::Oracle => "oracle",
            Self::Random => "random",
            Self::GlobalSize => "global-size",
        }
    }

    /// Whether it is none of the modes, but what they are held against.
    pub(super) fn is_reference(self) -> bool {
        matches!(self, Self::Oracle | Self::Random | Self::GlobalSize)
    }

    /// What its parameter is.
    pub(super) fn knob(self) -> &'static str {
        match self {
            Self::RangeTallest | Self::RangeFootprint => "far_dist_m",
            Self::Error | Self::Oracle => "max_error_px",
            Self::Budget | Self::Random => "max_objects",
            Self::GlobalSize => "least_radius_m",
        }
    }
}
