//! What was typed → one call.

pub mod glb;
