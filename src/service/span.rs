//! Neighbouring objects by number: `start`, `end` and `revision` in the query.

use std::ops::Range;

use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::Response;

use super::problem::{Kind, Problem};
use super::scenes::City;
use super::visible::{COUNT, Parameter, REVISION, unknown};

/// Objects `start .. end` of a city.
#[derive(Debug)]
pub struct Span {
    /// Their numbers.
    pub range: Range<u32>,
    /// Whether the revision was named, and is the one served.
    pinned: bool,
}

impl Span {
    /// Reads a query; without `end` the span goes on as far as there are objects, up to `most`.
    ///
    /// # Errors
    /// 400 for what is not a number, 409 for another revision, 422 for more than there is or than
    /// `most`.
    pub fn read(city: &City, query: &str, most: u32) -> Result<Self, Problem> {
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
                _ => return Err(unknown(&name, &["start", "end", "revision"])),
            };
            if twice {
                return Err(parameter.problem("is given twice"));
            }
        }
        if let Some(revision) = &revision {
            check_revision(city, revision)?;
        }
        let start = start.unwrap_or(0);
        let end = end.unwrap_or_else(|| count.min(start.saturating_add(most)).max(start));
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
        if end - start > most {
            let detail = format!("ask for at most {most} objects at once");
            return impossible("end", detail);
        }
        Ok(Self {
            range: start..end,
            pinned: revision.is_some(),
        })
    }

    /// Says in the head of an answer what it is about, and that it may be kept for ever where the
    /// address names the contents.
    pub fn describe(&self, city: &City, response: &mut Response) {
        let headers = response.headers_mut();
        headers.insert(COUNT, HeaderValue::from(self.range.len()));
        pin(city, self.pinned, headers);
    }
}

/// That a city has this revision.
///
/// # Errors
/// 409.
pub fn check_revision(city: &City, revision: &str) -> Result<(), Problem> {
    let serves = city.revision();
    if revision == serves {
        return Ok(());
    }
    let detail = format!("the scene has revision {serves}, not {revision}");
    Err(Problem::new(Kind::StaleRevision, detail).at("revision"))
}

/// Says which revision an answer is of, and where the address names it that the answer may be
/// kept for ever.
pub fn pin(city: &City, pinned: bool, headers: &mut HeaderMap) {
    headers.insert(REVISION, city.revision_header().clone());
    if pinned {
        let forever = HeaderValue::from_static("public, max-age=31536000, immutable");
        headers.insert(header::CACHE_CONTROL, forever);
    }
}
