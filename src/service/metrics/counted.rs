//! Everything that is counted.

use std::time::SystemTime;

use super::super::stream::Ended;
use super::count::{Counter, Gauge, Histogram};
use super::requests::Requests;

/// Everything that is counted.
#[derive(Debug)]
pub struct Metrics {
    /// Requests, by path and status.
    pub requests: Requests,
    /// Connections that are open and not streams.
    pub connections: Gauge,
    /// Streams.
    pub streams: StreamMetrics,
    /// Times that the cities were read again, and that this failed.
    pub reloads: [Counter; 2],
    pub(super) started: SystemTime,
}

/// What is counted of streams.
#[derive(Debug, Default)]
pub struct StreamMetrics {
    /// Those that are open.
    pub open: Gauge,
    /// Messages that arrived.
    pub messages: Counter,
    /// Messages that were refused.
    pub refused: Counter,
    /// Accepted messages without an answer, since a newer one had arrived.
    pub skipped: Counter,
    /// Objects that answers added and removed.
    pub moved: [Counter; 2],
    /// From the arrival of a message to its answer on its way; one sample an answer.
    pub answers: Histogram,
    /// Streams that ended.
    pub ended: Ended,
}

impl Default for Metrics {
    fn default() -> Self {
        Self {
            requests: Requests::default(),
            connections: Gauge::default(),
            streams: StreamMetrics::default(),
            reloads: Default::default(),
            started: SystemTime::now(),
        }
    }
}
