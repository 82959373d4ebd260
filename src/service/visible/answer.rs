//! From a selection to bytes. Ids are stored ready for JSON, so an answer is made by copying.

use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::Response;
use serde::Serialize;

use super::super::problem::{Kind, Problem};
use super::super::scenes::City;
use super::feedback::Steered;
use super::request::Form;
use super::tail::Tail;
use crate::lod::Selection;

/// Header of a binary answer: how many numbers the body has.
pub const COUNT: header::HeaderName = header::HeaderName::from_static("x-citylod-count");
/// Header of a binary answer: what the numbers refer to.
pub const REVISION: header::HeaderName = header::HeaderName::from_static("x-citylod-revision");
/// Header of a binary answer: the bound, pixels; left out when infinite.
pub const ERROR_PX: header::HeaderName = header::HeaderName::from_static("x-citylod-error-px");

/// Header of a binary answer: what the controller chose, as JSON.
pub const FEEDBACK: header::HeaderName = header::HeaderName::from_static("x-citylod-feedback");

#[derive(Serialize)]
struct ObjectItem<'a> {
    index: u32,
    id: &'a str,
    class: &'a str,
    level: u32,
    bounds: [f64; 6],
}

fn finite(number: f64) -> Option<f64> {
    number.is_finite().then_some(number)
}

/// About how many bytes the answer takes.
///
/// # Errors
/// 413 when it would list more than `most` ids, or about as many bytes in another form.
pub fn size(form: Form, binary: bool, selection: &Selection, most: u32) -> Result<usize, Problem> {
    let count = selection.count() as usize;
    let (listed, what, most) = match form {
        _ if binary => (count, "numbers", u64::from(most) * 4),
        Form::Ids => (count, "ids", u64::from(most)),
        Form::Objects => (count, "objects", u64::from(most) / 10),
        Form::Ranges => {
            let listed = selection.ranges().len();
            size_of_ranges(listed, selection, most)?;
            return Ok(list_len(form, selection));
        }
    };
    let other = ", as ranges, or with Accept: application/octet-stream";
    within(listed, what, most, selection, other)?;
    Ok(if binary {
        listed * size_of::<u32>()
    } else {
        list_len(form, selection)
    })
}

/// Refuses an answer with more than `most` ranges.
///
/// # Errors
/// 413.
pub fn size_of_ranges(listed: usize, selection: &Selection, most: u32) -> Result<(), Problem> {
    within(listed, "ranges", u64::from(most), selection, "")
}

fn within(
    listed: usize,
    what: &str,
    most: u64,
    selection: &Selection,
    other: &str,
) -> Result<(), Problem> {
    if listed as u64 <= most {
        return Ok(());
    }
    let count = selection.count();
    let detail = format!(
        "{count} objects are visible; an answer may list {most} {what}: ask for less detail \
         (a smaller far_dist_m, a larger max_error_px, a smaller max_objects){other}"
    );
    Err(Problem::new(Kind::AnswerTooLarge, detail))
}

/// The answer as JSON.
pub fn json(city: &City, form: Form, selection: &Selection, tail: &Tail) -> Vec<u8> {
    let mut out = Vec::with_capacity(city.head().len() + list_len(form, selection) + TAIL);
    out.extend_from_slice(city.head());
    append(&mut out, &selection.count());
    match form {
        Form::Ids => {
            out.extend_from_slice(b",\"ids\":[");
            city.tree().append_ids_json(selection.ranges(), &mut out);
        }
        Form::Objects => {
            out.extend_from_slice(b",\"objects\":[");
            for object in selection.objects() {
                if let Some(known) = city.tree().object(object) {
                    let item = ObjectItem {
                        index: object,
                        id: &known.id,
                        class: known.class,
                        level: known.level,
                        bounds: known.bounds.to_array(),
                    };
                    append(&mut out, &item);
                    out.push(b',');
                }
            }
        }
        Form::Ranges => {
            out.extend_from_slice(b",\"ranges\":[");
            for range in selection.ranges() {
                append(&mut out, &[range.start, range.end]);
                out.push(b',');
            }
        }
    }
    if out.last() == Some(&b',') {
        out.pop();
    }
    out.extend_from_slice(b"],");
    // The tail is an object of its own but for its opening brace.
    let at = out.len();
    append(&mut out, tail);
    out.remove(at);
    out
}

/// Everything but the list, the head and the pixels takes less, whatever the numbers.
const TAIL: usize = 1536;

/// About how long the list becomes.
fn list_len(form: Form, selection: &Selection) -> usize {
    match form {
        Form::Ids => selection.count() as usize * 16,
        Form::Objects => selection.count() as usize * 192,
        Form::Ranges => selection.ranges().len() * 24,
    }
}

fn append(out: &mut Vec<u8>, value: &impl Serialize) {
    let before = out.len();
    if serde_json::to_writer(&mut *out, value).is_err() {
        // Numbers and strings into memory: there is nothing to fail.
        out.truncate(before);
        out.extend_from_slice(b"null");
    }
}

/// The answer as object numbers, u32 little endian, ascending.
pub fn numbers(selection: &Selection) -> Vec<u8> {
    let mut out = Vec::with_capacity(selection.count() as usize * size_of::<u32>());
    for object in selection.objects() {
        out.extend_from_slice(&object.to_le_bytes());
    }
    out
}

/// A response with a body of this type.
pub fn response(body: Vec<u8>, media_type: HeaderValue) -> Response {
    let mut response = Response::new(Body::from(Bytes::from(body)));
    response
        .headers_mut()
        .insert(header::CONTENT_TYPE, media_type);
    response
}

/// What a binary answer says beside its body.
pub fn describe(
    headers: &mut HeaderMap,
    city: &City,
    selection: &Selection,
    steered: Option<&Steered>,
) {
    headers.insert(COUNT, HeaderValue::from(selection.count()));
    headers.insert(REVISION, city.revision_header().clone());
    if let Some(error_px) = finite(selection.error_px())
        && let Ok(value) = HeaderValue::try_from(error_px.to_string())
    {
        headers.insert(ERROR_PX, value);
    }
    if let Some(steered) = steered
        && let Ok(text) = serde_json::to_string(steered)
        && let Ok(value) = HeaderValue::try_from(text)
    {
        headers.insert(FEEDBACK, value);
    }
}
