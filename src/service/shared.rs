//! What all handlers see: the cities on offer, the limits, what is counted, and whether the
//! service is closing.

use std::sync::Arc;

use tokio::sync::watch;

use super::config::Config;
use super::metrics::Metrics;
use super::places::Places;
use super::problem::Problem;
use super::request_id::RequestIds;
use super::scenes::{City, Scenes};

/// One service: made of cities and limits, then given to [`super::router`] and
/// [`super::Server::bind`].
#[derive(Debug)]
pub struct Shared {
    scenes: watch::Sender<Arc<Scenes>>,
    closing: watch::Sender<bool>,
    streams: Places,
    dear: Places,
    metrics: Metrics,
    request_ids: RequestIds,
    config: Config,
}

impl Shared {
    /// Offers these cities within these limits.
    pub fn new(scenes: Scenes, config: &Config) -> Arc<Self> {
        Arc::new(Self {
            scenes: watch::Sender::new(Arc::new(scenes)),
            closing: watch::Sender::new(false),
            streams: Places::new(config.max_streams),
            dear: Places::new(at_once()),
            metrics: Metrics::default(),
            request_ids: RequestIds::default(),
            config: *config,
        })
    }

    /// The cities on offer now. Who holds them sees no change.
    pub fn scenes(&self) -> Arc<Scenes> {
        Arc::clone(&self.scenes.borrow())
    }

    /// The city of this name, on offer now.
    ///
    /// # Errors
    /// 404.
    pub fn city(&self, name: &str) -> Result<Arc<City>, Problem> {
        self.scenes.borrow().get(name).cloned()
    }

    /// Offers these cities in place of the others, at once and for all that is asked from now on.
    /// A city that has not changed stays as it is, with what was prepared of it. Returns how many
    /// are new or have changed.
    pub fn replace(&self, mut scenes: Scenes) -> usize {
        let mut changed = 0;
        self.scenes.send_modify(|old| {
            changed = scenes.keep_unchanged(old);
            *old = Arc::new(scenes);
        });
        changed
    }

    /// Sees each replacement.
    pub fn replacements(&self) -> watch::Receiver<Arc<Scenes>> {
        self.scenes.subscribe()
    }

    /// Tells all connections to end.
    pub fn close(&self) {
        self.closing.send_replace(true);
    }

    /// Done when connections are to end.
    pub async fn closed(&self) {
        // The sender is part of `self`: there is nothing to fail.
        let _ = self.closing.subscribe().wait_for(|closing| *closing).await;
    }

    /// The places of streams.
    pub fn streams(&self) -> &Places {
        &self.streams
    }

    /// The places of frames of streams that take long.
    pub fn dear(&self) -> &Places {
        &self.dear
    }

    /// What is counted.
    pub fn metrics(&self) -> &Metrics {
        &self.metrics
    }

    /// Names for requests.
    pub fn request_ids(&self) -> &RequestIds {
        &self.request_ids
    }

    /// The limits.
    pub fn config(&self) -> &Config {
        &self.config
    }
}

/// Frames of streams that take long and are worked out at once: one core is left to all the rest,
/// where there are several.
fn at_once() -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    (cores - 1).max(1)
}
