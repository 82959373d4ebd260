//! How many answers may be under way: a client that is slow gets the newest, not a queue.
//!
//! Buffers between the two ends hold many answers, and a client would have to work through all
//! of them before it sees the newest. So after some answers the service sends a ping, which the
//! client's WebSocket answers once it has read up to there (RFC 6455, section 5.5.2), and what is
//! not known to be read counts as under way. At most one ping is out, so a client that waits for
//! each answer costs a quarter of a ping an answer.

use std::time::Instant;

/// Most answers under way. Where the round trip is longer than half as many frames, fewer answers
/// come than frames: at 60 frames a second from 133 ms on.
const MOST: u64 = 16;

/// From so many on, a ping asks how far the client has read.
const ASK_FROM: u64 = 4;

/// What was sent, and what is known to be read.
#[derive(Debug, Default)]
pub struct Window {
    sent: u64,
    read: u64,
    /// The ping that is out: how many answers went before it, and when it went.
    ping: Option<(u64, Instant)>,
}

impl Window {
    /// Whether another answer may go.
    pub fn is_open(&self) -> bool {
        self.sent - self.read < MOST
    }

    /// An answer went.
    pub fn sent(&mut self) {
        self.sent += 1;
    }

    /// Whether it is time to ask how far the client has read.
    pub fn wants_ping(&self) -> bool {
        self.ping.is_none() && self.sent - self.read >= ASK_FROM
    }

    /// A ping goes now; returns what it carries.
    pub fn ping(&mut self, now: Instant) -> [u8; 8] {
        self.ping = Some((self.sent, now));
        self.sent.to_be_bytes()
    }

    /// A pong came; others than that of the ping that is out mean nothing.
    pub fn pong(&mut self, payload: &[u8]) {
        if let Some((read, _)) = self.ping
            && payload == read.to_be_bytes()
        {
            self.read = read;
            self.ping = None;
        }
    }

    /// Since when a ping is out.
    pub fn waiting_since(&self) -> Option<Instant> {
        self.ping.map(|(_, since)| since)
    }
}

#[cfg(test)]
mod tests {
    use super::{ASK_FROM, MOST, Window};
    use std::time::Instant;

    #[test]
    fn nothing_more_goes_to_a_client_that_reads_nothing() {
        let mut window = Window::default();
        let mut pings = Vec::new();
        for sent in 0..MOST {
            assert!(window.is_open(), "{sent}");
            window.sent();
            if window.wants_ping() {
                pings.push(window.ping(Instant::now()));
            }
        }
        assert!(!window.is_open());
        assert_eq!(pings, [ASK_FROM.to_be_bytes()], "one ping is out");
        window.pong(&[1, 2, 3]);
        window.pong(&MOST.to_be_bytes());
        assert!(!window.is_open(), "the pong of no ping of ours");
        window.pong(&pings[0]);
        for sent in 0..ASK_FROM {
            assert!(window.is_open(), "{sent} more");
            window.sent();
        }
        assert!(!window.is_open());
        assert!(window.wants_ping(), "the next one");
    }
}
