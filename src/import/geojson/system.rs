use crate::geom::DVec3;
use crate::import::collector::Collector;
use crate::import::crs::Kind;
use crate::import::utm::{Utm, is_lon_lat};
use crate::import::{ImportError, Place, crs};

const REPROJECT: &str = "reproject the file to longitudes and latitudes, for one with \
     `ogr2ogr -t_srs EPSG:4326 NEW.geojson FILE`";

/// No footprint in metres is smaller than this along both axes.
const SMALLEST_M: f64 = 0.1;
/// Nothing in a city is larger than this, degrees.
const WIDEST_DEG: f64 = 1.0;

const AS_METRES: &str = "no coordinate reference system is given, and positions are no longitudes \
     and latitudes; they are taken as metres: name their system with --crs or in a member crs, or \
     reproject the file to longitudes and latitudes";
const AS_DEGREES: &str = "no coordinate reference system is given, and positions are taken as \
     longitudes and latitudes, but the first footprint is over a degree wide; if they are metres, \
     name their system with --crs or in a member crs before the features";

/// How the positions of one file become scene coordinates, settled by the file's `crs` member
/// (of `GeoJSON` before RFC 7946) or else by its first position.
#[derive(Default)]
pub(super) enum System {
    #[default]
    Unsettled,
    /// The file says that it holds longitudes and latitudes.
    LonLat {
        /// A footprint had them the other way round, which was told.
        turned: bool,
    },
    /// Longitude and latitude, projected.
    Utm(Box<Utm>),
    /// Metres, taken as they are.
    Metres {
        /// The file names their system.
        stated: bool,
    },
}

impl System {
    /// The caller names it.
    pub(super) fn tell(&mut self, collector: &mut Collector) -> Result<(), ImportError> {
        match collector.told_crs().map(ToOwned::to_owned) {
            Some(crs) => self.become_one_of(&crs, &Place::File, collector),
            None => Ok(()),
        }
    }

    /// A `crs` member names it.
    pub(super) fn state(
        &mut self,
        crs: &str,
        collector: &mut Collector,
    ) -> Result<(), ImportError> {
        collector.contradict(crs)?;
        if collector.told_crs().is_some() {
            return Ok(());
        }
        self.become_one_of(crs, &Place::Pointer("/crs".into()), collector)
    }

    /// It has this name, which stands there.
    fn become_one_of(
        &mut self,
        crs: &str,
        place: &Place,
        collector: &mut Collector,
    ) -> Result<(), ImportError> {
        let is_it_already = matches!(self, Self::Metres { stated: true });
        if is_it_already && collector.known_crs() == Some(crs) {
            return Ok(()); // each feature of a sequence may say so
        }
        if !in_degrees(crs, place, collector)? {
            collector.crs(crs)?;
            *self = Self::Metres { stated: true };
        } else if !matches!(self, Self::Utm(_)) {
            *self = Self::LonLat { turned: false };
        }
        Ok(())
    }

    /// A `crs` member names it behind the features. Where they were read as it says it is as good
    /// as one before them, else a warning.
    pub(super) fn state_late(
        &mut self,
        crs: &str,
        collector: &mut Collector,
    ) -> Result<(), ImportError> {
        collector.contradict(crs)?;
        if collector.told_crs().is_some() {
            return Ok(());
        }
        let in_degrees = crs::kind(crs) == Kind::Degrees;
        let place = Place::Pointer("/crs".into());
        let (read_as, way_out) = match self {
            Self::Unsettled | Self::LonLat { .. } | Self::Utm(_) if in_degrees => {
                return self.state(crs, collector);
            }
            Self::Unsettled | Self::Metres { stated: false } if !in_degrees => {
                self::in_degrees(crs, &place, collector)?;
                collector.crs(crs)?;
                *self = Self::Metres { stated: true };
                return Ok(());
            }
            // Before them it would make metres of them, which is wrong if they are degrees.
            Self::LonLat { .. } | Self::Utm(_) => (
                "longitudes and latitudes",
                "move it before them if they are metres; if they are degrees, leave it out or \
                 reproject the file to EPSG:4326",
            ),
            Self::Unsettled | Self::Metres { .. } => ("metres", "move it before them"),
        };
        if collector.known_crs() != Some(crs) {
            let what = format!(
                "{crs} is stated behind the features, which were read as {read_as} before it came; \
                 it is ignored, {way_out}"
            );
            collector.warn(None, place, what);
        }
        Ok(())
    }

    /// Settles it by the positions of the first footprint: one that can be degrees is taken as
    /// such. The zone is that of the files before, else the one the position lies in.
    pub(super) fn settle(
        &mut self,
        footprint: &[[f64; 3]],
        collector: &mut Collector,
    ) -> Result<(), ImportError> {
        let Some(&[x, y, _]) = footprint.first() else {
            return Ok(());
        };
        let degrees = is_lon_lat(x, y);
        let turned = !degrees && is_lon_lat(y, x);
        match self {
            Self::Utm(_) | Self::Metres { .. } => {}
            Self::LonLat { turned: told } if turned => {
                if !*told {
                    let what = latitude_first(x, y) + "; features that have it are left out";
                    collector.warn(None, Place::File, what);
                }
                *told = true;
            }
            // Nothing to go by yet.
            Self::LonLat { .. } if !degrees => {}
            Self::Unsettled if !x.is_finite() || !y.is_finite() => {}
            Self::Unsettled if !degrees => {
                *self = Self::Metres { stated: false };
                if turned && is_within(footprint, SMALLEST_M) {
                    collector.suspect(latitude_first(x, y) + "; taken as metres");
                } else {
                    collector.assume(AS_METRES.to_owned());
                }
            }
            Self::LonLat { .. } | Self::Unsettled => {
                if matches!(self, Self::Unsettled) && !is_within(footprint, WIDEST_DEG) {
                    collector.warn(None, Place::File, AS_DEGREES);
                }
                if let Some(utm) = Utm::begin([x, y], collector)? {
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
            Self::Metres { .. } => DVec3::new(x, y, z),
            Self::LonLat { .. } | Self::Unsettled => DVec3::NAN,
        }
    }

    /// Whether a position has none only because it lies too far from where the others do.
    pub(super) fn is_far(&self, [x, y, _]: [f64; 3]) -> bool {
        matches!(self, Self::Utm(utm) if is_lon_lat(x, y) && !utm.is_near(x, y))
    }

    /// What is wrong with positions that have none.
    pub(super) fn fault(&self) -> String {
        match self {
            Self::Utm(utm) => utm.fault(),
            Self::LonLat { .. } => "no longitudes and latitudes".to_owned(),
            Self::Metres { .. } | Self::Unsettled => "not finite".to_owned(),
        }
    }

    /// Why a file of which more features lie too far than are kept cannot be used: where those
    /// lie that are kept, and what to do.
    pub(super) fn apart(&self) -> Option<(String, &'static str)> {
        match self {
            Self::Utm(utm) => Some((utm.middle(), utm.way_out())),
            _ => None,
        }
    }
}

/// Whether positions in a system, whose name stands there, are degrees. They are lengths else.
///
/// # Errors
/// [`ImportError::Unsupported`] where they are lengths, but not metres in a plane.
fn in_degrees(crs: &str, place: &Place, collector: &mut Collector) -> Result<bool, ImportError> {
    let refuse = |what: &str| Err(crs::refusal(collector.path(), crs, what, REPROJECT));
    match crs::kind(crs) {
        Kind::Other(unit) => return refuse(&format!("are in {unit}")),
        Kind::EarthCentred => return refuse("count from the middle of the earth"),
        Kind::Metres => return Ok(false),
        Kind::Unknown => {
            collector.warn(None, place.clone(), crs::unknown(crs));
            return Ok(false);
        }
        Kind::Degrees => {}
    }
    if !crs::is_near_wgs84(crs) {
        collector.warn(None, place.clone(), crs::older(crs));
    }
    Ok(true)
}

fn latitude_first(x: f64, y: f64) -> String {
    format!(
        "positions such as {x}, {y} look like latitude before longitude, and GeoJSON has longitude \
         first; exchange the two"
    )
}

/// Whether all of a footprint lies nearer than this to its first position, along both axes.
fn is_within(footprint: &[[f64; 3]], size: f64) -> bool {
    let near = |p: &[f64; 3], axis: usize| (p[axis] - footprint[0][axis]).abs() < size;
    footprint.iter().all(|p| near(p, 0) && near(p, 1))
}
