//! Places of which there are so many.

use std::sync::Arc;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// As many as a semaphore can wait for.
const MOST: usize = 1 << 28;

/// So many places. Who waits for one is served in turn.
#[derive(Debug)]
pub struct Places {
    free: Arc<Semaphore>,
    most: usize,
}

/// A place, given back when it is dropped.
#[derive(Debug)]
pub struct Place {
    /// There, since the semaphore is never closed.
    _permit: Option<OwnedSemaphorePermit>,
}

impl Places {
    /// So many, all free.
    pub fn new(most: usize) -> Self {
        let most = most.min(MOST);
        Self {
            free: Arc::new(Semaphore::new(most)),
            most,
        }
    }

    /// How many there are, free or taken.
    pub fn most(&self) -> usize {
        self.most
    }

    /// Takes the next that is free.
    pub async fn take(&self) -> Place {
        Place {
            _permit: Arc::clone(&self.free).acquire_owned().await.ok(),
        }
    }

    /// Takes one if there is one now.
    pub fn try_take(&self) -> Option<Place> {
        let permit = Arc::clone(&self.free).try_acquire_owned().ok()?;
        Some(Place {
            _permit: Some(permit),
        })
    }

    /// Done when all are free.
    pub async fn all_free(&self) {
        let _ = self.free.acquire_many(self.most as u32).await;
    }
}
