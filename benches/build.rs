//! From objects in memory to a tree, beside rstar's bulk loading of the same boxes.
#![allow(missing_docs, reason = "benches are not an interface")]
#![allow(
    clippy::unwrap_used,
    reason = "a bench that cannot be set up cannot go on"
)]

use std::time::Duration;

use citylod::index::{self, Promotion};
use citylod::scene::{CityParams, Scene, generate};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use rstar::RTree;
use rstar::primitives::{GeomWithData, Rectangle};

fn boxes(scene: &Scene) -> Vec<GeomWithData<Rectangle<[f64; 3]>, u32>> {
    let objects = (0..).zip(&scene.objects);
    objects
        .map(|(number, object)| {
            let (min, max) = (object.bounds.min(), object.bounds.max());
            let rectangle = Rectangle::from_corners(min.to_array(), max.to_array());
            GeomWithData::new(rectangle, number)
        })
        .collect()
}

fn build(c: &mut Criterion) {
    let mut group = c.benchmark_group("build");
    group.sample_size(10);
    group.measurement_time(Duration::from_secs(3));
    for objects in [100_000, 1_000_000] {
        let scene = generate(&CityParams { objects, seed: 1 });
        group.bench_function(BenchmarkId::new("citylod", objects), |b| {
            b.iter(|| index::build(&scene, Promotion::Tallest).unwrap());
        });
        group.bench_function(BenchmarkId::new("rstar", objects), |b| {
            b.iter(|| RTree::bulk_load(boxes(&scene)));
        });
    }
}

criterion_group!(benches, build);
criterion_main!(benches);
