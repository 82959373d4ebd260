use std::fmt;
use std::path::{Path, PathBuf};

/// Where in a file: shown as `line 3, column 7`, `byte 1024`, `/CityObjects/b1` …
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// Line and column, both from 1.
    Line(usize, usize),
    /// Byte offset from 0.
    Byte(u64),
    /// JSON pointer (RFC 6901).
    Pointer(String),
}

impl Place {
    /// As it stands before what is said of it; nothing for the file as a whole.
    fn before(&self) -> String {
        match self {
            Self::File => String::new(),
            place => format!("at {place}: "),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => write!(f, "the file"),
            Self::Line(line, column) => write!(f, "line {line}, column {column}"),
            Self::Byte(offset) => write!(f, "byte {offset}"),
            Self::Pointer(pointer) => write!(f, "{pointer}"),
        }
    }
}

/// Why a file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The operating system refused.
    #[error("{}: cannot read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Neither name nor content is of a known format.
    #[error(
        "{}: not a city format known here; expected .gltf, .glb, .obj, .city.json, .json, .city.jsonl, .jsonl, .geojson, .geojsonl or .ndjson, any of them with .gz; elevation is laid under a city with --into",
        path.display()
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The name is that of what an import makes.
    #[error(
        "{}: is a city already, imported or generated; look at it with citylod info or serve it with citylod serve, and import the files that it was made of where it is to be made anew",
        path.display()
    )]
    AlreadyCity {
        /// The file.
        path: PathBuf,
    },
    /// The content breaks the rules of its format.
    #[error("{}: {}{reason}", path.display(), place.before())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: Place,
        /// What is wrong, and what was expected.
        reason: String,
    },
    /// The format is known, a feature the file requires is not.
    #[error("{}: needs {feature}, which is not supported; {way_out}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What it asks for.
        feature: String,
        /// What the user can do.
        way_out: String,
    },
    /// Two files lie in different coordinate reference systems.
    #[error(
        "{}: lies in {found}, but the files before it in {expected}; reproject one of them, or import them into separate scenes",
        path.display()
    )]
    CrsMismatch {
        /// The file that differs.
        path: PathBuf,
        /// Its system.
        found: String,
        /// The system of the files before it.
        expected: String,
    },
    /// A file states another system than the caller does.
    #[error(
        "{}: states that it lies in {found}, but --crs says {told}; leave --crs out to take its word, or correct the file",
        path.display()
    )]
    CrsContradicted {
        /// The file.
        path: PathBuf,
        /// The system that it states.
        found: String,
        /// The one that the caller states.
        told: String,
    },
    /// The positions of a file are to be degrees, and are none.
    #[error(
        "{}: positions such as {x}, {y} are no longitude and latitude, as {crs} would have them; {way_out}",
        path.display()
    )]
    NoDegrees {
        /// The file.
        path: PathBuf,
        /// The first of its positions.
        x: f64,
        /// The same.
        y: f64,
        /// The system.
        crs: String,
        /// What the user can do.
        way_out: &'static str,
    },
    /// A file states no system and holds degrees, which would be taken as metres.
    #[error("{}: {what}", path.display())]
    LooksLikeDegrees {
        /// The file.
        path: PathBuf,
        /// What shows it, and what the user can do.
        what: String,
    },
    /// A class that was asked for, or asked to be left out, is that of no object.
    #[error("no object is of the class {class:?}; the classes of the files are {found}")]
    NoSuchClass {
        /// Its name.
        class: String,
        /// Those there are.
        found: String,
    },
    /// The property that is to hold heights is one of no feature.
    #[error(
        "no feature has a property {name:?} to take its height from; the properties there are: {found}"
    )]
    NoSuchHeight {
        /// Its name.
        name: String,
        /// Those there are.
        found: String,
    },
    /// More features of a file lie too far from where the others do than lie there.
    #[error(
        "{}: {far} of its {of} features lie over {degrees} degrees from {from}; {way_out}",
        path.display()
    )]
    FarFeatures {
        /// The file.
        path: PathBuf,
        /// How many lie too far.
        far: usize,
        /// How many there are.
        of: usize,
        /// How far is too far.
        degrees: f64,
        /// From where.
        from: String,
        /// What the user can do.
        way_out: &'static str,
    },
    /// A file does not say which system it lies in, and cannot lie in that of the others.
    #[error(
        "{}: states no coordinate reference system and lies {km} km from {}, too far for one city{}; convert them to one system, or import them into separate scenes",
        path.display(), other.display(), suspected.as_ref().map_or(String::new(), |what| format!("; {what}"))
    )]
    FarApart {
        /// The file.
        path: PathBuf,
        /// The nearest of the others.
        other: PathBuf,
        /// How far apart they lie, km.
        km: f64,
        /// What looks wrong with its positions.
        suspected: Option<String>,
    },
}

impl ImportError {
    pub(super) fn malformed(path: &Path, place: Place, reason: impl Into<String>) -> Self {
        Self::Malformed {
            path: path.to_owned(),
            place,
            reason: reason.into(),
        }
    }
}
