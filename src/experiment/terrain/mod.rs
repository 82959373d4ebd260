//! The ground: what the criteria of four papers cost and give, side by side.

mod cracks;
mod criteria;
mod interpolation;
mod measured;
mod memory;
mod motion;
mod parallel;
mod place;
mod roam;
mod store;
mod supply;

pub(super) use cracks::run as cracks;
pub(super) use criteria::run as criteria;
pub(super) use interpolation::run as interpolation;
pub(super) use motion::run as motion;
pub(super) use parallel::run as parallel;
pub(super) use store::run as store;
