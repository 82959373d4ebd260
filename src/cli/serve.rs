use std::io::{IsTerminal, Write as _};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::ValueEnum;
use indicatif::ProgressBar;
use tracing_appender::non_blocking::{NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::EnvFilter;

use super::failure::told;
use super::numbers::{bytes, milliseconds, number};
use super::{ground, progress};
use crate::index::{self, LodTree, Promotion};
use crate::scene::{CityParams, generate};
use crate::service::{Config, Scenes, serve};

#[derive(Debug, Clone, clap::Args)]
#[command(allow_negative_numbers = true)]
pub(super) struct ServeArgs {
    /// Cities to serve, each under the name of its file; read again on SIGHUP
    pub files: Vec<PathBuf>,
    /// Address and port, or a port on this machine alone; port 0 picks a free one
    #[arg(long, default_value = "127.0.0.1:8080", value_parser = address)]
    pub listen: SocketAddr,
    /// Longest request body, and longest message of a stream
    #[arg(long, default_value_t = 64 * 1024, value_parser = bytes)]
    pub max_body_bytes: usize,
    /// Longest time a request may take to arrive, and an answer or a stream may go unread
    #[arg(long, default_value_t = 10_000, value_parser = milliseconds())]
    pub timeout_ms: u64,
    /// Most requests in work at once; more are answered 503
    #[arg(long, default_value_t = 256, value_parser = number)]
    pub max_concurrency: usize,
    /// Most ids in one answer; larger ones are refused with 413
    #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub max_answer_objects: u32,
    /// Longest time that occlusion may take; requests for which it takes longer are refused with 422
    #[arg(long, default_value_t = 2_000, value_parser = milliseconds())]
    pub max_occlusion_ms: u64,
    /// Most connections, without streams; more wait
    #[arg(long, default_value_t = 4096, value_parser = number)]
    pub max_connections: usize,
    /// Most streams; more are answered 503
    #[arg(long, default_value_t = 2048, value_parser = number)]
    pub max_streams: usize,
    /// Longest time a stream may go without a message before it is closed
    #[arg(long, default_value_t = 300_000, value_parser = milliseconds())]
    pub stream_idle_ms: u64,
    /// How the log is written to standard error; the variable `RUST_LOG` says how much
    #[arg(long, default_value = "text")]
    pub log_format: LogFormatArg,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum LogFormatArg {
    /// For people
    Text,
    /// One JSON object a line
    Json,
}

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
    // In the words that the command has for the errors of the system.
    let reread =
        move || self::scenes(&args, &ProgressBar::hidden()).map_err(|error| told(&error).into());
    let served = runtime.block_on(serve(config, scenes, reread, |text| {
        let _ = std::io::stderr().write_all(text.as_bytes()); // where nobody listens, it is lost
    }));
    // Answers that were not done in time are of no use any more.
    runtime.shutdown_background();
    Ok(served?)
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

/// `127.0.0.1:8080`, or `8080` alone.
fn address(text: &str) -> Result<SocketAddr, String> {
    let port = text.strip_prefix("localhost:").unwrap_or(text);
    let address = match port.parse() {
        Ok(port) => Some((Ipv4Addr::LOCALHOST, port).into()),
        Err(_) => text.parse().ok(),
    };
    address.ok_or_else(|| {
        "expected an address and a port such as 127.0.0.1:8080 (0.0.0.0:8080 for all who reach \
         this machine), or a port"
            .into()
    })
}
