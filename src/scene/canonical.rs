//! One order and one name for everything, however the objects came.

use std::cmp::Ordering;

use compact_str::{CompactString, format_compact};

use super::{Scene, SceneObject};

/// An object whose id was taken, under its new one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Renamed {
    /// The id in the source.
    pub from: CompactString,
    /// The id it has now.
    pub to: CompactString,
}

impl Scene {
    /// Sorts the objects by id and gives every second bearer of an id a new one: `a` becomes
    /// `a~2`, `a~3` … in the order of their content.
    ///
    /// The result depends only on the objects, not on their order before.
    pub fn canonicalize(&mut self) -> Vec<Renamed> {
        if self.objects.is_sorted_by(|a, b| a.id < b.id) {
            return Vec::new();
        }
        self.objects.sort_by(by_id_and_content);
        let mut renamed = Vec::new();
        for start in 1..self.objects.len() {
            if self.objects[start].id == self.objects[start - 1].id {
                renamed.push(start);
            }
        }
        let renames = self.rename(&renamed);
        if !renames.is_empty() {
            self.objects.sort_by(by_id_and_content);
        }
        renames
    }

    /// Gives the objects at `places` (ascending, in canonical order) free ids.
    fn rename(&mut self, places: &[usize]) -> Vec<Renamed> {
        // Ids that are taken: all of the source's, and those given out here.
        let source: Vec<CompactString> = self.objects.iter().map(|o| o.id.clone()).collect();
        let mut given = std::collections::BTreeSet::new();
        let mut number = 2_u32;
        let mut renames = Vec::with_capacity(places.len());
        for (i, &place) in places.iter().enumerate() {
            let from = source[place].clone();
            if i == 0 || source[places[i - 1]] != from {
                number = 2;
            }
            let to = loop {
                let candidate = format_compact!("{from}~{number}");
                number += 1;
                if source.binary_search(&candidate).is_err() && given.insert(candidate.clone()) {
                    break candidate;
                }
            };
            self.objects[place].id.clone_from(&to);
            renames.push(Renamed { from, to });
        }
        renames
    }
}

fn by_id_and_content(a: &SceneObject, b: &SceneObject) -> Ordering {
    let numbers = |o: &SceneObject| {
        let [x0, y0, z0, x1, y1, z1] = o.bounds.to_array().map(order_bits);
        [x0, y0, z0, x1, y1, z1, order_bits(o.footprint_area)]
    };
    let text = |o: &SceneObject| o.attributes.as_deref().map(|a| a.get().to_owned());
    a.id.cmp(&b.id)
        .then_with(|| numbers(a).cmp(&numbers(b)))
        .then_with(|| a.class.cmp(&b.class))
        .then_with(|| a.triangles.cmp(&b.triangles))
        .then_with(|| a.base_known.cmp(&b.base_known))
        .then_with(|| a.lift_m.total_cmp(&b.lift_m))
        .then_with(|| text(a).cmp(&text(b)))
}

/// Bits that sort as the numbers do (`f64::total_cmp`).
fn order_bits(x: f64) -> i64 {
    let bits = x.to_bits().cast_signed();
    bits ^ (((bits >> 63).cast_unsigned()) >> 1).cast_signed()
}
