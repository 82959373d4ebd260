//! The controller: how far to draw in full detail so that frames take as long as they should.
//!
//! [`step`] takes the last frame time to the next `far_dist`. It is pure: it sees no clock, no
//! tree and no view, and all it remembers is in a [`State`] that can travel as JSON.
//!
//! # The plant
//!
//! A frame drawn with `far_dist` D takes T = c + a·D^p. The exponent p is near 2, as a disc grows
//! (Gong, section 2.3), and taken to lie in \[1, 3\]; c, at most half the target, is what a frame
//! takes whatever is drawn. None of the three is known, and all of them drift as the camera flies.
//!
//! # The law
//!
//! 1. *Explain.* For a row of values of c the last samples are fitted by ln(T − c) = ln a + p ln D.
//!    Those that explain them about as well as the best one stay plausible (`family`). A sample
//!    carries the `far_dist` that it was drawn with, so it says the same whenever it arrives: the
//!    delay of a pipeline does not enter.
//! 2. *Doubt.* A frame time that no plausible plant explains is not used until the next one
//!    agrees with it. Then the load has changed, and what was learnt before is forgotten. So a
//!    single slow frame moves nothing, and a lasting change costs one frame.
//! 3. *Aim.* The next `far_dist` is the mean of what the plausible plants say meets the target,
//!    but no farther than where the steepest of them would pass it by 8 %.
//!
//! # Why it is stable
//!
//! Without noise, and as long as the true plant stays plausible, rule 3 keeps the frame time from
//! passing the target by more than 8 %. With a delay of three frames it does not always stay so:
//! of a thousand plants in experiment `controller` one passes the target by 10.8 %. With e the elasticity
//! dlnT/dlnD of the plant between the sample and the target, and ê that of the estimate, a sample
//! that lies ξ = ln(D/D*) off is answered by one that lies (1 − e/ê)·ξ off. As ê lies between e/2
//! and what is plausible, that is nearer, and no matter which of the last frames it is worked out
//! from: the largest error among the frames under way shrinks, which is the condition for
//! convergence under a bounded delay. This is a sketch, not a proof. Nothing is summed up, so nothing winds up at a limit.
//!
//! Under noise what the samples do not tell is filled in by a prior, p = 2 ± 1, and the fit averages
//! about eight frames; at rest `far_dist` does not move enough for its own jitter to be taken for
//! evidence.
//!
//! Sources: weighing many models of a plant by how well each explains what was seen is Magill,
//! "Optimal adaptive estimation of sampled stochastic processes", 1965; stepping with what is not
//! known in mind, Åström and Wittenmark, "Adaptive Control", chapter on dual control; convergence
//! under delays, Bertsekas and Tsitsiklis, "Parallel and Distributed Computation", section 6.2;
//! why reacting to the last frame alone swings, Funkhouser and Séquin, "Adaptive display
//! algorithm for interactive frame rates", 1993.

mod curve;
mod family;
mod law;
mod member;
mod params;
mod plant;
mod state;

pub use law::step;
pub use params::{Params, ParamsError};
pub use state::{Sample, State};
