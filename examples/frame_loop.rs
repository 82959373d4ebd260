//! A renderer's loop: each frame asks what to draw, and how far follows from how long frames take.
//!
//! ```text
//! cargo run --release --example frame_loop
//! ```

use std::time::{Duration, Instant};

use citylod::control::{Params, Sample, State};
use citylod::frame::{Active, Feedback, Frame};
use citylod::geom::{DVec3, DepthRange, Orientation, Projection, View};
use citylod::index::{self, Promotion};
use citylod::lod::{Lod, RangeLod};
use citylod::scene::{CityParams, generate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let city = generate(&CityParams {
        objects: 50_000,
        seed: 1,
    });
    let tree = index::build(&city, Promotion::Tallest)?;
    let knobs = RangeLod::default();
    let params = Params::new(16.7, 50.0, 5_000.0)?; // ms to hold; range of far_dist, m
    let (mut state, mut sample) = (State::starting_at(knobs.far_dist()), None);
    let mut frame = Frame::default(); // kept: allocates nothing in the long run
    for number in 0..240 {
        let start = Instant::now();
        let eye = DVec3::new(-1_500.0 + 12.0 * f64::from(number), -600.0, 120.0);
        let orientation = Orientation::LookAt {
            target: DVec3::ZERO,
            up: DVec3::Z,
        };
        let projection = Projection::Perspective { fov_y_deg: 60.0 };
        let depth = DepthRange::default();
        let view = View::new(eye, orientation, projection, depth, [1920, 1080])?;

        let lod;
        (lod, state) = Feedback {
            params,
            state,
            sample,
        }
        .steer(knobs);
        frame.work_out(&tree, &view, &Lod::Range(lod), &Active::default(), || {
            Duration::ZERO
        });
        draw(frame.selection().count());

        let frame_ms = start.elapsed().as_secs_f64() * 1000.0;
        sample = Some(Sample {
            frame_ms,
            far_dist_m: lod.far_dist(),
        });
        if number % 20 == 0 {
            eprintln!(
                "{frame_ms:5.1} ms, far_dist {:6.0} m, {} objects",
                lod.far_dist(),
                frame.selection().count()
            );
        }
    }
    Ok(())
}

/// Stands for the renderer: 4 ms, and 10 µs an object.
fn draw(objects: u32) {
    std::thread::sleep(Duration::from_micros(4_000 + 10 * u64::from(objects)));
}
