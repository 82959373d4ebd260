//! Listening, serving connections, stopping without dropping requests.

use std::convert::Infallible;
use std::future::Future;
use std::io;
use std::net::SocketAddr;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::http::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpStream};

use super::gate::Gate;
use super::patience::Patient;
use super::places::{Place, Places};
use super::shared::Shared;

/// The service could not start.
#[derive(Debug, thiserror::Error)]
#[error("cannot listen on {address}")]
pub struct ListenError {
    /// Where.
    pub address: SocketAddr,
    /// Why not.
    pub source: io::Error,
}

/// A router on a socket.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    gate: Gate,
    shared: Arc<Shared>,
}

impl Server {
    /// Takes the address; requests wait until [`Server::run`].
    ///
    /// # Errors
    /// [`ListenError`] when the address is taken or not ours.
    pub async fn bind(shared: Arc<Shared>, router: Router) -> Result<Self, ListenError> {
        let config = shared.config();
        let failed = |source| ListenError {
            address: config.listen,
            source,
        };
        let listener = TcpListener::bind(config.listen).await.map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        Ok(Self {
            gate: Gate::new(router, Arc::clone(&shared)),
            listener,
            address,
            shared,
        })
    }

    /// Where it listens; the port is the real one.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Serves until `stop` is done, then lets requests in work finish and tells streams to end,
    /// for `drain` at most.
    pub async fn run(self, stop: impl Future<Output = ()>) {
        let config = *self.shared.config();
        let mut http = http1::Builder::new();
        http.timer(TokioTimer::new())
            .header_read_timeout(config.timeout);
        let places = Places::new(config.max_connections);
        let mut stop = pin!(stop);
        loop {
            let next = async {
                let place = places.take().await;
                (place, self.accept().await)
            };
            let (place, stream) = tokio::select! {
                next = next => next,
                () = &mut stop => break,
            };
            tokio::spawn(self.connection(&http, stream, place));
        }
        drop(self.listener);
        self.shared.close();
        let all = async {
            places.all_free().await;
            self.shared.streams().all_free().await;
        };
        if tokio::time::timeout(config.drain, all).await.is_err() {
            tracing::warn!("requests were still in work when the time to finish was over");
        }
    }

    /// One connection from its first byte to its last, or until it becomes a stream.
    fn connection(
        &self,
        http: &http1::Builder,
        stream: TcpStream,
        place: Place,
    ) -> impl Future<Output = ()> + Send + 'static {
        let gate = self.gate.clone();
        let service = service_fn(move |request: Request<Incoming>| {
            let gate = gate.clone();
            async move { Ok::<_, Infallible>(gate.respond(request.map(Body::new)).await) }
        });
        let shared = Arc::clone(&self.shared);
        let io = Patient::new(TokioIo::new(stream), shared.config().timeout);
        let connection = http.serve_connection(io, service).with_upgrades();
        async move {
            let open = shared.metrics().connections.enter();
            let mut connection = pin!(connection);
            let ended = tokio::select! {
                biased;
                ended = connection.as_mut() => ended,
                () = shared.closed() => {
                    connection.as_mut().graceful_shutdown();
                    connection.await
                }
            };
            if let Err(error) = ended {
                tracing::debug!(%error, "connection ended");
            }
            drop(open);
            drop(place);
        }
    }

    async fn accept(&self) -> TcpStream {
        loop {
            match self.listener.accept().await {
                Ok((stream, _)) => {
                    if let Err(error) = stream.set_nodelay(true) {
                        tracing::debug!(%error, "cannot switch off Nagle's algorithm");
                    }
                    return stream;
                }
                Err(error) => {
                    // Out of file descriptors, mostly: connections that end give some back.
                    tracing::warn!(%error, "cannot accept a connection");
                    tokio::time::sleep(Duration::from_millis(100)).await;
                }
            }
        }
    }
}
