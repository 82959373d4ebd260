//! Clients that fly.

use std::collections::BTreeSet;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use futures_util::{SinkExt, StreamExt};
use serde::Deserialize;
use tokio::net::TcpStream;
use tokio::time::{Instant, MissedTickBehavior, interval_at, timeout};
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, client_async};

use super::tally::Tally;
use super::world::{Pose, SCENE, World};

/// One set in so many is held against the library's.
const CHECKED: u32 = 16;

/// An answer that takes longer has failed.
const PATIENCE: Duration = Duration::from_secs(20);

#[derive(Debug, Deserialize)]
struct Answer {
    seq: u32,
    /// Where the set begins anew.
    revision: Option<String>,
    count: usize,
    add: Vec<[u32; 2]>,
    remove: Vec<[u32; 2]>,
}

/// A stream and what its client holds.
struct Client {
    socket: WebSocketStream<MaybeTlsStream<TcpStream>>,
    held: BTreeSet<u32>,
    revision: String,
    bytes: usize,
}

impl Client {
    async fn open(world: &World) -> Result<Self> {
        let address = world.address()?;
        let stream = TcpStream::connect(address).await?;
        stream.set_nodelay(true)?;
        let url = format!("ws://{address}/collections/{SCENE}/stream");
        let (socket, _) = client_async(url, MaybeTlsStream::Plain(stream)).await?;
        Ok(Self {
            socket,
            held: BTreeSet::new(),
            revision: String::new(),
            bytes: 0,
        })
    }

    /// Sends a pose and waits for its answer; what comes unasked is carried out too.
    async fn ask(&mut self, seq: u32, pose: &Pose) -> Result<()> {
        let text = format!("{{\"seq\":{seq},{}}}", pose.json());
        self.socket.send(Message::text(text)).await?;
        loop {
            let message = self.socket.next().await.context("closed")??;
            match message {
                Message::Text(text) => {
                    self.bytes += text.len();
                    let answer: Answer =
                        serde_json::from_str(&text).with_context(|| text.to_string())?;
                    self.carry_out(&answer)?;
                    if answer.seq == seq {
                        return Ok(());
                    }
                }
                Message::Close(frame) => bail!("closed: {frame:?}"),
                _ => {}
            }
        }
    }

    fn carry_out(&mut self, answer: &Answer) -> Result<()> {
        if let Some(revision) = &answer.revision {
            self.held.clear();
            self.revision.clone_from(revision);
        }
        for object in answer.remove.iter().flat_map(|[start, end]| *start..*end) {
            ensure!(self.held.remove(&object), "{object} was never added");
        }
        for object in answer.add.iter().flat_map(|[start, end]| *start..*end) {
            ensure!(self.held.insert(object), "{object} was there already");
        }
        ensure!(answer.count == self.held.len(), "the count is wrong");
        Ok(())
    }

    fn check(&self, world: &World, pose: &Pose) -> Result<()> {
        let seen = world.seen(&self.revision, pose)?;
        ensure!(self.held == seen, "not the full answer to {pose:?}");
        Ok(())
    }
}

/// Flies until it is stopped; what fails is counted, and it starts again.
pub async fn fly(number: u32, world: &World, tally: &Tally, pause: Duration) {
    // Not all at once: over a second.
    tokio::time::sleep(Duration::from_millis(u64::from(number) * 7 % 1000)).await;
    loop {
        if let Err(error) = flight(number, world, tally, pause).await {
            tally.fail(format!("stream {number}: {error:#}"));
            tokio::time::sleep(Duration::from_millis(200)).await;
        }
    }
}

async fn flight(number: u32, world: &World, tally: &Tally, pause: Duration) -> Result<()> {
    let mut client = Client::open(world).await?;
    let mut ticks = interval_at(Instant::now() + pause, pause);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    for seq in 0.. {
        // From when it was due, so that waiting for a late answer counts as late too.
        let due = ticks.tick().await;
        let pose = Pose::at(number, f64::from(seq) * pause.as_secs_f64());
        let before = client.bytes;
        timeout(PATIENCE, client.ask(seq, &pose))
            .await
            .context("no answer")??;
        tally.streams.add(due.elapsed(), client.bytes - before);
        if seq % CHECKED == number % CHECKED {
            client.check(world, &pose)?;
            tally
                .checked
                .fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        }
    }
    Ok(())
}

/// Opens so many streams, one after another, and checks the first answer of each.
pub async fn all_come_back(world: &World, streams: u32) -> Result<u32> {
    let mut clients = Vec::new();
    for number in 0..streams {
        let mut client = Client::open(world).await?;
        let pose = Pose::at(number, 0.0);
        timeout(PATIENCE, client.ask(1, &pose))
            .await
            .context("no answer")??;
        client.check(world, &pose)?;
        clients.push(client);
    }
    Ok(streams)
}
