use super::utm::{Utm, Zone, is_lon_lat};
use crate::geom::DVec3;
use crate::import::ImportError;
use crate::import::collector::Collector;

/// Geographic systems whose longitudes and latitudes differ from WGS 84 by no more than about
/// two metres, all over: they are read as WGS 84.
const GEOGRAPHIC: [&str; 17] = [
    "OGC:CRS84",
    "OGC:CRS84H",
    "EPSG:4326",
    "EPSG:4979", // WGS 84
    "EPSG:4258",
    "EPSG:4937", // ETRS89
    "EPSG:4269",
    "EPSG:6318",
    "EPSG:6319", // NAD83
    "EPSG:4612",
    "EPSG:6668",
    "EPSG:6697", // Japan
    "EPSG:4283",
    "EPSG:7844",
    "EPSG:7843", // Australia
    "EPSG:4490",
    "EPSG:4674", // China, South America
];

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
        if !GEOGRAPHIC.contains(&crs) {
            collector.crs(crs)?;
            *self = Self::Metres;
        } else if !matches!(self, Self::Utm(_)) {
            *self = Self::LonLat;
        }
        Ok(())
    }

    /// Settles it by the first position: one that can be degrees is taken as such. The zone is
    /// that of the files before, else the one the position lies in.
    pub(super) fn settle(
        &mut self,
        first: [f64; 3],
        collector: &mut Collector,
    ) -> Result<(), ImportError> {
        let [x, y, _] = first;
        let degrees = is_lon_lat(x, y);
        match self {
            Self::Utm(_) | Self::Metres => {}
            // Nothing to go by yet.
            Self::LonLat if !degrees => {}
            Self::Unsettled if !x.is_finite() || !y.is_finite() => {}
            Self::Unsettled if !degrees => *self = Self::Metres,
            Self::LonLat | Self::Unsettled => {
                let known = collector.known_crs().and_then(Zone::from_crs);
                let zone = known.unwrap_or_else(|| Zone::of(x, y));
                collector.crs(&zone.crs())?;
                if let Ok(utm) = Utm::new(zone) {
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
            Self::Metres => DVec3::new(x, y, z),
            Self::LonLat | Self::Unsettled => DVec3::NAN,
        }
    }
}
