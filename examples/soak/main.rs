//! Runs the service for a long time under streams, queries and reloads, and looks whether memory
//! grows, an answer fails or a set is wrong.
//!
//! ```text
//! cargo build --release && cargo run --release --example soak            # half an hour of all
//! cargo run --release --example soak -- --seconds 60 --streams 1000 --rate 5 --queries 0 --reload-every 0
//! ```
//!
//! Every client adds and removes as it is told; each sixteenth set is held against the library's
//! own answer for the revision that the service names. At the end the service is killed under
//! load, started again, and every stream has to come back. Fails where an answer failed, a set
//! was wrong, or memory grew by more than 5 % between the first and the last quarter.
#![allow(clippy::print_stdout, reason = "a program's figures are its output")]

mod memory;
mod queries;
mod served;
mod streams;
mod tally;
mod world;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use clap::Parser;
use tokio::task::JoinSet;

use memory::Memory;
use served::Served;
use tally::Tally;
use world::World;

/// Load on a service of its own.
#[derive(Debug, Parser)]
struct Args {
    /// How long, without the kill at the end
    #[arg(long, default_value_t = 1800)]
    seconds: u64,
    /// Streams at once
    #[arg(long, default_value_t = 100)]
    streams: u32,
    /// Messages a second on each
    #[arg(long, default_value_t = 10.0)]
    rate: f64,
    /// Clients that ask one query after another
    #[arg(long, default_value_t = 2)]
    queries: u32,
    /// Queries a second of each
    #[arg(long, default_value_t = 200.0)]
    query_rate: f64,
    /// Seconds from one reload to the next; 0 for none
    #[arg(long, default_value_t = 5)]
    reload_every: u64,
    /// Objects of each city
    #[arg(long, default_value_t = 23_951)]
    objects: u32,
    /// The command to serve with [default: the one built beside this]
    #[arg(long)]
    command: Option<PathBuf>,
}

/// More growth is a leak.
const MOST_GROWTH_PERCENT: f64 = 5.0;

#[tokio::main]
async fn main() -> Result<ExitCode> {
    let args = Args::parse();
    let command = match &args.command {
        Some(command) => command.clone(),
        None => beside_this()?,
    };
    let folder = tempfile::tempdir()?;
    let world = Arc::new(World::new(args.objects, folder.path())?);
    let mut served = Served::start(&command, "127.0.0.1:0", world.path(), args.streams)?;
    world.set_address(served.address());
    let tally = Arc::new(Tally::default());
    let start = Instant::now();
    let end = start + Duration::from_secs(args.seconds);
    let mut clients = JoinSet::new();
    spread(&args, &world, &tally, &mut clients);
    let memory = watch(&args, &world, &tally, &served, end).await?;
    let took = start.elapsed();
    let failed = tally.failed.load(Ordering::Relaxed);
    println!("{}", tally.text(took));
    println!("{}", memory.text());
    let metrics = queries::metrics(&world).await?;
    println!("{}", told(&metrics));

    // The clients are still at it.
    tally.killed.store(true, Ordering::Relaxed);
    let before = Instant::now();
    served.kill()?;
    let listen = served.address().to_string();
    let mut served = Served::start(&command, &listen, world.path(), args.streams)?;
    clients.shutdown().await;
    let back = streams::all_come_back(&world, args.streams).await?;
    let seconds = before.elapsed().as_secs_f64();
    println!("killed under load: {back} streams were back {seconds:.1} s later");
    let code = served.stop()?;
    ensure!(
        code == Some(0),
        "told to stop, the service ended with {code:?}"
    );

    let growth = memory.growth_percent();
    for error in tally.errors() {
        eprintln!("{error}");
    }
    if failed > 0 || growth > MOST_GROWTH_PERCENT {
        eprintln!("failed: {failed} errors, memory grew by {growth:.1} %");
        return Ok(ExitCode::FAILURE);
    }
    Ok(ExitCode::SUCCESS)
}

/// Starts all clients, spread over a second.
fn spread(args: &Args, world: &Arc<World>, tally: &Arc<Tally>, clients: &mut JoinSet<()>) {
    for number in 0..args.streams {
        let (world, tally) = (Arc::clone(world), Arc::clone(tally));
        let pause = Duration::from_secs_f64(1.0 / args.rate);
        clients.spawn(async move { streams::fly(number, &world, &tally, pause).await });
    }
    for number in 0..args.queries {
        let (world, tally) = (Arc::clone(world), Arc::clone(tally));
        let pause = Duration::from_secs_f64(1.0 / args.query_rate);
        clients.spawn(async move { queries::ask(number, &world, &tally, pause).await });
    }
}

/// Looks at the memory each second and replaces the city now and then, until the end.
async fn watch(
    args: &Args,
    world: &World,
    tally: &Tally,
    served: &Served,
    end: Instant,
) -> Result<Memory> {
    let mut memory = Memory::default();
    let mut tick = tokio::time::interval(Duration::from_secs(1));
    for second in 0_u64.. {
        tick.tick().await;
        if Instant::now() >= end {
            break;
        }
        memory.look(served.id())?;
        if args.reload_every > 0 && second % args.reload_every == args.reload_every - 1 {
            world.replace()?;
            served.hang_up()?;
            tally.reloads.fetch_add(1, Ordering::Relaxed);
        }
        if second % 60 == 59 {
            eprintln!("{} s: {}", second + 1, memory.now_text());
        }
    }
    Ok(memory)
}

/// What the service says of its streams and reloads.
fn told(metrics: &str) -> String {
    let wanted = [
        "citylod_stream",
        "citylod_scene_reloads",
        "citylod_http_requests",
    ];
    let lines = metrics.lines().filter(|line| {
        wanted.iter().any(|name| line.starts_with(name)) && !line.contains("_bucket")
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn beside_this() -> Result<PathBuf> {
    let this = std::env::current_exe()?;
    let folder = this.parent().and_then(|examples| examples.parent());
    let command = folder.context("no folder")?.join("citylod");
    ensure!(
        command.exists(),
        "{} is not there: run cargo build --release first",
        command.display()
    );
    Ok(command)
}
