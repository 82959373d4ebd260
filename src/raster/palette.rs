//! Colours of things, linear light.

use glam::Vec3;

/// A colour in linear light from its sRGB hex number.
pub(super) fn srgb(hex: u32) -> Vec3 {
    let channel = |shift: u32| {
        let c = (hex >> shift & 0xff) as f32 / 255.0;
        if c <= 0.040_45 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    };
    Vec3::new(channel(16), channel(8), channel(0))
}

/// The 8-bit sRGB value of linear light.
pub(super) fn encode(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|c| {
        let c = toned(c.max(0.0));
        let encoded = if c <= 0.003_130_8 {
            c * 12.92
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        };
        (encoded * 255.0).round() as u8
    })
}

/// Bends light beyond 0.7 towards 1, which it never reaches, so that lit walls keep their hue.
fn toned(light: f32) -> f32 {
    const KNEE: f32 = 0.7;
    if light <= KNEE {
        light
    } else {
        1.0 - (1.0 - KNEE) * (-(light - KNEE) / (1.0 - KNEE)).exp()
    }
}

/// Walls and roofs of buildings: limewash, sandstone, plaster, concrete, a little brick.
const BUILDINGS: [u32; 8] = [
    0xe9_e2d5, 0xdf_d5c4, 0xd8_d3c9, 0xe4_dccb, 0xcf_c8ba, 0xdd_cdb6, 0xc9_c5be, 0xd6_b9a0,
];
const TREES: [u32; 4] = [0x74_9257, 0x66_864e, 0x80_9a5c, 0x5d_7d4c];

/// The colour of a kind of thing by its `CityJSON` type; kinds that come in many colours take one
/// by `variant`, any number.
pub(super) fn class_colour(class: &str, variant: u32) -> Vec3 {
    let class = class.trim_start_matches('+');
    let pick =
        |colours: &[u32]| colours[variant.wrapping_mul(0x9e37_79b9) as usize % colours.len()];
    let hex = if class.starts_with("Building") {
        pick(&BUILDINGS)
    } else if class.starts_with("Bridge") || class.starts_with("Tunnel") {
        0xb4_ada4
    } else {
        match class {
            "SolitaryVegetationObject" => pick(&TREES),
            "PlantCover" => 0x8f_a56c,
            "LandUse" => 0xbd_bf9c,
            "WaterBody" | "Waterway" => 0x6f_9bb5,
            "Road" | "TransportSquare" => 0x8e_8e90,
            "Railway" => 0x84_7c76,
            "TINRelief" => 0xb3_a98c,
            "CityFurniture" => 0x70_7a80,
            "OtherConstruction" => 0xc2_b5a3,
            _ => pick(&BUILDINGS),
        }
    };
    srgb(hex)
}

/// Colours of levels of detail, 0 the finest, with their sRGB hex numbers: tellable apart with
/// colour blindness (after Okabe and Ito, 2008). Coarser levels share the last. Light and shadow
/// change them in a picture.
pub const LEVEL_COLOURS: [(&str, u32); 7] = [
    ("ivory", 0xe6_e2d8),
    ("blue", 0x8c_c5e3),
    ("green", 0x45_a88a),
    ("yellow", 0xf0_c75e),
    ("orange", 0xe0_8a3c),
    ("red", 0xc8_5250),
    ("purple", 0x7a_4f8f),
];

/// The colour of a level of detail.
pub(super) fn level_colour(level: u32) -> Vec3 {
    let (_, hex) = LEVEL_COLOURS[(level as usize).min(LEVEL_COLOURS.len() - 1)];
    srgb(hex)
}
