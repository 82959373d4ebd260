//! What was typed → one call.
#![warn(
    clippy::print_stderr,
    reason = "panics where nobody listens any more: use `say`"
)]

mod args;
mod effects;
mod experiment;
mod failure;
mod generate;
pub mod glb;
mod ground;
mod import;
mod info;
mod numbers;
mod progress;
mod query;
mod render;
mod say;
mod select;
mod serve;
mod standing;
mod text;

use std::process::ExitCode;

use clap::Parser;

use args::{Args, Command};
use say::say;

/// Runs the command line; 0 done, 1 failed, 2 bad usage.
pub fn run() -> ExitCode {
    let result = match Args::parse().command {
        Command::Import(args) => import::run(&args),
        Command::Generate(args) => generate::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Query(args) => query::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Serve(args) => serve::run(&args),
        Command::Experiment(args) => experiment::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        // A reader that has seen enough, such as `head`, is no failure.
        Err(error) if failure::is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            if let Some(usage) = error.downcast_ref::<clap::Error>() {
                usage.exit();
            }
            say!("citylod: {}", failure::told(&error));
            ExitCode::FAILURE
        }
    }
}
