//! The cities on offer, each with what is worth preparing once.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use axum::body::Bytes;
use axum::http::HeaderValue;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};

use super::plan;
use super::problem::{Kind, Problem};
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

/// A name that cannot be given to a scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// Two cities would have one address.
    #[error("two scenes are called {name:?}: rename one of the files")]
    Taken {
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
    name: String,
    head: Vec<u8>,
    revision: String,
    revision_header: HeaderValue,
    etag: HeaderValue,
    plan: OnceLock<Bytes>,
}

impl City {
    fn new(name: String, tree: LodTree) -> Self {
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
            name,
            tree,
        }
    }

    /// Its index.
    pub fn tree(&self) -> &LodTree {
        &self.tree
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

    /// A request worth trying: the city from above its south-west.
    pub fn example_request(&self) -> String {
        let bounds = self.tree.bounds();
        if bounds.is_empty() {
            return r#"{"camera":{"eye":[0,0,100],"target":[0,100,0]}}"#.into();
        }
        let target = bounds.center();
        let reach = bounds.size().max_element().max(10.0);
        let round = |x: f64| (x * 10.0).round() / 10.0;
        let [x, y, z] = target.to_array().map(round);
        let (ex, ey, ez) = (
            round(target.x - 0.2 * reach),
            round(target.y - 0.3 * reach),
            round(target.z + 0.15 * reach),
        );
        format!(r#"{{"camera":{{"eye":[{ex},{ey},{ez}],"target":[{x},{y},{z}]}}}}"#)
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

    /// Adds a city.
    ///
    /// # Errors
    /// [`NameError::Taken`].
    pub fn insert(&mut self, name: impl Into<String>, tree: LodTree) -> Result<(), NameError> {
        let name = name.into();
        if self.cities.contains_key(&name) {
            return Err(NameError::Taken { name });
        }
        let city = Arc::new(City::new(name.clone(), tree));
        self.cities.insert(name, city);
        Ok(())
    }

    /// Takes over from `old` the cities that have the same contents under the same name, with
    /// what was prepared of them. Returns how many are new or have changed.
    pub fn keep_unchanged(&mut self, old: &Self) -> usize {
        let mut changed = 0;
        for (name, city) in &mut self.cities {
            match old.cities.get(name) {
                Some(same) if same.revision == city.revision && !same.tree.is_written_into() => {
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
    /// [`NameError::Nameless`] when there is none, or one that a URL cannot address.
    pub fn name_of(path: &Path) -> Result<String, NameError> {
        match path.file_stem().and_then(|stem| stem.to_str()) {
            Some(stem) if !stem.trim_matches('.').is_empty() => Ok(stem.to_owned()),
            _ => Err(NameError::Nameless {
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
