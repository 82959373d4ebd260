//! Files that are written into while they are served. They are mapped, so answers are wrong from
//! then on, and where a file became shorter the process may die: it cannot be made good, but it
//! can be said.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::{MissedTickBehavior, interval};

use super::scenes::City;
use super::shared::Shared;

/// So often the files are looked at.
const EVERY: Duration = Duration::from_secs(1);

/// Says so once of each city whose file, or that of its ground, was written into.
pub async fn watch(shared: Arc<Shared>) {
    let mut told: Vec<Arc<City>> = Vec::new();
    let mut ticks = interval(EVERY);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        ticks.tick().await;
        let scenes = shared.scenes();
        told.retain(|city| scenes.iter().any(|served| Arc::ptr_eq(served, city)));
        let is_told = |city: &Arc<City>| told.iter().any(|known| Arc::ptr_eq(known, city));
        let new: Vec<Arc<City>> = scenes
            .iter()
            .filter(|city| !is_told(city) && city.is_written_into())
            .cloned()
            .collect();
        for city in &new {
            tracing::error!(
                scene = city.name(),
                "the file, or that of its ground, was written into while it is served: answers are wrong, and the \
                 service may die; put whole files in its place (mv, not cp), then send SIGHUP"
            );
        }
        told.extend(new);
    }
}
