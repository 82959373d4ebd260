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
//! A sample carries the `far_dist` that it was drawn with, so it says the same whenever it
//! arrives: the delay of a pipeline need not be known.
//!
//! # The law
//!
//! 1. *One plant.* Where one plant goes through all frames remembered, drawn at five distances or
//!    more, frame times do not scatter, and the next frame is drawn where that plant meets the
//!    target (`curve`). Frames on their way are drawn at distances a little apart, so that these
//!    five are soon together.
//! 2. *All plausible plants.* Else, for each of a row of exponents, c and a are fitted to the last
//!    frames by least squares, and what explains them about as well as the best stays plausible
//!    (`member`, `family`). The aim is the mean of where these meet the target, but no farther
//!    than where the band of two standard deviations around any of them passes it by 8 %. The
//!    curves are laid through the middle of the frames, not their mean: frame times have a floor
//!    and a long tail, and it is the median that is to be held.
//! 3. *Doubt.* A frame time that no plausible plant explains is not used until the next one
//!    agrees with it. Then the load has changed, and what was learnt before is forgotten. So a
//!    single slow frame moves nothing, and a lasting change costs one frame.
//!
//! # Why it is stable
//!
//! *Without scatter.* With a delay of d frames the first that knows anything is frame d + 1. This
//! and the three after it are drawn at four new distances, inside the band; frame 2d + 5 is the
//! first that knows them all, and it meets the target: rule 1. That is two frames after the least
//! possible. Three unknowns need three distances, and as who knows nothing rests, frames 0 to d
//! are drawn at one; the third is drawn by frame d + 2 at the earliest and known to frame 2d + 3.
//! So 12 frames and the delay suffice up to a delay of 7. Until then the band bounds how far the
//! target is passed; that this is always less than 10 % is tested, not proved.
//!
//! *With scatter.* With e the elasticity dlnT/dlnD of the plant between a sample and the target,
//! and ê that of the estimate, a sample that lies ξ = ln(D/D*) off is answered by one that lies
//! (1 − e/ê)·ξ off. As ê lies between e/2 and what is plausible, that is nearer, no matter which of
//! the last frames it is worked out from: the largest error among the frames under way shrinks,
//! which is the condition for convergence under a bounded delay. This is a sketch, not a proof.
//! Nothing is summed up, so nothing winds up at a limit.
//!
//! What the samples do not tell is filled in by what is usual, p = 2 ± 1 and c = ¼ ± 0.15; at rest
//! `far_dist` does not move enough for its own jitter to be taken for evidence. The least scatter
//! beyond rounding switches rule 1 off: from a start that is off by hundreds of times and with
//! several frames of delay it then takes longer than 12 frames.
//!
//! Sources: weighing many models of a plant by how well each explains what was seen is Magill,
//! "Optimal adaptive estimation of sampled stochastic processes", 1965; stepping with what is not
//! known in mind, and drawing apart in order to learn, Åström and Wittenmark, "Adaptive Control",
//! chapter on dual control; the mean of the middle, Huber, "Robust Statistics", on L-estimates;
//! convergence under delays, Bertsekas and Tsitsiklis, "Parallel and Distributed Computation",
//! section 6.2; why reacting to the last frame alone swings, Funkhouser and Séquin, "Adaptive
//! display algorithm for interactive frame rates", 1993.

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
