//! The text format of Prometheus.
//!
//! Source: Prometheus, "Exposition formats", text format 0.0.4.

use std::fmt::Write as _;

use super::count::{BOUNDS_US, Histogram};

/// A document in the making.
#[derive(Debug, Default)]
pub struct Text(String);

/// One metric of a document: its values follow its head.
#[derive(Debug)]
pub struct Metric<'a> {
    text: &'a mut String,
    name: &'static str,
}

/// Name and value of a label.
pub type Label<'a> = (&'a str, &'a str);

impl Text {
    /// Begins a number that only grows.
    pub fn counter(&mut self, name: &'static str, help: &str) -> Metric<'_> {
        self.head(name, help, "counter")
    }

    /// Begins a number that comes and goes.
    pub fn gauge(&mut self, name: &'static str, help: &str) -> Metric<'_> {
        self.head(name, help, "gauge")
    }

    /// Begins a distribution.
    pub fn histogram(&mut self, name: &'static str, help: &str) -> Metric<'_> {
        self.head(name, help, "histogram")
    }

    fn head(&mut self, name: &'static str, help: &str, kind: &str) -> Metric<'_> {
        let _ = writeln!(self.0, "# HELP {name} {help}\n# TYPE {name} {kind}");
        Metric {
            text: &mut self.0,
            name,
        }
    }

    /// The whole document.
    pub fn finish(self) -> String {
        self.0
    }
}

impl Metric<'_> {
    /// One value.
    pub fn value(&mut self, labels: &[Label<'_>], value: f64) {
        self.line("", labels, value);
    }

    /// One distribution.
    pub fn samples(&mut self, labels: &[Label<'_>], histogram: &Histogram) {
        let mut below = 0;
        for (at, count) in histogram.buckets().iter().enumerate() {
            below += count;
            let bound = BOUNDS_US.get(at);
            let bound = bound.map_or("+Inf".to_owned(), |&us| (us as f64 / 1e6).to_string());
            let labels = [labels, &[("le", bound.as_str())]].concat();
            self.line("_bucket", &labels, below as f64);
        }
        self.line("_sum", labels, histogram.sum_us() as f64 / 1e6);
        self.line("_count", labels, below as f64);
    }

    fn line(&mut self, suffix: &str, labels: &[Label<'_>], value: f64) {
        self.text.push_str(self.name);
        self.text.push_str(suffix);
        for (at, (name, label)) in labels.iter().enumerate() {
            self.text.push(if at == 0 { '{' } else { ',' });
            let label = label
                .replace('\\', "\\\\")
                .replace('"', "\\\"")
                .replace('\n', "\\n");
            let _ = write!(self.text, "{name}=\"{label}\"");
        }
        if !labels.is_empty() {
            self.text.push('}');
        }
        let _ = writeln!(self.text, " {value}");
    }
}
