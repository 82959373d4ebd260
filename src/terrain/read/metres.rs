//! A raster is drawn anew on another plane: degrees become metres, one system another.

use std::path::Path;

use proj4rs::proj::Proj;
use proj4rs::transform::transform;

use super::error::ReadError;
use super::raster::{Raster, Units, count, field, grid, reserved};
use super::system::{System, definition, same_plane};
use crate::terrain::{HeightField, Interpolation};

/// Farthest from the central meridian of a system that has one, degrees; beyond it the plane is
/// too distorted.
const MOST_DEGREES: f64 = 12.0;
/// Points looked at along each edge to find how far the raster reaches on the plane.
const EDGE_POINTS: u32 = 64;

impl Raster {
    /// The same heights on a plane, in metres.
    ///
    /// A raster in metres stays as it is where it lies in `wanted` already, or in its horizontal
    /// part. Otherwise it is drawn anew in `wanted`, or where nothing is wanted in the UTM zone on
    /// WGS 84 of its middle: a north-up grid with posts as far apart as the raster's are at its
    /// middle, each height interpolated bilinearly between the four posts around it, no data where
    /// one of them is. Longitudes and latitudes are taken for WGS 84, which those of other modern
    /// systems differ from by no more than about two metres; older datums are shifted by the
    /// parameters that PROJ 4 has for them, to a metre or a few. Heights stay what they are.
    ///
    /// `wanted` is the system the heights are needed in, such as the city's.
    ///
    /// # Errors
    /// [`ReadError::CrsMismatch`] where the raster cannot be brought into `wanted`,
    /// [`ReadError::Beyond`] where it lies too far from where that is good, and
    /// [`ReadError::Unsupported`] for a raster too wide for one zone. `path` is named.
    pub fn to_metres(self, path: &Path, wanted: Option<&str>) -> Result<Self, ReadError> {
        if self.units == Units::Metres {
            match (self.crs.as_deref(), wanted) {
                (Some(found), Some(wanted)) if !same_plane(found, wanted) => {}
                _ => return Ok(self),
            }
        }
        let found = self.crs.as_deref().unwrap_or("degrees").to_owned();
        let source = match self.units {
            Units::Degrees => System::degrees(),
            Units::Metres => System::named(&found).map(|system| system.proj().clone()),
        };
        let name = wanted.map_or_else(|| utm(middle(&self.field)), str::to_owned);
        let system = System::named(&name);
        let (Some(source), Some(system)) = (source, system) else {
            return Err(ReadError::CrsMismatch {
                path: path.to_owned(),
                found,
                target: definition(&name).unwrap_or_else(|| name.clone()),
                wanted: name,
            });
        };
        let plane = Plane {
            source,
            target: system.proj(),
            units: self.units,
        };
        let [low, high] = reach(&self.field);
        let longitudes = plane.longitudes(low, high);
        let far = |[west, east]: [f64; 2]| {
            let off = |meridian: f64| (west - meridian).abs().max((east - meridian).abs());
            system.meridian().is_some_and(|m| off(m) > MOST_DEGREES)
        };
        let redrawn = match longitudes {
            Some(longitudes) if far(longitudes) => None,
            _ => plane.redraw(path, &self.field)?,
        };
        let Some(field) = redrawn else {
            let path = path.to_owned();
            return Err(match (wanted, longitudes) {
                (Some(_), Some([west, east])) => ReadError::Beyond {
                    path,
                    west,
                    east,
                    system: name,
                },
                _ => ReadError::Unsupported {
                    path,
                    feature: "a reach that one plane does not cover".into(),
                    way_out: "project it onto a plane, for example with gdalwarp -t_srs, or cut it",
                },
            });
        };
        Ok(Self {
            field,
            crs: Some(name),
            units: Units::Metres,
        })
    }
}

/// South-west and north-east post.
pub(super) fn reach(field: &HeightField) -> [[f64; 2]; 2] {
    let grid = field.grid();
    let (last_column, last_row) = (grid.columns() - 1, grid.rows() - 1);
    [
        [grid.x(0), grid.y(0)],
        [grid.x(last_column), grid.y(last_row)],
    ]
}

fn middle(field: &HeightField) -> [f64; 2] {
    let [low, high] = reach(field);
    [0, 1].map(|axis| f64::midpoint(low[axis], high[axis]))
}

/// The UTM zone of a longitude and latitude; the exceptions around Norway are not made.
fn utm([longitude, latitude]: [f64; 2]) -> String {
    let zone = ((longitude + 180.0) / 6.0).floor().clamp(0.0, 59.0) as u8 + 1;
    let family = if latitude < 0.0 { 327 } else { 326 };
    format!("EPSG:{family}{zone:02}")
}

/// From the plane of a raster, or the globe, to another.
struct Plane<'a> {
    source: Proj,
    target: &'a Proj,
    /// Those of the raster.
    units: Units,
}

impl Plane<'_> {
    fn forth(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let mut point = match self.units {
            Units::Degrees => (x.to_radians(), y.to_radians(), 0.0),
            Units::Metres => (x, y, 0.0),
        };
        transform(&self.source, self.target, &mut point).ok()?;
        (point.0.is_finite() && point.1.is_finite()).then_some([point.0, point.1])
    }

    fn back(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let mut point = (x, y, 0.0);
        transform(self.target, &self.source, &mut point).ok()?;
        Some(match self.units {
            Units::Degrees => [point.0.to_degrees(), point.1.to_degrees()],
            Units::Metres => [point.0, point.1],
        })
    }

    /// The longitudes that a raster reaches between, degrees.
    fn longitudes(&self, low: [f64; 2], high: [f64; 2]) -> Option<[f64; 2]> {
        if self.units == Units::Degrees {
            return Some([low[0], high[0]]);
        }
        let degrees = System::degrees()?;
        let longitude = |[x, y]: [f64; 2]| {
            let mut point = (x, y, 0.0);
            transform(&self.source, &degrees, &mut point).ok()?;
            Some(point.0.to_degrees())
        };
        let corners = [low, [low[0], high[1]], [high[0], low[1]], high];
        corners
            .into_iter()
            .map(longitude)
            .try_fold([f64::INFINITY, f64::NEG_INFINITY], |[west, east], at| {
                at.map(|at| [west.min(at), east.max(at)])
            })
    }

    /// The raster drawn anew; `None` where there is no way onto the plane and back.
    fn redraw(&self, path: &Path, old: &HeightField) -> Result<Option<HeightField>, ReadError> {
        let [low, high] = reach(old);
        let (Some(spacing), Some([from, to])) =
            (self.spacing(middle(old), old), self.reach(low, high))
        else {
            return Ok(None);
        };
        // A spacing that rounds to nothing gives more posts than any raster may have.
        let steps = |axis: usize| ((to[axis] - from[axis]) / spacing[axis]).floor() as u64;
        let along = |axis: usize| steps(axis).saturating_add(1);
        let posts = count(path, along(0), along(1))?;
        let grid = grid(path, [along(0) as u32, along(1) as u32], from, spacing)?;
        let mut heights = reserved(path, posts)?;
        for row in (0..grid.rows()).rev() {
            heights.extend((0..grid.columns()).map(|column| {
                let at = self.back([grid.x(column), grid.y(row)]);
                let height = at.and_then(|[x, y]| old.height_at(x, y, Interpolation::Bilinear));
                height.map_or(f32::NAN, |z| z as f32)
            }));
        }
        field(path, grid, heights).map(Some)
    }

    /// Size of a cell at a position, m.
    fn spacing(&self, at: [f64; 2], field: &HeightField) -> Option<[f64; 2]> {
        let [dx, dy] = field.grid().spacing().to_array();
        let here = self.forth(at)?;
        let length = |to: [f64; 2]| Some((to[0] - here[0]).hypot(to[1] - here[1]));
        Some([
            length(self.forth([at[0] + dx, at[1]])?)?,
            length(self.forth([at[0], at[1] + dy])?)?,
        ])
    }

    /// The box on the plane around the edges of a raster. `None` where they do not come back to
    /// where they were by a thousandth of its size: beyond what the plane can show.
    fn reach(&self, low: [f64; 2], high: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let mut from = [f64::INFINITY; 2];
        let mut to = [f64::NEG_INFINITY; 2];
        let size = (high[0] - low[0]).max(high[1] - low[1]);
        for step in 0..=EDGE_POINTS {
            let t = f64::from(step) / f64::from(EDGE_POINTS);
            let along = [0, 1].map(|axis| low[axis] + t * (high[axis] - low[axis]));
            for edge in [
                [along[0], low[1]],
                [along[0], high[1]],
                [low[0], along[1]],
                [high[0], along[1]],
            ] {
                let point = self.forth(edge)?;
                let back = self.back(point)?;
                let off = (back[0] - edge[0]).hypot(back[1] - edge[1]);
                if off.is_nan() || off > 1e-3 * size {
                    return None;
                }
                for axis in 0..2 {
                    from[axis] = from[axis].min(point[axis]);
                    to[axis] = to[axis].max(point[axis]);
                }
            }
        }
        Some([from, to])
    }
}
