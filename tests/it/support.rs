use citylod::geom::{Aabb, DMat4, DQuat, DVec3, DepthRange, Orientation, Projection, View};
use citylod::scene::{Scene, SceneObject};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

pub fn rng(seed: u64) -> Pcg64Mcg {
    use rand::SeedableRng;
    Pcg64Mcg::seed_from_u64(seed)
}

pub fn object(id: impl Into<String>, min: DVec3, size: DVec3) -> SceneObject {
    SceneObject {
        id: id.into().into(),
        class: "Building".into(),
        bounds: Aabb::new(min, min + size).unwrap(),
        footprint_area: size.x * size.y,
        triangles: 12,
        base_known: true,
        lift_m: 0.0,
        attributes: None,
    }
}

/// A view of 60 degrees and 1920 × 1080 pixels without far plane.
pub fn look(eye: DVec3, target: DVec3) -> View {
    View::new(
        eye,
        Orientation::LookAt {
            target,
            up: DVec3::Z,
        },
        Projection::Perspective { fov_y_deg: 60.0 },
        DepthRange::default(),
        [1920, 1080],
    )
    .unwrap()
}

pub fn between(rng: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

pub fn point(rng: &mut Pcg64Mcg, low: f64, high: f64) -> DVec3 {
    DVec3::new(
        between(rng, low, high),
        between(rng, low, high),
        between(rng, low, high),
    )
}

/// A small scene of one of several kinds: city blocks, whole metres that touch planes and range
/// borders exactly, flat and point boxes, identical boxes, far from the origin, tiny, giants
/// among dwarfs.
pub fn scene(rng: &mut Pcg64Mcg) -> Scene {
    let kind = rng.random_range(0..8);
    let count = match rng.random_range(0..10) {
        0 => rng.random_range(0..3),
        1 => rng.random_range(200..700),
        _ => rng.random_range(3..160),
    };
    let offset = match kind {
        4 => DVec3::new(486_000.25, 5_512_000.5, 120.0),
        5 => DVec3::new(4_014_743.25, 411_334.968_75, 4_922_395.0),
        _ => DVec3::ZERO,
    };
    let objects = (0..count)
        .map(|i| {
            let (min, size) = match kind {
                1 => {
                    let whole = |v: DVec3| v.floor();
                    (
                        whole(point(rng, -20.0, 20.0)) * 5.0,
                        whole(point(rng, 0.0, 4.0)) * 5.0,
                    )
                }
                2 => {
                    let mut size = point(rng, 0.0, 30.0);
                    size[rng.random_range(0..3)] = 0.0;
                    size[rng.random_range(0..3)] = 0.0;
                    (point(rng, -300.0, 300.0), size)
                }
                3 => (DVec3::splat(10.0), DVec3::splat(5.0)),
                6 => (point(rng, -1e-3, 1e-3), point(rng, 0.0, 1e-4)),
                7 => {
                    let large = if rng.random_bool(0.05) { 500.0 } else { 10.0 };
                    (point(rng, -400.0, 400.0), point(rng, 0.0, large))
                }
                _ => {
                    let mut min = point(rng, -800.0, 800.0);
                    min.z = 0.0;
                    (min + offset, point(rng, 3.0, 60.0))
                }
            };
            // Heights repeat, so that ties come up.
            let size = if rng.random_bool(0.3) {
                size.floor()
            } else {
                size
            };
            object(format!("{:03}", (i * 7919) % 1000), min, size)
        })
        .collect();
    let mut scene = Scene {
        objects,
        ..Scene::default()
    };
    scene.canonicalize();
    scene
}

/// A camera as the tests know it: enough to say independently what it sees.
#[derive(Debug, Clone)]
pub struct Camera {
    pub eye: DVec3,
    pub right: DVec3,
    pub up: DVec3,
    pub forward: DVec3,
    pub window: Window,
    pub near: f64,
    pub far: Option<f64>,
    pub viewport: [u32; 2],
    pub form: Form,
}

/// What the camera sees across: tangents of perspective, metres of parallel projection.
#[derive(Debug, Clone, Copy)]
pub enum Window {
    Tangents {
        left: f64,
        right: f64,
        bottom: f64,
        top: f64,
    },
    Metres {
        half_width: f64,
        half_height: f64,
    },
}

#[derive(Debug, Clone, Copy)]
pub enum Form {
    LookAt { target: DVec3, fov_y_deg: f64 },
    Quaternion { q: DQuat, fov_y_deg: f64 },
    Orthographic { target: DVec3, height: f64 },
    OffAxis { target: DVec3 },
    Matrix,
}

impl Camera {
    /// A random camera about a scene with these bounds.
    pub fn random(rng: &mut Pcg64Mcg, bounds: &Aabb) -> Self {
        let (middle, reach) = if bounds.is_empty() {
            (DVec3::ZERO, 100.0)
        } else {
            (bounds.center(), bounds.radius().max(1e-6))
        };
        let whole = rng.random_bool(0.2);
        let round = |v: DVec3| if whole { (v / 5.0).round() * 5.0 } else { v };
        let distance = [0.3, 1.0, 3.0, 50.0][rng.random_range(0..4)] * reach;
        let eye = round(middle + point(rng, -1.0, 1.0) * distance);
        let mut target = round(middle + point(rng, -0.7, 0.7) * reach);
        if whole {
            // Along an axis, so that planes are touched exactly.
            target = eye + [DVec3::X, DVec3::Y, DVec3::NEG_X][rng.random_range(0..3)] * 10.0;
        }
        if target == eye {
            target += DVec3::X * reach;
        }
        let forward = (target - eye).normalize();
        let right = forward.cross(DVec3::Z).normalize();
        if !right.is_finite() || forward.cross(DVec3::Z).length() < 1e-3 {
            return Self::random(rng, bounds);
        }
        let up = right.cross(forward);
        let viewport = [[1920, 1080], [800, 800], [600, 1200]][rng.random_range(0..3)];
        let aspect = f64::from(viewport[0]) / f64::from(viewport[1]);
        let near = [1e-6, 0.1, 1.0][rng.random_range(0..3)] * if reach < 1.0 { 1e-4 } else { 1.0 };
        let far = rng
            .random_bool(0.3)
            .then(|| near + between(rng, 0.1, 4.0) * reach);
        let fov_y_deg: f64 = if whole {
            90.0
        } else {
            [0.01, 20.0, 60.0, 60.0, 110.0, 179.9][rng.random_range(0..6)]
        };
        let tangent = (fov_y_deg.to_radians() / 2.0).tan();
        let symmetric = Window::Tangents {
            left: -tangent * aspect,
            right: tangent * aspect,
            bottom: -tangent,
            top: tangent,
        };
        let (form, window) = match rng.random_range(0..5) {
            0 => (Form::LookAt { target, fov_y_deg }, symmetric),
            1 => {
                let q = DQuat::from_mat3(&glam::DMat3::from_cols(right, up, -forward));
                (
                    Form::Quaternion {
                        q: q * 3.0,
                        fov_y_deg,
                    },
                    symmetric,
                )
            }
            2 => {
                let height = between(rng, 0.05, 2.0) * reach;
                let half_height = height / 2.0;
                let half_width = half_height * aspect;
                (
                    Form::Orthographic { target, height },
                    Window::Metres {
                        half_width,
                        half_height,
                    },
                )
            }
            3 => {
                let left = between(rng, -1.5, 0.5);
                let bottom = between(rng, -1.5, 0.5);
                let window = Window::Tangents {
                    left,
                    right: left + between(rng, 0.1, 1.5),
                    bottom,
                    top: bottom + between(rng, 0.1, 1.5),
                };
                (Form::OffAxis { target }, window)
            }
            // A matrix loses what its eye is far from the origin.
            _ if fov_y_deg < 170.0 && fov_y_deg > 1.0 => (Form::Matrix, symmetric),
            _ => (Form::LookAt { target, fov_y_deg }, symmetric),
        };
        Self {
            eye,
            right,
            up,
            forward,
            window,
            near,
            far,
            viewport,
            form,
        }
    }

    pub fn view(&self) -> View {
        let depth = DepthRange {
            near: self.near,
            far: self.far,
        };
        let look_at = |target| Orientation::LookAt {
            target,
            up: DVec3::Z,
        };
        let (orientation, projection) = match self.form {
            Form::LookAt { target, fov_y_deg } => {
                (look_at(target), Projection::Perspective { fov_y_deg })
            }
            Form::Quaternion { q, fov_y_deg } => (
                Orientation::Quaternion(q),
                Projection::Perspective { fov_y_deg },
            ),
            Form::Orthographic { target, height } => (
                look_at(target),
                Projection::Orthographic { height_m: height },
            ),
            Form::OffAxis { target } => {
                let Window::Tangents {
                    left,
                    right,
                    bottom,
                    top,
                } = self.window
                else {
                    unreachable!("off-axis windows are tangents");
                };
                (
                    look_at(target),
                    Projection::OffAxis {
                        left,
                        right,
                        bottom,
                        top,
                    },
                )
            }
            Form::Matrix => {
                return View::from_matrix(self.matrix(), self.eye, self.viewport).unwrap();
            }
        };
        View::new(self.eye, orientation, projection, depth, self.viewport).unwrap()
    }

    /// OpenGL clip space, z from −w to w.
    fn matrix(&self) -> DMat4 {
        let Window::Tangents { right, top, .. } = self.window else {
            unreachable!("matrices here are of perspectives");
        };
        let n = self.near;
        let (a, b) = match self.far {
            Some(f) => (-(f + n) / (f - n), -2.0 * f * n / (f - n)),
            None => (-1.0, -2.0 * n),
        };
        let projection = DMat4::from_cols_array(&[
            1.0 / right,
            0.0,
            0.0,
            0.0,
            0.0,
            1.0 / top,
            0.0,
            0.0,
            0.0,
            0.0,
            a,
            -1.0,
            0.0,
            0.0,
            b,
            0.0,
        ]);
        let (x, y, z) = (self.right, self.up, -self.forward);
        let view = DMat4::from_cols_array(&[
            x.x,
            y.x,
            z.x,
            0.0,
            x.y,
            y.y,
            z.y,
            0.0,
            x.z,
            y.z,
            z.z,
            0.0,
            -x.dot(self.eye),
            -y.dot(self.eye),
            -z.dot(self.eye),
            1.0,
        ]);
        projection * view
    }

    /// Whether all corners of the box lie beyond one of the planes, by more than `margin` of the
    /// magnitudes that go into it. Written from the corners, not from planes.
    pub fn sees_nothing_of(&self, b: &Aabb, margin: f64) -> bool {
        let (min, max) = (b.min(), b.max());
        let corners: Vec<DVec3> = (0..8)
            .map(|i| {
                let pick = |bit: usize, axis: usize| {
                    if i >> bit & 1 == 1 {
                        max[axis]
                    } else {
                        min[axis]
                    }
                };
                let p = DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)) - self.eye;
                DVec3::new(p.dot(self.right), p.dot(self.up), p.dot(self.forward))
            })
            .collect();
        // A matrix far from the origin is itself only so precise.
        let blur = match self.form {
            Form::Matrix => 1e-15 * self.eye.length() * 40.0,
            _ => 0.0,
        };
        let all = |signed: &dyn Fn(&DVec3) -> (f64, f64)| {
            corners.iter().all(|corner| {
                let (value, magnitude) = signed(corner);
                value < -(margin * magnitude + margin.signum() * blur * (1.0 + magnitude.min(1.0)))
            })
        };
        let depth_near = |c: &DVec3| (c.z - self.near, c.length() + self.near);
        if all(&depth_near) {
            return true;
        }
        if let Some(far) = self.far
            && all(&|c: &DVec3| (far - c.z, c.length() + far))
        {
            return true;
        }
        match self.window {
            Window::Tangents {
                left,
                right,
                bottom,
                top,
            } => {
                let size = |c: &DVec3, t: f64| c.length() * (1.0 + t.abs());
                all(&|c| (c.x - left * c.z, size(c, left)))
                    || all(&|c| (right * c.z - c.x, size(c, right)))
                    || all(&|c| (c.y - bottom * c.z, size(c, bottom)))
                    || all(&|c| (top * c.z - c.y, size(c, top)))
            }
            Window::Metres {
                half_width,
                half_height,
            } => {
                all(&|c| (half_width + c.x, half_width + c.length()))
                    || all(&|c| (half_width - c.x, half_width + c.length()))
                    || all(&|c| (half_height + c.y, half_height + c.length()))
                    || all(&|c| (half_height - c.y, half_height + c.length()))
            }
        }
    }

    /// Projected size in pixels of a box (DESIGN.md section 4).
    pub fn size_px(&self, b: &Aabb) -> f64 {
        let height = f64::from(self.viewport[1]);
        match self.window {
            Window::Tangents { bottom, top, .. } => {
                2.0 * b.radius() * height / (b.distance(self.eye) * (top - bottom))
            }
            Window::Metres { half_height, .. } => b.radius() * height / half_height,
        }
    }
}
