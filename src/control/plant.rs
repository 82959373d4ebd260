//! What is known of T = c + a·D^p before any frame; times in parts of the target.

/// Exponents of any city.
pub(super) const EXPONENTS: [f64; 2] = [1.0, 3.0];
/// The usual exponent, as a disc grows (Gong, section 2.3), and its standard deviation.
pub(super) const USUAL_EXPONENT: [f64; 2] = [2.0, 1.0];
/// Largest c.
pub(super) const LARGEST_BASE: f64 = 0.5;
/// Usual c, and its standard deviation.
pub(super) const USUAL_BASE: [f64; 2] = [0.25, 0.15];
