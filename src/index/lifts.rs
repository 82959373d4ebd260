//! How far above their ground objects begin, of the few that do: a roof, a bridge between houses.

use super::file::Section;
use super::hierarchy::Canonical;
use super::image::Image;

/// Objects by their place in the file, ascending, and how far each begins above its ground, m, of
/// `lifts` in canonical order. `order` is that of the file.
pub(super) fn placed(lifts: &[(Canonical, f64)], order: &[Canonical]) -> (Vec<u32>, Vec<f64>) {
    if lifts.is_empty() {
        return (Vec::new(), Vec::new());
    }
    let lift_of = |object: &Canonical| {
        let at = lifts.binary_search_by_key(object, |(lifted, _)| *lifted);
        at.ok().map(|at| lifts[at].1)
    };
    let places = (0..).zip(order);
    let lifted = places.filter_map(|(place, object)| Some((place, lift_of(object)?)));
    lifted.unzip()
}

/// How far above its ground an object begins, m.
pub(super) fn lift_m(image: &Image, object: u32) -> f64 {
    let at = lifted(image).binary_search(&object).ok();
    // Without one only in a damaged file.
    let lift_m = at.and_then(|at| lifts(image).get(at)).copied();
    lift_m.filter(|lift_m| lift_m.is_finite()).unwrap_or(0.0)
}

/// Whether they are lengths of objects, in order.
pub(super) fn are_sound(image: &Image) -> bool {
    are_lengths(lifted(image), lifts(image), image.header().objects)
}

fn are_lengths(lifted: &[u32], lifts: &[f64], objects: u32) -> bool {
    lifted.len() == lifts.len()
        && lifted.is_sorted_by(|a, b| a < b)
        && lifted.last().is_none_or(|&last| last < objects)
        && lifts
            .iter()
            .all(|lift_m| *lift_m > 0.0 && lift_m.is_finite())
}

fn lifted(image: &Image) -> &[u32] {
    image.slice(Section::Lifted)
}

fn lifts(image: &Image) -> &[f64] {
    image.slice(Section::Lifts)
}

#[cfg(test)]
mod tests {
    use super::{are_lengths, placed};

    #[test]
    fn lifts_go_where_their_objects_do() {
        let order = [4, 2, 0, 3, 1];
        let found = placed(&[(1, 2.5), (2, 4.0)], &order);
        assert_eq!(found, (vec![1, 4], vec![4.0, 2.5]));
    }

    #[test]
    fn lifts_are_looked_at_with_suspicion() {
        assert!(are_lengths(&[1, 7], &[4.0, 2.5], 8));
        assert!(are_lengths(&[], &[], 0));
        for (lifted, lifts, objects) in [
            (vec![1, 7], vec![4.0, 2.5], 7),
            (vec![7, 1], vec![4.0, 2.5], 8),
            (vec![1, 1], vec![4.0, 2.5], 8),
            (vec![1], vec![4.0, 2.5], 8),
            (vec![1], vec![f64::INFINITY], 8),
            (vec![1], vec![-5.0], 8),
            (vec![1], vec![0.0], 8),
        ] {
            assert!(
                !are_lengths(&lifted, &lifts, objects),
                "{lifted:?} {lifts:?}"
            );
        }
    }
}
