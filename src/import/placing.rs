//! Where positions of OBJ, glTF and `CityJSON` come to lie. `GeoJSON` has rules of its own.

use super::collector::Collector;
use super::crs::{self, Kind};
use super::utm::{Utm, is_lon_lat};
use super::{ImportError, Place};
use crate::geom::DVec3;

/// From the positions of one file to scene coordinates.
#[derive(Default)]
pub(super) enum Placing {
    /// They are that already.
    #[default]
    AsTheyAre,
    /// Longitudes and latitudes in this system, of which none came yet.
    Degrees(String),
    /// Longitudes and latitudes, projected.
    Utm(Box<Utm>),
}

impl Placing {
    /// Of the current file, which states the system `found`, at `place`, or none.
    ///
    /// # Errors
    /// [`ImportError::CrsContradicted`], [`ImportError::CrsMismatch`];
    /// [`ImportError::Unsupported`], with the way out, where positions are in another unit than the
    /// metre, or in degrees and the caller does not say so: which of them come first differs.
    pub(super) fn of(
        found: Option<&str>,
        place: Place,
        way_out: &str,
        collector: &mut Collector,
    ) -> Result<Self, ImportError> {
        if let Some(found) = found {
            collector.contradict(found)?;
        }
        let told = collector.told_crs().map(ToOwned::to_owned);
        let Some(name) = found.or(told.as_deref()) else {
            return Ok(Self::AsTheyAre);
        };
        let place = if found.is_some() { place } else { Place::File };
        match crs::kind(name) {
            Kind::Degrees if told.is_some() => {
                if !crs::is_near_wgs84(name) {
                    collector.warn(None, place, crs::older(name));
                }
                return Ok(Self::Degrees(name.to_owned()));
            }
            Kind::Degrees => {
                let way_out = format!(
                    "{way_out}; or import it with --crs {name} if x is longitude and y latitude"
                );
                let path = collector.path();
                return Err(crs::refusal(path, name, "are degrees", &way_out));
            }
            Kind::Other(unit) => {
                let what = format!("are in {unit}");
                return Err(crs::refusal(collector.path(), name, &what, way_out));
            }
            Kind::Unknown => collector.warn(None, place, crs::unknown(name)),
            Kind::Metres | Kind::EarthCentred => {}
        }
        collector.crs(name)?;
        Ok(Self::AsTheyAre)
    }

    /// Turns positions into scene coordinates; not finite where they have none.
    ///
    /// # Errors
    /// [`ImportError::NoDegrees`] where the first ones are to be degrees and none can be;
    /// [`ImportError::CrsMismatch`].
    pub(super) fn place(
        &mut self,
        positions: &mut [DVec3],
        collector: &mut Collector,
    ) -> Result<(), ImportError> {
        if let Self::Degrees(crs) = self {
            let on_globe = |at: &&DVec3| is_lon_lat(at.x, at.y);
            match positions.iter().find(on_globe) {
                Some(first) => {
                    if let Some(utm) = Utm::begin([first.x, first.y], collector)? {
                        *self = Self::Utm(Box::new(utm));
                    }
                }
                None => no_degrees(positions, crs, collector)?,
            }
        }
        match self {
            Self::AsTheyAre => {}
            Self::Degrees(_) => positions.fill(DVec3::NAN),
            Self::Utm(utm) => {
                for position in positions {
                    let [x, y] = utm.project(position.x, position.y);
                    *position = DVec3::new(x, y, position.z);
                }
            }
        }
        Ok(())
    }

    /// What is wrong with positions that have no place.
    pub(super) fn fault(&self) -> String {
        match self {
            Self::Utm(utm) => utm.fault(),
            Self::AsTheyAre | Self::Degrees(_) => "not finite".to_owned(),
        }
    }
}

fn no_degrees(positions: &[DVec3], crs: &str, collector: &Collector) -> Result<(), ImportError> {
    let Some(first) = positions.iter().find(|at| at.is_finite()) else {
        return Ok(());
    };
    Err(ImportError::NoDegrees {
        path: collector.path().to_owned(),
        x: first.x,
        y: first.y,
        crs: crs.to_owned(),
        way_out: if is_lon_lat(first.y, first.x) {
            "they look like latitude before longitude: exchange the two"
        } else {
            "name the system that they lie in"
        },
    })
}
