//! Whether positions are earth-centred, and where on the globe they are.

use super::utm::Zone;
use crate::geom::DVec3;

/// Semi-major axis of the WGS 84 ellipsoid, m. Source: EPSG:7030.
const EQUATORIAL_M: f64 = 6_378_137.0;
/// Inverse flattening of the WGS 84 ellipsoid. Source: EPSG:7030.
const INVERSE_FLATTENING: f64 = 298.257_223_563;
/// Semi-minor axis, m: a·(1 − f).
const POLAR_M: f64 = EQUATORIAL_M * (1.0 - 1.0 / INVERSE_FLATTENING);
/// Nothing of a city lies farther above or below the ellipsoid than this, m.
const HIGHEST_M: f64 = 10_000.0;

/// Whether a position lies near the surface of the globe when counted from its middle, and higher
/// above the plane z = 0 than any place in a system of a plane. That tells it from northings in the
/// same range of numbers, as those of UTM at 57 degrees. Places within 10 km of the equator are
/// not recognised.
pub(super) fn is_earth_centred(position: DVec3) -> bool {
    let shell = POLAR_M - HIGHEST_M..=EQUATORIAL_M + HIGHEST_M;
    shell.contains(&position.length()) && position.z.abs() > HIGHEST_M
}

/// Longitude and latitude of an earth-centred position near the ellipsoid, degrees. On it exact;
/// within 10 km of it off by less than 0.001.
///
/// Source: on the ellipsoid tan φ = z / (p·(1 − e²)), p the distance from the axis and
/// 1 − e² = (b/a)²; Bowring, "Transformation from spatial to geographical coordinates", 1976,
/// where the height is 0.
pub(super) fn lon_lat(position: DVec3) -> [f64; 2] {
    let DVec3 { x, y, z } = position;
    let squeezed = (POLAR_M / EQUATORIAL_M).powi(2);
    [y.atan2(x), z.atan2(x.hypot(y) * squeezed)].map(f64::to_degrees)
}

/// What is wrong with objects in such coordinates, one of them here, and the way out.
pub(super) fn warning(position: DVec3) -> String {
    let [longitude, latitude] = lon_lat(position);
    let crs = Zone::of(longitude, latitude).crs();
    format!(
        "its coordinates count from the middle of the earth (EPSG:4978), here at longitude \
         {longitude:.2}, latitude {latitude:.2}; z does not point up there, so that the city is \
         tilted: reproject it to a system in metres with z up, such as {crs}, or export it without \
         the transform that puts it on the globe"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An earth-centred position. Source: EPSG Guidance Note 7-2, method 9602.
    fn on_globe(longitude: f64, latitude: f64, height: f64) -> DVec3 {
        let (lon, lat) = (longitude.to_radians(), latitude.to_radians());
        let squeezed = (POLAR_M / EQUATORIAL_M).powi(2);
        let normal = EQUATORIAL_M / (1.0 - (1.0 - squeezed) * lat.sin().powi(2)).sqrt();
        DVec3::new(
            (normal + height) * lat.cos() * lon.cos(),
            (normal + height) * lat.cos() * lon.sin(),
            (normal * squeezed + height) * lat.sin(),
        )
    }

    /// The example of EPSG Guidance Note 7-2 for method 9602.
    #[test]
    fn a_known_place_is_where_it_is_known_to_be() {
        let known = DVec3::new(3_771_793.968, 140_253.342, 5_124_304.349);
        let place = on_globe(
            2.0 + 7.0 / 60.0 + 46.38 / 3600.0,
            53.0 + 48.0 / 60.0 + 33.82 / 3600.0,
            73.0,
        );
        assert!(place.distance(known) < 0.01, "{place}");
        assert!(is_earth_centred(known));
        let [longitude, latitude] = lon_lat(known);
        assert!((longitude - 2.129_55).abs() < 1e-5, "{longitude}");
        assert!((latitude - 53.809_394).abs() < 1e-5, "{latitude}");
    }

    #[test]
    fn all_places_but_those_on_the_equator_are_told() {
        for latitude in [-90.0, -89.99, -33.9, -0.2, 0.2, 1.3, 35.7, 57.0, 78.2, 90.0] {
            for longitude in [-180.0, -70.0, 0.0, 4.4, 139.7] {
                for height in [-430.0, 0.0, 8_900.0] {
                    let place = on_globe(longitude, latitude, height);
                    assert!(is_earth_centred(place), "{longitude} {latitude} {height}");
                    let error = lon_lat(place)[1] - latitude;
                    assert!(error.abs() < 1e-3, "{latitude}: off by {error}");
                }
            }
        }
        assert!(!is_earth_centred(on_globe(9.4, 0.0, 10.0)));
    }

    #[test]
    fn planes_are_not_taken_for_the_globe() {
        for place in [
            DVec3::ZERO,
            DVec3::new(500_000.0, 6_350_000.0, 40.0), // UTM at 57.3 degrees
            DVec3::new(550_000.0, 6_353_000.0, 8_849.0),
            DVec3::new(85_000.0, 446_000.0, 3.0),
            DVec3::new(2_683_000.0, 1_247_000.0, 400.0),
            DVec3::new(0.0, 0.0, 420_000.0),
        ] {
            assert!(!is_earth_centred(place), "{place}");
        }
    }
}
