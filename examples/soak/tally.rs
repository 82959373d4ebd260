//! What came of it.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// Errors told in full.
const TOLD: usize = 20;

/// Counted by all clients.
#[derive(Debug, Default)]
pub struct Tally {
    pub streams: Times,
    pub queries: Times,
    /// Sets held against the library's.
    pub checked: AtomicU64,
    pub reloads: AtomicU64,
    pub failed: AtomicU64,
    /// From here on connections break, as they should.
    pub killed: AtomicBool,
    errors: Mutex<Vec<String>>,
}

/// Answers of one kind.
#[derive(Debug, Default)]
pub struct Times {
    /// Each answer's, µs.
    us: Mutex<Vec<u32>>,
    bytes: AtomicU64,
}

impl Times {
    /// One answer.
    pub fn add(&self, took: Duration, bytes: usize) {
        self.bytes.fetch_add(bytes as u64, Ordering::Relaxed);
        if let Ok(mut us) = self.us.lock() {
            us.push(took.as_micros() as u32);
        }
    }

    fn text(&self, name: &str, over: Duration) -> String {
        let mut us = self.us.lock().map(|us| us.clone()).unwrap_or_default();
        us.sort_unstable();
        let count = us.len();
        let at = |share: f64| {
            let place = (share * count as f64) as usize;
            let us = us.get(place.min(count.saturating_sub(1)));
            us.map_or(0.0, |&us| f64::from(us) / 1000.0)
        };
        format!(
            "{name}: {count} answers, {:.0} a second; {:.2} ms median, {:.2} ms p99, {:.2} ms p99.9, \
             {:.1} ms at most; {:.0} bytes each",
            count as f64 / over.as_secs_f64(),
            at(0.5),
            at(0.99),
            at(0.999),
            at(1.0),
            self.bytes.load(Ordering::Relaxed) as f64 / count.max(1) as f64
        )
    }
}

impl Tally {
    /// Something went wrong, unless the service has been killed.
    pub fn fail(&self, error: String) {
        if self.killed.load(Ordering::Relaxed) {
            return;
        }
        self.failed.fetch_add(1, Ordering::Relaxed);
        if let Ok(mut errors) = self.errors.lock()
            && errors.len() < TOLD
        {
            errors.push(error);
        }
    }

    /// The first of what went wrong.
    pub fn errors(&self) -> Vec<String> {
        self.errors
            .lock()
            .map(|errors| errors.clone())
            .unwrap_or_default()
    }

    /// All figures.
    pub fn text(&self, over: Duration) -> String {
        let count = |number: &AtomicU64| number.load(Ordering::Relaxed);
        format!(
            "{:.0} s, {} reloads, {} sets checked, {} failed\n{}\n{}",
            over.as_secs_f64(),
            count(&self.reloads),
            count(&self.checked),
            count(&self.failed),
            self.streams.text("streams", over),
            self.queries.text("queries", over)
        )
    }
}
