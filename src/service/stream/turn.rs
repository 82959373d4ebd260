//! Frames that take long, of all streams, wait for each other: so many streams can neither take
//! all threads from cheap frames and requests, nor work on more frames at once than there are
//! cores.

use std::pin::Pin;

use super::super::places::{Place, Places};

/// A stream's rank among those that wait to work out a frame that takes long.
pub struct Turn<'a> {
    places: &'a Places,
    waiting: Option<Pin<Box<dyn Future<Output = Place> + Send + 'a>>>,
}

impl<'a> Turn<'a> {
    /// Of one stream, for these places.
    pub fn new(places: &'a Places) -> Self {
        Self {
            places,
            waiting: None,
        }
    }

    /// Done when it is this stream's turn. Who drops this future and comes again keeps its rank,
    /// so that clients that talk much do not fall behind.
    pub async fn come(&mut self) -> Place {
        let places = self.places;
        let waiting = self.waiting.get_or_insert_with(|| Box::pin(places.take()));
        let place = waiting.as_mut().await;
        self.waiting = None;
        place
    }

    /// Gives up the rank. To be done before the stream waits for anything else: its turn could
    /// come meanwhile, and the place would be held for nothing.
    pub fn leave(&mut self) {
        self.waiting = None;
    }
}
