//! `/collections/{scene}/visible`: which objects to draw for a camera.

mod answer;
mod effects;
mod feedback;
mod query;
pub mod request;
mod resolve;
mod tail;
mod undeclared;

use std::cell::RefCell;
use std::sync::Arc;
use std::time::Instant;

use axum::extract::{FromRequestParts, RawQuery, Request, State};
use axum::http::{HeaderMap, HeaderValue};
use axum::response::Response;

pub use answer::{COUNT, REVISION, size_of_ranges};
pub use feedback::Feedback;
pub use query::{Parameter, unknown};
pub use resolve::{Naming, Resolved};
pub use tail::{Lists, Tail};

use super::body;
use super::config::Config;
use super::documents::make;
use super::json;
use super::negotiate::{accepted, json_body};
use super::problem::{Kind, Problem};
use super::routes::SceneName;
use super::scenes::City;
use super::shared::Shared;
use crate::frame::{Active, Frame};
use request::Body;

const JSON: &str = "application/json";
const BINARY: &str = "application/octet-stream";

thread_local! {
    /// Kept from request to request, so that a frame allocates next to nothing.
    static FRAME: RefCell<Frame> = RefCell::default();
}

/// `POST`: the request is a JSON document.
pub async fn post(
    State(shared): State<Arc<Shared>>,
    request: Request,
) -> Result<Response, Problem> {
    let (mut parts, body) = request.into_parts();
    let city = if let Some(name) = plain_name(parts.uri.path()) {
        shared.city(name)?
    } else {
        let SceneName(name) = SceneName::from_request_parts(&mut parts, &shared).await?;
        shared.city(&name)?
    };
    json_body(&parts.headers)?;
    let form = accepted(&parts.headers, &[JSON, BINARY])?;
    let bytes = body::read(&parts.headers, body, shared.config().max_body_bytes).await?;
    let Body(request) = json::read(&bytes)?;
    respond(&shared, &city, &request, Naming::Pointer, form == BINARY)
}

/// `GET`: the request is in the query.
pub async fn get(
    State(shared): State<Arc<Shared>>,
    SceneName(name): SceneName,
    RawQuery(query): RawQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let city = shared.city(&name)?;
    let form = accepted(&headers, &[JSON, BINARY])?;
    let request = query::read(&query.unwrap_or_default())?;
    respond(&shared, &city, &request, Naming::Parameter, form == BINARY)
}

/// The scene of an address, where it is written without escapes: nothing needs to be allocated.
fn plain_name(path: &str) -> Option<&str> {
    let (name, _) = path.strip_prefix("/collections/")?.split_once('/')?;
    memchr::memchr(b'%', name.as_bytes())
        .is_none()
        .then_some(name)
}

fn respond(
    shared: &Shared,
    city: &City,
    request: &request::Request,
    naming: Naming,
    binary: bool,
) -> Result<Response, Problem> {
    let mut asked = request.resolve(city.tree().effects(), naming)?;
    if binary {
        request.output.check_binary(naming)?;
    }
    request.check_lists(true, binary, naming)?;
    let steered = match &request.feedback {
        Some(feedback) => {
            let (lod, steered) = feedback.steer(&asked.lod, naming)?;
            asked.lod = lod;
            Some(steered)
        }
        None => None,
    };
    with_frame(city, &asked, shared.config(), |frame| {
        let (selection, form) = (frame.selection(), request.output.form);
        let size = answer::size(form, binary, selection, shared.config().max_answer_objects)?;
        Ok(if binary {
            let body = make(size, || answer::numbers(selection));
            let mut response = answer::response(body, HeaderValue::from_static(BINARY));
            answer::describe(response.headers_mut(), city, selection, steered.as_ref());
            response
        } else {
            let lists = Lists {
                pixels: request.effects.visible_pixels(),
                patches: request.effects.patches(),
            };
            let tail = Tail::of(frame, lists);
            let tail = tail.with_feedback(steered.as_ref());
            let body = make(size, || answer::json(city, form, selection, &tail));
            answer::response(body, HeaderValue::from_static(JSON))
        })
    })
}

/// Works out what to draw and makes something of it.
///
/// # Errors
/// 422 where occlusion takes too long, and what `then` says.
pub fn with_frame<T>(
    city: &City,
    asked: &Resolved,
    config: &Config,
    then: impl FnOnce(&Frame) -> Result<T, Problem>,
) -> Result<T, Problem> {
    // Taken out, so that one of which the work panicked is not seen again.
    let mut frame = FRAME.take();
    work_out(&mut frame, city, asked, config);
    let made = if frame.gave_up() {
        Err(too_costly(&frame, config))
    } else {
        then(&frame)
    };
    FRAME.set(frame);
    made
}

fn work_out(frame: &mut Frame, city: &City, asked: &Resolved, config: &Config) {
    let Resolved { view, lod, active } = asked;
    let start = Instant::now();
    let mut work = |active: &Active| match city.land() {
        Some(land) => frame.work_out_on(land, city.tree(), view, lod, active, || start.elapsed()),
        None => frame.work_out(city.tree(), view, lod, active, || start.elapsed()),
    };
    if asked.is_dear() {
        let patience = Some(config.max_occlusion);
        let active = Active {
            patience,
            ..*active
        };
        make(usize::MAX, || work(&active)); // as long as there are objects
    } else {
        work(active);
    }
}

fn too_costly(frame: &Frame, config: &Config) -> Problem {
    let ms = config.max_occlusion.as_millis();
    let count = frame.selection().count();
    let detail = format!(
        "occlusion of {count} objects takes longer than {ms} ms (option --max-occlusion-ms): \
         ask for less detail, a smaller width_px, or switch it off"
    );
    Problem::new(Kind::TooCostly, detail)
}
