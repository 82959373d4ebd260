//! Makes a city of any size from a seed.
//!
//! An endless [`plan`] of streets, rivers and centres is filled quarter by quarter from the middle
//! outward, and the objects nearest to the middle are kept. So a smaller city of the same seed is
//! the heart of a larger one. Nothing but + − × ÷ and square roots goes into a coordinate, so the
//! bits are the same on every machine.

mod plan;
mod quad;
mod quarter;

use std::ops::Range;

use compact_str::{CompactString, format_compact};

use super::{Scene, SceneObject};
use crate::geom::{Aabb, DVec2};
use plan::{DISPLACEMENT, Plan, QUARTER};

/// Which city to make.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CityParams {
    /// How many objects it has, exactly; takes about 190 bytes each while it is made.
    pub objects: u32,
    /// Cities of different seeds differ in everything; any value is as good as any other.
    pub seed: u64,
}

/// What an object is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Building,
    Bridge,
    Tree,
}

impl Kind {
    /// In the order of their prefixes, so that ids come out sorted.
    const ALL: [Self; 3] = [Self::Building, Self::Bridge, Self::Tree];

    fn prefix(self) -> &'static str {
        match self {
            Self::Building => "b",
            Self::Bridge => "bridge",
            Self::Tree => "t",
        }
    }

    /// The `CityJSON` type.
    fn class(self) -> CompactString {
        CompactString::const_new(match self {
            Self::Building => "Building",
            Self::Bridge => "Bridge",
            Self::Tree => "SolitaryVegetationObject",
        })
    }
}

/// An object before it has a name.
#[derive(Debug, Clone, Copy)]
struct Item {
    kind: Kind,
    bounds: Aabb,
}

impl Item {
    fn new(kind: Kind, min: DVec2, max: DVec2, z: Range<f64>) -> Self {
        let bounds = Aabb::around([min.extend(z.start), max.extend(z.end)]);
        Self { kind, bounds }
    }

    /// From the middle of the city, m².
    fn distance_squared(&self) -> f64 {
        self.bounds.center().truncate().length_squared()
    }
}

/// Makes the city: boxes in metres on flat ground at z = 0, the main centre at the origin.
///
/// Ids are sorted and unique: `b-0000001` for buildings, `bridge-0000001`, `t-0000001` for trees,
/// each numbered roughly from the centre outward. Buildings overlap neither one another nor a
/// street. 1,000 objects stand on a km² of the main centre, 1,800 on one of a large city.
///
/// Same parameters, same bits.
pub fn generate(params: &CityParams) -> Scene {
    let items = nearest(params);
    let width = params.objects.to_string().len().max(7);
    let mut objects = Vec::with_capacity(items.len());
    for kind in Kind::ALL {
        let class = kind.class();
        let of_kind = items.iter().filter(|item| item.kind == kind);
        objects.extend(of_kind.zip(1_u32..).map(|(item, number)| {
            let size = item.bounds.size();
            SceneObject {
                id: format_compact!("{}-{number:0width$}", kind.prefix()),
                class: class.clone(),
                bounds: item.bounds,
                footprint_area: size.x * size.y,
                triangles: 12,
                base_known: true,
                lift_m: 0.0,
                attributes: None,
            }
        }));
    }
    Scene {
        objects,
        ..Scene::default()
    }
}

/// The `params.objects` objects nearest to the origin, ties to the one made first.
fn nearest(params: &CityParams) -> Vec<Item> {
    let plan = Plan::new(params.seed);
    let wanted = params.objects as usize;
    let mut items = Vec::new();
    // Objects by distance, in quarters. A ring is complete once the quarters `stray` rings farther
    // out are there: none strays more than `DISPLACEMENT` and its own diagonal from its place.
    let mut by_ring = Vec::<usize>::new();
    let stray = (DISPLACEMENT / QUARTER).ceil() as i32 + 2;
    let mut complete = 0;
    for ring in 0_i32.. {
        if complete >= wanted {
            break;
        }
        let before = items.len();
        for (i, j) in ring_of_quarters(ring) {
            quarter::fill(&plan, i, j, &mut items);
        }
        for item in &items[before..] {
            let at = (item.distance_squared().sqrt() / QUARTER) as usize;
            by_ring.resize(by_ring.len().max(at + 1), 0);
            by_ring[at] += 1;
        }
        if let Ok(safe) = usize::try_from(ring - stray) {
            complete += by_ring.get(safe).copied().unwrap_or(0);
        }
    }
    keep_nearest(&mut items, wanted);
    items
}

/// Lattice places whose distance from the origin rounds down to `ring`, in a fixed order.
fn ring_of_quarters(ring: i32) -> impl Iterator<Item = (i32, i32)> {
    let (inner, outer) = (i64::from(ring).pow(2), i64::from(ring + 1).pow(2));
    (-ring..=ring)
        .flat_map(move |j| (-ring..=ring).map(move |i| (i, j)))
        .filter(move |&(i, j)| {
            let d = i64::from(i).pow(2) + i64::from(j).pow(2);
            (inner..outer).contains(&d)
        })
}

fn keep_nearest(items: &mut Vec<Item>, wanted: usize) {
    if wanted >= items.len() {
        return;
    }
    let mut distances: Vec<f64> = items.iter().map(Item::distance_squared).collect();
    let (nearer, &mut limit, _) = distances.select_nth_unstable_by(wanted, f64::total_cmp);
    let mut at_limit = wanted - nearer.iter().filter(|d| **d < limit).count();
    items.retain(|item| {
        let distance = item.distance_squared();
        let tie = distance == limit && at_limit > 0;
        at_limit -= usize::from(tie);
        distance < limit || tie
    });
}

#[cfg(test)]
mod tests;
