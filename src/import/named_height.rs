//! The property that the caller names for heights, and whether any feature has it.

use std::collections::BTreeSet;

use compact_str::CompactString;

use super::ImportError;
use super::classes::listed;

/// Names that are kept of properties that features have instead.
const MOST_NAMES: usize = 1000;

/// What is known so far.
#[derive(Debug, Default)]
pub(super) struct NamedHeight {
    is_missed: bool,
    is_found: bool,
    others: BTreeSet<CompactString>,
}

impl NamedHeight {
    /// A feature has it.
    pub(super) fn find(&mut self) {
        self.is_found = true;
    }

    /// Whether no feature had it yet and there is room for what they have instead, so that it is
    /// worth a look.
    pub(super) fn is_sought(&self) -> bool {
        !self.is_found && self.has_room()
    }

    fn has_room(&self) -> bool {
        self.others.len() < MOST_NAMES
    }

    /// A feature has these properties instead.
    pub(super) fn miss(&mut self, names: impl Iterator<Item = CompactString>) {
        self.is_missed = true;
        for name in names {
            if self.has_room() {
                self.others.insert(name);
            }
        }
    }

    /// # Errors
    /// [`ImportError::NoSuchHeight`] where there are features, and none has it.
    pub(super) fn check(&self, name: Option<&str>) -> Result<(), ImportError> {
        match name {
            Some(name) if self.is_missed && !self.is_found => Err(ImportError::NoSuchHeight {
                name: name.to_owned(),
                found: if self.others.is_empty() {
                    "none at all".to_owned()
                } else {
                    listed(&self.others)
                },
            }),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use compact_str::format_compact;

    use super::{MOST_NAMES, NamedHeight};

    #[test]
    fn a_full_list_asks_for_no_more_names() {
        let mut height = NamedHeight::default();
        // Each feature has one property of its own behind one that all have.
        for feature in 0..MOST_NAMES - 1 {
            assert!(height.is_sought(), "{feature}");
            height.miss(["a".into(), format_compact!("b{feature}")].into_iter());
        }
        assert!(!height.is_sought());
        assert!(height.check(Some("h")).is_err());
        height.find();
        assert!(height.check(Some("h")).is_ok());
    }
}
