//! How many streams there may be.

use std::sync::Arc;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::super::problem::{Kind, Problem};

/// As many as a semaphore can wait for.
const MOST_PLACES: usize = 1 << 28;

/// The places of streams.
#[derive(Debug)]
pub struct Streams {
    places: Arc<Semaphore>,
    most: usize,
}

impl Streams {
    /// So many.
    pub fn new(most: usize) -> Self {
        let most = most.min(MOST_PLACES);
        Self {
            places: Arc::new(Semaphore::new(most)),
            most,
        }
    }

    /// Takes a place, until it is dropped.
    ///
    /// # Errors
    /// 503 when there is none.
    pub fn take(&self) -> Result<OwnedSemaphorePermit, Problem> {
        let place = Arc::clone(&self.places).try_acquire_owned();
        place.map_err(|_none_left| {
            let most = self.most;
            let detail = format!("{most} streams are open: try again later (option --max-streams)");
            Problem::new(Kind::Overloaded, detail)
        })
    }

    /// Done when all have ended.
    pub async fn ended(&self) {
        // The semaphore is never closed.
        let _ = self.places.acquire_many(self.most as u32).await;
    }
}
