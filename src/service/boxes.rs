//! `/collections/{scene}/boxes`: the geometry a viewer needs once, in bulk.

use std::ops::Range;
use std::sync::Arc;

use axum::body::Body;
use axum::extract::{RawQuery, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::Response;

use super::documents::{cached, make};
use super::negotiate::accepted;
use super::problem::{Kind, Problem};
use super::routes::SceneName;
use super::scenes::City;
use super::shared::Shared;
use super::visible::{COUNT, Parameter, REVISION, unknown};
use crate::index::LodTree;

/// Most boxes in one answer: 24 MB.
pub const MOST_BOXES: u32 = 1_000_000;

/// Length of a box, bytes.
const BOX: usize = 24;

/// Header: what the coordinates are relative to, `x,y,z` in scene coordinates.
pub const ORIGIN: HeaderName = HeaderName::from_static("x-citylod-origin");

/// `GET`: boxes `start .. end`, six f32 each (min x, y, z, max x, y, z), little endian, rounded
/// outward, relative to the origin.
pub async fn boxes(
    State(shared): State<Arc<Shared>>,
    SceneName(name): SceneName,
    RawQuery(query): RawQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let city = shared.city(&name)?;
    accepted(&headers, &["application/octet-stream"])?;
    let wanted = Wanted::read(&city, &query.unwrap_or_default())?;
    let mut response = cached(&headers, city.etag(), || {
        let range = wanted.range.clone();
        let body = make(range.len() * BOX, || encode(city.tree(), range));
        let mut response = Response::new(Body::from(body));
        let binary = HeaderValue::from_static("application/octet-stream");
        response.headers_mut().insert(header::CONTENT_TYPE, binary);
        response
    });
    let [x, y, z] = city.tree().origin().to_array();
    let headers = response.headers_mut();
    headers.insert(COUNT, HeaderValue::from(wanted.range.len()));
    headers.insert(REVISION, city.revision_header().clone());
    if let Ok(origin) = HeaderValue::try_from(format!("{x},{y},{z}")) {
        headers.insert(ORIGIN, origin);
    }
    if wanted.pinned {
        // The address names the contents.
        let forever = HeaderValue::from_static("public, max-age=31536000, immutable");
        headers.insert(header::CACHE_CONTROL, forever);
    }
    Ok(response)
}

struct Wanted {
    range: Range<u32>,
    /// Whether the revision was named, and is the one served.
    pinned: bool,
}

impl Wanted {
    fn read(city: &City, query: &str) -> Result<Self, Problem> {
        let count = city.tree().object_count();
        let (mut start, mut end, mut revision) = (None, None, None);
        for (name, text) in form_urlencoded::parse(query.as_bytes()) {
            let parameter = Parameter {
                name: &name,
                text: &text,
            };
            let twice = match &*name {
                "start" => start.replace(parameter.whole(&text)?.0).is_some(),
                "end" => end.replace(parameter.whole(&text)?.0).is_some(),
                "revision" => revision.replace(text.to_string()).is_some(),
                _ => return Err(unknown(&name)),
            };
            if twice {
                return Err(parameter.problem("is given twice"));
            }
        }
        let serves = city.tree().revision();
        if let Some(revision) = &revision
            && *revision != serves
        {
            let detail = format!("the scene has revision {serves}, not {revision}");
            return Err(Problem::new(Kind::StaleRevision, detail).at("revision"));
        }
        let start = start.unwrap_or(0);
        let end = end.unwrap_or_else(|| count.min(start.saturating_add(MOST_BOXES)).max(start));
        let impossible =
            |name: &str, detail: String| Err(Problem::new(Kind::ImpossibleValue, detail).at(name));
        if start > count {
            return impossible(
                "start",
                format!("the scene has {count} objects, not {start}"),
            );
        }
        if end > count {
            return impossible("end", format!("the scene has {count} objects, not {end}"));
        }
        if start > end {
            return impossible(
                "end",
                format!("must not be less than start ({start}), is {end}"),
            );
        }
        if end - start > MOST_BOXES {
            let detail = format!("ask for at most {MOST_BOXES} boxes at once");
            return impossible("end", detail);
        }
        Ok(Self {
            range: start..end,
            pinned: revision.is_some(),
        })
    }
}

fn encode(tree: &LodTree, range: Range<u32>) -> Vec<u8> {
    let mut out = Vec::with_capacity(range.len() * BOX);
    for corners in range.filter_map(|object| tree.relative_box(object)) {
        for corner in corners {
            out.extend_from_slice(&corner.to_le_bytes());
        }
    }
    out
}
