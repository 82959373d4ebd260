//! The document at `/metrics`.

use std::sync::Arc;

use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};

use super::super::negotiate::accepted;
use super::super::problem::Problem;
use super::super::shared::Shared;
use super::counted::StreamMetrics;
use super::process;
use super::text::Text;

/// The text format that every Prometheus reads.
const TEXT: &str = "text/plain; version=0.0.4; charset=utf-8";

/// `GET /metrics`.
pub async fn get(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    accepted(&headers, &["text/plain"])?;
    let plain = HeaderValue::from_static(TEXT);
    let no_store = HeaderValue::from_static("no-store");
    let headers = [
        (header::CONTENT_TYPE, plain),
        (header::CACHE_CONTROL, no_store),
    ];
    Ok((headers, write(&shared)).into_response())
}

fn write(shared: &Shared) -> String {
    let metrics = shared.metrics();
    let mut text = Text::default();
    let version = [("version", env!("CARGO_PKG_VERSION"))];
    text.gauge("citylod_build_info", "The version that runs; always 1.")
        .value(&version, 1.0);
    metrics.requests.write(&mut text);
    text.gauge(
        "citylod_http_connections",
        "Open connections, without streams.",
    )
    .value(&[], metrics.connections.value() as f64);
    write_streams(&metrics.streams, &mut text);
    let mut reloads = text.counter(
        "citylod_scene_reloads_total",
        "Times the scenes were read again.",
    );
    for (counter, result) in metrics.reloads.iter().zip(["ok", "failed"]) {
        reloads.value(&[("result", result)], counter.value() as f64);
    }
    let scenes = shared.scenes();
    let mut objects = text.gauge("citylod_scene_objects", "Objects of each scene.");
    for city in scenes.iter() {
        let count = f64::from(city.tree().object_count());
        objects.value(&[("scene", city.name())], count);
    }
    process::write(metrics.started, &mut text);
    text.finish()
}

fn write_streams(streams: &StreamMetrics, text: &mut Text) {
    text.gauge("citylod_streams", "Open streams.")
        .value(&[], streams.open.value() as f64);
    for (name, help, counter) in [
        (
            "citylod_stream_messages_total",
            "Messages that arrived on streams.",
            &streams.messages,
        ),
        (
            "citylod_stream_messages_refused_total",
            "Messages answered by a problem.",
            &streams.refused,
        ),
        (
            "citylod_stream_messages_skipped_total",
            "Messages not answered because a newer one had arrived.",
            &streams.skipped,
        ),
    ] {
        text.counter(name, help).value(&[], counter.value() as f64);
    }
    let mut moved = text.counter(
        "citylod_stream_objects_total",
        "Objects that answers on streams added and removed.",
    );
    for (counter, change) in streams.moved.iter().zip(["add", "remove"]) {
        moved.value(&[("change", change)], counter.value() as f64);
    }
    text.histogram(
        "citylod_stream_answer_duration_seconds",
        "From the arrival of a message to its answer.",
    )
    .samples(&[], &streams.answers);
    let mut ended = text.counter("citylod_streams_ended_total", "Streams that ended.");
    for (end, count) in streams.ended.iter() {
        ended.value(&[("reason", end.label())], count as f64);
    }
}
