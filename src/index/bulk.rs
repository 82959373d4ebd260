//! Building a whole city at once, in parallel, with nodes equally full.
//!
//! Top-down tiling in the manner of OMT (Lee and Lee, "OMT: Overlap Minimizing Top-down Bulk
//! Loading Algorithm for R-tree", 2003), by recursive bisection along the wider of x and y, for
//! [`Promotion::Largest`] along the widest of x, y and size (see [`SIZE_SCALE`]).
//! rstar's own bulk loader cuts every node into 8 and so leaves between 1 and 9 objects in a
//! leaf, depending on how many there are; here only the root takes up the slack.

use rayon::prelude::*;

use super::hierarchy::{Canonical, Hierarchy, Level};
use super::{Candidate, LodEnvelope, MAX_FAN_OUT, Promotion};
use crate::scene::SceneObject;

/// Children of an inner node: one less than it may have, so that one group of eight boxes is
/// tested at a time. Leaves take [`MAX_FAN_OUT`], of which one is promoted.
const INNER_FAN_OUT: usize = MAX_FAN_OUT - 1;
/// Smaller pieces are not worth another thread.
const PARALLEL_FROM: usize = 16 * 1024;

/// Where an object lies in the space that is cut up: its midpoint on the ground, relative to the
/// middle of the city, and for [`Promotion::Largest`] its radius on the scale of [`SIZE_SCALE`].
#[derive(Debug, Clone, Copy)]
struct Place<const AXES: usize> {
    at: [f32; AXES],
    object: Canonical,
}

/// How many metres of distance count as much as one of radius. Which objects are large enough on
/// the screen depends on radius by distance, so where the two are d = s·r, a difference of 1 m in
/// radius and one of s m in distance tell objects apart equally well. This s is what an object of
/// 14 pixels has in a view of 1080 lines and 60°.
const SIZE_SCALE: f64 = 128.0;

/// The hierarchy of all objects of the scene.
pub(super) fn load(objects: &[&SceneObject], promotion: Promotion) -> Hierarchy {
    if objects.is_empty() {
        return Hierarchy::default();
    }
    let height = height(objects.len());
    let mut levels: Vec<Level> = (0..=height).map(|_| Level::default()).collect();
    plan(objects.len(), height, &mut levels);
    let order = match promotion {
        Promotion::Tallest | Promotion::Footprint => order(objects, height, |_, [x, y]| [x, y]),
        Promotion::Largest => order(objects, height, |object, [x, y]| {
            [x, y, (object.bounds.radius() * SIZE_SCALE) as f32]
        }),
    };

    for k in 0..levels.len() {
        let (below, this) = levels.split_at_mut(k);
        let starts = this[0].child_starts();
        let children = |node: usize| starts[node] as usize..starts[node + 1] as usize;
        let merged = |parts: &mut dyn Iterator<Item = LodEnvelope<Canonical>>| {
            parts.fold(LodEnvelope::nothing(), |mut all, part| {
                all.absorb(&part);
                all
            })
        };
        this[0].envelopes = (0..starts.len() - 1)
            .into_par_iter()
            .map(|node| match below.last() {
                Some(below) => merged(&mut below.envelopes[children(node)].iter().cloned()),
                None => merged(&mut order[children(node)].iter().map(|&key| {
                    let object = objects[key as usize];
                    let score = promotion.score(object);
                    LodEnvelope::of(&object.bounds, Candidate { score, key })
                })),
            })
            .collect();
    }
    Hierarchy {
        objects: order,
        levels,
    }
}

/// The objects in the order in which the nodes of a tree of this height hold them.
fn order<const AXES: usize>(
    objects: &[&SceneObject],
    height: usize,
    place: impl Fn(&SceneObject, [f32; 2]) -> [f32; AXES] + Sync,
) -> Vec<Canonical> {
    let middle = objects
        .par_iter()
        .map(|o| o.bounds)
        .reduce_with(|a, b| a.union(&b))
        .map_or(glam::DVec3::ZERO, |all| all.center());
    let mut places: Vec<Place<AXES>> = objects
        .par_iter()
        .enumerate()
        .map(|(key, object)| {
            let center = object.bounds.center() - middle;
            Place {
                at: place(object, [center.x as f32, center.y as f32]),
                object: key as Canonical,
            }
        })
        .collect();
    tile(&mut places, height);
    places.into_par_iter().map(|p| p.object).collect()
}

/// Objects below a full node at this height above the leaves.
fn capacity(height: usize) -> usize {
    INNER_FAN_OUT
        .saturating_pow(height as u32)
        .saturating_mul(MAX_FAN_OUT)
}

fn height(objects: usize) -> usize {
    let mut height = 0;
    while capacity(height) < objects {
        height += 1;
    }
    height
}

/// Children of a node over so many objects, as few as hold them.
fn fan_out(objects: usize, height: usize) -> usize {
    objects.div_ceil(capacity(height - 1))
}

/// How many of `objects` go to the first of the halves that `parts` children fall into.
fn first_half(objects: usize, parts: usize) -> usize {
    // u128: objects · parts may pass 64 bits only in theory, but costs nothing to rule out.
    (objects as u128 * (parts / 2) as u128 / parts as u128) as usize
}

/// Orders `places` so that the objects of every node lie together, ascending in a leaf.
fn tile<const AXES: usize>(places: &mut [Place<AXES>], height: usize) {
    if height > 0 {
        let parts = fan_out(places.len(), height);
        bisect(places, parts, height);
    } else {
        places.sort_unstable_by_key(|place| place.object);
    }
}

fn bisect<const AXES: usize>(places: &mut [Place<AXES>], parts: usize, height: usize) {
    if parts == 1 {
        return tile(places, height - 1);
    }
    let first = first_half(places.len(), parts);
    let axis = widest_axis(places);
    places.select_nth_unstable_by(first, |a, b| {
        a.at[axis]
            .total_cmp(&b.at[axis])
            .then(a.object.cmp(&b.object))
    });
    let parallel = places.len() >= PARALLEL_FROM;
    let (a, b) = places.split_at_mut(first);
    let mut left = || bisect(a, parts / 2, height);
    let mut right = || bisect(b, parts - parts / 2, height);
    if parallel {
        rayon::join(left, right);
    } else {
        left();
        right();
    }
}

fn widest_axis<const AXES: usize>(places: &[Place<AXES>]) -> usize {
    let mut low = [f32::INFINITY; AXES];
    let mut high = [f32::NEG_INFINITY; AXES];
    for place in places {
        for axis in 0..AXES {
            low[axis] = low[axis].min(place.at[axis]);
            high[axis] = high[axis].max(place.at[axis]);
        }
    }
    let width = |axis: usize| high[axis] - low[axis];
    (1..AXES).fold(0, |widest, axis| {
        if width(axis) > width(widest) {
            axis
        } else {
            widest
        }
    })
}

/// Writes down the child counts that [`tile`] arrives at; they depend on the number alone.
fn plan(objects: usize, height: usize, levels: &mut [Level]) {
    if height == 0 {
        levels[0].children.push(objects as u32);
        return;
    }
    let parts = fan_out(objects, height);
    plan_parts(objects, parts, height, levels);
    levels[height].children.push(parts as u32);
}

fn plan_parts(objects: usize, parts: usize, height: usize, levels: &mut [Level]) {
    if parts == 1 {
        plan(objects, height - 1, levels);
    } else {
        let first = first_half(objects, parts);
        plan_parts(first, parts / 2, height, levels);
        plan_parts(objects - first, parts - parts / 2, height, levels);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_keeps_to_its_fan_out() {
        for objects in (1..3000).chain([23_951, 100_000, 294_913, 1_000_000]) {
            let height = height(objects);
            let mut levels = vec![Level::default(); height + 1];
            plan(objects, height, &mut levels);
            assert_eq!(levels[height].children.len(), 1);
            let total: u32 = levels[0].children.iter().sum();
            assert_eq!(total as usize, objects);
            for (k, level) in levels.iter().enumerate() {
                let most = if k == 0 { MAX_FAN_OUT } else { INNER_FAN_OUT };
                let least = if k == height {
                    1
                } else {
                    super::super::MIN_FAN_OUT
                };
                assert!(
                    level
                        .children
                        .iter()
                        .all(|&c| (least..=most).contains(&(c as usize))),
                    "{objects} objects, level {k}"
                );
            }
        }
    }
}
