//! Reading the cities again while they are served.

use std::error::Error;
use std::sync::Arc;

use tokio::sync::{Notify, oneshot};

use super::scenes::Scenes;
use super::shared::Shared;

/// Why the cities could not be read.
pub type ReadError = Box<dyn Error + Send + Sync>;

/// Each time it is `asked`, reads the cities again and offers them in place of the others. What
/// cannot be read leaves everything as it was.
pub async fn reload_when<F>(asked: Arc<Notify>, shared: Arc<Shared>, read: F)
where
    F: Fn() -> Result<Scenes, ReadError> + Send + Sync + 'static,
{
    let read = Arc::new(read);
    loop {
        asked.notified().await;
        tracing::info!("scenes are read again");
        let read = Arc::clone(&read);
        let scenes = aside(move || read()).await;
        let [done, failed] = &shared.metrics().reloads;
        match scenes {
            Ok(scenes) => {
                let served = scenes.len();
                let changed = shared.replace(scenes);
                done.add(1);
                tracing::info!(served, changed, "scenes were read again");
            }
            Err(error) => {
                failed.add(1);
                let error = chain(&*error);
                tracing::error!(error, "scenes could not be read again: the old ones stay");
            }
        }
    }
}

/// Reads in a thread that nobody waits for: a large file takes seconds to check, and a service that
/// is told to stop meanwhile has no use for it. A runtime would wait for a thread of its own.
async fn aside<F>(read: F) -> Result<Scenes, ReadError>
where
    F: FnOnce() -> Result<Scenes, ReadError> + Send + 'static,
{
    let (tell, told) = oneshot::channel();
    std::thread::Builder::new()
        .name("reread".into())
        .spawn(move || tell.send(read()))?;
    told.await
        .unwrap_or_else(|_| Err("reading them panicked".into()))
}

/// The error and its causes.
fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}
