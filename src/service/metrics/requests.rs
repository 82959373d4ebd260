//! Requests by path and status, and how long they took.

use std::time::Duration;

use axum::http::StatusCode;

use super::count::{Counter, Histogram};
use super::text::Text;

/// Paths as they are told apart; the last stands for all that there are not.
const PLACES: [&str; 17] = [
    "/",
    "/about",
    "/api",
    "/conformance",
    "/health",
    "/metrics",
    "/collections",
    "/assets/{file}",
    "/collections/{scene}/visible",
    "/collections/{scene}",
    "/collections/{scene}/stream",
    "/collections/{scene}/boxes",
    "/collections/{scene}/items",
    "/collections/{scene}/items/{id}",
    "/collections/{scene}/plan.svg",
    "/collections/{scene}/ground/{level}/{x}/{y}",
    "other",
];

/// Where the parts of the viewer lie in [`PLACES`], behind all that are told by their whole path.
const ASSETS: usize = 7;
/// Where the places below a scene begin.
const OF_SCENES: usize = ASSETS + 1;

/// As many as there are statuses.
const STATUSES: usize = 500;

#[derive(Debug)]
struct Place {
    /// By status, from 100 on.
    answers: [Counter; STATUSES],
    durations: Histogram,
}

impl Default for Place {
    fn default() -> Self {
        Self {
            answers: std::array::from_fn(|_| Counter::default()),
            durations: Histogram::default(),
        }
    }
}

/// What is counted of requests.
#[derive(Debug, Default)]
pub struct Requests {
    places: Box<[Place; PLACES.len()]>,
}

impl Requests {
    /// Counts a request.
    pub fn count(&self, path: &str, status: StatusCode, took: Duration) {
        let place = &self.places[place_of(path)];
        let status = usize::from(status.as_u16()).saturating_sub(100);
        place.answers[status.min(STATUSES - 1)].add(1);
        place.durations.observe(took);
    }

    /// Writes all that is not zero.
    pub(super) fn write(&self, text: &mut Text) {
        let places = || PLACES.iter().zip(self.places.iter());
        let mut requests = text.counter("citylod_http_requests_total", "Requests answered.");
        for (path, place) in places() {
            for (at, counter) in place.answers.iter().enumerate() {
                if counter.value() > 0 {
                    let status = (at + 100).to_string();
                    let labels = [("path", *path), ("status", status.as_str())];
                    requests.value(&labels, counter.value() as f64);
                }
            }
        }
        let mut durations = text.histogram(
            "citylod_http_request_duration_seconds",
            "From the head of a request to the head of its answer.",
        );
        for (path, place) in places() {
            if place.durations.buckets().iter().any(|&count| count > 0) {
                durations.samples(&[("path", *path)], &place.durations);
            }
        }
    }
}

/// Which of [`PLACES`] an address is at. Most requests are for what is visible: that comes first.
fn place_of(path: &str) -> usize {
    let other = PLACES.len() - 1;
    let Some(below) = path.strip_prefix("/collections/") else {
        if path.starts_with("/assets/") {
            return ASSETS;
        }
        let top = PLACES[..ASSETS].iter().position(|place| *place == path);
        return top.unwrap_or(other);
    };
    let wanted = below.split_once('/').map_or("", |(_, wanted)| wanted);
    match wanted {
        "visible" => OF_SCENES,
        "" => OF_SCENES + 1,
        "stream" => OF_SCENES + 2,
        "boxes" => OF_SCENES + 3,
        "items" => OF_SCENES + 4,
        _ if wanted.starts_with("items/") => OF_SCENES + 5,
        "plan.svg" => OF_SCENES + 6,
        _ if wanted.starts_with("ground/") => OF_SCENES + 7,
        _ => other,
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::ROUTES;
    use super::{PLACES, place_of};

    #[test]
    fn every_route_is_counted_under_its_own_path() {
        for route in ROUTES {
            assert_eq!(PLACES[place_of(route.path)], route.path);
        }
        for path in ["", "/nothing", "/collections/a/b", "*"] {
            assert_eq!(PLACES[place_of(path)], "other", "{path}");
        }
    }
}
