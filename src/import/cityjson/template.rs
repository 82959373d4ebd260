use serde::Deserialize;
use serde_json::value::RawValue;

use super::boundaries::{Boundaries, Geometry, depth_of, points};
use super::lod::Lod;
use crate::geom::DVec3;
use crate::import::json::{pointer, reason};

/// A geometry that instances place in the city.
pub(super) struct Template {
    pub(super) lod: Option<Lod>,
    /// In its own coordinates, each once.
    pub(super) vertices: Vec<DVec3>,
    pub(super) triangles: u64,
    pub(super) problem: Option<String>,
}

/// The geometry templates of a file.
#[derive(Default)]
pub(super) struct Templates(Vec<Template>);

impl Templates {
    /// Of the `geometry-templates` of a document. A template that cannot be used is kept with its
    /// problem, for the objects that use it.
    pub(super) fn read(text: Option<&RawValue>) -> Result<Self, (String, String)> {
        const POINTER: &str = "/geometry-templates";
        #[derive(Deserialize)]
        struct Raw<'a> {
            #[serde(borrow, default)]
            templates: Vec<&'a RawValue>,
            #[serde(rename = "vertices-templates", borrow)]
            vertices: Option<&'a RawValue>,
        }
        let Some(text) = text else {
            return Ok(Self::default());
        };
        let raw: Raw = serde_json::from_str(text.get())
            .map_err(|error| (POINTER.to_owned(), reason(&error)))?;
        let mut vertices = Vec::new();
        points(
            raw.vertices,
            &pointer(POINTER, "vertices-templates"),
            &mut vertices,
        )?;
        let templates = raw.templates.iter();
        Ok(Self(
            templates.map(|t| Template::read(t, &vertices)).collect(),
        ))
    }

    pub(super) fn at(&self, index: Option<usize>) -> Result<&Template, String> {
        let index = index.ok_or("it names no template")?;
        self.0
            .get(index)
            .ok_or_else(|| format!("template {index} is missing; there are {}", self.0.len()))
    }
}

impl Template {
    fn read(text: &RawValue, vertices: &[DVec3]) -> Self {
        let mut template = Self {
            lod: None,
            vertices: Vec::new(),
            triangles: 0,
            problem: None,
        };
        let geometry: Geometry = match serde_json::from_str(text.get()) {
            Ok(geometry) => geometry,
            Err(error) => {
                template.problem = Some(reason(&error));
                return template;
            }
        };
        template.lod = Lod::of(geometry.lod);
        let (Some(depth), Some(boundaries)) = (depth_of(&geometry.kind), geometry.boundaries)
        else {
            template.problem = Some(format!("a {:?} without boundaries", geometry.kind));
            return template;
        };
        let mut indices = Vec::new();
        let found = Boundaries::walk(boundaries.get(), depth, vertices.len(), |index| {
            indices.push(index);
        });
        indices.sort_unstable();
        indices.dedup();
        template.vertices = indices.into_iter().map(|index| vertices[index]).collect();
        template.triangles = found.triangles;
        template.problem = found.problem;
        template
    }
}
