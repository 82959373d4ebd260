//! How long things take, so that it can be repeated: medians of several runs.

use std::hint::black_box;
use std::time::{Duration, Instant};

/// The middle of the values, after sorting; the lower one of two.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values
        .get(values.len().saturating_sub(1) / 2)
        .copied()
        .unwrap_or(f64::NAN)
}

/// Seconds one call takes.
pub(super) fn seconds<T>(f: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let value = f();
    (start.elapsed().as_secs_f64(), value)
}

/// Median microseconds of a call, over `samples` batches long enough for the clock.
pub(super) fn median_us<T>(samples: usize, mut f: impl FnMut() -> T) -> f64 {
    const BATCH: Duration = Duration::from_millis(2);
    let (once, _) = seconds(|| black_box(f()));
    let calls = (BATCH.as_secs_f64() / once.max(1e-9)).clamp(1.0, 1e6) as u32;
    let batches = (0..samples).map(|_| {
        let (batch, ()) = seconds(|| {
            for _ in 0..calls {
                black_box(f());
            }
        });
        batch * 1e6 / f64::from(calls)
    });
    median(batches.collect())
}
