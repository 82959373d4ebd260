//! What there is, as a table: the router is built from it, and a test holds `openapi.yaml`
//! against it.

use std::sync::Arc;

use axum::Router;
use axum::extract::path::ErrorKind;
use axum::extract::rejection::PathRejection;
use axum::extract::{FromRequestParts, Path};
use axum::http::request::Parts;
use axum::http::{Method, Uri};
use axum::routing::{MethodFilter, MethodRouter, on};

use super::problem::{Kind, Problem};
use super::shared::Shared;
use super::{boxes, collections, ground, items, landing, metrics, stream, viewer, visible};

/// A method of HTTP that the service uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verb {
    /// Also answers HEAD.
    Get,
    /// With a JSON body.
    Post,
}

impl Verb {
    /// As it is written.
    pub fn name(self) -> &'static str {
        match self {
            Self::Get => "GET",
            Self::Post => "POST",
        }
    }

    fn filter(self) -> MethodFilter {
        match self {
            Self::Get => MethodFilter::GET,
            Self::Post => MethodFilter::POST,
        }
    }
}

/// One operation.
#[derive(Debug, Clone, Copy)]
pub struct Route {
    /// How it is called.
    pub verb: Verb,
    /// Where, with `{parameters}` as in `OpenAPI`.
    pub path: &'static str,
    /// What it is for, in a few words.
    pub what: &'static str,
    handler: fn(MethodFilter) -> MethodRouter<Arc<Shared>>,
}

macro_rules! route {
    ($verb:ident $path:literal $handler:path, $what:literal) => {
        Route {
            verb: Verb::$verb,
            path: $path,
            what: $what,
            handler: |filter| on(filter, $handler),
        }
    };
}

/// Every operation of the service.
pub const ROUTES: &[Route] = &[
    route!(Get "/" landing::landing, "the viewer, or links for programs"),
    route!(Get "/about" landing::about, "this page"),
    route!(Get "/assets/{file}" viewer::asset, "parts of the viewer"),
    route!(Get "/api" landing::api, "the API as OpenAPI"),
    route!(Get "/conformance" landing::conformance, "the standards it follows"),
    route!(Get "/health" landing::health, "whether it is up"),
    route!(Get "/metrics" metrics::get, "counters for Prometheus"),
    route!(Get "/collections" collections::list, "the scenes"),
    route!(Get "/collections/{scene}" collections::one, "one scene: extent, counts, levels, classes"),
    route!(Get "/collections/{scene}/visible" visible::get, "what to draw for a camera given in the query"),
    route!(Post "/collections/{scene}/visible" visible::post, "what to draw for a camera given as JSON"),
    route!(Get "/collections/{scene}/items" items::items, "ids and classes of objects in bulk"),
    route!(Get "/collections/{scene}/stream" stream::get, "what comes and what goes as the camera moves, by WebSocket"),
    route!(Get "/collections/{scene}/items/{id}" items::item, "one object with its attributes"),
    route!(Get "/collections/{scene}/boxes" boxes::boxes, "boxes of objects in bulk, binary"),
    route!(Get "/collections/{scene}/ground/{level}/{x}/{y}" ground::tile, "posts of the ground, tile by tile, binary"),
    route!(Get "/collections/{scene}/plan.svg" collections::plan, "the scene from above"),
];

/// The routes, with the limits on bodies and answers; those on number and time are kept by
/// [`super::Server`].
pub fn router(shared: Arc<Shared>) -> Router {
    ROUTES
        .iter()
        .fold(Router::new(), |router, route| {
            router.route(route.path, (route.handler)(route.verb.filter()))
        })
        .fallback(no_such_path)
        .method_not_allowed_fallback(no_such_method)
        .with_state(shared)
}

async fn no_such_path(uri: Uri) -> Problem {
    let detail = format!(
        "there is nothing at {:?}: GET / lists what there is",
        uri.path()
    );
    Problem::new(Kind::NotFound, detail)
}

async fn no_such_method(method: Method, uri: Uri) -> Problem {
    let detail = format!("{:?} has no {method}: see the header Allow", uri.path());
    Problem::new(Kind::MethodNotAllowed, detail)
}

/// The path parameter `scene`, percent-decoded.
#[derive(Debug)]
pub struct SceneName(pub String);

impl FromRequestParts<Arc<Shared>> for SceneName {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, shared: &Arc<Shared>) -> Result<Self, Problem> {
        let path = Path::<String>::from_request_parts(parts, shared).await;
        path.map(|Path(scene)| Self(scene)).map_err(malformed)
    }
}

/// The path parameters `scene` and `id`, percent-decoded.
#[derive(Debug)]
pub struct ItemName {
    /// The scene.
    pub scene: String,
    /// The object.
    pub id: String,
}

impl FromRequestParts<Arc<Shared>> for ItemName {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, shared: &Arc<Shared>) -> Result<Self, Problem> {
        let path = Path::<(String, String)>::from_request_parts(parts, shared).await;
        path.map(|Path((scene, id))| Self { scene, id })
            .map_err(malformed)
    }
}

/// The path parameter `file`, percent-decoded.
#[derive(Debug)]
pub struct FileName(pub String);

impl FromRequestParts<Arc<Shared>> for FileName {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, shared: &Arc<Shared>) -> Result<Self, Problem> {
        let path = Path::<String>::from_request_parts(parts, shared).await;
        path.map(|Path(file)| Self(file)).map_err(malformed)
    }
}

/// The refusal of path parameters that cannot be read.
pub fn malformed(rejection: PathRejection) -> Problem {
    let PathRejection::FailedToDeserializePathParams(error) = rejection else {
        return Problem::new(Kind::NotFound, "the path cannot be read");
    };
    match error.kind() {
        ErrorKind::InvalidUtf8InPathParam { key } => {
            let detail = format!("{key} has bytes that are no UTF-8, percent-decoded");
            Problem::new(Kind::NotFound, detail).at(key)
        }
        _ => Problem::new(Kind::NotFound, "the path cannot be read"),
    }
}
