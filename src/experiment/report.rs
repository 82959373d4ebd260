//! One flat record, several small writers.

use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::geom::ViewError;
use crate::import::ImportError;
use crate::index::{BuildError, FileError};

/// What an experiment found.
#[derive(Debug, Clone)]
pub struct Report {
    /// Name of the experiment and of its files.
    pub name: &'static str,
    /// What was asked and what the table says, for people.
    pub text: String,
    /// Column heads of the table.
    pub columns: Vec<&'static str>,
    /// The table.
    pub rows: Vec<Vec<String>>,
    /// Everything, for programs.
    pub json: Value,
    /// The plot; empty where pictures take its place.
    pub svg: String,
    /// What was seen.
    pub pictures: Vec<ReportPicture>,
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
    /// A camera cannot stand where it should.
    #[error("camera: {0}")]
    View(#[from] ViewError),
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
    /// The table with a heading, as people read it.
    pub fn to_text(&self) -> String {
        let width = |column: usize| {
            let cells = self.rows.iter().map(|row| row[column].chars().count());
            cells.fold(self.columns[column].chars().count(), usize::max)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let line = |cells: &mut dyn Iterator<Item = &str>| {
            let padded = cells.zip(&widths).map(|(cell, &w)| format!("{cell:>w$}"));
            padded.collect::<Vec<_>>().join("  ")
        };
        let mut out = format!("{}\n\n{}\n\n", self.name, self.text);
        let _ = writeln!(out, "{}", line(&mut self.columns.iter().copied()));
        let _ = writeln!(
            out,
            "{}",
            "-".repeat(widths.iter().map(|w| w + 2).sum::<usize>() - 2)
        );
        for row in &self.rows {
            let _ = writeln!(out, "{}", line(&mut row.iter().map(String::as_str)));
        }
        out
    }

    /// The table as comma-separated values.
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

    /// Writes `NAME.csv`, `NAME.json`, `NAME.svg` if there is a plot, and the pictures into a
    /// folder, which is made if need be.
    ///
    /// # Errors
    /// [`ReportError::Write`] naming the file.
    pub fn write(&self, folder: &Path) -> Result<(), ReportError> {
        let write = |path: PathBuf, bytes: &[u8]| {
            std::fs::write(&path, bytes).map_err(|source| ReportError::Write { path, source })
        };
        std::fs::create_dir_all(folder).map_err(|source| ReportError::Write {
            path: folder.to_owned(),
            source,
        })?;
        let file = |extension: &str| folder.join(format!("{}.{extension}", self.name));
        write(file("csv"), self.to_csv().as_bytes())?;
        if !self.svg.is_empty() {
            write(file("svg"), self.svg.as_bytes())?;
        }
        for picture in &self.pictures {
            write(folder.join(&picture.file), &picture.png)?;
        }
        write(file("json"), format!("{:#}\n", self.json).as_bytes())
    }
}

/// A page that shows the reports in a folder with their plots.
fn page(reports: &[Report]) -> String {
    let escaped = |text: &str| {
        let text = text
            .replace('&', "&amp;")
            .replace('<', "&lt;")
            .replace('"', "&quot;");
        text.replace('\n', "<br>")
    };
    let row = |cells: &mut dyn Iterator<Item = &str>, tag: &str| {
        let cells = cells.map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell)));
        format!("<tr>{}</tr>", cells.collect::<String>())
    };
    let sections = reports.iter().map(|report| {
        let name = report.name;
        let head = row(&mut report.columns.iter().copied(), "th");
        let rows = report.rows.iter();
        let rows = rows.map(|cells| row(&mut cells.iter().map(String::as_str), "td"));
        let plot = if report.svg.is_empty() {
            String::new()
        } else {
            format!("<img src=\"{name}.svg\" alt=\"{name}\">")
        };
        let pictures = report.pictures.iter().map(|ReportPicture { file, caption, .. }| {
            let (file, caption) = (escaped(file), escaped(caption));
            format!("<figure><img src=\"{file}\" alt=\"\"><figcaption>{caption}</figcaption></figure>")
        });
        format!(
            "<h2>{name}</h2><p>{}</p>{plot}<div class=\"pictures\">{}</div>\
             <div class=\"wide\"><table>{head}{}</table></div>\
             <p>Repeat it: <code>citylod experiment {name} --out .</code> · \
             <a href=\"{name}.csv\">csv</a> · <a href=\"{name}.json\">json</a></p>",
            escaped(&report.text),
            pictures.collect::<String>(),
            rows.collect::<String>()
        )
    });
    format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>citylod experiments</title>\
         <style>body{{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem}}\
         img{{max-width:100%}}figure{{margin:0}}figcaption{{font-size:.85rem;color:#555}}\
         .pictures{{display:grid;grid-template-columns:repeat(auto-fit,minmax(18rem,1fr));gap:.8rem}}.wide{{overflow-x:auto}}table{{border-collapse:collapse;font-size:.85rem}}\
         td,th{{padding:.15rem .6rem;text-align:right;border-bottom:1px solid #ddd}}</style>\
         <h1>citylod experiments</h1>{}</html>\n",
        sections.collect::<String>()
    )
}

/// Writes `index.html`, which shows reports that were written into the same folder.
///
/// # Errors
/// [`ReportError::Write`] naming the file.
pub fn write_index(reports: &[Report], folder: &Path) -> Result<(), ReportError> {
    let path = folder.join("index.html");
    std::fs::write(&path, page(reports)).map_err(|source| ReportError::Write { path, source })
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
