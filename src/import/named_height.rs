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

    /// Whether no feature had it yet, so that it is worth a look what they have instead.
    pub(super) fn is_sought(&self) -> bool {
        !self.is_found
    }

    /// A feature has these properties instead.
    pub(super) fn miss(&mut self, names: impl Iterator<Item = CompactString>) {
        self.is_missed = true;
        let room = MOST_NAMES.saturating_sub(self.others.len());
        self.others.extend(names.take(room));
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
