//! Where the files of one import lie, and whether that can be one city.

use std::path::PathBuf;
use std::sync::Arc;

use super::tilt::{self, Spread};
use super::{ImportError, Place, Warning, globe};
use crate::geom::{Aabb, DVec3};

/// Files that lie farther apart than this are worth a word, m.
pub(super) const FAR_M: f64 = 10_000.0;
/// Files that lie farther apart than this are no city, m.
const TOO_FAR_M: f64 = 100_000.0;

/// The files so far.
#[derive(Debug, Default)]
pub(super) struct Extents(Vec<Extent>);

#[derive(Debug)]
struct Extent {
    path: Arc<PathBuf>,
    /// It says which system it lies in.
    stated: bool,
    /// What is said of it where no file says which system it lies in.
    assumed: Option<String>,
    /// What is said of it whatever the others say, unless it says itself where it lies.
    suspected: Option<String>,
    bounds: Aabb,
    objects: u64,
    /// Of these, those with earth-centred coordinates, and where the first of them is.
    on_globe: u64,
    place: DVec3,
    spread: Spread,
}

impl Extents {
    pub(super) fn begin(&mut self, path: Arc<PathBuf>) {
        self.0.push(Extent {
            path,
            stated: false,
            assumed: None,
            suspected: None,
            bounds: Aabb::EMPTY,
            objects: 0,
            on_globe: 0,
            place: DVec3::ZERO,
            spread: Spread::default(),
        });
    }

    /// The current file says which system it lies in.
    pub(super) fn state(&mut self) {
        if let Some(file) = self.0.last_mut() {
            file.stated = true;
        }
    }

    /// Whether it does.
    pub(super) fn is_stated(&self) -> bool {
        self.0.last().is_some_and(|file| file.stated)
    }

    /// Whether something looks wrong with its positions and is told.
    pub(super) fn is_suspected(&self) -> bool {
        self.0.last().is_some_and(|file| file.suspected.is_some())
    }

    /// The current file does not say so yet: what is to be said of it if it never does.
    pub(super) fn assume(&mut self, what: String) {
        if let Some(file) = self.0.last_mut() {
            file.assumed = Some(what);
        }
    }

    /// The current file does not say so yet, and this looks wrong with it if it never does.
    pub(super) fn suspect(&mut self, what: String) {
        if let Some(file) = self.0.last_mut() {
            file.suspected = Some(what);
        }
    }

    /// The current file has an object there.
    pub(super) fn add(&mut self, bounds: &Aabb) {
        if let Some(file) = self.0.last_mut() {
            file.bounds = file.bounds.union(bounds);
            file.objects += 1;
            let middle = bounds.center();
            file.spread.add(middle);
            if globe::is_earth_centred(middle) {
                if file.on_globe == 0 {
                    file.place = middle;
                }
                file.on_globe += 1;
            }
        }
    }

    /// A warning where most objects of a file are earth-centred, and one where those of another
    /// lie in a plane far from level; one for all such files.
    pub(super) fn tilted(&self) -> impl Iterator<Item = Warning> {
        let is_on_globe = |file: &Extent| file.on_globe * 2 > file.objects;
        let on_globe = self.first(is_on_globe, |file| globe::warning(file.place));
        let tilt_deg = move |file: &Extent| file.spread.tilt_deg().filter(|_| !is_on_globe(file));
        let tilted = self.first(
            |file| tilt_deg(file).is_some(),
            |file| tilt::warning(tilt_deg(file).unwrap_or_default()),
        );
        on_globe.into_iter().chain(tilted)
    }

    /// What is said of the first of the files of which something is so, and how many others there
    /// are.
    fn first(
        &self,
        is_so: impl Fn(&Extent) -> bool,
        what: impl FnOnce(&Extent) -> String,
    ) -> Option<Warning> {
        let mut files = self.0.iter().filter(|file| is_so(file));
        let first = files.next()?;
        let also = match files.count() {
            0 => String::new(),
            1 => "; so it is with 1 more file".into(),
            more => format!("; so it is with {more} more files"),
        };
        Some(Warning {
            path: Arc::clone(&first.path),
            object: None,
            place: Place::File,
            what: what(first) + &also,
        })
    }

    /// A warning for each file of which it is not sure that it lies in the system of the others,
    /// which is `crs` where one of them states it.
    ///
    /// # Errors
    /// [`ImportError::FarApart`] where it is sure that it does not.
    pub(super) fn doubts(&self, crs: Option<&str>) -> Result<Vec<Warning>, ImportError> {
        let mut doubts = Vec::new();
        for (at, file) in self.0.iter().enumerate() {
            if file.stated || file.bounds.is_empty() {
                continue;
            }
            // Those that say where they lie, if any do, tell where the others should.
            let known = self.0.iter().enumerate().filter(|(other_at, other)| {
                !other.bounds.is_empty()
                    && if crs.is_some() {
                        other.stated
                    } else {
                        *other_at < at
                    }
            });
            let nearest = known
                .map(|(_, other)| (apart(&file.bounds, &other.bounds), other))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let far = nearest.filter(|(apart, _)| *apart > FAR_M);
            let km = |apart: f64| (apart / 1000.0).round();
            if let Some((apart, other)) = far
                && apart > TOO_FAR_M
            {
                return Err(ImportError::FarApart {
                    path: file.path.to_path_buf(),
                    other: other.path.to_path_buf(),
                    km: km(apart),
                    suspected: file.suspected.clone(),
                });
            }
            let far = far.map(|(apart, other)| {
                format!("it lies {} km from {}", km(apart), other.path.display())
            });
            let what = match (crs, far) {
                (Some(crs), far) => Some(format!(
                    "states no coordinate reference system; taken to lie in {crs} like the other \
                     files{}",
                    far.map_or(String::new(), |far| format!("; {far}"))
                )),
                (None, Some(far)) => Some(format!(
                    "{far}, and neither states a coordinate reference system; taken to lie in one"
                )),
                (None, None) => file.assumed.clone(),
            };
            let said: Vec<String> = what.into_iter().chain(file.suspected.clone()).collect();
            if said.is_empty() {
                continue;
            }
            let what = said.join("; ");
            doubts.push(Warning {
                path: Arc::clone(&file.path),
                object: None,
                place: Place::File,
                what,
            });
        }
        Ok(doubts)
    }
}

/// Distance on the map, m.
fn apart(a: &Aabb, b: &Aabb) -> f64 {
    let gap = (a.min() - b.max()).max(b.min() - a.max());
    gap.truncate().max(glam::DVec2::ZERO).length()
}
