//! The HTTP service over real sockets.

/// Each route, and which form the answer takes.
mod answers;
/// The description and the routes agree; every example of it works.
mod description;
/// Effects asked for, switched off, and not declared.
mod effects;
/// Limits on size, time and number; panics; stopping.
mod limits;
/// What malformed requests get, and where the document says the fault is.
mod malformed;
/// Property tests of the description against the service, by schemathesis.
mod schemathesis;
/// A server to talk to, and a small client.
mod server;
/// The viewer and what it is given beside the answers.
mod viewer;
