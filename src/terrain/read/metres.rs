//! Degrees become metres: the raster is drawn anew on the plane of a UTM zone.

use proj4rs::proj::Proj;
use proj4rs::transform::transform;

use super::error::ReadError;
use super::raster::{Raster, Units, count, field, grid, reserved};
use crate::terrain::{HeightField, Interpolation};

/// Farthest from the zone's central meridian, degrees; beyond it the plane is too distorted.
const MOST_DEGREES: f64 = 12.0;
/// Points looked at along each edge to find how far the raster reaches on the plane.
const EDGE_POINTS: u32 = 64;

impl Raster {
    /// The same heights on a plane, in metres.
    ///
    /// A raster in metres stays as it is. One in degrees is drawn anew in a UTM zone on WGS 84,
    /// that of `wanted` (`EPSG:326zz`, `327zz`, or `258zz` on ETRS89) or else of the raster's middle: a north-up grid with posts as far apart as
    /// the raster's are at its middle, each height interpolated bilinearly between the four posts
    /// around it, no data where one of them is. Longitudes and latitudes are taken for WGS 84,
    /// which those of other modern systems differ from by no more than about two metres.
    ///
    /// `wanted` is the system the heights are needed in, such as the city's.
    ///
    /// # Errors
    /// [`ReadError::CrsMismatch`] where the raster cannot be brought into `wanted`, and
    /// [`ReadError::Unsupported`] for a raster beyond the reach of one zone. `path` is named.
    pub fn to_metres(
        self,
        path: &std::path::Path,
        wanted: Option<&str>,
    ) -> Result<Self, ReadError> {
        let mismatch = |found: &str| ReadError::CrsMismatch {
            path: path.to_owned(),
            found: found.to_owned(),
            wanted: wanted.unwrap_or_default().to_owned(),
        };
        if self.units == Units::Metres {
            return match (self.crs.as_deref(), wanted) {
                (Some(found), Some(wanted)) if found != wanted => Err(mismatch(found)),
                _ => Ok(self),
            };
        }
        let too_wide = || ReadError::Unsupported {
            path: path.to_owned(),
            feature: "a reach that no UTM zone covers".into(),
            way_out: "project it onto a plane, for example with gdalwarp -t_srs, or cut it",
        };
        let [low, high] = reach(&self.field);
        let middle = [
            f64::midpoint(low[0], high[0]),
            f64::midpoint(low[1], high[1]),
        ];
        let zone = match wanted {
            Some(crs) => Zone::from_crs(crs)
                .ok_or_else(|| mismatch(self.crs.as_deref().unwrap_or("degrees")))?,
            None => Zone::of(middle),
        };
        let off = |longitude: f64| (longitude - zone.meridian()).abs() > MOST_DEGREES;
        if off(low[0]) || off(high[0]) || low[1] < -85.0 || high[1] > 85.0 {
            return Err(too_wide());
        }
        let plane = Plane::new(zone).ok_or_else(too_wide)?;
        let spacing = plane.spacing(middle, &self.field).ok_or_else(too_wide)?;
        let [from, to] = plane.reach(low, high).ok_or_else(too_wide)?;
        // A spacing that rounds to nothing gives more posts than any raster may have.
        let steps = |axis: usize| ((to[axis] - from[axis]) / spacing[axis]).floor() as u64;
        let along = |axis: usize| steps(axis).saturating_add(1);
        let posts = count(path, along(0), along(1))?;
        let grid = grid(path, [along(0) as u32, along(1) as u32], from, spacing)?;
        let mut heights = reserved(path, posts)?;
        for row in (0..grid.rows()).rev() {
            heights.extend((0..grid.columns()).map(|column| {
                let at = plane.degrees([grid.x(column), grid.y(row)]);
                let height =
                    at.and_then(|[x, y]| self.field.height_at(x, y, Interpolation::Bilinear));
                height.map_or(f32::NAN, |z| z as f32)
            }));
        }
        Ok(Self {
            field: field(path, grid, heights)?,
            crs: Some(wanted.map_or_else(|| zone.crs(), str::to_owned)),
            units: Units::Metres,
        })
    }
}

/// South-west and north-east post.
fn reach(field: &HeightField) -> [[f64; 2]; 2] {
    let grid = field.grid();
    let (last_column, last_row) = (grid.columns() - 1, grid.rows() - 1);
    [
        [grid.x(0), grid.y(0)],
        [grid.x(last_column), grid.y(last_row)],
    ]
}

/// Number and half of the globe: `EPSG:326zz` or, within a metre of it, `EPSG:258zz` (north),
/// `EPSG:327zz` (south).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Zone {
    number: u8,
    south: bool,
}

impl Zone {
    /// The zone of a longitude and latitude; the exceptions around Norway are not made.
    fn of([longitude, latitude]: [f64; 2]) -> Self {
        Self {
            number: ((longitude + 180.0) / 6.0).floor().clamp(0.0, 59.0) as u8 + 1,
            south: latitude < 0.0,
        }
    }

    fn from_crs(crs: &str) -> Option<Self> {
        let code: u16 = crs.strip_prefix("EPSG:")?.parse().ok()?;
        let number = (code % 100) as u8;
        let known = match code / 100 {
            326 | 327 => (1..=60).contains(&number),
            258 => (28..=38).contains(&number),
            _ => false,
        };
        known.then_some(Self {
            number,
            south: code / 100 == 327,
        })
    }

    fn crs(self) -> String {
        let family = if self.south { 327 } else { 326 };
        format!("EPSG:{family}{:02}", self.number)
    }

    /// Longitude of the central meridian, degrees.
    fn meridian(self) -> f64 {
        f64::from(self.number) * 6.0 - 183.0
    }
}

struct Plane {
    geographic: Proj,
    projected: Proj,
}

impl Plane {
    fn new(zone: Zone) -> Option<Self> {
        let south = if zone.south { " +south" } else { "" };
        let number = zone.number;
        let utm = format!("+proj=utm +zone={number}{south} +datum=WGS84 +units=m +no_defs");
        Some(Self {
            geographic: Proj::from_proj_string("+proj=longlat +datum=WGS84 +no_defs").ok()?,
            projected: Proj::from_proj_string(&utm).ok()?,
        })
    }

    fn metres(&self, degrees: [f64; 2]) -> Option<[f64; 2]> {
        let mut point = (degrees[0].to_radians(), degrees[1].to_radians(), 0.0);
        transform(&self.geographic, &self.projected, &mut point).ok()?;
        (point.0.is_finite() && point.1.is_finite()).then_some([point.0, point.1])
    }

    fn degrees(&self, metres: [f64; 2]) -> Option<[f64; 2]> {
        let mut point = (metres[0], metres[1], 0.0);
        transform(&self.projected, &self.geographic, &mut point).ok()?;
        Some([point.0.to_degrees(), point.1.to_degrees()])
    }

    /// Size of a cell at a position, m.
    fn spacing(&self, at: [f64; 2], field: &HeightField) -> Option<[f64; 2]> {
        let [dx, dy] = field.grid().spacing().to_array();
        let here = self.metres(at)?;
        let length = |to: [f64; 2]| Some((to[0] - here[0]).hypot(to[1] - here[1]));
        Some([
            length(self.metres([at[0] + dx, at[1]])?)?,
            length(self.metres([at[0], at[1] + dy])?)?,
        ])
    }

    /// The box on the plane around the edges of one in degrees.
    fn reach(&self, low: [f64; 2], high: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let mut from = [f64::INFINITY; 2];
        let mut to = [f64::NEG_INFINITY; 2];
        for step in 0..=EDGE_POINTS {
            let t = f64::from(step) / f64::from(EDGE_POINTS);
            let along = [0, 1].map(|axis| low[axis] + t * (high[axis] - low[axis]));
            for edge in [
                [along[0], low[1]],
                [along[0], high[1]],
                [low[0], along[1]],
                [high[0], along[1]],
            ] {
                let point = self.metres(edge)?;
                for axis in 0..2 {
                    from[axis] = from[axis].min(point[axis]);
                    to[axis] = to[axis].max(point[axis]);
                }
            }
        }
        Some([from, to])
    }
}
