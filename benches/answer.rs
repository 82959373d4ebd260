//! From a view to the list of ids as JSON: copied as the tree keeps them, and written anew.
#![allow(missing_docs, reason = "benches are not an interface")]
#![allow(
    clippy::unwrap_used,
    reason = "a bench that cannot be set up cannot go on"
)]

mod city;

use std::time::Duration;

use citylod::index::LodTree;
use citylod::lod::{Selection, retrieve};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};

fn copied(tree: &LodTree, selection: &Selection) -> Vec<u8> {
    let mut json = vec![b'['];
    for range in selection.ranges() {
        json.extend_from_slice(tree.ids_json(range.clone()));
    }
    json.pop_if(|last| *last == b',');
    json.push(b']');
    json
}

fn written(tree: &LodTree, selection: &Selection) -> Vec<u8> {
    let ids = selection.objects().filter_map(|object| tree.id(object));
    let ids: Vec<String> = ids.map(Into::into).collect();
    serde_json::to_vec(&ids).unwrap()
}

fn answer(c: &mut Criterion) {
    let mut group = c.benchmark_group("answer");
    group.sample_size(20);
    group.measurement_time(Duration::from_secs(1));
    group.warm_up_time(Duration::from_millis(500));
    let (view, lod) = (city::view(), city::lod(2000.0));
    for objects in city::SIZES {
        let tree = city::tree(objects);
        let mut selection = Selection::default();
        retrieve(&tree, &view, &lod, &mut selection);
        assert_eq!(copied(&tree, &selection), written(&tree, &selection));
        for (name, body) in [
            ("copied", copied as fn(&LodTree, &Selection) -> Vec<u8>),
            ("serde_json", written),
        ] {
            group.bench_function(BenchmarkId::new(name, objects), |b| {
                b.iter(|| {
                    retrieve(&tree, &view, &lod, &mut selection);
                    body(&tree, &selection)
                });
            });
        }
    }
}

criterion_group!(benches, answer);
criterion_main!(benches);
