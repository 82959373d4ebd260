//! From the world to the pixels of a buffer, and back along rays.

use crate::geom::{Aabb, DVec3, Form, View};

/// Longest side of a buffer, pixels; longer ones are cut to it.
pub const LONGEST_SIDE: u32 = 65_536;

/// A view onto a buffer of a size of its own: the view's window is stretched over the whole
/// buffer, whatever the view's viewport is.
///
/// Pixel (i, j) is column i from the left, row j from the top; its centre is at (i + ½, j + ½).
#[derive(Debug, Clone)]
pub struct Projector {
    /// Where all rays of a perspective meet; in parallel projections a point of depth 0.
    centre: DVec3,
    forms: [Form; FORMS],
    rays: Rays,
    /// Half the buffer's size, pixels.
    half: [f64; 2],
}

/// What is known of a point, as linear forms relative to [`Projector::centre`].
pub(super) const FORMS: usize = 6;
pub(super) const X: usize = 0;
pub(super) const Y: usize = 1;
pub(super) const W: usize = 2;
pub(super) const NEAR: usize = 3;
pub(super) const FAR: usize = 4;
/// Metres along the line of sight.
pub(super) const DEPTH: usize = 5;

/// The lines of sight, by the pixel they go through: `corner + column · across + row · down`.
#[derive(Debug, Clone, Copy)]
struct Rays {
    /// Through the centre of pixel (0, 0).
    corner: DVec3,
    across: DVec3,
    down: DVec3,
    /// Of parallel rays; the sum above is then where they start, otherwise where they go.
    parallel: Option<DVec3>,
}

/// A function of pixel centres: `constant + column · across + row · down`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gradient {
    pub constant: f64,
    pub across: f64,
    pub down: f64,
}

/// A line of sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts, m.
    pub origin: DVec3,
    /// Where it goes: one metre of depth.
    pub direction: DVec3,
}

impl Projector {
    /// A view onto a buffer of width × height pixels.
    ///
    /// A view by a matrix that squeezes space into a plane shows nothing.
    pub fn new(view: &View, size: [u32; 2]) -> Self {
        let half = size.map(|side| f64::from(side.min(LONGEST_SIDE)) * 0.5);
        let clip = view.clip();
        // In perspective w is made the depth in metres, in parallel projections 1.
        let slope = clip.w.normal.abs().max_element();
        let parallel = slope == 0.0;
        let length = if parallel {
            clip.w.offset
        } else {
            slope * (clip.w.normal / slope).length()
        };
        let [x, y, w] = [clip.x, clip.y, clip.w].map(|form| form * length.recip());
        let sight = parallel.then(|| {
            // Away from the eye's side of the depth range, which may run either way round.
            let forward = if clip.near.offset <= clip.far.offset {
                clip.near.normal
            } else {
                clip.far.normal
            };
            let direction = x.normal.cross(y.normal).normalize_or_zero();
            if direction.dot(forward) > 0.0 {
                direction
            } else {
                -direction
            }
        });
        let depth = sight.map_or(w, |normal| Form {
            normal,
            offset: 0.0,
        });
        // The inverse of the rows x, y, depth.
        let [a, b, c] = [x, y, depth].map(|form| form.normal);
        let determinant = a.dot(b.cross(c));
        let [p, q, r] = [b.cross(c), c.cross(a), a.cross(b)].map(|column| column / determinant);
        let to_centre = -(p * x.offset + q * y.offset + r * depth.offset);
        let centre = view.eye() + to_centre;
        let moved = |form: Form| Form {
            offset: form.offset + form.normal.dot(to_centre),
            ..form
        };
        let fixed = |form: Form, offset| Form { offset, ..form };
        let mut near = moved(clip.near);
        if !(p.is_finite() && q.is_finite() && r.is_finite() && centre.is_finite()) {
            near = Form {
                normal: DVec3::ZERO,
                offset: -1.0,
            };
        }
        let (across, down) = (p / half[0], -q / half[1]);
        let middle = if parallel { DVec3::ZERO } else { r };
        Self {
            centre,
            forms: [
                fixed(x, 0.0),
                fixed(y, 0.0),
                fixed(w, if parallel { 1.0 } else { 0.0 }),
                near,
                moved(clip.far),
                fixed(depth, 0.0),
            ],
            rays: Rays {
                corner: middle + across * (0.5 - half[0]) + down * (0.5 - half[1]),
                across,
                down,
                parallel: sight,
            },
            half,
        }
    }

    /// The line of sight through a point of the buffer; (0, 0) is its upper left corner.
    pub fn ray(&self, column: f64, row: f64) -> Ray {
        let Rays {
            corner,
            across,
            down,
            parallel,
        } = self.rays;
        let through = corner + across * (column - 0.5) + down * (row - 0.5);
        match parallel {
            Some(direction) => Ray {
                origin: self.centre + through,
                direction,
            },
            None => Ray {
                origin: self.centre,
                direction: through,
            },
        }
    }

    /// Metres along the line of sight for a value of [`IdBuffer::depth`](super::IdBuffer::depth).
    pub fn metres(&self, depth: f64) -> f64 {
        if self.rays.parallel.is_some() || depth == f64::INFINITY {
            depth
        } else {
            -depth.recip()
        }
    }

    /// The reverse of [`Projector::metres`]: affine on the screen for points of a plane, less is
    /// nearer.
    pub(super) fn screen_depth(&self, metres: f64) -> f64 {
        if self.rays.parallel.is_some() {
            metres
        } else {
            -metres.recip()
        }
    }

    /// All forms of a point.
    pub(super) fn point(&self, p: DVec3) -> [f64; FORMS] {
        let p = p - self.centre;
        self.forms.map(|form| form.normal.dot(p) + form.offset)
    }

    /// All forms of the corners of a box: form by form, bit `axis` of a corner's number set where
    /// it lies at the box's maximum.
    pub(super) fn corners(&self, b: &Aabb) -> [[f64; 8]; FORMS] {
        let (min, max) = (b.min() - self.centre, b.max() - self.centre);
        self.forms.map(|Form { normal, offset }| {
            let (low, high) = (normal * min, normal * max);
            let x = [low.x + offset, high.x + offset];
            let xy = [x[0] + low.y, x[1] + low.y, x[0] + high.y, x[1] + high.y];
            let mut values = [0.0; 8];
            for i in 0..4 {
                values[i] = xy[i] + low.z;
                values[i + 4] = xy[i] + high.z;
            }
            values
        })
    }

    /// Where a point lies on the buffer, pixels, from its x, y and w.
    pub(super) fn place(&self, x: f64, y: f64, w: f64) -> [f64; 2] {
        let inverse = w.recip();
        [
            self.half[0] + self.half[0] * (x * inverse),
            self.half[1] - self.half[1] * (y * inverse),
        ]
    }

    /// Whether a face of a box turns to the eye: the one at `coordinate` of an axis, the box
    /// lying towards `+side`.
    pub(super) fn faces(&self, axis: usize, coordinate: f64, side: f64) -> bool {
        match self.rays.parallel {
            Some(direction) => direction[axis] * side > 0.0,
            None => (coordinate - self.centre[axis]) * side > 0.0,
        }
    }

    /// Screen depth of the plane where an axis has this coordinate.
    pub(super) fn axis_depth(&self, axis: usize, coordinate: f64) -> Gradient {
        let mut normal = DVec3::ZERO;
        normal[axis] = 1.0;
        self.plane_depth(normal, coordinate - self.centre[axis])
    }

    /// Screen depth of the plane through three points; `None` where they span none.
    pub(super) fn triangle_depth(&self, [a, b, c]: [DVec3; 3]) -> Option<Gradient> {
        let normal = (b - a).cross(c - a);
        (normal != DVec3::ZERO).then(|| self.plane_depth(normal, normal.dot(a - self.centre)))
    }

    /// Screen depth where `normal · (p − centre) = offset`. In perspective p − centre = depth ·
    /// ray, so −1 / depth = −normal · ray / offset; in parallel projections it is start + depth ·
    /// direction. Both are affine in the pixel.
    fn plane_depth(&self, normal: DVec3, offset: f64) -> Gradient {
        let Rays {
            corner,
            across,
            down,
            parallel,
        } = self.rays;
        let [constant, across, down] = [corner, across, down].map(|v| normal.dot(v));
        match parallel {
            Some(direction) => {
                let slope = normal.dot(direction);
                Gradient {
                    constant: (offset - constant) / slope,
                    across: -across / slope,
                    down: -down / slope,
                }
            }
            None => Gradient {
                constant: -constant / offset,
                across: -across / offset,
                down: -down / offset,
            },
        }
    }
}
