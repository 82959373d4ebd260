//! Pictures of boxes: sun and shadows, sky, ground, haze, dark edges.

use std::io::{self, Write};

use glam::Vec3;
use rayon::prelude::*;

use super::light::{LONGEST_SHADOW, Light, ground, hillside, storeys};
use super::palette::{class_colour, encode, level_colour};
use super::projector::{Projector, Ray};
use super::shadow::Shadows;
use super::{IdBuffer, NONE, Relief};
use crate::geom::{Aabb, DVec3, View};
use crate::scene::{is_building, is_cover};

/// A box as it is painted.
#[derive(Debug, Clone, Copy)]
pub struct Solid {
    pub(super) bounds: Aabb,
    /// Share of light it sends back.
    pub(super) colour: Vec3,
    /// Whether its walls show storeys.
    pub(super) storeys: bool,
}

impl Solid {
    /// In the colours of its kind; the id picks one of several.
    pub fn by_class(bounds: Aabb, class: &str, id: &str) -> Self {
        Self {
            bounds: painted(bounds, class),
            colour: class_colour(class, crc32fast::hash(id.as_bytes())),
            storeys: has_storeys(class),
        }
    }

    /// In the colour of its level of detail, 0 the finest.
    pub fn by_level(bounds: Aabb, class: &str, level: u32) -> Self {
        Self {
            bounds: painted(bounds, class),
            colour: level_colour(level),
            storeys: has_storeys(class),
        }
    }
}

fn has_storeys(class: &str) -> bool {
    is_building(class)
}

/// What covers the ground is painted as a sheet at its lowest: a box would bury what stands on it.
fn painted(bounds: Aabb, class: &str) -> Aabb {
    let (low, high) = (bounds.min(), bounds.max());
    let sheet = Aabb::new(low, high.with_z(low.z)).ok();
    sheet.filter(|_| is_cover(class, &bounds)).unwrap_or(bounds)
}

/// Rows of pixels, red, green, blue, 8 bits each in sRGB, from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Width × height, pixels.
    pub size: [u32; 2],
    /// Three bytes a pixel.
    pub rgb: Vec<u8>,
}

impl Picture {
    /// Writes the picture as a PNG file.
    ///
    /// # Errors
    /// What writing to `out` says.
    pub fn write_png(&self, out: impl Write) -> io::Result<()> {
        let [width, height] = self.size;
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()?;
        Ok(())
    }
}

/// Samples of a pixel along each side.
const SAMPLES: u32 = 2;

/// Paints what a view shows of some boxes on flat ground at height `ground_z`.
///
/// A box around the eye is left out: one would see nothing but its inner walls. Same input, same
/// bytes.
pub fn paint(view: &View, size: [u32; 2], solids: &[Solid], ground_z: f64) -> Picture {
    picture(view, size, solids, Floor::Level(ground_z))
}

/// The same on ground that is not level; beyond it there is sky.
pub fn paint_on(view: &View, size: [u32; 2], solids: &[Solid], relief: &Relief) -> Picture {
    picture(view, size, solids, Floor::Relief(relief))
}

/// What everything stands on.
#[derive(Debug, Clone, Copy)]
enum Floor<'a> {
    /// A plane at this height, m.
    Level(f64),
    Relief(&'a Relief),
}

impl<'a> Floor<'a> {
    fn relief(self) -> Option<&'a Relief> {
        match self {
            Self::Level(_) => None,
            Self::Relief(relief) => Some(relief),
        }
    }
}

fn picture(view: &View, size: [u32; 2], solids: &[Solid], floor: Floor) -> Picture {
    let fine = size.map(|side| side * SAMPLES);
    let projector = Projector::new(view, fine);
    let mut buffer = IdBuffer::new(fine[0], fine[1]);
    let open = solids
        .iter()
        .filter(|s| s.bounds.distance(view.eye()) > 0.0);
    let solids: Vec<Solid> = open.copied().collect();
    for (id, solid) in (0..).zip(&solids) {
        buffer.draw_box(&projector, &solid.bounds, id);
    }
    if let Floor::Relief(relief) = floor {
        let ids = solids.len() as u32..NONE;
        let triangles = relief.triangles.iter().copied().zip(ids);
        buffer.draw_triangles(&projector, &relief.corners, triangles);
    }
    let painter = Painter::new(projector, buffer, &solids, floor);
    let row_bytes = size[0] as usize * 3;
    let mut rgb = vec![0; row_bytes * size[1] as usize];
    if row_bytes > 0 {
        let rows = rgb.par_chunks_mut(row_bytes).enumerate();
        rows.for_each(|(row, bytes)| painter.paint_row(row as u32, bytes));
    }
    Picture { size, rgb }
}

/// What a ray meets.
#[derive(Debug, Clone, Copy)]
struct Hit {
    /// Metres along the line of sight.
    depth: f64,
    point: DVec3,
    normal: DVec3,
    /// `None` is the ground.
    solid: Option<u32>,
}

struct Painter<'a> {
    projector: Projector,
    buffer: IdBuffer,
    solids: &'a [Solid],
    floor: Floor<'a>,
    light: Light,
    shadows: Shadows,
}

impl<'a> Painter<'a> {
    fn new(projector: Projector, buffer: IdBuffer, solids: &'a [Solid], floor: Floor<'a>) -> Self {
        let [width, height] = buffer.size();
        let middle = projector.ray(f64::from(width) * 0.5, f64::from(height) * 0.5);
        let mut painter = Self {
            projector,
            buffer,
            solids,
            floor,
            light: Light::afternoon(middle.direction, 0.0..0.0),
            shadows: Shadows::new(&[], None, &[], DVec3::Z),
        };
        let city = solids
            .iter()
            .fold(Aabb::EMPTY, |all, s| all.union(&s.bounds));
        let sampled = (0..height).step_by(SHADOW_STEP).flat_map(|row| {
            (0..width)
                .step_by(SHADOW_STEP)
                .map(move |column| (column, row))
        });
        let mut points: Vec<(f64, DVec3)> = sampled
            .filter_map(|(column, row)| painter.hit(column, row))
            .filter(|hit| hit.solid.is_some() || over(&city, hit.point))
            .map(|hit| (hit.depth, hit.point))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let at = |share: f64| {
            let place = (points.len() as f64 * share) as usize;
            points.get(place).map_or(0.0, |point| point.0)
        };
        painter.light = Light::afternoon(middle.direction, at(0.02)..at(0.98));
        painter.shadows = Shadows::new(solids, floor.relief(), &points, painter.light.sun);
        painter
    }

    fn paint_row(&self, row: u32, bytes: &mut [u8]) {
        for (column, pixel) in (0_u32..).zip(bytes.chunks_exact_mut(3)) {
            let mut sum = Vec3::ZERO;
            for sample in 0..SAMPLES * SAMPLES {
                sum += self.colour(
                    column * SAMPLES + sample % SAMPLES,
                    row * SAMPLES + sample / SAMPLES,
                );
            }
            pixel.copy_from_slice(&encode(sum / (SAMPLES * SAMPLES) as f32));
        }
    }

    fn ray(&self, column: u32, row: u32) -> Ray {
        let [x, y] = [column, row].map(|c| f64::from(c) + 0.5);
        self.projector.ray(x, y)
    }

    /// The nearer of box and ground.
    fn hit(&self, column: u32, row: u32) -> Option<Hit> {
        let ray = self.ray(column, row);
        let at = row as usize * self.buffer.size()[0] as usize + column as usize;
        let ground = match self.floor {
            Floor::Level(z) if ray.direction.z < 0.0 => {
                Some((z - ray.origin.z) / ray.direction.z).filter(|&depth| depth > 0.0)
            }
            _ => None,
        };
        let id = self.buffer.ids()[at];
        let depth = self.projector.metres(self.buffer.depth()[at]);
        if id == NONE || ground.is_some_and(|ground| ground < depth) {
            return ground.map(|depth| Hit {
                depth,
                point: ray.origin + ray.direction * depth,
                normal: DVec3::Z,
                solid: None,
            });
        }
        let point = ray.origin + ray.direction * depth;
        let (normal, solid) = match (self.solids.get(id as usize), self.floor) {
            (Some(solid), _) => (normal(&solid.bounds, point, ray.direction), Some(id)),
            (None, Floor::Relief(relief)) => {
                (relief.normal(id as usize - self.solids.len(), point), None)
            }
            (None, Floor::Level(_)) => return None,
        };
        Some(Hit {
            depth,
            point,
            normal,
            solid,
        })
    }

    fn colour(&self, column: u32, row: u32) -> Vec3 {
        let ray = self.ray(column, row);
        let direction = ray.direction.normalize_or(DVec3::Y);
        let Some(hit) = self.hit(column, row) else {
            return self.light.sky(direction);
        };
        let distance = hit.depth * ray.direction.length();
        let next = self.ray(column + 1, row);
        let pixel =
            ((next.origin - ray.origin) + (next.direction - ray.direction) * hit.depth).length();
        let footprint = pixel / direction.dot(hit.normal).abs().max(1e-3);
        let albedo = match (hit.solid, self.floor) {
            (Some(id), _) => albedo(&self.solids[id as usize], &hit, pixel),
            (None, Floor::Level(_)) => ground(hit.point, footprint),
            (None, Floor::Relief(_)) => hillside(hit.point, hit.normal, footprint),
        };
        let lit = self.shadows.light(hit.depth, hit.point, hit.normal);
        let lower = self.open(&hit);
        let shaded = self.light.surface(albedo, hit.normal, lit, lower);
        let inked = shaded * (1.0 - self.ink(column, row, &hit, distance));
        self.light.through_haze(inked, distance, direction)
    }

    /// How much of the sky reaches a point: walls are darker at their foot.
    fn open(&self, hit: &Hit) -> f32 {
        const FOOT_M: f64 = 9.0;
        match hit.solid {
            Some(id) if hit.normal.z == 0.0 => {
                let foot = match self.floor {
                    Floor::Level(z) => z,
                    Floor::Relief(_) => self.solids[id as usize].bounds.min().z,
                };
                let height = (hit.point.z - foot).max(0.0);
                1.0 - 0.42 * (-height / FOOT_M).exp() as f32
            }
            _ => 1.0,
        }
    }

    /// How dark the line at a sample is: where something nearer or of another face begins.
    fn ink(&self, column: u32, row: u32, hit: &Hit, distance: f64) -> f32 {
        const OUTLINE: f32 = 0.55;
        const CREASE: f32 = 0.22;
        let [width, height] = self.buffer.size();
        let neighbours = [(1, 0), (0, 1)].map(|(dx, dy)| {
            let (x, y) = (column + dx, row + dy);
            (x < width && y < height).then(|| self.hit(x, y)).flatten()
        });
        let mut ink = 0.0_f32;
        for beside in neighbours.into_iter().flatten() {
            if beside.solid != hit.solid {
                ink = ink.max(OUTLINE);
            } else if hit.solid.is_some() && beside.normal != hit.normal {
                ink = ink.max(CREASE);
            }
        }
        let clear = self.light.transmittance(distance * 2.0);
        ink * clear
    }
}

/// The colour of a box at a point of its surface, for a pixel of this many metres.
fn albedo(solid: &Solid, hit: &Hit, pixel: f64) -> Vec3 {
    if !solid.storeys || hit.normal.z != 0.0 {
        return solid.colour;
    }
    let along = usize::from(hit.normal.x != 0.0);
    let (from, size) = (hit.point - solid.bounds.min(), solid.bounds.size());
    storeys(
        solid.colour,
        [from[along], from.z],
        [size[along], size.z],
        pixel,
    )
}

/// Pixels between those that shadow maps are fitted to.
const SHADOW_STEP: usize = 8;

/// Whether a point lies where the city's shadow may fall.
fn over(city: &Aabb, point: DVec3) -> bool {
    let reach = city.size().z * LONGEST_SHADOW;
    let off = (city.min() - point).max(point - city.max());
    off.x <= reach && off.y <= reach
}

/// The face of a box that a point lies on, of those that turn against the ray.
fn normal(b: &Aabb, point: DVec3, direction: DVec3) -> DVec3 {
    let mut best = (f64::INFINITY, DVec3::Z);
    for axis in 0..3 {
        let towards = direction[axis];
        if towards == 0.0 {
            continue;
        }
        let face = if towards > 0.0 { b.min() } else { b.max() };
        let off = (point[axis] - face[axis]).abs() / towards.abs();
        if off < best.0 {
            let mut normal = DVec3::ZERO;
            normal[axis] = -towards.signum();
            best = (off, normal);
        }
    }
    best.1
}
