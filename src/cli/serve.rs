use std::io::{IsTerminal, Write as _};

use anyhow::{Context, Result};
use indicatif::ProgressBar;
use tracing_appender::non_blocking::{NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::EnvFilter;

use super::args::{LogFormatArg, ServeArgs};
use super::{ground, progress};
use crate::index::{self, LodTree, Promotion};
use crate::scene::{CityParams, generate};
use crate::service::{Config, Scenes, serve};

/// Name of the city that is served when none is given.
const DEMO: &str = "demo";
/// As many objects as in Gong's test.
const DEMO_OBJECTS: u32 = 23_951;

pub(super) fn run(args: &ServeArgs) -> Result<()> {
    let _log = log(args.log_format);
    let config = Config {
        listen: args.listen,
        max_body_bytes: args.max_body_bytes,
        timeout: std::time::Duration::from_millis(args.timeout_ms),
        max_concurrency: args.max_concurrency,
        max_connections: args.max_connections,
        max_answer_objects: args.max_answer_objects,
        max_occlusion: std::time::Duration::from_millis(args.max_occlusion_ms),
        max_streams: args.max_streams,
        stream_idle: std::time::Duration::from_millis(args.stream_idle_ms),
        ..Config::default()
    };
    let scenes = scenes(args, &progress::spinner())?;
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()
        .context("cannot start the service")?;
    let args = args.clone();
    let reread = move || self::scenes(&args, &ProgressBar::hidden()).map_err(Into::into);
    runtime.block_on(serve(config, scenes, reread, |text| {
        let _ = std::io::stderr().write_all(text.as_bytes()); // where nobody listens, it is lost
    }))?;
    Ok(())
}

/// Lines that wait to be written; further ones are lost, so that a log that nobody reads does not
/// hold up the service.
const LOG_LINES: usize = 4096;

/// Logs to standard error until the guard is dropped.
fn log(format: LogFormatArg) -> WorkerGuard {
    let (writer, guard) = NonBlockingBuilder::default()
        .buffered_lines_limit(LOG_LINES)
        .lossy(true)
        .finish(std::io::stderr());
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| "info".into());
    let log = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_ansi(std::io::stderr().is_terminal())
        .with_writer(writer);
    match format {
        LogFormatArg::Text => log.init(),
        LogFormatArg::Json => log.json().flatten_event(true).init(),
    }
    guard
}

/// The cities; `spinner` shows what is being done.
fn scenes(args: &ServeArgs, spinner: &ProgressBar) -> Result<Scenes> {
    let mut scenes = Scenes::new();
    for file in &args.files {
        spinner.set_message(format!("opening {}", file.display()));
        let tree = LodTree::open_verified(file)?;
        let name = Scenes::name_of(file)?;
        let land = ground::land(file, &tree)?;
        scenes
            .insert_on(name, tree, land)
            .with_context(|| file.display().to_string())?;
    }
    if scenes.is_empty() {
        spinner.set_message("building the demo city");
        let city = generate(&CityParams {
            objects: DEMO_OBJECTS,
            seed: 1,
        });
        scenes.insert(DEMO, index::build(&city, Promotion::default())?)?;
    }
    spinner.finish_and_clear();
    Ok(scenes)
}
