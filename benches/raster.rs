//! Drawing 20,000 boxes of a city into a 1280 × 720 id-buffer.
#![allow(missing_docs, reason = "benches are not an interface")]
#![allow(
    clippy::unwrap_used,
    reason = "a bench that cannot be set up cannot go on"
)]

use citylod::geom::{Aabb, DVec3, DepthRange, Orientation, Projection, View};
use citylod::raster::{IdBuffer, Projector};
use citylod::scene::{CityParams, generate};
use criterion::{Criterion, criterion_group, criterion_main};

const SIZE: [u32; 2] = [1280, 720];

fn view(eye: DVec3, target: DVec3) -> View {
    let orientation = Orientation::LookAt {
        target,
        up: DVec3::Z,
    };
    let depth = DepthRange::default();
    let projection = Projection::Perspective { fov_y_deg: 60.0 };
    View::new(eye, orientation, projection, depth, SIZE).unwrap()
}

fn draw(c: &mut Criterion) {
    let mut group = c.benchmark_group("draw 20,000 boxes");
    group.sample_size(20);
    let scene = generate(&CityParams {
        objects: 200_000,
        seed: 1,
    });
    let all: Vec<Aabb> = scene.objects.iter().map(|object| object.bounds).collect();
    for (name, eye, target) in [
        (
            "street",
            DVec3::new(205.0, 35.0, 2.5),
            DVec3::new(305.0, 75.0, 22.0),
        ),
        (
            "roofs",
            DVec3::new(-500.0, 0.0, 60.0),
            DVec3::new(300.0, 100.0, 40.0),
        ),
        (
            "from above",
            DVec3::new(-1500.0, -2000.0, 1800.0),
            DVec3::ZERO,
        ),
    ] {
        let view = view(eye, target);
        let mut boxes = all.clone();
        boxes.retain(|b| !view.frustum().is_outside(b));
        boxes.sort_by(|a, b| a.distance(eye).total_cmp(&b.distance(eye)));
        boxes.truncate(20_000);
        assert_eq!(boxes.len(), 20_000);
        let projector = Projector::new(&view, SIZE);
        let mut buffer = IdBuffer::new(SIZE[0], SIZE[1]);
        for (order, reversed) in [("near first", false), ("far first", true)] {
            if reversed {
                boxes.reverse();
            }
            group.bench_function(format!("{name}, {order}"), |b| {
                b.iter(|| {
                    buffer.clear();
                    for (id, b) in (0..).zip(&boxes) {
                        buffer.draw_box(&projector, b, id);
                    }
                });
            });
        }
    }
}

criterion_group!(benches, draw);
criterion_main!(benches);
