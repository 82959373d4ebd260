//! `/collections`: the scenes and what is known of each (OGC API Common, part 2).

use std::sync::Arc;

use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use super::boxes::MOST_BOXES;
use super::documents::{Link, cached, json};
use super::ground::Ground;
use super::negotiate::accepted;
use super::problem::Problem;
use super::routes::SceneName;
use super::scenes::City;
use super::shared::Shared;
use crate::frame::Overview;

#[derive(Serialize)]
struct List<'a> {
    links: Vec<Link<'a>>,
    collections: Vec<Collection<'a>>,
}

#[derive(Serialize)]
struct Collection<'a> {
    id: &'a str,
    title: &'a str,
    #[serde(rename = "itemType")]
    item_type: &'static str,
    extent: Option<Extent<'a>>,
    crs: Option<&'a str>,
    bounds: Option<[f64; 6]>,
    origin: [f64; 3],
    objects: u32,
    nodes: u32,
    levels: Vec<Counts>,
    classes: Vec<&'a str>,
    promotion: &'static str,
    /// What the scene declares.
    effects: &'a crate::scene::Effects,
    ground: Option<Ground>,
    overview: Option<View>,
    revision: String,
    max_boxes: u32,
    links: Vec<Link<'a>>,
}

/// A place to see it from, and a box about what is seen from there.
#[derive(Serialize)]
struct View {
    eye: [f64; 3],
    target: [f64; 3],
    far_dist_m: f64,
    bounds: [f64; 6],
}

impl View {
    fn of(overview: &Overview) -> Self {
        Self {
            eye: overview.eye.to_array(),
            target: overview.target.to_array(),
            far_dist_m: overview.far_dist,
            bounds: overview.bounds.to_array(),
        }
    }
}

#[derive(Serialize)]
struct Extent<'a> {
    spatial: Spatial<'a>,
}

#[derive(Serialize)]
struct Spatial<'a> {
    bbox: [[f64; 6]; 1],
    #[serde(skip_serializing_if = "Option::is_none")]
    crs: Option<&'a str>,
}

/// What a level stores, level 0 (the finest) last.
#[derive(Serialize)]
struct Counts {
    level: u32,
    nodes: u32,
    objects: u32,
}

impl<'a> Collection<'a> {
    fn of(city: &'a City) -> Self {
        let tree = city.tree();
        let path = city.path();
        let bounds = Some(tree.bounds()).filter(|b| !b.is_empty());
        let bounds = bounds.map(crate::geom::Aabb::to_array);
        let arrays = tree.arrays();
        let counts = arrays
            .level_nodes
            .windows(2)
            .zip(arrays.level_objects.windows(2));
        let levels = counts.enumerate().map(|(at, (nodes, objects))| Counts {
            level: tree.level_count().saturating_sub(at as u32 + 1),
            nodes: nodes[1].saturating_sub(nodes[0]),
            objects: objects[1].saturating_sub(objects[0]),
        });
        Self {
            id: city.name(),
            title: city.name(),
            item_type: "object",
            extent: bounds.map(|bounds| Extent {
                spatial: Spatial {
                    bbox: [bounds],
                    crs: tree.crs(),
                },
            }),
            crs: tree.crs(),
            bounds,
            origin: tree.origin().to_array(),
            objects: tree.object_count(),
            nodes: tree.node_count(),
            levels: levels.collect(),
            classes: tree.classes().iter().map(AsRef::as_ref).collect(),
            promotion: promotion_name(tree.promotion()),
            effects: tree.effects(),
            ground: city.land().map(Ground::of),
            overview: city.overview().map(View::of),
            revision: tree.revision(),
            max_boxes: MOST_BOXES,
            links: vec![
                Link::json("self", path.clone(), "this scene"),
                Link::json(
                    "visible",
                    format!("{path}/visible"),
                    "what to draw for a camera",
                ),
                Link::new(
                    "stream",
                    format!("{path}/stream"),
                    "application/json",
                    "the same as the camera moves, by WebSocket",
                ),
                Link::new(
                    "boxes",
                    format!("{path}/boxes?revision={}", tree.revision()),
                    "application/octet-stream",
                    "boxes of all objects",
                ),
                Link::new(
                    "preview",
                    format!("{path}/plan.svg"),
                    "image/svg+xml",
                    "top view",
                ),
            ],
        }
    }
}

fn promotion_name(promotion: crate::index::Promotion) -> &'static str {
    use crate::index::Promotion;
    match promotion {
        Promotion::Tallest => "tallest",
        Promotion::Footprint => "footprint",
        Promotion::Largest => "largest",
    }
}

/// `GET /collections`.
pub async fn list(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    accepted(&headers, &["application/json"])?;
    let scenes = shared.scenes();
    Ok(json(&List {
        links: vec![Link::json("self", "/collections", "this list")],
        collections: scenes.iter().map(|city| Collection::of(city)).collect(),
    }))
}

/// `GET /collections/{scene}`.
pub async fn one(
    State(shared): State<Arc<Shared>>,
    SceneName(name): SceneName,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let city = shared.city(&name)?;
    accepted(&headers, &["application/json"])?;
    Ok(cached(&headers, city.etag(), || {
        json(&Collection::of(&city))
    }))
}

/// `GET /collections/{scene}/plan.svg`.
pub async fn plan(
    State(shared): State<Arc<Shared>>,
    SceneName(name): SceneName,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let city = shared.city(&name)?;
    accepted(&headers, &["image/svg+xml"])?;
    Ok(cached(&headers, city.etag(), || {
        let svg = HeaderValue::from_static("image/svg+xml");
        ([(header::CONTENT_TYPE, svg)], city.plan()).into_response()
    }))
}
