//! The process itself, under the names that Prometheus clients share.

use std::time::{SystemTime, UNIX_EPOCH};

use super::text::Text;

/// Writes what can be found out.
pub fn write(started: SystemTime, text: &mut Text) {
    if let Ok(since) = started.duration_since(UNIX_EPOCH) {
        text.gauge(
            "process_start_time_seconds",
            "When the service began, seconds since 1970.",
        )
        .value(&[], since.as_secs_f64());
    }
    if let Some(bytes) = resident_bytes() {
        text.gauge(
            "process_resident_memory_bytes",
            "Memory in use, with the mapped parts of scene files that were read.",
        )
        .value(&[], bytes as f64);
    }
    if let Ok(open) = std::fs::read_dir("/proc/self/fd") {
        text.gauge("process_open_fds", "Open file descriptors.")
            .value(&[], open.count() as f64);
    }
}

/// Linux only.
fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kilobytes: u64 = line.trim().trim_end_matches(" kB").parse().ok()?;
    Some(kilobytes * 1024)
}
