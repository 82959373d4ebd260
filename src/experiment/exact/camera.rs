//! What a view was made from, and the half-spaces that it stands for.

use std::cmp::Ordering;

use super::dyadic::Dyadic;
use super::real::Enclosure;
use crate::geom::{DMat4, DVec3, DepthRange, Orientation, Projection, View, ViewError};

/// The arguments of [`View::new`] or of [`View::from_matrix`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Camera {
    /// By position, orientation and projection.
    Posed {
        /// Where it stands, m.
        eye: DVec3,
        /// Which way it faces.
        orientation: Orientation,
        /// How it turns space into a picture.
        projection: Projection,
        /// From where to where it sees.
        depth: DepthRange,
        /// Width × height, px.
        viewport: [u32; 2],
    },
    /// By view-projection matrix: what meets −w ≤ x, y, z ≤ w.
    Matrix {
        /// World to clip space, column vectors.
        view_projection: DMat4,
        /// Where it stands, m.
        eye: DVec3,
        /// Width × height, px.
        viewport: [u32; 2],
    },
}

/// Three coordinates.
pub(super) type Vector = [Dyadic; 3];

/// The half-space a·p + b ≥ 0 with (a, b) = `fixed` + κ·`growing`, p relative to the eye.
///
/// κ may be irrational. In front of the eye a larger κ makes a larger half-space, so putting its
/// upper bound in encloses the frustum, and its lower bound what is certainly in it.
#[derive(Debug, Clone)]
pub(super) struct HalfSpace {
    pub fixed: [Dyadic; 4],
    pub growing: [Dyadic; 4],
    pub factor: Enclosure,
}

impl HalfSpace {
    fn rational(fixed: [Dyadic; 4]) -> Self {
        Self {
            fixed,
            growing: [(); 4].map(|()| Dyadic::zero()),
            factor: Enclosure::exact(Dyadic::zero()),
        }
    }

    /// The coefficients for one value of κ.
    pub fn at(&self, factor: &Dyadic) -> [Dyadic; 4] {
        std::array::from_fn(|k| {
            if self.growing[k].sign() == Ordering::Equal {
                self.fixed[k].clone()
            } else {
                &self.fixed[k] + &(&self.growing[k] * factor)
            }
        })
    }
}

impl Camera {
    /// The view that production code makes of it.
    ///
    /// # Errors
    /// As [`View::new`] and [`View::from_matrix`].
    pub fn view(&self) -> Result<View, ViewError> {
        match *self {
            Self::Posed {
                eye,
                orientation,
                projection,
                depth,
                viewport,
            } => View::new(eye, orientation, projection, depth, viewport),
            Self::Matrix {
                view_projection,
                eye,
                viewport,
            } => View::from_matrix(view_projection, eye, viewport),
        }
    }

    /// Where it stands, m.
    pub fn eye(&self) -> DVec3 {
        let (Self::Posed { eye, .. } | Self::Matrix { eye, .. }) = *self;
        eye
    }

    /// The half-spaces, irrational numbers in them to `bits` bits.
    pub(super) fn half_spaces(&self, bits: u32) -> Vec<HalfSpace> {
        match self {
            Self::Posed {
                eye,
                orientation,
                projection,
                depth,
                viewport,
            } => posed(*eye, *orientation, *projection, *depth, *viewport, bits),
            Self::Matrix {
                view_projection,
                eye,
                ..
            } => clip_planes(view_projection, *eye),
        }
    }
}

fn posed(
    eye: DVec3,
    orientation: Orientation,
    projection: Projection,
    depth: DepthRange,
    [width, height]: [u32; 2],
    bits: u32,
) -> Vec<HalfSpace> {
    let [right, up, forward] = axes(eye, orientation);
    let squared = |v: &Vector| dot(v, v);
    let length = |v: &Vector| Enclosure::sqrt(&squared(v), bits);
    let (width, height) = (Dyadic::from(width), Dyadic::from(height));
    let one = Dyadic::from(1);
    let at_depth = |direction: &Vector, distance: f64| HalfSpace {
        fixed: with_offset(direction.clone(), Dyadic::zero()),
        growing: with_offset(zero_vector(), one.clone()),
        factor: length(&forward).times(&Dyadic::from(distance)),
    };
    let mut planes = vec![at_depth(&forward, -depth.near)];
    if let Some(far) = depth.far {
        planes.push(at_depth(&negated(&forward), far));
    }
    match projection {
        Projection::Perspective { fov_y_deg } => {
            // X ≤ Z·tan·width/height with X = right·p/|right| and Z = forward·p/|forward|.
            let tangent = Enclosure::tan_half_degrees(fov_y_deg, bits);
            for (axis, across) in [(&right, &width), (&up, &height)] {
                let root = Enclosure::sqrt(&(&squared(axis) * &squared(&forward)), bits);
                let factor = tangent.times_positive(&root).times(across);
                let scale = &squared(&forward) * &height;
                planes.push(beside(&scaled(axis, &scale), &forward, factor.clone()));
                planes.push(beside(&scaled(axis, &-&scale), &forward, factor));
            }
        }
        Projection::OffAxis {
            left,
            right: to_right,
            bottom,
            top,
        } => {
            for (axis, low, high) in [(&right, left, to_right), (&up, bottom, top)] {
                let root = Enclosure::sqrt(&(&squared(axis) * &squared(&forward)), bits);
                let axis = scaled(axis, &squared(&forward));
                let low = root.times(&Dyadic::from(-low));
                planes.push(beside(&axis, &forward, low));
                let high = root.times(&Dyadic::from(high));
                planes.push(beside(&negated(&axis), &forward, high));
            }
        }
        Projection::Orthographic { height_m } => {
            // |X| ≤ height_m·width/(2·height), |Y| ≤ height_m/2.
            let tall = Dyadic::from(height_m);
            for (axis, across) in [(&right, &width), (&up, &height)] {
                let factor = length(axis).times(&(&tall * across));
                let scale = &height + &height;
                for axis in [scaled(axis, &scale), scaled(axis, &-&scale)] {
                    planes.push(HalfSpace {
                        fixed: with_offset(axis, Dyadic::zero()),
                        growing: with_offset(zero_vector(), one.clone()),
                        factor: factor.clone(),
                    });
                }
            }
        }
    }
    planes
}

/// axis·p + κ·forward·p ≥ 0.
fn beside(axis: &Vector, forward: &Vector, factor: Enclosure) -> HalfSpace {
    HalfSpace {
        fixed: with_offset(axis.clone(), Dyadic::zero()),
        growing: with_offset(forward.clone(), Dyadic::zero()),
        factor,
    }
}

/// Right, up and forward, at right angles, of any length.
fn axes(eye: DVec3, orientation: Orientation) -> [Vector; 3] {
    match orientation {
        Orientation::LookAt { target, up } => {
            let (eye, target) = (vector(eye), vector(target));
            let forward = std::array::from_fn(|k| &target[k] - &eye[k]);
            let right = cross(&forward, &vector(up));
            let up = cross(&right, &forward);
            [right, up, forward]
        }
        Orientation::Quaternion(q) => {
            // The rotation times |q|², the axes of the camera being x, y and −z.
            let [x, y, z, w] = q.to_array().map(Dyadic::from);
            let two = |a: Dyadic| a.shifted(1);
            let diagonal = |a: &Dyadic, b: &Dyadic, c: &Dyadic| {
                &(&(&w * &w) + &(a * a)) - &(&(b * b) + &(c * c))
            };
            let sum = |a: &Dyadic, b: &Dyadic, c: &Dyadic| two(&(a * b) + &(c * &w));
            let difference = |a: &Dyadic, b: &Dyadic, c: &Dyadic| two(&(a * b) - &(c * &w));
            [
                [
                    diagonal(&x, &y, &z),
                    sum(&x, &y, &z),
                    difference(&x, &z, &y),
                ],
                [
                    difference(&x, &y, &z),
                    diagonal(&y, &x, &z),
                    sum(&y, &z, &x),
                ],
                negated(&[
                    sum(&x, &z, &y),
                    difference(&y, &z, &x),
                    diagonal(&z, &x, &y),
                ]),
            ]
        }
    }
}

/// w ± x, w ± y and w ± z, relative to the eye.
fn clip_planes(matrix: &DMat4, eye: DVec3) -> Vec<HalfSpace> {
    let [x, y, z, w] = [0, 1, 2, 3].map(|i| matrix.row(i).to_array().map(Dyadic::from));
    let eye = vector(eye);
    let mut planes = Vec::new();
    for row in [&x, &y, &z] {
        for sign in [1, -1] {
            let sign = Dyadic::from(sign);
            let [a, b, c, d]: [Dyadic; 4] = std::array::from_fn(|k| &w[k] + &(&row[k] * &sign));
            let normal = [a, b, c];
            let offset = &d + &dot(&normal, &eye);
            planes.push(HalfSpace::rational(with_offset(normal, offset)));
        }
    }
    planes
}

pub(super) fn vector(v: DVec3) -> Vector {
    v.to_array().map(Dyadic::from)
}

pub(super) fn dot(a: &Vector, b: &Vector) -> Dyadic {
    let terms = a.iter().zip(b).map(|(a, b)| a * b);
    terms.fold(Dyadic::zero(), |sum, term| &sum + &term)
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        &(&a[i] * &b[j]) - &(&a[j] * &b[i])
    })
}

fn negated(v: &Vector) -> Vector {
    std::array::from_fn(|k| -&v[k])
}

fn scaled(v: &Vector, factor: &Dyadic) -> Vector {
    std::array::from_fn(|k| &v[k] * factor)
}

fn zero_vector() -> Vector {
    [(); 3].map(|()| Dyadic::zero())
}

fn with_offset([x, y, z]: Vector, offset: Dyadic) -> [Dyadic; 4] {
    [x, y, z, offset]
}
