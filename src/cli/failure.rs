//! What is said of a failure.

use std::error::Error;
use std::io::{self, ErrorKind};

use crate::service::ListenError;

/// The error and its causes. One that only repeats its own cause with more words, such as the
/// temporary name a file was written under, is passed over.
pub(super) fn told(error: &anyhow::Error) -> String {
    let mut doing = Doing::Reading;
    let texts: Vec<String> = error
        .chain()
        .map(|cause| {
            let text = text(cause, doing);
            if text.ends_with("cannot write") {
                doing = Doing::Writing;
            } else if cause.is::<ListenError>() {
                doing = Doing::Listening;
            }
            text
        })
        .collect();
    let told = (0..texts.len()).filter(|&at| match texts.get(at + 1) {
        Some(cause) => at == 0 || !texts[at].starts_with(cause.as_str()),
        None => at == 0 || !texts[at - 1].ends_with(texts[at].as_str()),
    });
    told.map(|at| texts[at].as_str())
        .collect::<Vec<_>>()
        .join(": ")
}

/// What failed.
#[derive(Clone, Copy, PartialEq)]
enum Doing {
    Reading,
    Writing,
    Listening,
}

fn text(error: &(dyn Error + 'static), doing: Doing) -> String {
    match error.downcast_ref::<io::Error>() {
        Some(io) if doing == Doing::Listening => of_address(io),
        Some(io) if io.get_ref().is_none() => plain(io, doing == Doing::Writing),
        _ => error.to_string(),
    }
}

/// What the system says of an address, in words that tell the way out.
fn of_address(error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::AddrInUse => {
            "another program listens there; stop it, or give another port: --listen 0 takes one that is free".into()
        }
        ErrorKind::AddrNotAvailable => {
            "it is no address of this machine; --listen 0.0.0.0:PORT takes all that it has".into()
        }
        ErrorKind::PermissionDenied => {
            "the system does not permit it; give a port from 1024 on with --listen".into()
        }
        _ => error.to_string(),
    }
}

/// What the system says, in words that tell the way out.
fn plain(error: &io::Error, writing: bool) -> String {
    match error.kind() {
        ErrorKind::NotFound if writing => "there is no such folder; make it first".into(),
        ErrorKind::NotFound => "there is no such file".into(),
        ErrorKind::PermissionDenied => {
            "the system does not permit it; `ls -l` tells who may".into()
        }
        ErrorKind::IsADirectory => "it is a folder; name a file".into(),
        ErrorKind::NotADirectory => "a part of its path is a file, not a folder".into(),
        ErrorKind::StorageFull => "the disk is full".into(),
        _ => error.to_string(),
    }
}

/// Whether what was printed is read no further.
pub(super) fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<io::Error>())
        .any(|io| io.kind() == ErrorKind::BrokenPipe)
}
