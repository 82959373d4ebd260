//! Limits, with defaults that are safe on an open port.

use std::net::{Ipv4Addr, SocketAddr};
use std::time::Duration;

/// Where the service listens and what it takes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Config {
    /// Address and port; port 0 picks a free one. Loopback unless told otherwise.
    pub listen: SocketAddr,
    /// Longest request body, and longest message of a stream, bytes; longer ones are answered 413,
    /// or by the end of the stream (1009). A request has some 500.
    pub max_body_bytes: usize,
    /// Longest time that the head of a request, then its body, may take to arrive; also how long
    /// an idle connection is kept, and one whose reader takes nothing of its answer, a stream
    /// too.
    pub timeout: Duration,
    /// Most requests in work at once; further ones are answered 503 at once.
    pub max_concurrency: usize,
    /// Most objects that an answer may list by id; larger ones are answered 413. The other forms
    /// are held to about as many bytes: a tenth as many as `objects`, as many ranges, four times
    /// as many binary numbers. The default keeps bodies near 16 MB.
    pub max_answer_objects: u32,
    /// Longest time that occlusion may take; requests and messages of streams for which it takes
    /// longer are answered 422.
    pub max_occlusion: Duration,
    /// Most connections; further ones wait to be accepted.
    pub max_connections: usize,
    /// Most streams; further ones are answered 503. They do not count as connections or requests
    /// in work.
    pub max_streams: usize,
    /// Longest time without a message from the client before a stream is closed.
    pub stream_idle: Duration,
    /// How long requests in work may take to finish once the service is told to stop.
    pub drain: Duration,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            listen: SocketAddr::from((Ipv4Addr::LOCALHOST, 8080)),
            max_body_bytes: 64 * 1024,
            timeout: Duration::from_secs(10),
            max_concurrency: 256,
            max_answer_objects: 1_000_000,
            max_occlusion: Duration::from_secs(2),
            max_connections: 4096,
            max_streams: 2048,
            stream_idle: Duration::from_secs(300),
            drain: Duration::from_secs(10),
        }
    }
}
