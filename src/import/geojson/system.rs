use super::utm::{Utm, Zone, is_lon_lat};
use crate::geom::DVec3;
use crate::import::collector::Collector;
use crate::import::{ImportError, Place, crs};

/// How the positions of one file become scene coordinates, settled by the file's `crs` member
/// (of `GeoJSON` before RFC 7946) or else by its first position.
#[derive(Default)]
pub(super) enum System {
    #[default]
    Unsettled,
    /// The file says that it holds longitudes and latitudes.
    LonLat,
    /// Longitude and latitude, projected.
    Utm(Box<Utm>),
    /// The file names a system that is taken to be in metres.
    Stated(String),
    /// Metres, taken as they are.
    Metres,
}

impl System {
    /// A `crs` member names it.
    pub(super) fn state(
        &mut self,
        crs: &str,
        collector: &mut Collector,
    ) -> Result<(), ImportError> {
        if !crs::is_geographic(crs) {
            collector.crs(crs)?;
            *self = Self::Stated(crs.to_owned());
            return Ok(());
        }
        if !crs::is_near_wgs84(crs) {
            let what = format!(
                "longitudes and latitudes of {crs} are read as those of WGS 84; places may be off \
                 by some hundred metres, reproject the file to EPSG:4326 to be exact"
            );
            collector.warn(None, Place::Pointer("/crs".into()), what);
        }
        if !matches!(self, Self::Utm(_)) {
            *self = Self::LonLat;
        }
        Ok(())
    }

    /// Settles it by the positions of the first footprint: one that can be degrees is taken as such. The zone is
    /// that of the files before, else the one the position lies in.
    pub(super) fn settle(
        &mut self,
        footprint: &[[f64; 3]],
        collector: &mut Collector,
    ) -> Result<(), ImportError> {
        let Some(&[x, y, _]) = footprint.first() else {
            return Ok(());
        };
        let degrees = is_lon_lat(x, y);
        match self {
            Self::Utm(_) | Self::Metres => {}
            Self::Stated(crs) => {
                if degrees && is_tiny(footprint) {
                    let what = format!(
                        "positions look like degrees, but {crs} is not known to have any; taken as \
                         metres, reproject the file to a system in metres or to EPSG:4326"
                    );
                    collector.warn(None, Place::File, what);
                }
                *self = Self::Metres;
            }
            // Nothing to go by yet.
            Self::LonLat if !degrees => {}
            Self::Unsettled if !x.is_finite() || !y.is_finite() => {}
            Self::Unsettled if !degrees => *self = Self::Metres,
            Self::LonLat | Self::Unsettled => {
                let known = collector.known_crs().and_then(Zone::from_crs);
                let zone = known.unwrap_or_else(|| Zone::of(x, y));
                collector.crs(&zone.crs())?;
                if let Ok(utm) = Utm::new(zone, y) {
                    *self = Self::Utm(Box::new(utm));
                }
            }
        }
        Ok(())
    }

    /// The position in scene coordinates; not finite where it has none.
    pub(super) fn place(&mut self, position: [f64; 3], z: f64) -> DVec3 {
        let [x, y, _] = position;
        match self {
            Self::Utm(utm) => {
                let [x, y] = utm.project(x, y);
                DVec3::new(x, y, z)
            }
            Self::Metres | Self::Stated(_) => DVec3::new(x, y, z),
            Self::LonLat | Self::Unsettled => DVec3::NAN,
        }
    }
}

/// Whether a footprint is too small for one in metres.
fn is_tiny(footprint: &[[f64; 3]]) -> bool {
    const SMALLEST_M: f64 = 0.1;
    let near = |p: &[f64; 3], axis: usize| (p[axis] - footprint[0][axis]).abs() < SMALLEST_M;
    footprint.iter().all(|p| near(p, 0) && near(p, 1))
}
