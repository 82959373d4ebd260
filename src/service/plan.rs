//! A city from above, as SVG: its coarse levels, coloured by height.

use std::fmt::Write as _;

use crate::geom::{Aabb, DVec3};
use crate::index::LodTree;

/// Objects drawn: a preview, not a map.
const MOST_OBJECTS: u32 = 5_000;
/// Boxes of nodes drawn beneath them, as the ground they stand on.
const MOST_DISTRICTS: u32 = 4_000;
/// Side of the picture, its own units.
const SIDE: f64 = 1000.0;
/// Below this an object would not be seen, same units.
const SMALLEST: f64 = 2.4;
/// Classes of height.
const SHADES: usize = 8;

/// Draws the city. Light and dark follow the reader's preference.
pub fn draw(tree: &LodTree) -> String {
    let bounds = tree.bounds();
    let mut svg = String::with_capacity(64 * 1024);
    let _ = write!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {SIDE} {SIDE}\" role=\"img\" \
         aria-label=\"top view\">{STYLE}"
    );
    if bounds.is_empty() {
        svg.push_str("<text class=\"label\" x=\"500\" y=\"500\" text-anchor=\"middle\">no objects</text></svg>");
        return svg;
    }
    let frame = Frame::around(&bounds);
    svg.push_str("<path class=\"ground\" d=\"");
    for district in districts(tree) {
        frame.rectangle(&mut svg, &district);
    }
    svg.push_str("\"/>");
    let mut drawn: Vec<Aabb> = sample(tree).filter_map(|o| tree.bounds_of(o)).collect();
    // Tall ones last, on top.
    drawn.sort_by(|a, b| a.size().z.total_cmp(&b.size().z));
    let shades = Shades::of(&drawn);
    let mut open = None;
    for object in &drawn {
        let shade = shades.of_height(object.size().z);
        if open != Some(shade) {
            let close = if open.is_some() { "\"/>" } else { "" };
            let _ = write!(svg, "{close}<path class=\"h{shade}\" d=\"");
            open = Some(shade);
        }
        frame.rectangle(&mut svg, object);
    }
    if open.is_some() {
        svg.push_str("\"/>");
    }
    frame.scale_bar(&mut svg);
    svg.push_str("</svg>");
    svg
}

const STYLE: &str = "<style>\
.h0{fill:#cfd8e3}.h1{fill:#b3c4d9}.h2{fill:#92aecd}.h3{fill:#6f95bf}\
.h4{fill:#4c7aae}.h5{fill:#2f5f99}.h6{fill:#1c447c}.h7{fill:#e4572e}\
.ground{fill:#eef1f5}\
.bar{stroke:#33415c;stroke-width:3;fill:none}\
.label{fill:#33415c;font:500 22px system-ui,sans-serif}\
@media (prefers-color-scheme:dark){\
.h0{fill:#27364c}.h1{fill:#2f4564}.h2{fill:#39587f}.h3{fill:#466f9f}\
.h4{fill:#5a8cc0}.h5{fill:#7cabd8}.h6{fill:#a9cdec}.h7{fill:#ff9a5c}\
.ground{fill:#182333}.bar{stroke:#c7d2e3}.label{fill:#c7d2e3}}</style>";

/// Boxes of the finest level of nodes that has not too many.
fn districts(tree: &LodTree) -> Vec<Aabb> {
    let arrays = tree.arrays();
    let levels = arrays.level_nodes.windows(2).rev();
    let nodes = levels
        .map(|level| level[0]..level[1])
        .find(|nodes| nodes.len() <= MOST_DISTRICTS as usize)
        .unwrap_or(0..0);
    let corners = arrays.node_boxes;
    nodes
        .filter_map(|node| corners.get(node as usize))
        .map(|c| Aabb::around([DVec3::new(c[0], c[1], c[2]), DVec3::new(c[3], c[4], c[5])]))
        .collect()
}

/// Objects from the top of the level order: whole levels while they fit, then every n-th of the
/// next, so that no district is left out.
fn sample(tree: &LodTree) -> impl Iterator<Item = u32> + use<> {
    let starts = tree.arrays().level_objects;
    let whole = starts
        .iter()
        .copied()
        .take_while(|&end| end <= MOST_OBJECTS)
        .last()
        .unwrap_or(0);
    let next = starts.iter().copied().find(|&end| end > whole);
    let left = (MOST_OBJECTS - whole).max(1);
    let end = next.unwrap_or(whole);
    let step = (end - whole).div_ceil(left).max(1);
    (0..whole).chain((whole..end).step_by(step as usize))
}

/// Classes of equal count, so that a single tower does not grey out the rest.
struct Shades {
    limits: [f64; SHADES - 1],
}

impl Shades {
    fn of(ascending: &[Aabb]) -> Self {
        Self {
            limits: std::array::from_fn(|class| {
                // The top class is for the tallest twentieth.
                let share = if class + 2 == SHADES {
                    0.95
                } else {
                    (class + 1) as f64 / SHADES as f64
                };
                let place = (ascending.len() as f64 * share) as usize;
                ascending.get(place).map_or(f64::INFINITY, |b| b.size().z)
            }),
        }
    }

    fn of_height(&self, height: f64) -> usize {
        self.limits.partition_point(|&limit| limit <= height)
    }
}

/// From scene coordinates to those of the picture.
struct Frame {
    scale: f64,
    left: f64,
    top: f64,
}

impl Frame {
    /// Fits the bounds in the middle, with room for the scale bar below.
    fn around(bounds: &Aabb) -> Self {
        let (size, center) = (bounds.size(), bounds.center());
        let scale = (SIDE - 100.0) / size.x.max(size.y).max(1.0);
        Self {
            scale,
            left: center.x - SIDE * 0.5 / scale,
            top: center.y + (SIDE * 0.5 - 20.0) / scale,
        }
    }

    fn rectangle(&self, svg: &mut String, object: &Aabb) {
        let (size, center) = (object.size(), object.center());
        let width = (size.x * self.scale).max(SMALLEST);
        let height = (size.y * self.scale).max(SMALLEST);
        let x = (center.x - self.left) * self.scale - width * 0.5;
        let y = (self.top - center.y) * self.scale - height * 0.5;
        let _ = write!(svg, "M{x:.1} {y:.1}h{width:.1}v{height:.1}h-{width:.1}z");
    }

    /// A round length between a tenth and a quarter of the side.
    fn scale_bar(&self, svg: &mut String) {
        let room = SIDE * 0.25 / self.scale;
        let unit = 10_f64.powf(room.log10().floor());
        let metres = [5.0, 2.0, 1.0]
            .into_iter()
            .map(|step| step * unit)
            .find(|&length| length <= room)
            .unwrap_or(unit);
        let width = metres * self.scale;
        let text = if metres >= 1000.0 {
            format!("{} km", metres / 1000.0)
        } else {
            format!("{metres} m")
        };
        let (x, y) = (SIDE - 40.0 - width, SIDE - 22.0);
        let middle = x - 14.0;
        let _ = write!(
            svg,
            "<path class=\"bar\" d=\"M{x:.1} {:.1}v10h{width:.1}v-10\"/>\
             <text class=\"label\" x=\"{middle:.1}\" y=\"{y}\" text-anchor=\"end\">{text}</text>",
            y - 10.0
        );
    }
}
