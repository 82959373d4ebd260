//! The controller: how far to draw in full detail so that frames take as long as they should.
//!
//! [`step`] takes the last frame time to the next `far_dist`. It is pure: it sees no clock, no
//! tree and no view, and all it remembers is in a [`State`] that can travel as JSON.

mod law;
mod params;
mod state;

pub use law::step;
pub use params::{Params, ParamsError};
pub use state::{Sample, State};
