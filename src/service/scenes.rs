//! The cities on offer, each with what is worth preparing once.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use axum::body::Bytes;
use axum::http::HeaderValue;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};

use super::plan;
use super::problem::{Kind, Problem};
use crate::effects::terrain::Land;
use crate::frame::Overview;
use crate::index::LodTree;

/// All but the unreserved characters of RFC 3986.
const RESERVED: AsciiSet = NON_ALPHANUMERIC
    .remove(b'-')
    .remove(b'.')
    .remove(b'_')
    .remove(b'~');

/// A name as one segment of a URL path.
pub fn segment(name: &str) -> String {
    utf8_percent_encode(name, &RESERVED).to_string()
}

/// A city that cannot be a scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// Two cities would have one address.
    #[error("two scenes are called {name:?}: rename one of the files")]
    Taken {
        /// The name.
        name: String,
    },
    /// Its ground is not given with it.
    #[error("the scene {name:?} declares terrain: give its ground with it")]
    Groundless {
        /// The name.
        name: String,
    },
    /// The file has none that can be part of a URL.
    #[error("{path:?} has no file name to call the scene by")]
    Nameless {
        /// The file.
        path: String,
    },
}

/// A city being served.
#[derive(Debug)]
pub struct City {
    tree: LodTree,
    land: Option<Land>,
    name: String,
    head: Vec<u8>,
    revision: String,
    revision_header: HeaderValue,
    etag: HeaderValue,
    plan: OnceLock<Bytes>,
    overview: OnceLock<Option<Overview>>,
}

impl City {
    fn new(name: String, tree: LodTree, land: Option<Land>) -> Self {
        let revision = tree.revision();
        let quoted = serde_json::Value::from(name.as_str());
        let head = format!("{{\"scene\":{quoted},\"revision\":\"{revision}\",\"count\":");
        // Digits and dashes: always a header value.
        let header = |text: &str| {
            HeaderValue::try_from(text).unwrap_or_else(|_| HeaderValue::from_static("0"))
        };
        Self {
            head: head.into_bytes(),
            etag: header(&format!("W/\"{}-{revision}\"", env!("CARGO_PKG_VERSION"))),
            revision_header: header(&revision),
            revision,
            plan: OnceLock::new(),
            overview: OnceLock::new(),
            name,
            tree,
            land,
        }
    }

    /// Its index.
    pub fn tree(&self) -> &LodTree {
        &self.tree
    }

    /// Its ground, where it declares terrain.
    pub fn land(&self) -> Option<&Land> {
        self.land.as_ref()
    }

    /// Whether its file, or that of its ground, was written into since it was opened
    /// ([`LodTree::is_written_into`]).
    pub fn is_written_into(&self) -> bool {
        let land = self.land.as_ref();
        self.tree.is_written_into() || land.is_some_and(|land| land.pyramid().is_written_into())
    }

    /// What it is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its address: `/collections/{scene}`.
    pub fn path(&self) -> String {
        format!("/collections/{}", segment(&self.name))
    }

    /// How answers begin: scene, revision and `"count":`.
    pub fn head(&self) -> &[u8] {
        &self.head
    }

    /// [`LodTree::revision`], as a header.
    pub fn revision_header(&self) -> &HeaderValue {
        &self.revision_header
    }

    /// [`LodTree::revision`].
    pub fn revision(&self) -> &str {
        &self.revision
    }

    /// Validator of everything that depends on the city and the program alone; weak, since
    /// documents are sent compressed or not.
    pub fn etag(&self) -> &HeaderValue {
        &self.etag
    }

    /// The top view, drawn when it is first asked for.
    pub fn plan(&self) -> Bytes {
        self.plan
            .get_or_init(|| plan::draw(&self.tree).into())
            .clone()
    }

    /// Where it is seen well from; looked for when it is first asked for.
    pub fn overview(&self) -> Option<&Overview> {
        let height = |x: f64, y: f64| self.land.as_ref()?.pyramid().height_near(x, y);
        let overview = self
            .overview
            .get_or_init(|| Overview::on(&self.tree, &height));
        overview.as_ref()
    }

    /// A request worth trying: some thousand objects of the city, from above its south.
    pub fn example_request(&self) -> String {
        let Some(overview) = self.overview() else {
            return r#"{"camera":{"eye":[0,0,100],"target":[0,100,0]}}"#.into();
        };
        let (eye, target) = (overview.eye.to_array(), overview.target.to_array());
        let far = overview.far_dist;
        format!(
            r#"{{"camera":{{"eye":{eye:?},"target":{target:?}}},"lod":{{"far_dist_m":{far}}}}}"#
        )
    }
}

/// Cities by name.
#[derive(Debug, Default)]
pub struct Scenes {
    cities: BTreeMap<String, Arc<City>>,
}

impl Scenes {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a city without ground.
    ///
    /// # Errors
    /// [`SceneError::Taken`], and [`SceneError::Groundless`] where it declares terrain.
    pub fn insert(&mut self, name: impl Into<String>, tree: LodTree) -> Result<(), SceneError> {
        self.insert_on(name, tree, None)
    }

    /// Adds a city with its ground.
    ///
    /// # Errors
    /// As [`Scenes::insert`].
    pub fn insert_on(
        &mut self,
        name: impl Into<String>,
        tree: LodTree,
        land: Option<Land>,
    ) -> Result<(), SceneError> {
        let name = name.into();
        if self.cities.contains_key(&name) {
            return Err(SceneError::Taken { name });
        }
        let land = land.filter(|_| tree.effects().terrain.is_some());
        if tree.effects().terrain.is_some() && land.is_none() {
            return Err(SceneError::Groundless { name });
        }
        let city = Arc::new(City::new(name.clone(), tree, land));
        self.cities.insert(name, city);
        Ok(())
    }

    /// Takes over from `old` the cities that have the same contents under the same name, with
    /// what was prepared of them. Returns how many are new or have changed.
    pub fn keep_unchanged(&mut self, old: &Self) -> usize {
        let mut changed = 0;
        for (name, city) in &mut self.cities {
            match old.cities.get(name) {
                Some(same) if same.revision == city.revision && !same.is_written_into() => {
                    *city = Arc::clone(same);
                }
                _ => changed += 1,
            }
        }
        changed
    }

    /// What a city from this file is called: the file name without its extension.
    ///
    /// # Errors
    /// [`SceneError::Nameless`] when there is none, or one that a URL cannot address.
    pub fn name_of(path: &Path) -> Result<String, SceneError> {
        match path.file_stem().and_then(|stem| stem.to_str()) {
            Some(stem) if !stem.trim_matches('.').is_empty() => Ok(stem.to_owned()),
            _ => Err(SceneError::Nameless {
                path: path.display().to_string(),
            }),
        }
    }

    /// The city of this name.
    ///
    /// # Errors
    /// 404.
    pub fn get(&self, name: &str) -> Result<&Arc<City>, Problem> {
        self.cities.get(name).ok_or_else(|| {
            let detail = format!("there is no scene {name:?}: GET /collections lists them");
            Problem::new(Kind::NotFound, detail).at("scene")
        })
    }

    /// All of them, by name.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<City>> {
        self.cities.values()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.cities.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.cities.is_empty()
    }
}
