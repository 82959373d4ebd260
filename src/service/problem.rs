//! Problem documents (RFC 9457): the one form in which the service says no.

use axum::body::Body;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Serialize, Serializer};

/// What can go wrong, each with one status and one title. The page at `/` explains every kind;
/// `type` links there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The body is no JSON.
    MalformedJson,
    /// A type, a member or a parameter is not one the request has, or one is missing.
    InvalidRequest,
    /// It reads well, but no camera and no level of detail has such values.
    ImpossibleValue,
    /// It could be, but takes longer than the service gives it.
    TooCostly,
    /// No such scene, object or path.
    NotFound,
    /// The path has other methods.
    MethodNotAllowed,
    /// None of the forms asked for can be given.
    NotAcceptable,
    /// The request did not arrive in time.
    Timeout,
    /// The scene has changed since the revision asked for.
    StaleRevision,
    /// The body is longer than the limit.
    TooLarge,
    /// The answer would list more than the limit.
    AnswerTooLarge,
    /// The body is of another type than the service reads.
    UnsupportedMediaType,
    /// The path is that of a WebSocket.
    UpgradeRequired,
    /// A defect of the service.
    Internal,
    /// Too many requests at once.
    Overloaded,
}

impl Kind {
    /// All kinds, by status.
    pub const ALL: [Self; 15] = [
        Self::MalformedJson,
        Self::InvalidRequest,
        Self::ImpossibleValue,
        Self::TooCostly,
        Self::NotFound,
        Self::MethodNotAllowed,
        Self::NotAcceptable,
        Self::Timeout,
        Self::StaleRevision,
        Self::TooLarge,
        Self::AnswerTooLarge,
        Self::UnsupportedMediaType,
        Self::UpgradeRequired,
        Self::Internal,
        Self::Overloaded,
    ];

    /// Status, last part of the type, title.
    pub const fn parts(self) -> (StatusCode, &'static str, &'static str) {
        match self {
            Self::MalformedJson => (
                StatusCode::BAD_REQUEST,
                "malformed-json",
                "The body is not JSON",
            ),
            Self::InvalidRequest => (
                StatusCode::BAD_REQUEST,
                "invalid-request",
                "The request cannot be read",
            ),
            Self::ImpossibleValue => (
                StatusCode::UNPROCESSABLE_ENTITY,
                "impossible-value",
                "The request describes nothing that can be",
            ),
            Self::TooCostly => (
                StatusCode::UNPROCESSABLE_ENTITY,
                "too-costly",
                "The request takes too long to answer",
            ),
            Self::NotFound => (StatusCode::NOT_FOUND, "not-found", "There is no such thing"),
            Self::MethodNotAllowed => (
                StatusCode::METHOD_NOT_ALLOWED,
                "method-not-allowed",
                "The path has other methods",
            ),
            Self::NotAcceptable => (
                StatusCode::NOT_ACCEPTABLE,
                "not-acceptable",
                "No acceptable form of the answer",
            ),
            Self::Timeout => (
                StatusCode::REQUEST_TIMEOUT,
                "timeout",
                "The request took too long to arrive",
            ),
            Self::StaleRevision => (
                StatusCode::CONFLICT,
                "stale-revision",
                "The scene has another revision now",
            ),
            Self::TooLarge => (
                StatusCode::PAYLOAD_TOO_LARGE,
                "too-large",
                "The body is longer than the limit",
            ),
            Self::AnswerTooLarge => (
                StatusCode::PAYLOAD_TOO_LARGE,
                "answer-too-large",
                "The answer would be larger than the limit",
            ),
            Self::UnsupportedMediaType => (
                StatusCode::UNSUPPORTED_MEDIA_TYPE,
                "unsupported-media-type",
                "The body must be JSON",
            ),
            Self::UpgradeRequired => (
                StatusCode::UPGRADE_REQUIRED,
                "upgrade-required",
                "This is a WebSocket",
            ),
            Self::Internal => (
                StatusCode::INTERNAL_SERVER_ERROR,
                "internal",
                "The service failed",
            ),
            Self::Overloaded => (
                StatusCode::SERVICE_UNAVAILABLE,
                "overloaded",
                "Too many requests at once",
            ),
        }
    }
}

/// One refusal: what kind, why, and where in the request.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    kind: Kind,
    detail: String,
    pointer: Option<String>,
    place: Option<(usize, usize)>,
}

/// As it is sent.
#[derive(Serialize)]
struct Document<'a> {
    r#type: String,
    title: &'a str,
    status: u16,
    detail: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pointer: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    column: Option<usize>,
}

impl Problem {
    /// A problem of the request as a whole.
    pub fn new(kind: Kind, detail: impl Into<String>) -> Self {
        Self {
            kind,
            detail: detail.into(),
            pointer: None,
            place: None,
        }
    }

    /// Why, and where, in one line; a place that the detail has in its words is not said twice.
    pub fn reason(&self) -> String {
        let is_of_name = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
        let mut words = self.detail.split(|c| !is_of_name(c));
        match &self.pointer {
            Some(pointer) if !pointer.is_empty() && words.all(|word| word != pointer) => {
                format!("{pointer}: {}", self.detail)
            }
            _ => self.detail.clone(),
        }
    }

    /// Names the part at fault: a JSON pointer into the body, or the name of a parameter.
    #[must_use]
    pub fn at(mut self, pointer: impl Into<String>) -> Self {
        self.pointer = Some(pointer.into());
        self
    }

    /// Names the place in the text of the body, both counted from 1.
    #[must_use]
    pub fn on_line(mut self, line: usize, column: usize) -> Self {
        self.place = Some((line, column));
        self
    }
}

/// Media type of a problem document.
pub const PROBLEM_JSON: HeaderValue = HeaderValue::from_static("application/problem+json");

impl Serialize for Problem {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let (status, slug, title) = self.kind.parts();
        let document = Document {
            r#type: format!("/#{slug}"),
            title,
            status: status.as_u16(),
            detail: &self.detail,
            pointer: self.pointer.as_deref(),
            line: self.place.map(|(line, _)| line),
            column: self.place.map(|(_, column)| column),
        };
        document.serialize(to)
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let (status, ..) = self.kind.parts();
        let body = serde_json::to_vec(&self).unwrap_or_default();
        let mut response = Response::new(Body::from(body));
        *response.status_mut() = status;
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, PROBLEM_JSON);
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        match self.kind {
            Kind::Overloaded => {
                headers.insert(header::RETRY_AFTER, HeaderValue::from_static("1"));
            }
            Kind::UpgradeRequired => {
                // RFC 9110, section 7.8, and RFC 6455, section 4.4.
                for (name, value) in [
                    (header::UPGRADE, "websocket"),
                    (header::CONNECTION, "upgrade"),
                    (header::SEC_WEBSOCKET_VERSION, "13"),
                ] {
                    headers.insert(name, HeaderValue::from_static(value));
                }
            }
            // What is left of the body would be read as the next request.
            Kind::Timeout | Kind::TooLarge => {
                headers.insert(header::CONNECTION, HeaderValue::from_static("close"));
            }
            _ => {}
        }
        // For the log.
        response.extensions_mut().insert(self);
        response
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reason_names_the_place_once() {
        for (place, detail, reason) in [
            ("far", "must be a number", "far: must be a number"),
            (
                "far",
                "far_dist_m is too large",
                "far: far_dist_m is too large",
            ),
            (
                "scene",
                "there is no scene \"x\"",
                "there is no scene \"x\"",
            ),
            (
                "Content-Type",
                "Content-Type must be application/json, is \"\"",
                "Content-Type must be application/json, is \"\"",
            ),
            ("", "the body is empty", "the body is empty"),
            ("/far", "far is null", "/far: far is null"),
        ] {
            let problem = Problem::new(Kind::InvalidRequest, detail).at(place);
            assert_eq!(problem.reason(), reason);
        }
    }
}
