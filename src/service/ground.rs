//! `/collections/{scene}/ground/{level}/{x}/{y}`: the posts of the ground, tile by tile.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::{FromRequestParts, Path, RawQuery, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::Response;
use serde::Serialize;

use super::documents::try_cached;
use super::negotiate::accepted;
use super::plain::plain;
use super::problem::{Kind, Problem};
use super::routes::malformed;
use super::shared::Shared;
use super::span::{check_revision, pin};
use super::visible::{Parameter, unknown};
use crate::effects::terrain::Land;
use crate::terrain::Node;

/// What is known of the ground of a scene: all that it takes to place the posts of a tile.
#[derive(Debug, Serialize)]
pub struct Ground {
    posts: [u32; 2],
    origin: [f64; 2],
    spacing: [f64; 2],
    heights: Option<[f32; 2]>,
    block_levels: u32,
    tile_levels: u32,
    finest: u32,
    blocks: [u32; 2],
    crs: Option<String>,
}

impl Ground {
    pub fn of(land: &Land) -> Self {
        let pyramid = land.pyramid();
        let tiling = pyramid.tiling();
        let (layout, grid) = (tiling.layout(), tiling.layout().grid());
        Self {
            posts: [grid.columns(), grid.rows()],
            origin: grid.origin().to_array(),
            spacing: grid.spacing().to_array(),
            heights: pyramid.height_range(),
            block_levels: layout.levels(),
            tile_levels: tiling.tile_levels(),
            finest: tiling.finest(),
            blocks: layout.blocks(),
            crs: pyramid.crs().map(str::to_owned),
        }
    }
}

/// The path parameters `scene`, `level`, `x` and `y`.
#[derive(Debug)]
pub struct TileName {
    scene: String,
    tile: Node,
}

impl FromRequestParts<Arc<Shared>> for TileName {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, shared: &Arc<Shared>) -> Result<Self, Problem> {
        let path =
            Path::<(String, String, String, String)>::from_request_parts(parts, shared).await;
        let Path((scene, level, x, y)) = path.map_err(malformed)?;
        Ok(Self {
            scene,
            tile: Node {
                level: number(&level, "level")?,
                x: number(&x, "x")?,
                y: number(&y, "y")?,
            },
        })
    }
}

/// A part of the path that is a number.
fn number(text: &str, part: &str) -> Result<u32, Problem> {
    let number: Option<u32> = text.parse().ok();
    number.ok_or_else(|| {
        let wanted = format!("a whole number from 0 to {}", u32::MAX);
        let said = format!("invalid value: string {text:?}, expected {wanted}");
        Problem::new(Kind::NotFound, plain(&said, part)).at(part)
    })
}

/// `GET`: the heights of a tile, f32 each, little endian, row by row from the south-west, NaN
/// where unknown.
pub async fn tile(
    State(shared): State<Arc<Shared>>,
    TileName { scene, tile }: TileName,
    RawQuery(query): RawQuery,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let city = shared.city(&scene)?;
    accepted(&headers, &["application/octet-stream"])?;
    let pinned = revision(&query.unwrap_or_default())?
        .map(|revision| check_revision(&city, &revision))
        .transpose()?
        .is_some();
    let Some(land) = city.land() else {
        let detail = "the scene has no ground: it declares no terrain";
        return Err(Problem::new(Kind::NotFound, detail).at("scene"));
    };
    let Node { level, x, y } = tile;
    let tiling = land.pyramid().tiling();
    if tiling.tile_index(tile).is_none() {
        let (finest, [across, up]) = (tiling.finest(), tiling.layout().blocks());
        let (pointer, detail) = if level > finest {
            let detail = format!("the ground has tiles of levels 0 to {finest}, not {level}");
            ("level", detail)
        } else {
            let (wide, high) = (u64::from(across) << level, u64::from(up) << level);
            let pointer = if u64::from(x) >= wide { "x" } else { "y" };
            let detail =
                format!("level {level} has {wide} x {high} tiles; there is none at {x}, {y}");
            (pointer, detail)
        };
        return Err(Problem::new(Kind::NotFound, detail).at(pointer));
    }
    let mut response = try_cached(&headers, city.etag(), || {
        let heights = land.pyramid().tile(tile).map_err(|error| {
            tracing::error!(%error, "a tile of the ground cannot be read");
            Problem::new(
                Kind::Internal,
                "the tile cannot be read: its file was changed",
            )
        })?;
        let bytes = heights.heights.iter().flat_map(|z| z.to_le_bytes());
        let mut response = Response::new(Body::from(bytes.collect::<Vec<u8>>()));
        let binary = HeaderValue::from_static("application/octet-stream");
        response.headers_mut().insert(header::CONTENT_TYPE, binary);
        Ok(response)
    })?;
    pin(&city, pinned, response.headers_mut());
    Ok(response)
}

/// The only parameter there is.
fn revision(query: &str) -> Result<Option<String>, Problem> {
    let mut revision = None;
    for (name, text) in form_urlencoded::parse(query.as_bytes()) {
        if name != "revision" {
            return Err(unknown(&name, &["revision"]));
        }
        if revision.replace(text.to_string()).is_some() {
            let parameter = Parameter {
                name: &name,
                text: &text,
            };
            return Err(parameter.problem("is given twice"));
        }
    }
    Ok(revision)
}
