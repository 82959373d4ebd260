//! Longitude and latitude → metres in one zone of UTM.

use proj4rs::Proj;
use proj4rs::transform::transform;

use super::ImportError;
use super::collector::Collector;

/// Cells a degree, along longitude and along latitude.
const CELLS_PER_DEGREE: f64 = 100.0;
/// Cells kept, a power of two. They take about 1 MB whatever the size of the file.
const CELLS_KEPT: usize = 1 << 12;

/// Positions farther than this from the middle of a zone or from the latitude of the first one,
/// degrees, are of no city that lies there. A zone is 6 wide; here a metre is still within 4 % of
/// one.
pub(super) const FARTHEST_DEG: f64 = 15.0;

/// WGS 84 longitude and latitude → one zone of UTM.
///
/// The projection costs a hundred times as much as reading a coordinate. So it is evaluated at
/// 3 × 3 nodes of each cell of 0.01° and interpolated by the parabolas through them. Within a
/// cell of 2h ≤ 1.2 km the error is h³/(9√3 R²) times a number near 1, i.e. below 1 µm. What is
/// projected comes to the same in every file and order; whether a position is projected depends on
/// the zone and on the first position that lies near it.
pub(super) struct Utm {
    geographic: Proj,
    projected: Proj,
    zone: Zone,
    /// The zone is that of the files before, not that of the first position.
    is_given: bool,
    /// The first position that lies near the zone, which the others must not lie far from.
    first: Option<[f64; 2]>,
    cells: Vec<Cell>,
}

#[derive(Clone, Copy)]
struct Cell {
    key: (i32, i32),
    /// By row of latitude, then longitude.
    nodes: [[[f64; 2]; 3]; 3],
}

/// Numbers of the system `EPSG:326zz` (north) or `EPSG:327zz` (south).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Zone {
    number: u8,
    south: bool,
}

impl Zone {
    /// The zone of a position; the exceptions around Norway and Svalbard are not made.
    pub(super) fn of(longitude: f64, latitude: f64) -> Self {
        Self {
            number: ((longitude + 180.0) / 6.0).floor().clamp(0.0, 59.0) as u8 + 1,
            south: latitude < 0.0,
        }
    }

    pub(super) fn from_crs(crs: &str) -> Option<Self> {
        let code: u16 = crs.strip_prefix("EPSG:")?.parse().ok()?;
        let number = (code % 100) as u8;
        let known = matches!(code / 100, 326 | 327) && (1..=60).contains(&number);
        known.then_some(Self {
            number,
            south: code / 100 == 327,
        })
    }

    /// Longitude of its middle, degrees.
    fn meridian(self) -> f64 {
        f64::from(self.number) * 6.0 - 183.0
    }

    pub(super) fn crs(self) -> String {
        let family = if self.south { 327 } else { 326 };
        format!("EPSG:{family}{:02}", self.number)
    }
}

impl Utm {
    /// Of a file with its first position there: in the zone of the files before, else in that of
    /// the position.
    pub(super) fn begin(
        [longitude, latitude]: [f64; 2],
        collector: &mut Collector,
    ) -> Result<Option<Self>, ImportError> {
        let known = collector.known_crs().and_then(Zone::from_crs);
        let zone = known.unwrap_or_else(|| Zone::of(longitude, latitude));
        collector.crs(&zone.crs())?;
        Ok(Self::new(zone, known.is_some()).ok())
    }

    /// What is wrong with positions that have no place.
    pub(super) fn fault(&self) -> String {
        format!(
            "not finite, off the globe or over {FARTHEST_DEG} degrees from {}",
            self.middle()
        )
    }

    /// `is_given` says that the zone is that of the files before.
    pub(super) fn new(zone: Zone, is_given: bool) -> Result<Self, proj4rs::errors::Error> {
        let south = if zone.south { " +south" } else { "" };
        Ok(Self {
            geographic: Proj::from_proj_string("+proj=longlat +datum=WGS84 +no_defs")?,
            projected: Proj::from_proj_string(&format!(
                "+proj=utm +zone={}{south} +datum=WGS84 +units=m +no_defs",
                zone.number
            ))?,
            zone,
            is_given,
            first: None,
            cells: vec![
                Cell {
                    key: (i32::MAX, i32::MAX),
                    nodes: [[[f64::NAN; 2]; 3]; 3],
                };
                CELLS_KEPT
            ],
        })
    }

    /// Whether a position lies no more than [`FARTHEST_DEG`] from where the others are.
    pub(super) fn is_near(&self, longitude: f64, latitude: f64) -> bool {
        // The shorter way around the globe.
        let east = (longitude - self.zone.meridian() + 180.0).rem_euclid(360.0) - 180.0;
        let north = self.first.map_or(0.0, |first| latitude - first[1]);
        east.abs().max(north.abs()) <= FARTHEST_DEG
    }

    /// Where the others are, for people.
    pub(super) fn middle(&self) -> String {
        let crs = self.zone.crs();
        let at = |[x, y]: [f64; 2]| format!("longitude {x}, latitude {y}");
        match self.first.map(at) {
            None => format!("{crs}, the UTM zone of the files before"),
            Some(at) if self.is_given => format!(
                "{crs}, the UTM zone of the files before, or from the latitude of the first one \
                 near it, at {at}"
            ),
            Some(at) => format!("the UTM zone or the latitude of the first one, at {at}"),
        }
    }

    /// What to do where most lie elsewhere.
    pub(super) fn way_out(&self) -> &'static str {
        match self.first {
            None => "import the file into a separate scene",
            Some(_) => "remove that one if it is astray, or import the places into separate scenes",
        }
    }

    /// Easting and northing in metres; NaN where the position is not on the globe or not near.
    pub(super) fn project(&mut self, longitude: f64, latitude: f64) -> [f64; 2] {
        if !is_lon_lat(longitude, latitude) || !self.is_near(longitude, latitude) {
            return [f64::NAN; 2];
        }
        self.first.get_or_insert([longitude, latitude]);
        let (x, y) = (longitude * CELLS_PER_DEGREE, latitude * CELLS_PER_DEGREE);
        let (column, row) = (x.floor(), y.floor());
        let cell = self.cell(column as i32, row as i32);
        let (along_x, along_y) = (parabolas(x - column), parabolas(y - row));
        let mut point = [0.0; 2];
        for (nodes, weight) in cell.iter().zip(along_y) {
            for (axis, sum) in point.iter_mut().enumerate() {
                *sum += weight
                    * (nodes[0][axis] * along_x[0]
                        + nodes[1][axis] * along_x[1]
                        + nodes[2][axis] * along_x[2]);
            }
        }
        if point[0].is_finite() {
            point
        } else {
            // A cell at the edge of the domain has nodes that cannot be projected.
            self.exactly(longitude, latitude)
        }
    }

    fn cell(&mut self, column: i32, row: i32) -> &[[[f64; 2]; 3]; 3] {
        let slot =
            (column as u32).wrapping_add((row as u32).wrapping_mul(61)) as usize & (CELLS_KEPT - 1);
        if self.cells[slot].key != (column, row) {
            let at =
                |cell: i32, node: usize| (f64::from(cell) + node as f64 * 0.5) / CELLS_PER_DEGREE;
            let nodes = std::array::from_fn(|j| {
                std::array::from_fn(|i| self.exactly(at(column, i), at(row, j)))
            });
            self.cells[slot] = Cell {
                key: (column, row),
                nodes,
            };
        }
        &self.cells[slot].nodes
    }

    fn exactly(&self, longitude: f64, latitude: f64) -> [f64; 2] {
        let mut point = (longitude.to_radians(), latitude.to_radians(), 0.0);
        match transform(&self.geographic, &self.projected, &mut point) {
            Ok(()) => [point.0, point.1],
            Err(_) => [f64::NAN; 2],
        }
    }
}

/// Whether the numbers can be degrees of longitude and latitude.
pub(super) fn is_lon_lat(longitude: f64, latitude: f64) -> bool {
    (-180.0..=180.0).contains(&longitude) && (-90.0..=90.0).contains(&latitude)
}

/// Weights of the values at 0, ½ and 1 for the parabola through them, at t in [0, 1].
fn parabolas(t: f64) -> [f64; 3] {
    [
        (1.0 - t) * (1.0 - 2.0 * t),
        4.0 * t * (1.0 - t),
        t * (2.0 * t - 1.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Metres.
    const TOLERANCE: f64 = 1e-6;

    #[test]
    fn interpolated_positions_are_the_projected_ones() {
        let mut state = 7_u64;
        let mut random = |low: f64, high: f64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * ((state >> 11) as f64 / (1_u64 << 53) as f64)
        };
        for _ in 0..300 {
            let (lon, lat) = (random(-180.0, 180.0), random(-84.0, 84.0));
            let Ok(mut utm) = Utm::new(Zone::of(lon, lat), false) else {
                unreachable!("every zone has a projection");
            };
            for _ in 0..20 {
                let lon = (lon + random(-0.02, 0.02)).clamp(-180.0, 180.0);
                let lat = lat + random(-0.02, 0.02);
                let (fast, exact) = (utm.project(lon, lat), utm.exactly(lon, lat));
                for axis in 0..2 {
                    let error = (fast[axis] - exact[axis]).abs();
                    assert!(error < TOLERANCE, "{error} m at {lon} {lat}");
                }
            }
        }
    }

    /// The CN Tower, the usual example: zone 17, 630 084 m east, 4 833 438 m north.
    #[test]
    fn a_known_place_is_where_it_is_known_to_be() {
        let (lon, lat) = (-79.387_139, 43.642_567);
        let zone = Zone::of(lon, lat);
        assert_eq!(zone.crs(), "EPSG:32617");
        let Ok(mut utm) = Utm::new(zone, false) else {
            unreachable!("every zone has a projection");
        };
        let [x, y] = utm.project(lon, lat);
        assert!((x - 630_084.0).abs() < 1.0, "{x}");
        assert!((y - 4_833_438.0).abs() < 1.0, "{y}");
    }

    #[test]
    fn what_is_far_from_a_zone_has_no_place_in_it() {
        let Ok(mut utm) = Utm::new(Zone::of(179.9, 50.0), false) else {
            unreachable!("every zone has a projection");
        };
        for (lon, lat, is_near) in [
            (177.0, 50.0, true),
            (162.1, 50.0, true),
            (161.9, 50.0, false),
            (-168.1, 50.0, true),
            (-167.9, 50.0, false),
            (0.0, 50.0, false),
            (177.0, 64.9, true),
            (177.0, 65.1, false),
            (177.0, 0.0, false),
        ] {
            let [x, _] = utm.project(lon, lat);
            assert_eq!(x.is_finite(), is_near, "{lon} {lat}");
        }
    }

    #[test]
    fn zones() {
        for (lon, lat, crs) in [
            (139.76, 35.68, "EPSG:32654"),
            (-180.0, 1.0, "EPSG:32601"),
            (180.0, 1.0, "EPSG:32660"),
            (18.42, -33.92, "EPSG:32734"),
            (0.0, 0.0, "EPSG:32631"),
        ] {
            let zone = Zone::of(lon, lat);
            assert_eq!(zone.crs(), crs);
            assert_eq!(Zone::from_crs(crs), Some(zone));
        }
        for crs in ["EPSG:6677", "EPSG:32600", "EPSG:32661", "OGC:CRS84", ""] {
            assert_eq!(Zone::from_crs(crs), None, "{crs}");
        }
    }
}
