//! What stands in one quarter: blocks of buildings, parks, and the trees along its avenues.

use rand::RngExt as _;
use rand_pcg::Pcg32;

use super::plan::{Line, Plan};
use super::quad::Quad;
use super::{Item, Kind};
use crate::geom::DVec2;

/// Adds everything in quarter (i, j) to `items`.
pub(super) fn fill(plan: &Plan, i: i32, j: i32, items: &mut Vec<Item>) {
    let mut rng = plan.quarter_rng(i, j);
    let ground = plan.quarter(i, j);
    bridge(plan, i, j, items);
    line_with_trees(&ground, i, j, &mut rng, items);
    // One large park always lies beside the main centre.
    let main_park = matches!((i, j), (2 | 3, 1));
    if main_park || chance(&mut rng, 0.025) {
        return plant(&ground, 23.0, &mut rng, items);
    }
    for block in blocks(&ground, &mut rng) {
        let urbanity = plan.urbanity(block.at(0.5, 0.5));
        if chance(&mut rng, 0.035) {
            plant(&block, 15.0, &mut rng, items);
        } else {
            build(&block, urbanity, &mut rng, items);
        }
    }
}

/// Cuts a quarter into blocks with streets between them.
pub(super) fn blocks(quarter: &Quad, rng: &mut Pcg32) -> Vec<Quad> {
    let longest = between(rng, 110.0, 210.0);
    let deepest = between(rng, 52.0, 78.0);
    let mut done = Vec::new();
    let mut todo = vec![(*quarter, 13.0)];
    while let Some((ground, street)) = todo.pop() {
        let ground = ground.lengthwise();
        let (length, depth) = ground.size();
        if length <= longest && depth <= deepest {
            done.push(ground);
            continue;
        }
        let t = between(rng, 0.42, 0.58);
        let narrower = f64::max(street - 2.0, 7.0);
        let cut = if length > longest || length > 1.6 * depth {
            let gap = street * 0.5 / length;
            [(0.0..t - gap, 0.0..1.0), (t + gap..1.0, 0.0..1.0)]
        } else {
            let gap = street * 0.5 / depth;
            [(0.0..1.0, 0.0..t - gap), (0.0..1.0, t + gap..1.0)]
        };
        todo.extend(cut.map(|(u, v)| (ground.piece(u, v), narrower)));
    }
    done
}

/// Cuts a block into rows of lots and builds on them.
pub(super) fn build(block: &Quad, urbanity: f64, rng: &mut Pcg32, items: &mut Vec<Item>) {
    let (length, depth) = block.size();
    let rows = (depth / (26.0 + 16.0 * urbanity)).round().max(1.0) as u32;
    let frontage = 15.0 + 20.0 * urbanity;
    for row in 0..rows {
        let v = f64::from(row) / f64::from(rows)..f64::from(row + 1) / f64::from(rows);
        let mut u = 0.0;
        while u < 1.0 {
            let width =
                frontage * between(rng, 0.75, 1.35) * if chance(rng, 0.04) { 3.0 } else { 1.0 };
            // What is left over is too narrow for one more lot: it goes to this one.
            let end = if (1.0 - u) * length < width * 1.6 {
                1.0
            } else {
                u + width / length
            };
            lot(&block.piece(u..end, v.clone()), urbanity, rng, items);
            u = end;
        }
    }
}

/// A building on its lot, or a few trees, or both.
fn lot(lot: &Quad, urbanity: f64, rng: &mut Pcg32, items: &mut Vec<Item>) {
    let setback = 0.8 + 1.6 * (1.0 - urbanity) * rng.random::<f64>();
    let full = lot.room(setback).filter(|h| h.min_element() > 2.0);
    let Some(full) = full.filter(|_| !chance(rng, 0.03)) else {
        return plant(lot, 10.0, rng, items);
    };
    let least = 0.6 + 0.3 * urbanity;
    let cover = DVec2::new(between(rng, least, 1.0), between(rng, least, 1.0));
    let half = full * cover;
    let slack = full - half;
    let center =
        lot.at(0.5, 0.5) + slack * DVec2::new(between(rng, -1.0, 1.0), between(rng, -1.0, 1.0));
    let height = height(urbanity, rng).min(18.0 * half.min_element());
    items.push(Item::new(
        Kind::Building,
        center - half,
        center + half,
        0.0..height,
    ));
    if chance(rng, 0.3 * (1.0 - urbanity)) {
        let corner = [
            lot.at(0.1, 0.1),
            lot.at(0.9, 0.1),
            lot.at(0.9, 0.9),
            lot.at(0.1, 0.9),
        ][rng.random_range(0..4)];
        if (corner - center).abs().cmpgt(half + 1.0).any() {
            tree(corner, 0.6, rng, items);
        }
    }
}

/// Height of a building, m: a power law, heavier in the centre, where few towers rise far above
/// the rest.
fn height(urbanity: f64, rng: &mut Pcg32) -> f64 {
    let common = between(rng, 4.8, 7.0) + 27.0 * urbanity;
    let rarity = (1.0 - rng.random::<f64>()).sqrt();
    let tower = chance(rng, 0.1 + urbanity);
    let factor = 1.0 / if tower { rarity } else { rarity.sqrt() };
    let highest = (26.0 + 290.0 * urbanity) * between(rng, 0.75, 1.0);
    (common * factor).min(highest)
}

/// Trees all over, about `spacing` m apart.
fn plant(ground: &Quad, spacing: f64, rng: &mut Pcg32, items: &mut Vec<Item>) {
    let (length, depth) = ground.size();
    let (columns, rows) = ((length / spacing) as u32, (depth / spacing) as u32);
    for row in 0..rows {
        for column in 0..columns {
            if chance(rng, 0.25) {
                continue;
            }
            let u = (f64::from(column) + between(rng, 0.1, 0.9)) / f64::from(columns);
            let v = (f64::from(row) + between(rng, 0.1, 0.9)) / f64::from(rows);
            tree(ground.at(u, v), 1.0, rng, items);
        }
    }
}

/// Trees along those sides of the quarter that face an avenue or a river.
fn line_with_trees(ground: &Quad, i: i32, j: i32, rng: &mut Pcg32, items: &mut Vec<Item>) {
    let [a, b, c, d] = ground.0;
    let sides = [
        (Plan::row(j), a, b),
        (Plan::column(i + 1), b, c),
        (Plan::row(j + 1), c, d),
        (Plan::column(i), d, a),
    ];
    for (_, from, to) in sides.into_iter().filter(|s| s.0 != Line::Street) {
        let length = from.distance(to);
        let outward = -(to - from).perp() / length * 4.5;
        let count = (length / 20.0) as u32;
        for n in 0..count {
            let t = (f64::from(n) + 0.5) / f64::from(count);
            if chance(rng, 0.85) {
                tree(from + (to - from) * t + outward, 0.75, rng, items);
            }
        }
    }
}

/// The bridge by which the avenue west of the quarter crosses the river south of it.
fn bridge(plan: &Plan, i: i32, j: i32, items: &mut Vec<Item>) {
    if Plan::row(j) == Line::River && Plan::column(i) == Line::Avenue {
        let half = DVec2::new(
            Line::Avenue.half_width() - 7.0,
            Line::River.half_width() + 6.0,
        );
        let center = plan.crossing(i, j);
        items.push(Item::new(
            Kind::Bridge,
            center - half,
            center + half,
            5.0..8.0,
        ));
    }
}

fn tree(at: DVec2, vigour: f64, rng: &mut Pcg32, items: &mut Vec<Item>) {
    let height = vigour * between(rng, 7.0, 19.0);
    let crown = DVec2::splat(height * between(rng, 0.18, 0.26));
    items.push(Item::new(Kind::Tree, at - crown, at + crown, 0.0..height));
}

fn between(rng: &mut Pcg32, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

fn chance(rng: &mut Pcg32, probability: f64) -> bool {
    rng.random::<f64>() < probability
}
