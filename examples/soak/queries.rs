//! Clients that ask one thing after another, on one connection each.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use bytes::Bytes;
use http_body_util::{BodyExt, Full};
use hyper::client::conn::http1::{SendRequest, handshake};
use hyper::{Method, Request, Response};
use hyper_util::rt::TokioIo;
use serde::Deserialize;
use tokio::net::TcpStream;
use tokio::time::{Instant, MissedTickBehavior, interval_at, timeout};

use super::tally::Tally;
use super::world::{Pose, SCENE, World};

const PATIENCE: Duration = Duration::from_secs(20);

/// What is looked at of an answer.
#[derive(Debug, Deserialize)]
struct Visible {
    revision: String,
    count: usize,
}

struct Client(SendRequest<Full<Bytes>>);

impl Client {
    async fn open(world: &World) -> Result<Self> {
        let stream = TcpStream::connect(world.address()?).await?;
        stream.set_nodelay(true)?;
        let (sender, connection) = handshake(TokioIo::new(stream)).await?;
        tokio::spawn(connection);
        Ok(Self(sender))
    }

    async fn send(
        &mut self,
        path: &str,
        accept: &str,
        body: Option<String>,
    ) -> Result<Response<Bytes>> {
        let request = Request::builder()
            .method(if body.is_some() {
                Method::POST
            } else {
                Method::GET
            })
            .uri(path)
            .header("host", "localhost")
            .header("accept", accept)
            .header("content-type", "application/json")
            .body(Full::new(Bytes::from(body.unwrap_or_default())))?;
        self.0.ready().await?;
        let (head, body) = self.0.send_request(request).await?.into_parts();
        Ok(Response::from_parts(head, body.collect().await?.to_bytes()))
    }
}

/// Asks until it is stopped.
pub async fn ask(number: u32, world: &World, tally: &Tally, pause: Duration) {
    loop {
        if let Err(error) = questions(number, world, tally, pause).await {
            tally.fail(format!("query {number}: {error:#}"));
            tokio::time::sleep(Duration::from_millis(200)).await;
        }
    }
}

async fn questions(number: u32, world: &World, tally: &Tally, pause: Duration) -> Result<()> {
    let mut client = Client::open(world).await?;
    let mut ticks = interval_at(Instant::now() + pause, pause);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    for turn in 0_u32.. {
        let due = ticks.tick().await;
        let asked = question(&mut client, world, number, turn);
        let bytes = timeout(PATIENCE, asked).await.context("no answer")??;
        tally.queries.add(due.elapsed(), bytes);
    }
    Ok(())
}

/// One of many kinds, with the status it should have.
async fn question(client: &mut Client, world: &World, number: u32, turn: u32) -> Result<usize> {
    const JSON: &str = "application/json";
    const BINARY: &str = "application/octet-stream";
    let pose = Pose::at(number * 31 + turn % 97, f64::from(turn) * 0.1);
    let base = format!("/collections/{SCENE}");
    let visible = format!("{base}/visible");
    let body = |more: &str| Some(format!("{{{}{more}}}", pose.json()));
    let (path, accept, body, status) = match turn % 12 {
        0..4 => (visible, JSON, body(""), 200),
        4 => (visible, JSON, body(r#","output":{"form":"ranges"}"#), 200),
        5 => (visible, JSON, body(r#","output":{"form":"objects"}"#), 200),
        6 => (visible, BINARY, body(""), 200),
        7 => (
            format!("{base}/boxes?start={}", turn % 1000),
            BINARY,
            None,
            200,
        ),
        8 => (base, JSON, None, 200),
        9 => ("/metrics".to_owned(), "text/plain", None, 200),
        // The other city has other objects.
        10 => (format!("{base}/items/{}", world.id(turn)), JSON, None, 0),
        _ => (
            visible,
            JSON,
            Some(r#"{"camera":{"eye":[0,0]}}"#.to_owned()),
            400,
        ),
    };
    let counted = accept == JSON && status == 200 && body.is_some();
    let answer = client.send(&path, accept, body).await?;
    let (found, length) = (answer.status().as_u16(), answer.body().len());
    let expected = found == status || (status == 0 && matches!(found, 200 | 404));
    let text = || {
        String::from_utf8_lossy(answer.body())
            .chars()
            .take(300)
            .collect::<String>()
    };
    ensure!(expected, "{path}: {found}, not {status}: {}", text());
    if counted {
        let seen: Visible = serde_json::from_slice(answer.body()).with_context(text)?;
        let expected = world.seen(&seen.revision, &pose)?.len();
        ensure!(
            seen.count == expected,
            "{} objects, not {expected}",
            seen.count
        );
    }
    Ok(length)
}

/// What the service counts.
pub async fn metrics(world: &World) -> Result<String> {
    let answer = Client::open(world)
        .await?
        .send("/metrics", "text/plain", None)
        .await?;
    Ok(String::from_utf8(answer.into_body().to_vec())?)
}
