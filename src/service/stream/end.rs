//! Why a stream ends, and what the client is told of it.

use std::time::Duration;

use tokio_tungstenite::tungstenite::Error;
use tokio_tungstenite::tungstenite::protocol::CloseFrame;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;

use super::super::config::Config;
use super::super::metrics::Counter;

/// Why a stream ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The client said goodbye.
    Left,
    /// The connection broke.
    Broken,
    /// The service stops.
    Stopping,
    /// The scene is not served any more.
    SceneGone,
    /// No message for too long.
    Idle,
    /// The client does not take what is sent to it.
    Unread,
    /// A message is too long.
    TooLong,
    /// A message is not text.
    NotText,
    /// A message is not UTF-8.
    NotUtf8,
    /// What arrives is not a WebSocket's.
    Garbage,
}

impl End {
    /// All there are.
    pub const ALL: [Self; 10] = [
        Self::Left,
        Self::Broken,
        Self::Stopping,
        Self::SceneGone,
        Self::Idle,
        Self::Unread,
        Self::TooLong,
        Self::NotText,
        Self::NotUtf8,
        Self::Garbage,
    ];

    /// How it is called where ends are counted.
    pub fn label(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Broken => "broken",
            Self::Stopping => "stopping",
            Self::SceneGone => "scene_gone",
            Self::Idle => "idle",
            Self::Unread => "unread",
            Self::TooLong => "too_long",
            Self::NotText => "not_text",
            Self::NotUtf8 => "not_utf8",
            Self::Garbage => "garbage",
        }
    }

    /// What a failed read or write means.
    pub fn of(error: &Error) -> Self {
        match error {
            Error::Capacity(_) => Self::TooLong,
            Error::Utf8(_) => Self::NotUtf8,
            Error::Protocol(
                tokio_tungstenite::tungstenite::error::ProtocolError::ResetWithoutClosingHandshake,
            ) => Self::Broken,
            Error::Protocol(_) | Error::AttackAttempt => Self::Garbage,
            Error::Io(io) if io.kind() == std::io::ErrorKind::TimedOut => Self::Unread,
            Error::ConnectionClosed | Error::AlreadyClosed => Self::Left,
            _ => Self::Broken,
        }
    }

    /// What the client is told; `None` where there is nobody to tell.
    pub fn frame(self, config: &Config) -> Option<CloseFrame> {
        let seconds = |limit: Duration| limit.as_secs_f64();
        let (code, reason) = match self {
            Self::Left | Self::Broken => return None,
            Self::Stopping => (CloseCode::Away, "the service stops".to_owned()),
            Self::SceneGone => (CloseCode::Away, "the scene is no longer served".to_owned()),
            Self::Idle => {
                let limit = seconds(config.stream_idle);
                let reason = format!("no message for {limit} s (option --stream-idle-ms)");
                (CloseCode::Policy, reason)
            }
            Self::Unread => {
                let limit = seconds(config.timeout);
                let reason = format!("answers were not read for {limit} s (option --timeout-ms)");
                (CloseCode::Policy, reason)
            }
            Self::TooLong => {
                let most = config.max_body_bytes;
                let reason = format!("a message may have {most} bytes (option --max-body-bytes)");
                (CloseCode::Size, reason)
            }
            Self::NotText => (
                CloseCode::Unsupported,
                "messages are text frames of JSON".to_owned(),
            ),
            Self::NotUtf8 => (CloseCode::Invalid, "text must be UTF-8".to_owned()),
            Self::Garbage => (
                CloseCode::Protocol,
                "this is not how WebSockets talk (RFC 6455)".to_owned(),
            ),
        };
        Some(CloseFrame {
            code,
            reason: reason.into(),
        })
    }
}

/// How many streams ended, and why.
#[derive(Debug, Default)]
pub struct Ended([Counter; End::ALL.len()]);

impl Ended {
    /// Counts one.
    pub fn count(&self, end: End) {
        for (counter, of) in self.0.iter().zip(End::ALL) {
            if of == end {
                counter.add(1);
            }
        }
    }

    /// How many of each.
    pub fn iter(&self) -> impl Iterator<Item = (End, u64)> {
        End::ALL.into_iter().zip(self.0.iter().map(Counter::value))
    }
}

#[cfg(test)]
mod tests {
    use super::{End, Ended};
    use std::collections::BTreeSet;

    #[test]
    fn every_end_is_counted_once_under_a_name_of_its_own() {
        let ended = Ended::default();
        for (times, end) in End::ALL.into_iter().enumerate() {
            for _ in 0..=times {
                ended.count(end);
            }
        }
        let counted: Vec<(End, u64)> = ended.iter().collect();
        assert_eq!(counted, End::ALL.into_iter().zip(1..).collect::<Vec<_>>());
        let labels: BTreeSet<&str> = End::ALL.into_iter().map(End::label).collect();
        assert_eq!(labels.len(), End::ALL.len());
    }
}
