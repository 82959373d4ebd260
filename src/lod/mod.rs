//! Which objects a view calls for: the seven-step retrieval of Gong et al. over a packed tree.
//!
//! `retrieve(tree, view, lod, &mut selection)`: what is asked, the knobs, and the answer with its
//! statistics are three types. Retrieval is total: it cannot fail.
//!
//! Knows nothing of the controller, of files or of HTTP.

mod border;
mod budget;
mod descent;
mod difference;
mod error;
mod gather;
mod lanes;
mod mode;
mod near;
mod omitted;
mod range;
mod ranges;
mod retrieve;
mod search;
mod selection;
mod settle;
mod sight;
mod sizing;
mod survey;
mod sweep;

pub use budget::{BudgetLod, keep_largest};
pub use difference::difference;
pub use error::ErrorLod;
pub use mode::{Lod, select};
pub use range::{Beyond, LodError, RangeLod};
pub use retrieve::retrieve;
pub use selection::{Selection, Stats};
