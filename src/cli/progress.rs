//! Progress bars on a terminal; elsewhere nothing, or a line a step where there are several.

use indicatif::{ProgressBar, ProgressStyle};

use super::say::say;

/// A bar that counts bytes.
pub(super) fn bytes() -> ProgressBar {
    styled(
        ProgressBar::new(0),
        "{msg:12} {bar:32} {bytes}/{total_bytes} {bytes_per_sec} {eta}",
    )
}

/// A line that tells what is being done.
pub(super) fn spinner() -> ProgressBar {
    let spinner = styled(ProgressBar::new_spinner(), "{spinner} {msg} ({elapsed})");
    spinner.enable_steady_tick(std::time::Duration::from_millis(120));
    spinner
}

/// Several steps, each of which takes long.
pub(super) struct Steps(ProgressBar);

impl Steps {
    pub(super) fn new(count: usize) -> Self {
        let bar = styled(
            ProgressBar::new(count as u64),
            "{spinner} {bar:24} {pos}/{len} {msg} ({elapsed})",
        );
        bar.enable_steady_tick(std::time::Duration::from_millis(120));
        Self(bar)
    }

    /// Tells what is being done.
    pub(super) fn doing(&self, what: &str) {
        self.0.set_message(what.to_owned());
    }

    /// Ends a step with a line that stays.
    pub(super) fn done(&self, what: &str) {
        self.0.inc(1);
        if self.0.is_hidden() {
            say!(
                "[{}/{}] {what}",
                self.0.position(),
                self.0.length().unwrap_or(0)
            );
        } else {
            self.0.println(what);
        }
    }

    /// Keeps out of the way of something that prints.
    pub(super) fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.0.suspend(print)
    }

    pub(super) fn finish(&self) {
        self.0.finish_and_clear();
    }
}

fn styled(bar: ProgressBar, template: &str) -> ProgressBar {
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
