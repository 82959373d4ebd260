//! One stream from its first message to its last.

use std::sync::Arc;
use std::time::{Duration, Instant};

use futures_util::{FutureExt, SinkExt, StreamExt};
use hyper::upgrade::Upgraded;
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::{Message, Role, WebSocketConfig};

use super::super::config::Config;
use super::super::documents::make;
use super::super::scenes::City;
use super::super::shared::Shared;
use super::end::End;
use super::session::Session;
use super::turn::Turn;
use super::window::Window;

type Socket = WebSocketStream<TokioIo<Upgraded>>;

/// Messages are short, and there are many streams, bytes.
const READ_BUFFER: usize = 4096;

/// Of messages that wait, at most so many are taken in before the newest is answered, so that who
/// never stops talking gets answers too.
const MOST_AT_ONCE: usize = 64;

/// How long the client may take to read why the stream ends and to close its side. Closing before
/// that would reset the connection, and the reason would be lost.
const FAREWELL: Duration = Duration::from_secs(1);

/// Talks until either side has enough.
pub async fn serve(upgraded: Upgraded, shared: &Shared, city: Arc<City>) {
    let metrics = &shared.metrics().streams;
    let open = metrics.open.enter();
    let config = shared.config();
    let limits = WebSocketConfig::default()
        .read_buffer_size(READ_BUFFER)
        .write_buffer_size(0)
        .max_message_size(Some(config.max_body_bytes))
        .max_frame_size(Some(config.max_body_bytes));
    let io = TokioIo::new(upgraded);
    let mut socket = WebSocketStream::from_raw_socket(io, Role::Server, Some(limits)).await;
    tracing::debug!("stream begins");
    let end = talk(&mut socket, shared, city).await;
    let _ = tokio::time::timeout(FAREWELL, part(&mut socket, end, config)).await;
    metrics.ended.count(end);
    match end {
        End::Left | End::Broken | End::Stopping => {
            tracing::debug!(end = end.label(), "stream ends");
        }
        _ => tracing::info!(end = end.label(), "stream ends"),
    }
    drop(open);
}

/// When things were last heard.
struct Heard {
    anything: Instant,
    message: Instant,
}

async fn talk(socket: &mut Socket, shared: &Shared, city: Arc<City>) -> End {
    let (config, metrics) = (shared.config(), &shared.metrics().streams);
    let name = city.name().to_owned();
    let mut session = Session::new(city);
    let mut window = Window::default();
    let mut turn = Turn::new(shared.dear());
    let mut place = None;
    let mut scenes = shared.replacements();
    // What was replaced between the request and now counts too.
    scenes.mark_changed();
    let now = Instant::now();
    let mut heard = Heard {
        anything: now,
        message: now,
    };
    let mut stopping = std::pin::pin!(shared.closed());
    loop {
        while window.is_open() && (place.is_some() || !session.is_dear()) {
            let mut next = || session.next(config, metrics);
            let text = match place.take() {
                Some(_place) => make(usize::MAX, next), // as long as it takes
                None => next(),
            };
            let Some(text) = text else { break };
            turn.leave();
            if let Err(error) = socket.send(Message::text(text)).await {
                return End::of(&error);
            }
            window.sent();
        }
        let mut now = Instant::now();
        let silent = now.duration_since(heard.anything) >= config.timeout;
        if window.wants_ping() || (silent && window.waiting_since().is_none()) {
            let ping = window.ping(now).to_vec();
            turn.leave();
            if let Err(error) = socket.send(Message::Ping(ping.into())).await {
                return End::of(&error);
            }
            now = Instant::now();
        }
        let wake = match overdue(&window, &heard, config, now) {
            Ok(wake) => wake,
            Err(end) => return end,
        };
        let mut arrived = tokio::select! {
            biased;
            () = &mut stopping => return End::Stopping,
            _ = scenes.changed() => {
                match scenes.borrow_and_update().get(&name) {
                    Ok(city) => session.move_to(Arc::clone(city), metrics),
                    Err(_) => return End::SceneGone,
                }
                continue;
            }
            taken = turn.come(), if window.is_open() && session.is_dear() => {
                place = Some(taken);
                continue;
            }
            arrived = socket.next() => Some(arrived),
            () = tokio::time::sleep_until(wake.into()) => None,
        };
        let mut taken_in = 0;
        while let Some(message) = arrived {
            heard.anything = Instant::now();
            match message {
                None => return End::Broken,
                Some(Err(error)) => return End::of(&error),
                Some(Ok(Message::Text(text))) => {
                    heard.message = heard.anything;
                    session.hear(&text, metrics);
                }
                Some(Ok(Message::Pong(payload))) => window.pong(&payload),
                Some(Ok(Message::Ping(_) | Message::Frame(_))) => {} // answered by the socket
                Some(Ok(Message::Binary(_))) => return End::NotText,
                Some(Ok(Message::Close(_))) => return End::Left,
            }
            taken_in += 1;
            if taken_in == MOST_AT_ONCE {
                break;
            }
            arrived = socket.next().now_or_never();
        }
    }
}

/// When to look again whether the client has been silent for too long.
///
/// # Errors
/// The end, if it has.
fn overdue(window: &Window, heard: &Heard, config: &Config, now: Instant) -> Result<Instant, End> {
    let idle = heard.message + config.stream_idle;
    if now >= idle {
        return Err(End::Idle);
    }
    // Whether a ping is out or has yet to go, the client has `timeout` from there.
    let unread = window.waiting_since().map(|since| since + config.timeout);
    if unread.is_some_and(|unread| now >= unread) {
        return Err(End::Unread);
    }
    Ok(idle.min(unread.unwrap_or(heard.anything + config.timeout)))
}

/// Tells the client why, and waits until it has closed its side.
async fn part(socket: &mut Socket, end: End, config: &Config) {
    let told = match end.frame(config) {
        Some(frame) => socket.close(Some(frame)).await,
        None => socket.flush().await,
    };
    if told.is_err() || matches!(end, End::Left | End::Broken | End::Unread) {
        return;
    }
    let io = socket.get_mut();
    let _ = io.shutdown().await;
    let mut rest = [0; 4096];
    while matches!(io.read(&mut rest).await, Ok(1..)) {}
}
