//! Sun, sky, ground and haze.

use std::ops::Range;

use glam::Vec3;

use super::palette::srgb;
use crate::geom::DVec3;

/// Height of the sun above the horizon, radians.
const ELEVATION: f64 = 0.68;
/// Length of a shadow on the ground for a height of 1: more than 1 / tan 0.68.
pub(super) const LONGEST_SHADOW: f64 = 1.25;

/// Everything about the weather.
#[derive(Debug, Clone)]
pub(super) struct Light {
    /// Towards the sun, of unit length.
    pub sun: DVec3,
    sunlight: Vec3,
    /// From straight above, and from the horizon and the ground.
    zenith: Vec3,
    horizon: Vec3,
    /// Where haze begins, and over which length it takes all but 1/e, m.
    haze: [f64; 2],
}

impl Light {
    /// A clear afternoon, the sun a little to the left of and behind who looks along `forward`, so
    /// that of two walls seen one is lit; of what is seen, between these distances, the near end is
    /// clear and the far end well in the haze.
    pub(super) fn afternoon(forward: DVec3, seen_m: Range<f64>) -> Self {
        const TO_THE_LEFT: f64 = 2.25;
        let ahead = forward.with_z(0.0).try_normalize().unwrap_or(DVec3::Y);
        let left = DVec3::Z.cross(ahead);
        let level = ahead * TO_THE_LEFT.cos() + left * TO_THE_LEFT.sin();
        Self {
            sun: level * ELEVATION.cos() + DVec3::Z * ELEVATION.sin(),
            sunlight: Vec3::new(1.0, 0.91, 0.76) * 1.42,
            zenith: srgb(0x6f_9fd0),
            horizon: srgb(0xe6_edf1),
            haze: [seen_m.start, (seen_m.end - seen_m.start).max(1000.0) / 0.55],
        }
    }

    /// What a surface sends back: `albedo` in the sun's light as far as it is `lit`, and in the
    /// light of the sky as far as it is `open` to it, both 0 to 1.
    pub(super) fn surface(&self, albedo: Vec3, normal: DVec3, lit: f32, open: f32) -> Vec3 {
        let facing = normal.dot(self.sun).max(0.0) as f32;
        // Half of what a wall sees is ground, which is bright and warm where the sun is out.
        let upward = normal.z as f32 * 0.5 + 0.5;
        let bounced = Vec3::new(0.25, 0.225, 0.195);
        let sky = self.zenith.lerp(self.horizon, 0.45) * 0.70;
        let ambient = bounced.lerp(sky, upward) * open;
        albedo * (self.sunlight * (facing * lit) + ambient)
    }

    /// A colour seen through the air.
    pub(super) fn through_haze(&self, colour: Vec3, distance: f64, direction: DVec3) -> Vec3 {
        let left = self.transmittance(distance);
        let air = self.sky(direction.with_z(0.0));
        air.lerp(colour, left)
    }

    /// What the air leaves of a contrast, 0 to 1. Near things are clear: haze lies low and far.
    pub(super) fn transmittance(&self, distance: f64) -> f32 {
        let depth = (distance - self.haze[0]).max(0.0) / self.haze[1];
        (-depth.powf(1.35)).exp() as f32
    }

    /// The sky in a direction of unit length.
    pub(super) fn sky(&self, direction: DVec3) -> Vec3 {
        let height = direction.z.max(0.0) as f32;
        let gradient = 1.0 - (1.0 - height).powi(4);
        let warmth = direction.dot(self.sun).max(0.0).powi(6) as f32;
        let glow = Vec3::new(1.0, 0.86, 0.62) * (0.18 * warmth);
        self.horizon.lerp(self.zenith, gradient.min(1.0)) + glow
    }
}

/// Storeys and bays of a wall, for scale: a faint pattern of windows, about 3.2 m high and wide,
/// which fits the wall and becomes its own mean where it is finer than a pixel of `footprint`
/// metres. `along` and `up` run from 0 to the wall's `width` and `height`.
pub(super) fn storeys(
    wall: Vec3,
    [along, up]: [f64; 2],
    [width, height]: [f64; 2],
    footprint: f64,
) -> Vec3 {
    const STOREY_M: f64 = 3.2;
    const WINDOW: [(f64, f64); 2] = [(0.28, 0.72), (0.26, 0.80)];
    const STRENGTH: f32 = 0.34;
    let place = |at: f64, whole: f64| {
        let cells = (whole / STOREY_M).round().max(1.0);
        (at / whole * cells).rem_euclid(1.0)
    };
    let within = |at: f64, (low, high): (f64, f64)| (low..high).contains(&at);
    let glazed = within(place(along, width), WINDOW[0]) && within(place(up, height), WINDOW[1]);
    let mean = (WINDOW[0].1 - WINDOW[0].0) * (WINDOW[1].1 - WINDOW[1].0);
    let blurred = ((footprint / STOREY_M - 0.08) / 0.25).clamp(0.0, 1.0);
    let share = f64::from(u8::from(glazed)) * (1.0 - blurred) + mean * blurred;
    let glass = srgb(0x5c_6b7a);
    wall.lerp(glass, share as f32 * STRENGTH)
}

/// Bare ground with a faint grid of 100 m, which vanishes where its lines are finer than a pixel
/// of `footprint` metres.
pub(super) fn ground(point: DVec3, footprint: f64) -> Vec3 {
    gridded(srgb(0xbf_baab), srgb(0xcf_cbbe), point, footprint)
}

/// Open country with the same grid: grass where it is level, bare rock where it is steep.
pub(super) fn hillside(point: DVec3, normal: DVec3, footprint: f64) -> Vec3 {
    let steepness = 1.0 - normal.z;
    let bare = ((steepness - 0.02) / 0.16).clamp(0.0, 1.0) as f32;
    let earth = srgb(0xa7_a893).lerp(srgb(0x98_8b7a), bare);
    gridded(earth, earth * 1.14, point, footprint)
}

fn gridded(earth: Vec3, line: Vec3, point: DVec3, footprint: f64) -> Vec3 {
    const GRID_M: f64 = 100.0;
    const LINE_M: f64 = 0.8;
    let on_line = |coordinate: f64| {
        let from_line = (coordinate / GRID_M - (coordinate / GRID_M).round()).abs() * GRID_M;
        let half = LINE_M * 0.5 + footprint * 0.5;
        let thin = LINE_M / (LINE_M + footprint);
        if from_line < half { thin } else { 0.0 }
    };
    let share = on_line(point.x).max(on_line(point.y)) as f32;
    earth.lerp(line, share)
}
