use std::collections::BTreeSet;
use std::ops::Range;

use citylod::lod::difference;
use proptest::prelude::*;

/// The ranges of a set: ascending, disjoint, never adjacent.
fn ranges(set: &BTreeSet<u32>) -> Vec<Range<u32>> {
    let mut ranges: Vec<Range<u32>> = Vec::new();
    for &object in set {
        match ranges.last_mut() {
            Some(last) if last.end == object => last.end += 1,
            _ => ranges.push(object..object + 1),
        }
    }
    ranges
}

/// Runs and single numbers, so that ranges touch, overlap and hold one another.
fn objects() -> impl Strategy<Value = BTreeSet<u32>> {
    let run = (0_u32..60, 1_u32..12).prop_map(|(start, length)| start..start + length);
    prop::collection::vec(run, 0..9).prop_map(|runs| runs.into_iter().flatten().collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    #[test]
    fn a_difference_of_ranges_is_the_difference_of_their_sets(
        these in objects(), those in objects(), before in objects(),
    ) {
        let mut out = ranges(&before);
        difference(&ranges(&these), &ranges(&those), &mut out);
        let expected: BTreeSet<u32> = these.difference(&those).copied().collect();
        prop_assert_eq!(out, ranges(&expected));
    }

    #[test]
    fn what_came_and_what_went_turn_one_answer_into_the_next(
        old in objects(), new in objects(),
    ) {
        let (mut add, mut remove) = (Vec::new(), Vec::new());
        difference(&ranges(&new), &ranges(&old), &mut add);
        difference(&ranges(&old), &ranges(&new), &mut remove);
        let mut held = old;
        for object in remove.into_iter().flatten() {
            prop_assert!(held.remove(&object), "{} was never there", object);
        }
        for object in add.into_iter().flatten() {
            prop_assert!(held.insert(object), "{} was there already", object);
        }
        prop_assert_eq!(held, new);
    }
}

#[test]
fn the_ends_of_the_numbers_are_no_special_case() {
    let mut out = Vec::new();
    let last = u32::MAX;
    let whole = 0..last;
    difference(std::slice::from_ref(&whole), &[], &mut out);
    assert_eq!(out, std::slice::from_ref(&whole));
    difference(
        std::slice::from_ref(&whole),
        &[0..1, last - 1..last],
        &mut out,
    );
    assert_eq!((out.len(), out[0].clone()), (1, 1..last - 1));
    difference(&[], std::slice::from_ref(&whole), &mut out);
    assert!(out.is_empty());
}
