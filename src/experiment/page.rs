//! `index.html`: what was asked, picture, plot, table, how to repeat it.
//!
//! One file that needs no other but the pictures beside it. It is written anew after each
//! experiment, so that a run that is cut short leaves a page of what was found until then.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::time::Duration;

use super::report::{Report, ReportError, ReportPicture, Table};
use super::{Experiment, Options, plot};
use crate::file;

/// What came of an experiment that was to be run.
#[derive(Debug)]
pub enum Outcome {
    /// Not yet.
    Waiting,
    /// It was run and took so long.
    Done(Box<Report>, Duration),
    /// It could not be run, for this reason.
    Failed(String),
}

/// A chapter of the page.
#[derive(Debug)]
pub struct Entry {
    /// Which one.
    pub experiment: Experiment,
    /// What came of it.
    pub outcome: Outcome,
}

/// Writes `index.html`, which shows reports that were written into the same folder. It is replaced
/// whole or not at all.
///
/// # Errors
/// [`ReportError::Write`] naming the file.
pub fn write_index(entries: &[Entry], options: &Options, folder: &Path) -> Result<(), ReportError> {
    let path = folder.join("index.html");
    let page = page(entries, options);
    file::replace(&path, |file| file.write_all(page.as_bytes()))
        .map_err(|source| ReportError::Write { path, source })
}

fn page(entries: &[Entry], options: &Options) -> String {
    let done = |e: &&Entry| matches!(e.outcome, Outcome::Done(..));
    let done = entries.iter().filter(done).count();
    let mut body = String::new();
    let mut contents = String::new();
    for Entry {
        experiment,
        outcome,
    } in entries
    {
        let name = experiment.name();
        let question = escaped(experiment.question());
        let _ = write!(
            contents,
            "<li><a href=\"#{name}\">{question}</a> <span>{}</span></li>",
            state(outcome)
        );
        let _ = write!(
            body,
            "<section id=\"{name}\"><p class=\"name\">{name}</p><h2>{question}</h2>{}{}</section>",
            chapter(outcome),
            repeat(*experiment, outcome, options)
        );
    }
    let status = if done == entries.len() {
        format!("{done} experiments, run from beginning to end.")
    } else {
        format!(
            "{done} of {} experiments so far; the others are named below.",
            entries.len()
        )
    };
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>citylod: experiments</title>\n<style>\n{}</style>\n</head>\n<body>\n\
         <header><h1>What citylod does, measured</h1>\
         <p class=\"lead\">Which objects of a city to draw, at what detail, and how wrong the answer \
         is: each claim below comes from a run of the program itself.</p>\
         <p class=\"facts\">{status} {}</p><nav><ol>{contents}</ol></nav></header>\n\
         <main>\n{body}\n</main>\n</body>\n</html>\n",
        include_str!("page.css"),
        machine(),
    )
}

fn machine() -> String {
    let threads = std::thread::available_parallelism().map_or(0, usize::from);
    let build = if cfg!(debug_assertions) {
        ", debug build: times mean nothing"
    } else {
        ""
    };
    format!(
        "citylod {} on {} {} with {threads} threads{build}.",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::OS,
        std::env::consts::ARCH,
    )
}

fn state(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Waiting => "not run yet".into(),
        Outcome::Done(_, took) => format!("{:.0} s", took.as_secs_f64().ceil()),
        Outcome::Failed(_) => "failed".into(),
    }
}

fn chapter(outcome: &Outcome) -> String {
    let report = match outcome {
        Outcome::Waiting => return "<p class=\"note\">Not run yet.</p>".into(),
        Outcome::Failed(reason) => {
            return format!("<p class=\"note\">Failed: {}.</p>", escaped(reason));
        }
        Outcome::Done(report, _) => report,
    };
    let mut out = String::new();
    for paragraph in report.text.split("\n\n") {
        let _ = write!(out, "<p>{}</p>", escaped(paragraph).replace('\n', "<br>"));
    }
    if !report.pictures.is_empty() {
        let figures: String = report.pictures.iter().map(figure).collect();
        let _ = write!(out, "<div class=\"pictures\">{figures}</div>");
    }
    for drawn in &report.plots {
        let svg = plot::for_pages(&drawn.svg);
        let _ = write!(out, "<figure class=\"plot\">{svg}</figure>");
    }
    for (n, table) in report.tables.iter().enumerate() {
        out += &html_table(table, n == 0 && table.rows.len() <= LONG_TABLE);
    }
    out
}

/// Longer tables are folded away.
const LONG_TABLE: usize = 24;

fn figure(ReportPicture { file, caption, .. }: &ReportPicture) -> String {
    let (file, caption) = (escaped(file), escaped(caption));
    format!(
        "<figure><a href=\"{file}\"><img src=\"{file}\" alt=\"{caption}\" loading=\"lazy\"></a>\
         <figcaption>{caption}</figcaption></figure>"
    )
}

fn html_table(table: &Table, open: bool) -> String {
    let heads = table.columns.iter().map(|head| {
        let head = escaped(&head.replace('_', " "));
        format!("<th scope=\"col\">{head}</th>")
    });
    let head = heads.collect::<Vec<_>>().concat();
    let rows = table.rows.iter().map(|cells| {
        let cells = cells.iter().map(|cell| {
            let number = cell.starts_with(|c: char| c.is_ascii_digit() || c == '-');
            let class = if number { "" } else { " class=\"word\"" };
            format!("<td{class}>{}</td>", escaped(cell))
        });
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    });
    let title = if table.title.is_empty() {
        "The table".to_owned()
    } else {
        escaped(&table.title)
    };
    format!(
        "<details{}><summary>{title}</summary><div class=\"wide\" tabindex=\"0\"><table>\
         <thead><tr>{head}</tr></thead><tbody>{}</tbody></table></div></details>",
        if open { " open" } else { "" },
        rows.collect::<String>()
    )
}

fn repeat(experiment: Experiment, outcome: &Outcome, options: &Options) -> String {
    let name = experiment.name();
    let mut command = format!("citylod experiment {name} --out report");
    if let Some(largest) = options.largest {
        let _ = write!(command, " --largest {largest}");
    }
    if experiment.looks_at_cities() {
        for city in &options.cities {
            let _ = write!(command, " --city {}", city.display());
        }
    }
    let mut files = String::new();
    if let Outcome::Done(report, _) = outcome {
        let tables = report
            .tables
            .iter()
            .map(|t| report.file_name(t.name, "csv"));
        for file in tables.chain([report.file_name("", "json")]) {
            let _ = write!(files, " · <a href=\"{file}\">{file}</a>");
        }
    }
    let command = escaped(&command);
    format!("<p class=\"repeat\">Repeat it: <code>{command}</code>{files}</p>")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}
