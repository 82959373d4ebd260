//! The papers' questions, answered by measurement: run → records → tables, plots, pictures, json.
//!
//! Each experiment is one file, or a folder of its name. Timings are medians beside a baseline
//! measured in the same run. [`Experiment`] is the list of them.

mod accuracy;
mod catalogue;
mod city;
mod controller;
mod culling;
mod effects;
pub mod exact;
mod far_dist;
mod fit;
mod hills;
mod page;
mod plot;
mod report;
mod scaling;
pub mod stability;
mod street;
mod terrain;
mod timing;
mod views;

pub use catalogue::{Experiment, Options, Progress, run};
pub use page::{Entry, Outcome, write_index};
pub use report::{Plot, Report, ReportError, ReportPicture, Table};
