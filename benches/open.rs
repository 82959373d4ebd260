//! Mapping a file, unread and with every byte checked.
#![allow(missing_docs, reason = "benches are not an interface")]
#![allow(
    clippy::unwrap_used,
    reason = "a bench that cannot be set up cannot go on"
)]

use std::time::Duration;

use citylod::index::{self, LodTree, Promotion};
use citylod::scene::{CityParams, generate};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};

fn open(c: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let mut group = c.benchmark_group("open");
    group.sample_size(20);
    group.measurement_time(Duration::from_secs(2));
    for objects in [100_000, 1_000_000] {
        let scene = generate(&CityParams { objects, seed: 1 });
        let tree = index::build(&scene, Promotion::Tallest).unwrap();
        let path = folder.path().join(format!("{objects}.citylod"));
        tree.save(&path).unwrap();
        group.bench_function(BenchmarkId::new("unread", objects), |b| {
            b.iter(|| LodTree::open(&path).unwrap());
        });
        group.bench_function(BenchmarkId::new("verified", objects), |b| {
            b.iter(|| LodTree::open_verified(&path).unwrap());
        });
    }
}

criterion_group!(benches, open);
criterion_main!(benches);
