//! How large what lies below a node is: what bounds the size of anything left out.

use std::ops::Range;

use rayon::prelude::*;

use super::columns::OwnRadii;
use super::plan::Plan;

/// Radii rounded up, m; 0 where there is nothing.
pub(super) struct Radii {
    /// Largest of each node's own objects and of those below it.
    pub(super) held: Vec<f32>,
    /// Least of the same; infinite where there is none.
    pub(super) least: Vec<f32>,
    /// Largest below each node that is not its own.
    pub(super) hidden: Vec<f32>,
    /// The same of what is stored below a level, for each inner node: level 1 first, up to the
    /// last below the root's.
    pub(super) cuts: Vec<Vec<f32>>,
}

impl Radii {
    /// From those of each node's own objects.
    pub(super) fn new(plan: &Plan, own: &OwnRadii) -> Self {
        let nodes = plan.own.len() - 1;
        let (hidden, held) = below(plan, &own.largest, 0..nodes);
        // The section has one number more than there are levels.
        let levels = plan.levels.len() / 2 - 1;
        let cuts = (1..levels.saturating_sub(1)).into_par_iter().map(|cut| {
            let first = plan.levels[levels - cut] as usize;
            let (mut hidden, _) = below(plan, &own.largest, first..nodes);
            hidden.truncate(plan.children.len() - 1);
            hidden
        });
        Self {
            cuts: cuts.collect(),
            least: least(plan, &own.least),
            held,
            hidden,
        }
    }
}

/// For each node, the largest radius below it that is not its own, and the largest with its own:
/// of objects stored with the nodes `counted`. `own` has each node's largest of its own.
fn below(plan: &Plan, own: &[f32], counted: Range<usize>) -> (Vec<f32>, Vec<f32>) {
    let nodes = plan.own.len() - 1;
    let mut held = vec![0.0; nodes];
    held[counted.clone()].copy_from_slice(&own[counted]);
    let mut hidden = vec![0.0; nodes];
    for node in (0..plan.children.len() - 1).rev() {
        let children = plan.children[node] as usize..plan.children[node + 1] as usize;
        hidden[node] = largest(&held[children]);
        held[node] = hidden[node].max(held[node]);
    }
    (hidden, held)
}

/// For each node, the least radius of its own objects and of those below it.
fn least(plan: &Plan, own: &[f32]) -> Vec<f32> {
    let least = |radii: &[f32]| radii.iter().copied().fold(f32::INFINITY, f32::min);
    let mut held = own.to_vec();
    for node in (0..plan.children.len() - 1).rev() {
        let children = plan.children[node] as usize..plan.children[node + 1] as usize;
        held[node] = least(&held[children]).min(held[node]);
    }
    held
}

fn largest(radii: &[f32]) -> f32 {
    radii.iter().copied().fold(0.0, f32::max)
}
