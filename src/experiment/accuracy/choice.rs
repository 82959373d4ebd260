//! As many objects as are asked for, chosen by each strategy.

use std::hint::black_box;

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::full_detail::FullDetail;
use super::scan::Scan;
use super::strategy::Strategy;
use super::viewpoint::Viewpoint;
use crate::experiment::city::SEED;
use crate::experiment::timing::median_us;
use crate::experiment::{ReportError, city};
use crate::geom::View;
use crate::index::{self, LodTree, Promotion};
use crate::lod::{Beyond, BudgetLod, ErrorLod, Lod, RangeLod, Selection, select};
use crate::scene::Scene;

/// Ratio of the far distances of neighbouring levels in range mode.
pub(super) const DIST_FACTOR: f64 = 2.5;
const SAMPLES: usize = 3;

/// A city made ready for every strategy.
pub(super) struct City {
    pub(super) name: String,
    /// By the promotion `largest`. Its object numbers are those of all answers.
    pub(super) tree: LodTree,
    ranged: [Ranged; 2],
    pub(super) scan: Scan,
    /// Objects of the largest radius first.
    by_radius: Scan,
}

/// The tree of a promotion, with the number that each of its objects has in [`City::tree`].
struct Ranged {
    tree: LodTree,
    numbers: Vec<u32>,
}

/// The objects of a view that were chosen.
pub(super) struct Answer {
    pub(super) parameter: f64,
    pub(super) objects: Vec<u32>,
    /// Certified with the answer; a strategy without a tree certifies nothing.
    pub(super) error_px: Option<f64>,
    pub(super) retrieve_us: f64,
}

impl City {
    pub(super) fn new(name: String, scene: &Scene) -> Result<Self, ReportError> {
        let tree = index::build(scene, Promotion::Largest)?;
        let order = by_id(&tree);
        let ranged = |promotion| -> Result<Ranged, ReportError> {
            let ranged = index::build(scene, promotion)?;
            let mut numbers = vec![0; order.len()];
            for (here, &there) in by_id(&ranged).into_iter().zip(&order) {
                numbers[here as usize] = there;
            }
            Ok(Ranged {
                tree: ranged,
                numbers,
            })
        };
        let mut by_radius: Vec<u32> = (0..tree.object_count()).collect();
        let radius = |object: u32| tree.bounds_of(object).map_or(0.0, |b| b.radius());
        by_radius.sort_by(|&a, &b| radius(b).total_cmp(&radius(a)));
        Ok(Self {
            name,
            ranged: [ranged(Promotion::Tallest)?, ranged(Promotion::Footprint)?],
            scan: Scan::new(&tree, (0..tree.object_count()).collect()),
            by_radius: Scan::new(&tree, by_radius),
            tree,
        })
    }

    /// `count` objects of a view, of which there are as many or more; by error mode and the oracle
    /// more where sizes tie, by range mode the most it gives without exceeding that. `None` where
    /// a strategy has no answer so small or so large.
    pub(super) fn choose(
        &self,
        strategy: Strategy,
        view: &View,
        count: usize,
        ranked: &[(f64, u32)],
    ) -> Option<Answer> {
        let least_px = ranked.get(count.checked_sub(1)?)?.0;
        let radius = |object: u32| self.tree.bounds_of(object).map_or(0.0, |b| b.radius());
        match strategy {
            Strategy::RangeTallest | Strategy::RangeFootprint => {
                let mut selection = Selection::default();
                let mut exceeds = |far_dist: f64| {
                    self.select(strategy, view, far_dist, &mut selection);
                    selection.count() as usize > count
                };
                if exceeds(SHORTEST_FAR_DIST_M) {
                    return None;
                }
                let [within, _] = border([SHORTEST_FAR_DIST_M, self.reach(view)], exceeds);
                self.ask(strategy, view, within)
            }
            Strategy::Error => self.ask(strategy, view, least_px),
            Strategy::Budget => self.ask(strategy, view, count as f64),
            Strategy::Oracle => {
                let scan =
                    |found: &mut Vec<u32>| self.scan.large(&self.tree, view, least_px, found);
                Some(scanned(least_px, scan))
            }
            Strategy::Random => {
                let scan = |found: &mut Vec<u32>| {
                    self.scan.in_view(&self.tree, view, usize::MAX, found);
                    let mut rng = Pcg64Mcg::seed_from_u64(SEED);
                    let chosen = found.partial_shuffle(&mut rng, count).0.to_vec();
                    *found = chosen;
                };
                Some(scanned(count as f64, scan))
            }
            Strategy::GlobalSize => {
                let mut radii: Vec<f64> = ranked.iter().map(|&(_, o)| radius(o)).collect();
                radii.sort_unstable_by(|a, b| b.total_cmp(a));
                let least = radii[count - 1];
                let all = 0..self.tree.object_count();
                let large = all.filter(|&object| radius(object) >= least).count();
                let scan =
                    |found: &mut Vec<u32>| self.by_radius.in_view(&self.tree, view, large, found);
                Some(scanned(least, scan))
            }
        }
    }

    /// The answer of a mode with its parameter.
    pub(super) fn ask(&self, mode: Strategy, view: &View, parameter: f64) -> Option<Answer> {
        let mut selection = Selection::default();
        self.select(mode, view, parameter, &mut selection)?;
        let (tree, numbers) = self.tree_of(mode);
        let lod = self.lod(mode, parameter)?;
        let retrieve_us = median_us(SAMPLES, || select(tree, view, &lod, &mut selection));
        let mut objects = Vec::new();
        renumber(&selection, numbers, &mut objects);
        Some(Answer {
            parameter,
            objects,
            error_px: Some(selection.error_px()),
            retrieve_us,
        })
    }

    /// What a mode selects with its parameter.
    fn select(
        &self,
        mode: Strategy,
        view: &View,
        parameter: f64,
        selection: &mut Selection,
    ) -> Option<()> {
        let lod = self.lod(mode, parameter)?;
        select(self.tree_of(mode).0, view, &lod, selection);
        Some(())
    }

    /// The tree a mode walks, with numbers for its objects where they are not those of answers.
    fn tree_of(&self, mode: Strategy) -> (&LodTree, Option<&[u32]>) {
        let ranged = match mode {
            Strategy::RangeTallest => &self.ranged[0],
            Strategy::RangeFootprint => &self.ranged[1],
            _ => return (&self.tree, None),
        };
        (&ranged.tree, Some(&ranged.numbers))
    }

    fn lod(&self, mode: Strategy, parameter: f64) -> Option<Lod> {
        Some(match mode {
            Strategy::Error => Lod::Error(ErrorLod::new(parameter).ok()?),
            Strategy::Budget => Lod::Budget(BudgetLod::new(parameter as u32)),
            _ => {
                let levels = self.tree_of(mode).0.level_count().max(1);
                let lod = RangeLod::new(parameter, DIST_FACTOR, levels, Beyond::Show);
                Lod::Range(lod.ok()?)
            }
        })
    }

    /// A distance that nothing of the city is farther away than, m.
    fn reach(&self, view: &View) -> f64 {
        let bounds = self.tree.bounds();
        bounds.distance(view.eye()) + 2.0 * bounds.radius() + 1.0
    }

    /// The parameter of error mode or range mode with which the views miss so much or less on
    /// average.
    pub(super) fn parameter_for(
        &self,
        mode: Strategy,
        missed_px_pct: f64,
        views: &mut [(Viewpoint, FullDetail)],
    ) -> f64 {
        let numbers = self.tree_of(mode).1;
        let mut selection = Selection::default();
        let mut objects = Vec::new();
        let reach = views.iter().map(|(v, _)| self.reach(&v.view));
        let reach = reach.fold(SHORTEST_FAR_DIST_M, f64::max);
        let count = views.len() as f64;
        let mut misses_too_much = |parameter: f64| {
            let missed = views.iter_mut().map(|(viewpoint, full)| {
                self.select(mode, &viewpoint.view, parameter, &mut selection);
                renumber(&selection, numbers, &mut objects);
                full.missed_px_pct(&objects)
            });
            missed.sum::<f64>() > missed_px_pct * count
        };
        if mode == Strategy::Error {
            border(SIZES_PX, misses_too_much)[0]
        } else {
            border([SHORTEST_FAR_DIST_M, reach], |far_dist| {
                !misses_too_much(far_dist)
            })[1]
        }
    }
}

/// Far distances are sought from here on, m.
const SHORTEST_FAR_DIST_M: f64 = 0.01;
/// Sizes are sought between these, pixels.
const SIZES_PX: [f64; 2] = [0.01, 10_000.0];

/// Two neighbours, as far as they are told apart, the last that is not `past` and the first that
/// is, between two positive numbers; twice the lower or the upper one where all or none are.
fn border([mut low, mut high]: [f64; 2], mut past: impl FnMut(f64) -> bool) -> [f64; 2] {
    const HALVINGS: u32 = 32;
    if past(low) {
        return [low; 2];
    }
    if !past(high) {
        return [high; 2];
    }
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        if past(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    [low, high]
}

/// The objects of a selection under the numbers that answers have.
fn renumber(selection: &Selection, numbers: Option<&[u32]>, objects: &mut Vec<u32>) {
    objects.clear();
    let number = |object: u32| numbers.map_or(object, |numbers| numbers[object as usize]);
    objects.extend(selection.objects().map(number));
}

fn scanned(parameter: f64, mut scan: impl FnMut(&mut Vec<u32>)) -> Answer {
    let mut objects = Vec::new();
    let retrieve_us = median_us(SAMPLES, || {
        scan(&mut objects);
        black_box(objects.len())
    });
    Answer {
        parameter,
        objects,
        error_px: None,
        retrieve_us,
    }
}

/// The objects of a tree in the order of their ids, which is the same for every tree of a city.
fn by_id(tree: &LodTree) -> Vec<u32> {
    let mut order: Vec<u32> = (0..tree.object_count()).collect();
    order.par_sort_unstable_by(|&a, &b| tree.id(a).cmp(&tree.id(b)));
    order
}

/// The cities to look at: those that were asked for, or else the one of as many objects as Gong's,
/// real where there is one.
pub(super) fn cities(paths: &[std::path::PathBuf]) -> Result<Vec<City>, ReportError> {
    let real = city::real();
    let paths = if paths.is_empty() {
        real.as_slice()
    } else {
        paths
    };
    if paths.is_empty() {
        let scene = city::generated_scene(city::GONG_OBJECTS);
        return Ok(vec![City::new("generated".into(), &scene)?]);
    }
    let city = |path: &std::path::PathBuf| {
        let tree = city::from_file(path)?;
        City::new(city::name(path), &tree.scene())
    };
    paths.iter().map(city).collect()
}
