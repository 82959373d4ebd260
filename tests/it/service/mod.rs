//! The HTTP service over real sockets.

/// Each route, and which form the answer takes.
mod answers;
/// The description and the routes agree; every example of it works.
mod description;
/// Effects asked for, switched off, and not declared.
mod effects;
/// The controller over HTTP: settles, refuses, and keeps nothing.
mod feedback;
/// The ground over HTTP: tiles, patches, and what is refused.
mod ground;
/// Limits on size, time and number; panics; stopping.
mod limits;
/// What malformed requests get, and where the document says the fault is.
mod malformed;
/// What `/metrics` counts, and the names of requests.
mod metrics;
/// Property tests of the description against the service, by schemathesis.
mod schemathesis;
/// A server to talk to, and a small client.
mod server;
/// Streams: sets that grow and shrink with the camera, what holds and what is refused.
mod stream;
/// A client of streams, and the full answers to hold it against.
mod stream_client;
/// Why streams end, what the client is told, and that the service stays up.
mod stream_ends;
/// Streams whose scene is replaced.
mod stream_scenes;
/// The viewer and what it is given beside the answers.
mod viewer;
