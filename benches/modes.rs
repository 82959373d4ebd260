//! Error mode and budget mode beside a scan that projects every object.
#![allow(missing_docs, reason = "benches are not an interface")]
#![allow(
    clippy::unwrap_used,
    reason = "a bench that cannot be set up cannot go on"
)]

#[allow(dead_code, reason = "other benches take other trees from it")]
mod city;

use std::time::Duration;

use citylod::geom::{Aabb, Eight, Filter, SizeThreshold, View};
use citylod::index::{self, LodTree, Promotion};
use citylod::lod::{BudgetLod, ErrorLod, Lod, Selection, select};
use citylod::scene::{CityParams, generate};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use wide::f32x8;

/// What a scan reads: boxes eight to a block and the radius of each, in the order of the objects.
struct Table {
    boxes: Vec<Eight>,
    radii: Vec<f32x8>,
}

impl Table {
    fn of(tree: &LodTree) -> Self {
        let blocks = tree.object_count().div_ceil(8) as usize;
        // Boxes that are nowhere fill the last block.
        let mut boxes = vec![[f32x8::splat(f32::INFINITY); 6]; blocks];
        let mut radii = vec![f32x8::ZERO; blocks];
        for object in 0..tree.object_count() {
            let (block, lane) = (object as usize / 8, object as usize % 8);
            let corners = tree.relative_box(object).unwrap();
            for (row, corner) in boxes[block].iter_mut().zip(corners) {
                row.as_mut_array()[lane] = corner;
            }
            let radius = tree.bounds_of(object).unwrap().radius() as f32;
            radii[block].as_mut_array()[lane] = radius.next_up();
        }
        Self { boxes, radii }
    }

    /// Every object that is large enough and in the frustum: size first, eight at a time, then
    /// the planes, and in f64 what f32 leaves open.
    fn scan(&self, tree: &LodTree, view: &View, max_error_px: f64, found: &mut Vec<u32>) {
        found.clear();
        let filter = Filter::new(view.frustum(), tree.origin(), &tree.bounds());
        let threshold = SizeThreshold::new(&filter, view.pixels(), max_error_px);
        let planes = filter.all_planes();
        for ((block, boxes), &radii) in (0..).zip(&self.boxes).zip(&self.radii) {
            let distances = filter.distances(boxes);
            let missed = threshold.missed(radii, &distances);
            if missed == 0xff {
                continue;
            }
            let (outside, touching) = filter.outside_or_touching(boxes, planes);
            let mut rest = !(missed | outside) & 0xff;
            if rest == 0 {
                continue;
            }
            let sure = touching & threshold.reached(radii, &distances);
            while rest != 0 {
                let lane = rest.trailing_zeros();
                let object = block * 8 + lane;
                if sure >> lane & 1 == 1 || is_wanted(tree, view, max_error_px, object) {
                    found.push(object);
                }
                rest &= rest - 1;
            }
        }
    }
}

fn is_wanted(tree: &LodTree, view: &View, max_error_px: f64, object: u32) -> bool {
    let bounds = tree.bounds_of(object).unwrap_or(Aabb::EMPTY);
    view.size_px(&bounds) >= max_error_px && !view.frustum().is_outside(&bounds)
}

/// The size that as many objects of the view have or exceed.
fn size_of_rank(tree: &LodTree, view: &View, rank: usize) -> f64 {
    let objects = (0..tree.object_count()).filter_map(|o| tree.bounds_of(o));
    let mut sizes: Vec<f64> = objects
        .filter(|bounds| !view.frustum().is_outside(bounds))
        .map(|bounds| view.size_px(&bounds))
        .collect();
    let (_, size, _) = sizes.select_nth_unstable_by(rank - 1, |a, b| b.total_cmp(a));
    *size
}

fn compare(c: &mut Criterion) {
    let mut group = c.benchmark_group("modes");
    group.sample_size(20);
    group.measurement_time(Duration::from_secs(1));
    group.warm_up_time(Duration::from_millis(300));
    let view = city::view();
    for objects in [1_000_000, 10_000_000] {
        let scene = generate(&CityParams { objects, seed: 1 });
        let tree = index::build(&scene, Promotion::Largest).unwrap();
        drop(scene);
        let table = Table::of(&tree);
        let mut selection = Selection::default();
        let mut found = Vec::new();
        for count in [1_000, 5_000, 20_000] {
            let size = size_of_rank(&tree, &view, count);
            let error = Lod::Error(ErrorLod::new(size).unwrap());
            select(&tree, &view, &error, &mut selection);
            table.scan(&tree, &view, size, &mut found);
            assert!(selection.objects().eq(found.iter().copied()));
            let budget = Lod::Budget(BudgetLod::new(selection.count()));
            select(&tree, &view, &budget, &mut selection);
            assert!(selection.objects().eq(found.iter().copied()));
            let id = |name: &str| BenchmarkId::new(format!("{name} {count}"), objects);
            group.bench_function(id("scan"), |b| {
                b.iter(|| table.scan(&tree, &view, size, &mut found));
            });
            group.bench_function(id("error"), |b| {
                b.iter(|| select(&tree, &view, &error, &mut selection));
            });
            group.bench_function(id("budget"), |b| {
                b.iter(|| select(&tree, &view, &budget, &mut selection));
            });
        }
    }
}

criterion_group!(benches, compare);
criterion_main!(benches);
