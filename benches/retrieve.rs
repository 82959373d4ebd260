//! What a view calls for, beside testing every box and beside rstar's selection.
#![allow(missing_docs, reason = "benches are not an interface")]
#![allow(
    clippy::unwrap_used,
    reason = "a bench that cannot be set up cannot go on"
)]

mod city;

use std::time::Duration;

use citylod::geom::View;
use citylod::lod::{RangeLod, Selection, retrieve};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree, RTreeObject, SelectionFunction};

type Boxed = GeomWithData<Rectangle<[f64; 3]>, u32>;

struct InFrustum<'a>(&'a View);

/// The plainest test there is: no slack, out at the first plane.
fn is_outside(view: &View, min: [f64; 3], max: [f64; 3]) -> bool {
    let eye = view.eye().to_array();
    view.frustum().planes().iter().any(|plane| {
        let normal = plane.normal.to_array();
        let farthest = (0..3).map(|axis| {
            let corner = if normal[axis] >= 0.0 { max } else { min };
            normal[axis] * (corner[axis] - eye[axis])
        });
        farthest.sum::<f64>() + plane.offset < 0.0
    })
}

impl SelectionFunction<Boxed> for InFrustum<'_> {
    fn should_unpack_parent(&self, envelope: &AABB<[f64; 3]>) -> bool {
        !is_outside(self.0, envelope.lower(), envelope.upper())
    }

    fn should_unpack_leaf(&self, leaf: &Boxed) -> bool {
        let envelope = leaf.envelope();
        !is_outside(self.0, envelope.lower(), envelope.upper())
    }
}

fn compare(c: &mut Criterion) {
    let mut group = c.benchmark_group("retrieve");
    group.sample_size(20);
    group.measurement_time(Duration::from_secs(1));
    group.warm_up_time(Duration::from_millis(500));
    let view = city::view();
    for objects in city::SIZES {
        let tree = city::tree(objects);
        let mut selection = Selection::default();
        for (name, lod) in [
            ("far_dist 500", city::lod(500.0)),
            ("far_dist 2000", city::lod(2000.0)),
            ("full detail", RangeLod::full_detail()),
        ] {
            group.bench_function(BenchmarkId::new(name, objects), |b| {
                b.iter(|| retrieve(&tree, &view, &lod, &mut selection));
            });
        }
        let exact = tree.arrays().object_boxes;
        group.bench_function(BenchmarkId::new("every box", objects), |b| {
            b.iter(|| {
                let boxes = (0_u32..).zip(exact);
                let seen = boxes.filter(|(_, [x0, y0, z0, x1, y1, z1])| {
                    !is_outside(&view, [*x0, *y0, *z0], [*x1, *y1, *z1])
                });
                seen.map(|(object, _)| object).collect::<Vec<_>>()
            });
        });
        let boxes = (0..).zip(exact).map(|(number, &[x0, y0, z0, x1, y1, z1])| {
            GeomWithData::new(Rectangle::from_corners([x0, y0, z0], [x1, y1, z1]), number)
        });
        let rstar = RTree::bulk_load(boxes.collect());
        group.bench_function(BenchmarkId::new("rstar", objects), |b| {
            b.iter(|| {
                let mut seen = Vec::new();
                for object in rstar.locate_with_selection_function(InFrustum(&view)) {
                    seen.push(object.data);
                }
                seen
            });
        });
    }
}

criterion_group!(benches, compare);
criterion_main!(benches);
