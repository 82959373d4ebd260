//! What was typed → one call.

mod args;
mod effects;
mod experiment;
mod generate;
pub mod glb;
mod ground;
mod import;
mod info;
mod progress;
mod query;
mod render;
mod select;
mod serve;
mod text;

use std::process::ExitCode;

use clap::Parser;

use args::{Args, Command};

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
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            if let Some(usage) = error.downcast_ref::<clap::Error>() {
                usage.exit();
            }
            eprintln!("citylod: {}", chain(&error));
            ExitCode::FAILURE
        }
    }
}

/// The error and its causes. One that only repeats its own cause with more words, such as the
/// temporary name a file was written under, is passed over.
fn chain(error: &anyhow::Error) -> String {
    let texts: Vec<String> = error.chain().map(ToString::to_string).collect();
    let told = (0..texts.len()).filter(|&at| match texts.get(at + 1) {
        Some(cause) => at == 0 || !texts[at].starts_with(cause.as_str()),
        None => true,
    });
    told.map(|at| texts[at].as_str())
        .collect::<Vec<_>>()
        .join(": ")
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<std::io::Error>())
        .any(|io| io.kind() == std::io::ErrorKind::BrokenPipe)
}
