//! Which kinds of object are taken over.

use std::collections::BTreeSet;

use compact_str::CompactString;

use super::ImportError;

/// A choice among the classes of objects, by their names as the files spell them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Classes {
    /// Objects of every class.
    #[default]
    All,
    /// Only objects of these.
    Only(Vec<String>),
    /// All but objects of these.
    Except(Vec<String>),
}

impl Classes {
    /// Whether objects of this class are taken.
    pub(super) fn take(&self, class: &str) -> bool {
        match self {
            Self::All => true,
            Self::Only(names) => names.iter().any(|name| name == class),
            Self::Except(names) => names.iter().all(|name| name != class),
        }
    }

    /// # Errors
    /// [`ImportError::NoSuchClass`] for a class that is named and not `found`, unless there is no
    /// object at all.
    pub(super) fn check(&self, found: &BTreeSet<CompactString>) -> Result<(), ImportError> {
        let names: &[String] = match self {
            Self::All => &[],
            Self::Only(names) | Self::Except(names) => names,
        };
        let missing = names.iter().find(|name| !found.contains(name.as_str()));
        match missing.filter(|_| !found.is_empty()) {
            Some(class) => Err(ImportError::NoSuchClass {
                class: class.clone(),
                found: listed(found),
            }),
            None => Ok(()),
        }
    }
}

/// The first of many names.
pub(super) fn listed(names: &BTreeSet<CompactString>) -> String {
    const MOST: usize = 30;
    let first: Vec<&str> = names.iter().take(MOST).map(CompactString::as_str).collect();
    let more = names.len().saturating_sub(MOST);
    let more = if more > 0 {
        format!(" and {more} more")
    } else {
        String::new()
    };
    first.join(", ") + &more
}
