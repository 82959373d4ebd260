//! The city and the view that benches share.

use citylod::geom::{DVec3, DepthRange, Orientation, Projection, View};
use citylod::index::{self, LodTree, Promotion};
use citylod::lod::{Beyond, RangeLod};
use citylod::scene::{CityParams, generate};

pub const SIZES: [u32; 2] = [100_000, 1_000_000];

pub fn tree(objects: u32) -> LodTree {
    let scene = generate(&CityParams { objects, seed: 1 });
    index::build(&scene, Promotion::Tallest).unwrap()
}

/// A level view above the roofs, from the middle of the city.
pub fn view() -> View {
    let eye = DVec3::new(0.0, 0.0, 60.0);
    let orientation = Orientation::LookAt {
        target: eye + DVec3::new(3.0, 1.0, 0.0),
        up: DVec3::Z,
    };
    let depth = DepthRange::default();
    let projection = Projection::Perspective { fov_y_deg: 60.0 };
    View::new(eye, orientation, projection, depth, [1920, 1080]).unwrap()
}

pub fn lod(far_dist: f64) -> RangeLod {
    RangeLod::new(far_dist, 2.5, 8, Beyond::Show).unwrap()
}
