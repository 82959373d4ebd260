use std::path::PathBuf;

/// Why a tree cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// Object numbers are 32 bits wide.
    #[error("{count} objects are more than a tree can number (4,294,967,294); split the scene")]
    TooManyObjects {
        /// How many there are.
        count: usize,
    },
    /// An id must lead to one object.
    #[error("two objects have the id {id:?}; make ids unique with Scene::canonicalize")]
    DuplicateId {
        /// The id.
        id: String,
    },
}

/// Why a `.citylod` file is refused.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The operating system refused.
    #[error("{}: {action}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was being done.
        action: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// Nothing is in it.
    #[error("{}: header: the file is empty; make one with `citylod import` or `citylod generate`", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Not one of these files at all.
    #[error("{}: header: not a .citylod file; make one with `citylod import` or `citylod generate`", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// Made by another version of the format.
    #[error("{}: header: format version {found}, this program reads {expected}; import the city again", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u32,
        /// The version read here.
        expected: u32,
    },
    /// Damaged.
    #[error("{}: section `{section}`: {reason}; the file is damaged, import the city again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Which section.
        section: String,
        /// What is wrong with it.
        reason: String,
    },
}
