//! `/collections/{scene}/items`: what the objects are called, and everything known of one.

use std::borrow::Cow;
use std::sync::Arc;

use axum::extract::{RawQuery, State};
use axum::http::HeaderMap;
use axum::response::Response;
use serde::Serialize;
use serde_json::value::RawValue;

use super::documents::{Link, cached, json, make};
use super::negotiate::accepted;
use super::problem::{Kind, Problem};
use super::routes::{ItemName, SceneName};
use super::scenes::segment;
use super::shared::Shared;
use super::span::Span;

/// Most objects in one list: about 1 MB.
pub const MOST_ITEMS: u32 = 50_000;

/// Length of an object in the list, bytes, about.
const ITEM: usize = 20;

/// Column by column: what a viewer wants to know of all that it draws.
#[derive(Serialize)]
struct Items<'a> {
    start: u32,
    ids: Vec<Cow<'a, str>>,
    classes: Vec<usize>,
}

/// `GET` of the list: ids and classes of objects `start .. end`.
pub async fn items(
    State(shared): State<Arc<Shared>>,
    SceneName(name): SceneName,
    RawQuery(query): RawQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let city = shared.city(&name)?;
    accepted(&headers, &["application/json"])?;
    let span = Span::read(&city, &query.unwrap_or_default(), MOST_ITEMS)?;
    let tree = city.tree();
    let mut response = cached(&headers, city.etag(), || {
        make(span.range.len() * ITEM, || {
            let objects = || span.range.clone();
            json(&Items {
                start: span.range.start,
                ids: objects().filter_map(|object| tree.id(object)).collect(),
                classes: objects()
                    .filter_map(|object| tree.class_number(object))
                    .collect(),
            })
        })
    });
    span.describe(&city, &mut response);
    Ok(response)
}

#[derive(Serialize)]
struct Item<'a> {
    id: &'a str,
    index: u32,
    class: &'a str,
    level: u32,
    bounds: [f64; 6],
    height_m: f64,
    footprint_area_m2: f64,
    triangles: u32,
    attributes: Option<&'a RawValue>,
    links: [Link<'a>; 2],
}

/// `GET`.
pub async fn item(
    State(shared): State<Arc<Shared>>,
    ItemName { scene, id }: ItemName,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let city = shared.city(&scene)?;
    accepted(&headers, &["application/json"])?;
    let tree = city.tree();
    let found = tree.find(&id);
    let known = found.and_then(|index| Some((index, tree.object(index)?)));
    let Some((index, object)) = known else {
        let detail = format!("scene {scene:?} has no object {id:?}");
        return Err(Problem::new(Kind::NotFound, detail).at("id"));
    };
    let path = city.path();
    Ok(cached(&headers, city.etag(), || {
        json(&Item {
            id: &object.id,
            index,
            class: object.class,
            level: object.level,
            bounds: object.bounds.to_array(),
            height_m: object.bounds.size().z,
            footprint_area_m2: object.footprint_area,
            triangles: object.triangles,
            attributes: object
                .attributes
                .and_then(|text| serde_json::from_str(text).ok()),
            links: [
                Link::json(
                    "self",
                    format!("{path}/items/{}", segment(&id)),
                    "this object",
                ),
                Link::json("collection", path, "the scene it is in"),
            ],
        })
    }))
}
