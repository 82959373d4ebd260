//! What the process is told from outside.

use std::io::IsTerminal;

/// Done when the process is told to stop (Ctrl-C, or SIGTERM as service managers send it).
pub async fn stop_signal() {
    let interrupt = async {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
    };
    #[cfg(unix)]
    let terminate = async {
        use tokio::signal::unix::{SignalKind, signal};
        match signal(SignalKind::terminate()) {
            Ok(mut signal) => {
                signal.recv().await;
            }
            Err(_) => std::future::pending::<()>().await,
        }
    };
    #[cfg(not(unix))]
    let terminate = std::future::pending::<()>();
    tokio::select! {
        () = interrupt => {}
        () = terminate => {}
    }
}

/// What SIGHUP means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HangUp {
    /// Read the files again.
    Reload,
    /// The terminal that the service was started from is gone.
    TerminalClosed,
}

/// SIGHUP, from the moment this is made; never where there is no such signal.
pub struct HangUps {
    #[cfg(unix)]
    signal: Option<tokio::signal::unix::Signal>,
    /// Whether there is a terminal that can be closed.
    attached: bool,
}

impl HangUps {
    /// Takes the signal over: it no longer ends the process by itself.
    pub fn listen() -> Self {
        Self {
            #[cfg(unix)]
            signal: tokio::signal::unix::signal(tokio::signal::unix::SignalKind::hangup()).ok(),
            attached: std::io::stdin().is_terminal(),
        }
    }

    /// The next one.
    pub async fn next(&mut self) -> HangUp {
        #[cfg(unix)]
        if let Some(signal) = &mut self.signal {
            if signal.recv().await.is_none() {
                std::future::pending::<()>().await;
            }
            // A closed terminal is none any more by the time it sends the signal.
            return if self.attached && !std::io::stdin().is_terminal() {
                HangUp::TerminalClosed
            } else {
                HangUp::Reload
            };
        }
        std::future::pending().await
    }
}
