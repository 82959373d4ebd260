//! What a view cannot be.

use super::DVec3;

/// A view that cannot be: which field is wrong, and why. Field names are those of the JSON form.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{field}: {reason}")]
pub struct ViewError {
    /// The field at fault.
    pub field: &'static str,
    /// What is wrong with it.
    pub reason: String,
}

impl ViewError {
    pub(super) fn new(field: &'static str, reason: impl Into<String>) -> Self {
        Self {
            field,
            reason: reason.into(),
        }
    }
}

pub(super) fn finite(field: &'static str, v: DVec3) -> Result<(), ViewError> {
    if v.is_finite() {
        Ok(())
    } else {
        Err(ViewError::new(field, format!("must be finite, is {v}")))
    }
}

pub(super) fn ordered(field: &'static str, low: f64, high: f64) -> Result<(), ViewError> {
    if low.is_finite() && high.is_finite() && low < high {
        Ok(())
    } else {
        Err(ViewError::new(
            field,
            format!("must be less than the opposite border, is {low} against {high}"),
        ))
    }
}

pub(super) fn aspect([width, height]: [u32; 2]) -> Result<f64, ViewError> {
    if width == 0 || height == 0 {
        return Err(ViewError::new(
            "viewport",
            format!("must be at least one pixel each way, is {width}x{height}"),
        ));
    }
    Ok(f64::from(width) / f64::from(height))
}

pub(super) fn direction(field: &'static str, v: DVec3) -> Result<DVec3, ViewError> {
    finite(field, v)?;
    // Scaled first, so that neither tiny nor huge vectors under- or overflow.
    let largest = v.abs().max_element();
    if largest == 0.0 {
        return Err(ViewError::new(
            field,
            "has no direction: its length is zero",
        ));
    }
    let scaled = v / largest;
    Ok(scaled / scaled.length())
}
