//! A camera: where it stands, what it shows, how many pixels it has.

use super::clip::ClipSpace;
use super::frustum::{Frustum, Plane};
use super::view_error::{ViewError, aspect, direction, finite, ordered};
use super::{DMat4, DQuat, DVec3};

/// How a view turns space into a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Symmetric about the forward axis; the width follows from the viewport.
    Perspective {
        /// Full vertical angle, degrees, in (0, 180).
        fov_y_deg: f64,
    },
    /// Parallel; the width follows from the viewport.
    Orthographic {
        /// Height of what is seen, m, > 0.
        height_m: f64,
    },
    /// Perspective through a window anywhere on the near side, for tiled and stereo displays:
    /// tangents of the angles to its borders, `left < right`, `bottom < top`.
    OffAxis {
        /// Tangent of the angle to the left border, negative to the left of forward.
        left: f64,
        /// To the right border.
        right: f64,
        /// To the lower border.
        bottom: f64,
        /// To the upper border.
        top: f64,
    },
}

/// Which way a camera faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Orientation {
    /// Towards a point, with a direction that appears upright.
    LookAt {
        /// The point in the middle of the picture (for symmetric projections).
        target: DVec3,
        /// Any direction not parallel to the line of sight.
        up: DVec3,
    },
    /// By rotation of a camera that looks along −z with y up and x right (OpenGL, glTF,
    /// three.js). Need not be of unit length.
    Quaternion(DQuat),
}

/// Everything about a view that a retrieval needs, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    frustum: Frustum,
    clip: ClipSpace,
    pixels: PixelScale,
    viewport: [u32; 2],
}

/// How large things appear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PixelScale {
    /// An extent e at distance d covers e/d times this many pixels.
    PerRadian(f64),
    /// An extent e covers e times this many pixels at any distance.
    PerMetre(f64),
}

/// The depth range: `near` > 0 except for orthographic views (≥ 0 there), `far` = `None` is
/// infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthRange {
    /// Distance of the near plane along forward, m.
    pub near: f64,
    /// Distance of the far plane along forward, m.
    pub far: Option<f64>,
}

impl Default for DepthRange {
    /// From 0.1 m to infinity.
    fn default() -> Self {
        Self {
            near: 0.1,
            far: None,
        }
    }
}

struct Basis {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Sine of the angle between forward and up as given: how well they fix the basis.
    sine: f64,
}

impl View {
    /// A view by position, orientation and projection.
    ///
    /// `viewport` is width × height in pixels.
    ///
    /// # Errors
    /// [`ViewError`] naming the field: not finite, zero-length direction, `up` parallel to the
    /// line of sight, angle outside (0°, 180°), `near` ≥ `far`, empty window or viewport.
    pub fn new(
        eye: DVec3,
        orientation: Orientation,
        projection: Projection,
        depth: DepthRange,
        viewport: [u32; 2],
    ) -> Result<Self, ViewError> {
        finite("eye", eye)?;
        let basis = basis(eye, orientation)?;
        let aspect = aspect(viewport)?;
        let orthographic = matches!(projection, Projection::Orthographic { .. });
        let mut planes = depth_planes(basis.forward, depth, orthographic)?;
        let height_px = f64::from(viewport[1]);
        let pixels = match projection {
            Projection::Perspective { fov_y_deg } => {
                if !(fov_y_deg > 0.0 && fov_y_deg < 180.0) {
                    return Err(ViewError::new(
                        "fov_y_deg",
                        format!("must lie between 0 and 180 degrees, is {fov_y_deg}"),
                    ));
                }
                let y = (fov_y_deg.to_radians() * 0.5).tan();
                let x = y * aspect;
                planes.extend(window_planes(&basis, [-x, x, -y, y]));
                PixelScale::PerRadian(height_px / (2.0 * y))
            }
            Projection::OffAxis {
                left,
                right,
                bottom,
                top,
            } => {
                ordered("left", left, right)?;
                ordered("bottom", bottom, top)?;
                planes.extend(window_planes(&basis, [left, right, bottom, top]));
                PixelScale::PerRadian(height_px / (top - bottom))
            }
            Projection::Orthographic { height_m } => {
                if !(height_m > 0.0 && height_m.is_finite()) {
                    return Err(ViewError::new(
                        "orthographic_height_m",
                        format!("must be a positive number of metres, is {height_m}"),
                    ));
                }
                let y = height_m * 0.5;
                let x = y * aspect;
                planes.extend(
                    [
                        (basis.right, x),
                        (-basis.right, x),
                        (basis.up, y),
                        (-basis.up, y),
                    ]
                    .map(|(normal, offset)| Plane::exact(normal, offset)),
                );
                PixelScale::PerMetre(height_px / height_m)
            }
        };
        // In units of roundoff, relative to a normal's largest component. Basis vectors come from
        // a normalisation (3), a cross product (2) that loses 1/sine, a division by its length
        // (2) and a second cross product (3): 7/sine + 3 of their length, √3 times that of their
        // largest component. The tangent of an angle x that is off by 3 moves the normal by
        // 3x/sin²x where it is above 1 and by 3x/cos²x below: less than 10. The sum adds 1.
        let coefficient_error = 20.0 + 16.0 / basis.sine;
        Ok(Self {
            clip: ClipSpace::of_planes(&planes),
            frustum: Frustum::new(eye, planes, coefficient_error),
            pixels,
            viewport,
        })
    }

    /// A view by its view-projection matrix (world to clip space, column vectors). Depth may run
    /// over −1…1 or 0…1, either way round: the half-spaces −w ≤ z ≤ w hold in all of them.
    ///
    /// # Errors
    /// [`ViewError`] naming the field when a number is not finite or the matrix shows nothing.
    pub fn from_matrix(
        view_projection: DMat4,
        eye: DVec3,
        viewport: [u32; 2],
    ) -> Result<Self, ViewError> {
        const FIELD: &str = "view_projection";
        finite("eye", eye)?;
        aspect(viewport)?;
        if !view_projection.is_finite() {
            return Err(ViewError::new(FIELD, "must be 16 finite numbers"));
        }
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| view_projection.row(i));
        let rows = [w + z, w - z, w + x, w - x, w + y, w - y];
        let mut planes = Vec::with_capacity(Frustum::MAX_PLANES);
        for row in rows {
            // Scaled first, so that no product underflows.
            let Plane { normal, offset, .. } = Plane::exact(row.truncate(), row.w).rescaled();
            let magnitude = normal.abs().dot(eye.abs()) + offset.abs();
            let offset = normal.dot(eye) + offset;
            if !normal.is_finite() || !offset.is_finite() {
                return Err(ViewError::new(FIELD, "overflows: scale it down"));
            }
            if normal != DVec3::ZERO {
                // Absolute matrices make the offset a difference of large numbers.
                planes.push(Plane {
                    normal,
                    offset,
                    offset_error: 6.0 * f64::EPSILON * magnitude,
                });
            } else if offset < 0.0 {
                return Err(ViewError::new(
                    FIELD,
                    "shows nothing: a clip plane is empty",
                ));
            }
        }
        // Sizes do not change with the scale of the matrix, but lengths may underflow with it.
        let largest = view_projection
            .to_cols_array()
            .into_iter()
            .fold(0.0, |most: f64, c| most.max(c.abs()));
        let [x, y, w] = [x, y, w].map(|row| row / largest);
        // What y holds along w is where the window lies, not how tall it is.
        let along = w.truncate().normalize_or_zero();
        let upright = y.truncate();
        let vertical = (upright - along * upright.dot(along)).length();
        let depth = w.truncate().length();
        let wide = x.truncate().length() > 0.0; // false for 0 / 0 too
        if !(vertical > 0.0 && wide) {
            return Err(ViewError::new(FIELD, "has an x or y row without direction"));
        }
        let half_height = f64::from(viewport[1]) * 0.5;
        let pixels = if depth > 0.0 {
            PixelScale::PerRadian(half_height * vertical / depth)
        } else {
            PixelScale::PerMetre(half_height * vertical / w.w.abs())
        };
        // One sum per coefficient.
        let coefficient_error = 2.0;
        Ok(Self {
            clip: ClipSpace::of_planes(&rows.map(|row| {
                let normal = row.truncate();
                Plane::exact(normal, normal.dot(eye) + row.w)
            })),
            frustum: Frustum::new(eye, planes, coefficient_error),
            pixels,
            viewport,
        })
    }

    /// Where the view is seen from, m.
    pub fn eye(&self) -> DVec3 {
        self.frustum.eye()
    }

    /// The same view without what lies beyond `distance` (m); see [`Frustum::within`].
    #[must_use]
    pub fn within(&self, distance: f64) -> Self {
        Self {
            frustum: self.frustum.within(distance),
            ..self.clone()
        }
    }

    /// What it shows.
    pub fn frustum(&self) -> &Frustum {
        &self.frustum
    }

    /// Where points lie in its picture.
    pub fn clip(&self) -> &ClipSpace {
        &self.clip
    }

    /// Width × height of its picture, pixels.
    pub fn viewport(&self) -> [u32; 2] {
        self.viewport
    }

    /// How large things appear in it.
    pub fn pixels(&self) -> PixelScale {
        self.pixels
    }
}

fn basis(eye: DVec3, orientation: Orientation) -> Result<Basis, ViewError> {
    match orientation {
        Orientation::LookAt { target, up } => {
            finite("target", target)?;
            let forward = direction("target", target - eye)?;
            let upright = direction("up", up)?;
            let side = forward.cross(upright);
            let sine = side.length();
            if sine < SMALLEST_SINE {
                return Err(ViewError::new("up", "is parallel to the line of sight"));
            }
            let right = side / sine;
            Ok(Basis {
                right,
                up: right.cross(forward),
                forward,
                sine,
            })
        }
        Orientation::Quaternion(q) => {
            if !q.is_finite() {
                return Err(ViewError::new("quaternion", "must be four finite numbers"));
            }
            let largest = q
                .to_array()
                .into_iter()
                .fold(0.0, |m: f64, c| m.max(c.abs()));
            if largest == 0.0 {
                return Err(ViewError::new(
                    "quaternion",
                    "has no direction: its length is zero",
                ));
            }
            let q = DQuat::from_array(q.to_array().map(|c| c / largest)).normalize();
            Ok(Basis {
                right: q * DVec3::X,
                up: q * DVec3::Y,
                forward: q * DVec3::NEG_Z,
                sine: 1.0,
            })
        }
    }
}

/// Below this the direction that `up` leaves open is rounding noise.
const SMALLEST_SINE: f64 = 1e-9;

fn depth_planes(
    forward: DVec3,
    DepthRange { near, far }: DepthRange,
    orthographic: bool,
) -> Result<Vec<Plane>, ViewError> {
    if !near.is_finite() || near < 0.0 || (near == 0.0 && !orthographic) {
        return Err(ViewError::new(
            "near",
            format!("must be a positive number of metres, is {near}"),
        ));
    }
    let mut planes = Vec::with_capacity(Frustum::MAX_PLANES);
    planes.push(Plane::exact(forward, -near));
    if let Some(far) = far {
        if !far.is_finite() || far <= near {
            return Err(ViewError::new(
                "far",
                format!("must be finite and beyond near ({near} m), or null, is {far}"),
            ));
        }
        planes.push(Plane::exact(-forward, far));
    }
    Ok(planes)
}

/// Side planes through the eye: left, right, bottom, top of a window given by tangents.
fn window_planes(basis: &Basis, [left, right, bottom, top]: [f64; 4]) -> [Plane; 4] {
    [
        basis.right - basis.forward * left,
        basis.forward * right - basis.right,
        basis.up - basis.forward * bottom,
        basis.forward * top - basis.up,
    ]
    .map(|normal| Plane::exact(normal, 0.0))
}
