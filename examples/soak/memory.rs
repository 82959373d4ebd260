//! What the service holds.

use anyhow::{Context, Result};

/// One look a second, MB.
#[derive(Debug, Default)]
pub struct Memory {
    /// All that is resident, with the mapped file.
    resident: Vec<f64>,
    /// What is not backed by a file.
    anonymous: Vec<f64>,
}

impl Memory {
    /// Looks at a process.
    pub fn look(&mut self, process: u32) -> Result<()> {
        let status = std::fs::read_to_string(format!("/proc/{process}/status"))?;
        let megabytes = |name: &str| -> Result<f64> {
            let line = status.lines().find_map(|line| line.strip_prefix(name));
            let text = line.with_context(|| format!("no {name}"))?;
            let kilobytes: f64 = text.trim().trim_end_matches(" kB").parse()?;
            Ok(kilobytes / 1024.0)
        };
        self.resident.push(megabytes("VmRSS:")?);
        self.anonymous.push(megabytes("RssAnon:")?);
        Ok(())
    }

    /// How much more the last quarter holds than the first; medians. The time in which things get
    /// going does not count.
    pub fn growth_percent(&self) -> f64 {
        let (early, late) = quarters(&self.resident);
        100.0 * (late / early - 1.0)
    }

    /// Figures of the whole time.
    pub fn text(&self) -> String {
        let row = |name: &str, series: &[f64]| {
            let (early, late) = quarters(series);
            let most = series.iter().copied().fold(0.0, f64::max);
            let percent = 100.0 * (late / early - 1.0);
            format!(
                "{name}: {early:.1} MB first, {late:.1} MB last quarter ({percent:+.1} %), {most:.1} MB at most"
            )
        };
        format!(
            "{}\n{}",
            row("resident memory", &self.resident),
            row("of that, anonymous", &self.anonymous)
        )
    }

    /// The last look.
    pub fn now_text(&self) -> String {
        let last = |series: &[f64]| series.last().copied().unwrap_or_default();
        format!(
            "{:.1} MB resident, {:.1} MB anonymous",
            last(&self.resident),
            last(&self.anonymous)
        )
    }
}

/// Seconds in which threads, buffers and pages come to be; at most a third of all.
const WARM_UP: usize = 60;

fn quarters(series: &[f64]) -> (f64, f64) {
    let counted = &series[WARM_UP.min(series.len() / 3)..];
    let quarter = (counted.len() / 4).max(1).min(counted.len());
    (
        median(&counted[..quarter]),
        median(&counted[counted.len() - quarter..]),
    )
}

fn median(series: &[f64]) -> f64 {
    let mut sorted = series.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or_default()
}
