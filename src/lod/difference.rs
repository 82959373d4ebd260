//! What one answer has that another has not.

use std::ops::Range;

/// Writes the objects of `these` that are not among `those` into `out`, in place of what it held.
///
/// Both lists, and the outcome, are as [`super::Selection::ranges`]: not empty, ascending,
/// disjoint, never adjacent. Takes time in proportion to the number of ranges.
pub fn difference(these: &[Range<u32>], those: &[Range<u32>], out: &mut Vec<Range<u32>>) {
    out.clear();
    let mut others = those.iter().peekable();
    for range in these {
        let mut from = range.start;
        while let Some(other) = others.peek() {
            if other.start >= range.end {
                break;
            }
            if other.start > from {
                out.push(from..other.start);
            }
            from = from.max(other.end);
            if other.end > range.end {
                break; // it goes on into the next range
            }
            others.next();
        }
        if from < range.end {
            out.push(from..range.end);
        }
    }
}
