//! From what a feature says of its height to where it begins and ends.

use super::properties::{Height, Properties};

/// What is said of a feature that does not say how high it is.
pub(super) const KEPT_FLAT: &str = "no height; kept flat";
/// The same in a few words.
pub(super) const NO_HEIGHT: &str = "no height";

/// How high a footprint rises, m.
#[derive(Debug)]
pub(super) struct Rise {
    pub(super) base: f64,
    pub(super) top: f64,
    /// How far above its ground the base is.
    pub(super) lift: f64,
    /// It says something of its height.
    pub(super) has_height: bool,
    pub(super) is_extruded: bool,
    /// Why it is flat, where it should not be.
    pub(super) flat_for: Option<&'static str>,
}

impl Rise {
    /// Of a feature whose positions lie between `ground` and `highest`. What is wrong with its
    /// properties is put to the `problems`.
    pub(super) fn of(
        properties: &Properties,
        named: Option<&str>,
        [ground, highest]: [f64; 2],
        problems: &mut Vec<String>,
    ) -> Self {
        let height = properties.height(named);
        let has_height = height != Height::Missing;
        let is_extruded = matches!(height, Height::Metres(m) if m > 0.0);
        let lift = if is_extruded && highest <= ground {
            lift(properties, problems)
        } else {
            0.0
        };
        let base = ground + lift;
        let mut flat_for = None;
        let top = match height {
            Height::Metres(height) if lift > 0.0 && height <= lift => {
                problems.push(format!(
                    "it begins {lift} m above the ground and its height is {height} m; taken to be {height} m from there"
                ));
                base + height
            }
            Height::Metres(height) => {
                let is_flat = height <= 0.0 && highest <= ground;
                flat_for = is_flat.then_some("a height of 0");
                highest.max(ground + height)
            }
            // The positions themselves tell how high it is.
            _ if highest > ground => highest,
            Height::Missing => {
                flat_for = Some(NO_HEIGHT);
                problems.push(KEPT_FLAT.into());
                ground
            }
            Height::Unusable(name, value) => {
                flat_for = Some("a height that is none");
                problems.push(format!("{name} is {value}, which is no height; kept flat"));
                ground
            }
        };
        Self {
            base,
            top,
            lift,
            has_height,
            is_extruded,
            flat_for,
        }
    }
}

/// How far above the ground it begins, m.
fn lift(properties: &Properties, problems: &mut Vec<String>) -> f64 {
    match properties.min_height() {
        Height::Metres(lift) => lift,
        Height::Missing => 0.0,
        Height::Unusable(name, value) => {
            problems.push(format!(
                "{name} is {value}, which is no height; begins at the ground"
            ));
            0.0
        }
    }
}
