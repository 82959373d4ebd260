//! How far from level a city lies, told by where its objects are.

use glam::DMat3;

use crate::geom::DVec3;

/// Fewer objects may lie in any plane.
const FEWEST: f64 = 20.0;
/// The spread of objects across their plane, of that along it, up to which they lie in one.
const THICKEST: f64 = 0.2;
/// Their spread along the plane's narrow side, of that along its wide one, from which on it is a
/// plane and no line.
const NARROWEST: f64 = 0.1;
/// No town as a whole lies on a steeper slope, degrees.
const STEEPEST_DEG: f64 = 20.0;

/// What is said of objects that lie in a plane so far from level, and the way out.
pub(super) fn warning(tilt_deg: f64) -> String {
    format!(
        "its objects lie in a plane {tilt_deg:.0} degrees from level, so that z hardly points up: \
         tell which axis does with --up (glTF and OBJ), or turn it upright; models cut from 3D \
         Tiles have the axes of the globe, and are to be reprojected first"
    )
}

/// Of positions, what tells the plane they lie in.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Spread {
    count: f64,
    /// Sums count from here, so that large coordinates lose no digits.
    first: DVec3,
    sum: DVec3,
    /// Of each position times itself, column by column.
    products: DMat3,
}

impl Spread {
    pub(super) fn add(&mut self, position: DVec3) {
        if self.count == 0.0 {
            *self = Self {
                first: position,
                products: DMat3::ZERO,
                ..Self::default()
            };
        }
        let from = position - self.first;
        self.count += 1.0;
        self.sum += from;
        self.products += DMat3::from_cols(from * from.x, from * from.y, from * from.z);
    }

    /// The angle between the plane of the positions and a level one, degrees, where that is more
    /// than a slope; `None` where they lie in no plane too.
    pub(super) fn tilt_deg(&self) -> Option<f64> {
        if self.count < FEWEST {
            return None;
        }
        let mean = self.sum / self.count;
        let about_mean = DMat3::from_cols(mean * mean.x, mean * mean.y, mean * mean.z);
        let covariance = self.products * self.count.recip() - about_mean;
        let [thin, narrow, wide] = eigenvalues(&covariance).map(|value| value.max(0.0).sqrt());
        if thin > THICKEST * narrow || narrow < NARROWEST * wide || wide == 0.0 {
            return None;
        }
        let normal = across(&covariance, thin * thin)?;
        let tilt = normal.z.abs().min(1.0).acos().to_degrees();
        (tilt > STEEPEST_DEG).then_some(tilt)
    }
}

/// Of a symmetric matrix, ascending.
///
/// Source: Smith, "Eigenvalues of a symmetric 3 × 3 matrix", Communications of the ACM 4, 1961.
fn eigenvalues(m: &DMat3) -> [f64; 3] {
    let mean = (m.x_axis.x + m.y_axis.y + m.z_axis.z) / 3.0;
    let off = *m - DMat3::from_diagonal(DVec3::splat(mean));
    let columns = [off.x_axis, off.y_axis, off.z_axis];
    let spread = (columns.map(DVec3::length_squared).iter().sum::<f64>() / 6.0).sqrt();
    if spread == 0.0 {
        return [mean; 3];
    }
    let half = (off * spread.recip()).determinant() / 2.0;
    let angle = half.clamp(-1.0, 1.0).acos() / 3.0;
    let at = |turn: f64| mean + 2.0 * spread * (angle + turn).cos();
    let (most, least) = (at(0.0), at(std::f64::consts::TAU / 3.0));
    [least, 3.0 * mean - most - least, most]
}

/// The direction of an eigenvalue that occurs once: it is across all columns of `m` less the
/// value, so along the longest cross product of two of them.
fn across(m: &DMat3, value: f64) -> Option<DVec3> {
    let off = *m - DMat3::from_diagonal(DVec3::splat(value));
    let (x, y, z) = (off.x_axis, off.y_axis, off.z_axis);
    let products = [x.cross(y), y.cross(z), z.cross(x)];
    let longest = products
        .into_iter()
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    longest.and_then(DVec3::try_normalize)
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;

    /// 7 × 9 places 30 m and 40 m apart, up to 4 m above a plane.
    fn places() -> impl Iterator<Item = DVec3> {
        (0..63_u32).map(|at| {
            let height = f64::from(at * 37 % 5);
            DVec3::new(f64::from(at % 7) * 30.0, f64::from(at / 7) * 40.0, height)
        })
    }

    fn tilt_deg(turn: DQuat, origin: DVec3) -> Option<f64> {
        let mut spread = Spread::default();
        places().for_each(|place| spread.add(origin + turn * place));
        spread.tilt_deg()
    }

    #[test]
    fn a_plane_that_is_turned_is_told_by_its_angle() {
        let origins = [
            DVec3::ZERO,
            DVec3::new(4_014_743.25, 411_334.97, 4_922_395.0),
        ];
        for origin in origins {
            for angle in [0.0, 5.0, 15.0, 175.0] {
                for axis in [DVec3::X, DVec3::Y, DVec3::new(0.6, -0.8, 0.0)] {
                    let turn = DQuat::from_axis_angle(axis, f64::to_radians(angle));
                    assert_eq!(tilt_deg(turn, origin), None, "{angle} about {axis}");
                }
            }
            for (angle, expected) in [(25.0, 25.0), (51.0, 51.0), (90.0, 90.0), (130.0, 50.0)] {
                for axis in [DVec3::X, DVec3::Y, DVec3::new(0.6, -0.8, 0.0)] {
                    let turn = DQuat::from_axis_angle(axis, f64::to_radians(angle));
                    let found = tilt_deg(turn, origin).unwrap_or_default();
                    assert!((found - expected).abs() < 1.0, "{found}, not {expected}");
                }
            }
        }
    }

    #[test]
    fn what_lies_in_no_plane_is_not_tilted() {
        let of = |places: &mut dyn Iterator<Item = DVec3>| {
            let mut spread = Spread::default();
            places.for_each(|place| spread.add(place));
            spread.tilt_deg()
        };
        let row = |at: u32| DVec3::new(0.5, f64::from(at) * 20.0, f64::from(at * 37 % 11) * 5.0);
        assert_eq!(of(&mut (0..40).map(row)), None, "towers along a street");
        let ball = |at: u32| {
            let at = f64::from(at);
            DVec3::new((at * 1.3).sin(), (at * 2.1).cos(), (at * 0.7).sin()) * 50.0
        };
        assert_eq!(of(&mut (0..200).map(ball)), None, "a heap");
        assert_eq!(of(&mut (0..50).map(|_| DVec3::ONE)), None, "one place");
        let turned = places().map(|place| DVec3::new(place.x, -place.z, place.y));
        assert_eq!(of(&mut turned.take(19)), None, "too few");
    }
}
