use citylod::terrain::{
    Block, BlockError, Criterion, Detail, Ground, HeightField, Layout, Node, NodeRecord, QUARTERS,
    State, Workers, child_number, refine,
};
use rayon::prelude::*;

use super::places::{from_above, made_up, rng};

fn grounds() -> impl ParallelIterator<Item = (HeightField, Ground)> {
    (0..60_u64).into_par_iter().map(|seed| {
        let field = made_up(&mut rng(seed + 20_000));
        let layout = Layout::with_levels(*field.grid(), (seed % 7) as u32 + 1);
        let ground = Ground::cut(&field, &layout);
        (field, ground)
    })
}

fn nodes(layout: &Layout) -> impl Iterator<Item = Node> + use<> {
    let ([across, up], levels) = (layout.blocks(), layout.levels());
    (0..levels).flat_map(move |level| {
        (0..up << level).flat_map(move |y| (0..across << level).map(move |x| Node { level, x, y }))
    })
}

/// A, equation (1).
#[test]
fn numbers_of_children_follow_the_equation() {
    for level in 0..6 {
        for number in 0..1_u32 << (2 * level) {
            let node = Node {
                level,
                x: number % (1 << level),
                y: number >> level,
            };
            assert_eq!(node.number(), number);
            for (quarter, place) in QUARTERS.into_iter().enumerate() {
                let child = node.child(quarter);
                assert_eq!(child.number(), child_number(number, level, place));
                assert_eq!((child.parent(), child.quarter()), (Some(node), quarter));
            }
        }
    }
}

#[test]
fn no_number_of_a_record_grows_from_parent_to_child() {
    grounds().for_each(|(_, ground)| {
        for node in nodes(ground.layout()) {
            let record = ground.record(node);
            for quarter in 0..4 {
                let child = ground.record(node.child(quarter));
                assert!(child.low >= record.low && child.high <= record.high);
                assert!(child.error <= record.error && child.holes <= record.holes);
                assert!(child.vertex_error <= record.vertex_error);
                assert!(
                    record
                        .skipped
                        .iter()
                        .all(|skipped| *skipped <= record.error)
                );
                assert!(record.whole <= record.error && record.error <= record.margin);
                assert!(child.margin <= record.margin);
                assert!(child.deviation <= record.deviation);
            }
        }
    });
}

/// Range, holes and deviation of a node against its cells.
#[test]
fn records_are_what_the_posts_say() {
    grounds().for_each(|(field, ground)| {
        let known = |x, y| Some(field.height(x, y)).filter(|z| !z.is_nan());
        for node in nodes(ground.layout()) {
            let (record, posts) = (ground.record(node), ground.layout().posts(node));
            let (mut holes, mut heights) = (0, Vec::new());
            for y in posts.first[1]..posts.last[1] {
                for x in posts.first[0]..posts.last[0] {
                    let cell = [
                        known(x, y),
                        known(x + 1, y),
                        known(x, y + 1),
                        known(x + 1, y + 1),
                    ];
                    match cell {
                        [Some(a), Some(b), Some(c), Some(d)] => heights.extend([a, b, c, d]),
                        _ => holes += 1,
                    }
                }
            }
            assert_eq!(record.holes, holes);
            assert_eq!(record.has_ground(), !heights.is_empty());
            if heights.is_empty() {
                continue;
            }
            assert_eq!(
                record.low,
                heights.iter().copied().fold(f32::INFINITY, f32::min)
            );
            assert_eq!(
                record.high,
                heights.iter().copied().fold(f32::NEG_INFINITY, f32::max)
            );
            let count = heights.len() as f64;
            let mean = heights.iter().map(|z| f64::from(*z)).sum::<f64>() / count;
            let variance = heights
                .iter()
                .map(|z| (f64::from(*z) - mean).powi(2))
                .sum::<f64>()
                / count;
            let slack = 1e-6 * f64::from(record.high - record.low);
            assert!(f64::from(record.deviation) >= variance.sqrt() - slack);
            // No more than half the range, for any heights whatever.
            assert!(
                f64::from(record.deviation) <= f64::from(record.high - record.low) / 2.0 + slack
            );
        }
    });
}

#[test]
fn a_block_comes_back_from_its_arrays() {
    grounds().for_each(|(_, ground)| {
        for number in 0..ground.layout().block_count() {
            let block = ground.block(number).unwrap();
            let (records, heights) = (block.records().to_vec(), block.heights().to_vec());
            let again = Block::from_arrays(block.levels(), records, heights).unwrap();
            assert_eq!(again.records(), block.records());
        }
    });
}

#[test]
fn arrays_that_are_no_block_are_refused() {
    let arrays = || (vec![NodeRecord::NOTHING; 5], vec![0.0; 25]);
    let refused = |records, heights| Block::from_arrays(2, records, heights).unwrap_err();
    let (records, mut heights) = arrays();
    heights.pop();
    assert!(matches!(
        refused(records, heights),
        BlockError::Length {
            what: "heights",
            ..
        }
    ));
    for spoil in [
        |r: &mut NodeRecord| r.error = f32::NAN,
        |r: &mut NodeRecord| r.margin = -0.5,
        |r: &mut NodeRecord| r.deviation = -1.0,
        |r: &mut NodeRecord| r.low = f32::NAN,
        |r: &mut NodeRecord| r.high = f32::INFINITY,
    ] {
        let (mut records, heights) = arrays();
        spoil(&mut records[3]);
        assert!(matches!(
            refused(records, heights),
            BlockError::Number { index: 3, .. }
        ));
    }
    let (records, mut heights) = arrays();
    heights[7] = f32::NEG_INFINITY;
    assert!(matches!(
        refused(records, heights),
        BlockError::Number { index: 7, .. }
    ));
}

/// Nodes that nobody should ask for are answered as no ground.
#[test]
fn nodes_beyond_the_ground_are_nothing() {
    let field = made_up(&mut rng(1));
    let ground = Ground::cut(&field, &Layout::with_levels(*field.grid(), 3));
    let view = from_above(&field, 2.0);
    let detail = Detail::of(Criterion::Error);
    let cut = refine(&ground, &view, &detail, Workers::One).unwrap();
    for (level, x) in [
        (0, 1000),
        (3, 0),
        (4, 0),
        (31, 7),
        (32, 7),
        (u32::MAX, u32::MAX),
    ] {
        let node = Node { level, x, y: 0 };
        let posts = ground.layout().posts(node);
        assert!(posts.last[0] < field.grid().columns());
        assert_eq!(cut.state(node), State::Unreached);
        if level != 3 {
            assert_eq!(ground.record(node), NodeRecord::NOTHING);
            assert!(ground.height(node, [0, 0]).is_nan());
        }
        assert!(ground.layout().side_m(level) > 0.0);
    }
    assert_eq!(cut.splits(3).count() + cut.splits(u32::MAX).count(), 0);
}
