//! One flat record, several small writers.

use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::geom::ViewError;
use crate::import::ImportError;
use crate::index::{BuildError, FileError};
use crate::terrain::pyramid::PyramidError;
use crate::terrain::read::ReadError;
use crate::terrain::{FieldError, KnobError};

/// What an experiment found: tables, plots and pictures, and all of it for programs.
#[derive(Debug, Clone, Default)]
pub struct Report {
    /// Name of the experiment, and what the names of its files begin with.
    pub name: &'static str,
    /// What the tables say, for people: lines, with blank ones between paragraphs.
    pub text: String,
    /// The tables, the most important first.
    pub tables: Vec<Table>,
    /// The plots, likewise.
    pub plots: Vec<Plot>,
    /// The pictures, likewise.
    pub pictures: Vec<ReportPicture>,
    /// Everything, for programs.
    pub json: Value,
}

/// Rows under heads.
#[derive(Debug, Clone, Default)]
pub struct Table {
    /// Tells the tables of an experiment apart in names of files; empty for the main one.
    pub name: &'static str,
    /// What it shows, for people; may be empty where it is the only one.
    pub title: String,
    /// Column heads.
    pub columns: Vec<&'static str>,
    /// As many cells each as there are heads.
    pub rows: Vec<Vec<String>>,
}

/// A drawing with its axes.
#[derive(Debug, Clone, Default)]
pub struct Plot {
    /// As in [`Table::name`].
    pub name: String,
    /// SVG.
    pub svg: String,
}

/// A picture of a report.
#[derive(Debug, Clone)]
pub struct ReportPicture {
    /// Name of its file, which ends in `.png`.
    pub file: String,
    /// What it shows.
    pub caption: String,
    /// The file.
    pub png: Vec<u8>,
}

/// Why an experiment could not be run or kept.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A city cannot be imported.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A `.citylod` file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A tree cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A `.terrain` file cannot be read or written.
    #[error(transparent)]
    Pyramid(#[from] PyramidError),
    /// Elevation cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A camera cannot stand where it should.
    #[error("camera: {0}")]
    View(#[from] ViewError),
    /// The ground cannot be as it should.
    #[error("ground: {0}")]
    Ground(#[from] FieldError),
    /// A criterion cannot be tuned as it should.
    #[error("criterion: {0}")]
    Criterion(#[from] KnobError),
    /// No threads to be had.
    #[error("cannot start threads: {0}")]
    Threads(String),
    /// A result cannot be written.
    #[error("{}: cannot write", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A city lacks what the experiment is about.
    #[error("the city does not have {0}: take a larger one")]
    Nothing(&'static str),
    /// A plot cannot be drawn.
    #[error("cannot draw the plot: {0}")]
    Plot(String),
}

impl Report {
    /// The tables with a heading, as people read them.
    pub fn to_text(&self) -> String {
        let mut out = format!("{}\n\n{}\n", self.name, self.text);
        for table in &self.tables {
            let _ = write!(out, "\n{}", table.to_text());
        }
        out
    }

    /// Writes `NAME.json`, each table and plot as `NAME.csv` and `NAME.svg` or, past the main ones,
    /// as `NAME-ITS-OWN.csv` and so on, and the pictures, into a folder, which is made if need be.
    ///
    /// # Errors
    /// [`ReportError::Write`] naming the file.
    pub fn write(&self, folder: &Path) -> Result<(), ReportError> {
        std::fs::create_dir_all(folder).map_err(|source| ReportError::Write {
            path: folder.to_owned(),
            source,
        })?;
        let write = |file: &str, content: &[u8]| {
            let path = folder.join(file);
            std::fs::write(&path, content).map_err(|source| ReportError::Write { path, source })
        };
        for table in &self.tables {
            let file = self.file_name(table.name, "csv");
            write(&file, table.to_csv().as_bytes())?;
        }
        for plot in &self.plots {
            write(&self.file_name(&plot.name, "svg"), plot.svg.as_bytes())?;
        }
        for picture in &self.pictures {
            write(&picture.file, &picture.png)?;
        }
        let file = self.file_name("", "json");
        write(&file, format!("{:#}\n", self.json).as_bytes())
    }

    pub(super) fn file_name(&self, name: &str, extension: &str) -> String {
        let joint = if name.is_empty() { "" } else { "-" };
        format!("{}{joint}{name}.{extension}", self.name)
    }
}

impl Table {
    /// Columns padded, to the right.
    fn to_text(&self) -> String {
        let width = |column: usize| {
            let cells = self.rows.iter().map(|row| row[column].chars().count());
            cells.fold(self.columns[column].chars().count(), usize::max)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let line = |cells: &mut dyn Iterator<Item = &str>| {
            let padded = cells.zip(&widths).map(|(cell, &w)| format!("{cell:>w$}"));
            padded.collect::<Vec<_>>().join("  ")
        };
        let mut out = String::new();
        if !self.title.is_empty() {
            let _ = writeln!(out, "{}\n", self.title);
        }
        let _ = writeln!(out, "{}", line(&mut self.columns.iter().copied()));
        let dashes = widths.iter().map(|w| w + 2).sum::<usize>() - 2;
        let _ = writeln!(out, "{}", "-".repeat(dashes));
        for row in &self.rows {
            let _ = writeln!(out, "{}", line(&mut row.iter().map(String::as_str)));
        }
        out
    }

    /// Comma-separated values.
    pub fn to_csv(&self) -> String {
        let mut out = self.columns.join(",") + "\n";
        for row in &self.rows {
            let cells = row.iter().map(|cell| {
                if cell.contains([',', '"', '\n']) {
                    format!("\"{}\"", cell.replace('"', "\"\""))
                } else {
                    cell.clone()
                }
            });
            out += &(cells.collect::<Vec<_>>().join(",") + "\n");
        }
        out
    }
}

/// What every record carries, so that it can be repeated.
pub(super) fn circumstances(parameters: &Value) -> Value {
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "seed": super::city::SEED,
        "parameters": parameters,
        "machine": {
            "os": std::env::consts::OS,
            "arch": std::env::consts::ARCH,
            "threads": std::thread::available_parallelism().map_or(0, usize::from),
            "debug_build": cfg!(debug_assertions),
        },
    })
}

/// A whole number with thousands apart, for tables.
pub(super) fn thousands(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}
