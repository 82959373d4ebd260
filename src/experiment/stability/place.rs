//! Cameras of each kind, and boxes where it matters: about the borders of what they see.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::experiment::exact::{Camera, Dyadic, Oracle};
use crate::geom::{Aabb, DMat4, DQuat, DVec3, DepthRange, Orientation, Projection};

/// Where a scene lies, and how large it is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Magnitude {
    pub scale: f64,
    pub offset: DVec3,
}

/// What is special about a camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Usual,
    Quaternion,
    /// Along an axis, opening 90°: borders are rational, so they can be touched exactly.
    Aligned,
    /// `up` nearly along the line of sight.
    Steep,
    Narrow,
    Wide,
    Close,
    Orthographic,
    OffAxis,
    Matrix,
    FarAway,
}

impl Kind {
    pub const ALL: [Self; 11] = [
        Self::Usual,
        Self::Quaternion,
        Self::Aligned,
        Self::Steep,
        Self::Narrow,
        Self::Wide,
        Self::Close,
        Self::Orthographic,
        Self::OffAxis,
        Self::Matrix,
        Self::FarAway,
    ];
}

/// A camera with what it sees, roughly, in f64: enough to put boxes about its borders.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stand {
    pub camera: Camera,
    pub eye: DVec3,
    right: DVec3,
    up: DVec3,
    pub forward: DVec3,
    lens: Lens,
    /// How far off things are.
    reach: f64,
    /// And over how much depth they are spread, where that is less.
    spread: Option<f64>,
}

pub(super) fn between(rng: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

pub(super) fn vector(rng: &mut Pcg64Mcg, low: f64, high: f64) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| between(rng, low, high)))
}

fn any<T: Copy>(rng: &mut Pcg64Mcg, options: &[T]) -> T {
    options[rng.random_range(0..options.len())]
}

/// How a camera turns space into a picture.
#[derive(Debug, Clone, Copy)]
struct Lens {
    projection: Projection,
    /// Left, right, bottom, top: tangents, or metres in a parallel projection.
    window: [f64; 4],
    parallel: bool,
    depth: DepthRange,
    viewport: [u32; 2],
}

impl Lens {
    fn random(rng: &mut Pcg64Mcg, kind: Kind, reach: f64) -> Self {
        let fov_y_deg: f64 = match kind {
            Kind::Narrow => 0.01,
            Kind::Wide => 179.9,
            Kind::Aligned => 90.0,
            Kind::FarAway => any(rng, &[0.01, 60.0]),
            _ => any(rng, &[20.0, 45.0, 60.0, 75.5, 110.0]),
        };
        let viewport = any(rng, &[[1920, 1080], [800, 800], [601, 1200]]);
        let aspect = f64::from(viewport[0]) / f64::from(viewport[1]);
        let tangent = (fov_y_deg.to_radians() * 0.5).tan();
        let mut depth = DepthRange {
            near: any(rng, &[1e-6, 1e-3, 0.05]) * reach,
            far: rng.random_bool(0.4).then(|| between(rng, 0.1, 3.0) * reach),
        };
        if kind == Kind::Close {
            (depth.near, depth.far) = (1e-6, None);
        }
        let mut window = [-tangent * aspect, tangent * aspect, -tangent, tangent];
        let mut projection = Projection::Perspective { fov_y_deg };
        match kind {
            Kind::Orthographic => {
                let height_m = between(rng, 0.05, 2.0) * reach;
                let (x, y) = (height_m * 0.5 * aspect, height_m * 0.5);
                window = [-x, x, -y, y];
                projection = Projection::Orthographic { height_m };
                if rng.random_bool(0.3) {
                    depth.near = 0.0;
                }
            }
            Kind::OffAxis => {
                let (left, bottom) = (between(rng, -1.5, 0.5), between(rng, -1.5, 0.5));
                let (width, height) = (between(rng, 0.1, 1.5), between(rng, 0.1, 1.5));
                window = [left, left + width, bottom, bottom + height];
                projection = Projection::OffAxis {
                    left,
                    right: left + width,
                    bottom,
                    top: bottom + height,
                };
            }
            _ => {}
        }
        Self {
            projection,
            window,
            parallel: kind == Kind::Orthographic,
            depth,
            viewport,
        }
    }
}

impl Stand {
    /// A random camera of a kind about `at`.
    pub fn random(rng: &mut Pcg64Mcg, kind: Kind, at: Magnitude) -> Self {
        let mut eye = at.offset + vector(rng, -1.0, 1.0) * at.scale;
        let mut along = vector(rng, -1.0, 1.0);
        along.z *= 0.5;
        if kind == Kind::Aligned {
            eye = at.offset + (vector(rng, -8.0, 8.0).round() * (at.scale / 8.0));
            along = any(
                rng,
                &[DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z],
            );
        }
        let mut reach = at.scale;
        if kind == Kind::FarAway {
            reach = 1e7;
            eye -= along.normalize_or(DVec3::X) * reach;
        }
        let mut target = eye + along * reach;
        if target == eye {
            target.x += reach.max(eye.x.abs() * 1e-3);
        }
        // Scaled first, as squares of what is tiny underflow.
        let along = target - eye;
        let forward = (along / along.abs().max_element()).normalize();
        let upright = match kind {
            Kind::Steep => forward + vector(rng, -1.0, 1.0) * any(rng, &[1e-2, 1e-5, 1e-8]),
            Kind::Aligned => any(rng, &[DVec3::X, DVec3::Y, DVec3::Z]),
            _ => any(rng, &[DVec3::Z, DVec3::Z, DVec3::new(0.1, -0.2, 1.0)]),
        };
        let across = forward.cross(upright);
        if across.length() < 2e-9 * upright.length() {
            return Self::random(rng, kind, at);
        }
        let right = across.normalize();
        let up = right.cross(forward);
        let lens = Lens::random(rng, kind, reach);
        let orientation = if kind == Kind::Quaternion {
            let axes = glam::DMat3::from_cols(right, up, -forward);
            Orientation::Quaternion(DQuat::from_mat3(&axes) * any(rng, &[1.0, 3.0, 1e-5]))
        } else {
            let up = upright;
            Orientation::LookAt { target, up }
        };
        let mut stand = Self {
            camera: Camera::Posed {
                eye,
                orientation,
                projection: lens.projection,
                depth: lens.depth,
                viewport: lens.viewport,
            },
            eye,
            right,
            up,
            forward,
            lens,
            reach,
            spread: (kind == Kind::FarAway).then_some(at.scale),
        };
        // What is refused is not asked (N1): a near plane that underflows, for one.
        if stand.camera.view().is_err() {
            return Self::random(rng, kind, at);
        }
        if kind == Kind::Matrix {
            let camera = Camera::Matrix {
                view_projection: stand.matrix() * any(rng, &[1.0, 1.0, 1e-3, 1e-310, 1e200]),
                eye,
                viewport: lens.viewport,
            };
            if camera.view().is_ok() {
                stand.camera = camera;
            }
        }
        stand
    }

    /// The camera's matrix, depth from −1 to 1.
    fn matrix(&self) -> DMat4 {
        let near = self.lens.depth.near;
        let (a, b) = match self.lens.depth.far {
            Some(far) => (
                -(far + near) / (far - near),
                -2.0 * far * near / (far - near),
            ),
            None => (-1.0, -2.0 * near),
        };
        let mut projection = DMat4::from_diagonal(glam::DVec4::new(
            1.0 / self.lens.window[1],
            1.0 / self.lens.window[3],
            a,
            0.0,
        ));
        projection.z_axis.w = -1.0;
        projection.w_axis.z = b;
        let to_eye = DMat4::from_mat3(glam::DMat3::from_cols(self.right, self.up, -self.forward));
        projection * to_eye.transpose() * DMat4::from_translation(-self.eye)
    }

    /// A far distance that some things are beyond and some are not.
    pub fn far_dist(&self, rng: &mut Pcg64Mcg) -> f64 {
        self.reach * between(rng, 0.02, 1.2)
    }

    /// A point about what the camera sees, often on or about a border.
    pub fn point(&self, rng: &mut Pcg64Mcg) -> DVec3 {
        let near = self.lens.depth.near.max(self.reach * 1e-9);
        let far = self.lens.depth.far.unwrap_or(self.reach);
        let depth = match (rng.random_range(0..10), self.spread) {
            (4.., Some(spread)) => self.reach + between(rng, -1.0, 1.0) * spread,
            (0, _) => self.lens.depth.near,
            (1, _) => far,
            (2, _) => near * (far / near).powf(rng.random()),
            (3, _) => between(rng, -0.3, 0.0) * self.reach,
            _ => between(rng, 0.0, 1.3) * far,
        };
        let scale = if self.lens.parallel { 1.0 } else { depth };
        let across = |rng: &mut Pcg64Mcg, low: f64, high: f64| {
            let at = match rng.random_range(0..8) {
                0 => 0.0,
                1 => 1.0,
                2 => any(rng, &[0.0, 1.0]) + between(rng, -1e-6, 1e-6),
                _ => between(rng, -0.4, 1.4),
            };
            (low + (high - low) * at) * scale
        };
        let [left, right, bottom, top] = self.lens.window;
        let (x, y) = (across(rng, left, right), across(rng, bottom, top));
        let point = self.eye + self.right * x + self.up * y + self.forward * depth;
        if point.is_finite() { point } else { self.eye }
    }

    /// The extent of a box, often flat.
    pub fn size(&self, rng: &mut Pcg64Mcg) -> DVec3 {
        let longest =
            self.spread.unwrap_or(self.reach) * 0.5 * 10_f64.powf(between(rng, -5.0, 0.0));
        let mut size = vector(rng, 0.0, longest);
        match rng.random_range(0..12) {
            0 => size = DVec3::ZERO,
            1 => size[rng.random_range(0..3)] = 0.0,
            2 => size = size.with_x(0.0).with_z(0.0),
            3 => size[rng.random_range(0..3)] *= 1e3,
            _ => {}
        }
        size
    }

    /// A box with a corner, a face or its middle about what the camera sees.
    pub fn aabb(&self, rng: &mut Pcg64Mcg) -> Aabb {
        let (at, size) = (self.point(rng), self.size(rng));
        let from = match rng.random_range(0..4) {
            0 => size * 0.5,
            _ => {
                size * vector(rng, -0.5, 1.5)
                    .round()
                    .clamp(DVec3::ZERO, DVec3::ONE)
            }
        };
        Aabb::around([at - from, at - from + size])
    }

    /// A box with a corner as close to a border as f64 allows: the corner farthest along the
    /// half-space's normal, or else the nearest.
    pub fn touching(&self, oracle: &Oracle, rng: &mut Pcg64Mcg, farthest: bool) -> Aabb {
        let plane = rng.random_range(0..oracle.plane_count());
        let mut at = self.point(rng);
        let mut normal = DVec3::X;
        for _ in 0..4 {
            let Some((value, exact_normal)) = oracle.value_at(plane, at) else {
                break;
            };
            // Only a guess, which the next round mends: scaled into the range of f64.
            let largest = exact_normal.iter().filter_map(Dyadic::magnitude).max();
            let rounded = |x: &Dyadic| x.clone().shifted(-largest.unwrap_or(0)).floor_f64();
            normal = DVec3::from_array([0, 1, 2].map(|k| rounded(&exact_normal[k])));
            let axis = normal.abs().max_position();
            at[axis] -= rounded(&value) / normal[axis];
        }
        if !at.is_finite() {
            return self.aabb(rng); // a clip plane without direction has no border
        }
        let axis = normal.abs().max_position();
        at[axis] = match rng.random_range(0..5) {
            0 => at[axis].next_down(),
            1 => at[axis].next_up(),
            2 => at[axis].next_up().next_up(),
            _ => at[axis],
        };
        let inward = DVec3::select(normal.cmpge(DVec3::ZERO), DVec3::ONE, DVec3::NEG_ONE);
        let size = self.size(rng) * inward;
        Aabb::around([at, if farthest { at - size } else { at + size }])
    }
}
