//! What the sun does not reach: depths seen from the sun, by the same rasteriser.
//!
//! The visible points are sorted into slices of depth, and each slice has a shadow map fitted to
//! its own points, so that a shadow's border is about as fine as the pixels it is seen in
//! (Lauritzen, Salvi, Lefohn, "Sample distribution shadow maps", 2011).

use super::projector::{DEPTH, Projector, X, Y};
use super::{IdBuffer, Relief, Solid};
use crate::geom::{DVec2, DVec3, DepthRange, Orientation, Projection, View};

const MAP_SIDE: u32 = 2048;
const SLICES: usize = 3;

pub(super) struct Shadows {
    /// Farthest depth of each slice but the last, m.
    limits: [f64; SLICES - 1],
    maps: Vec<Map>,
}

struct Map {
    projector: Projector,
    buffer: IdBuffer,
    /// Extent of a pixel, m.
    texel: f64,
}

impl Shadows {
    /// Shadows of `solids`, and of a relief, on points, given with their depth, in the light from `sun`.
    pub(super) fn new(
        solids: &[Solid],
        relief: Option<&Relief>,
        points: &[(f64, DVec3)],
        sun: DVec3,
    ) -> Self {
        let depths = points.iter().map(|point| point.0.max(f64::MIN_POSITIVE));
        let (nearest, farthest) = depths.fold((f64::MAX, 0.0_f64), |(near, far), depth| {
            (near.min(depth), far.max(depth))
        });
        let ratio = (farthest / nearest).max(1.0);
        let limits =
            std::array::from_fn(|slice| nearest * ratio.powf((slice + 1) as f64 / SLICES as f64));
        let maps = (0..SLICES).filter_map(|slice| {
            let of_slice = points.iter().filter(|p| slice_of(&limits, p.0) == slice);
            Map::new(solids, relief, of_slice.map(|p| p.1), sun)
        });
        Self {
            limits,
            maps: maps.collect(),
        }
    }

    /// Share of the sun's light that reaches a point of a surface, 0 to 1.
    pub(super) fn light(&self, depth: f64, point: DVec3, normal: DVec3) -> f32 {
        let first = slice_of(&self.limits, depth).min(self.maps.len().saturating_sub(1));
        let mut maps = self.maps.iter().skip(first);
        maps.find_map(|map| map.light(point, normal)).unwrap_or(1.0)
    }
}

fn slice_of(limits: &[f64], depth: f64) -> usize {
    limits.partition_point(|&limit| limit < depth)
}

impl Map {
    /// `None` where there is nothing to look at.
    fn new(
        solids: &[Solid],
        relief: Option<&Relief>,
        points: impl Iterator<Item = DVec3> + Clone,
        sun: DVec3,
    ) -> Option<Self> {
        let right = DVec3::Z.cross(sun).try_normalize().unwrap_or(DVec3::X);
        let up = sun.cross(right);
        let first = points.clone().next()?;
        let flat = points.map(|p| DVec2::new((p - first).dot(right), (p - first).dot(up)));
        let (low, high) = flat.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
        let middle = first + (right * (low.x + high.x) + up * (low.y + high.y)) * 0.5;
        let side = (high - low).max_element().max(1.0) * 1.02;
        // Beyond what casts a shadow into the slice.
        let away = side + REACH_M;
        let orientation = Orientation::LookAt { target: middle, up };
        let depth = DepthRange {
            near: 0.0,
            far: None,
        };
        let projection = Projection::Orthographic { height_m: side };
        let size = [MAP_SIDE; 2];
        let view = View::new(middle + sun * away, orientation, projection, depth, size).ok()?;
        let projector = Projector::new(&view, size);
        let mut buffer = IdBuffer::new(MAP_SIDE, MAP_SIDE);
        for (id, solid) in (0..).zip(solids) {
            buffer.draw_box(&projector, &solid.bounds, id);
        }
        if let Some(relief) = relief {
            buffer.draw_mesh(&projector, &relief.corners, &relief.triangles, 0);
        }
        Some(Self {
            projector,
            buffer,
            texel: side / f64::from(MAP_SIDE),
        })
    }

    /// `None` for points outside the map. Between pixels the four nearest are weighed.
    fn light(&self, point: DVec3, normal: DVec3) -> Option<f32> {
        // Off the surface, so that it does not shade itself.
        let forms = self
            .projector
            .point(point + normal * (1.5 * self.texel + 0.02));
        let [x, y] = self
            .projector
            .place(forms[X], forms[Y], 1.0)
            .map(|p| p - 0.5);
        let inside = 0.0..f64::from(MAP_SIDE - 1);
        if !inside.contains(&x) || !inside.contains(&y) {
            return None;
        }
        let (column, row) = (x as usize, y as usize);
        let (right, down) = (x.fract() as f32, y.fract() as f32);
        let depth = self.buffer.depth();
        let lit = |column: usize, row: usize| {
            let nearest = depth[row * MAP_SIDE as usize + column];
            f32::from(u8::from(nearest >= forms[DEPTH]))
        };
        let upper = lit(column, row) * (1.0 - right) + lit(column + 1, row) * right;
        let lower = lit(column, row + 1) * (1.0 - right) + lit(column + 1, row + 1) * right;
        Some(upper * (1.0 - down) + lower * down)
    }
}

/// Taller than anything, seen along the light.
const REACH_M: f64 = 5000.0;
