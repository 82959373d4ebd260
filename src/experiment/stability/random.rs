//! Random cases: every kind of camera, scenes from a millimetre to 100 km anywhere within
//! 10,000 km, most boxes about the borders.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::place::{Kind, Magnitude, Stand, between, vector};
use super::{Tally, city, examine};
use crate::experiment::exact::Oracle;
use crate::experiment::report::thousands;
use crate::experiment::{Progress, ReportError};
use crate::lod::{Beyond, RangeLod};

/// Boxes of one camera's tree.
const BOXES: u64 = 1024;
/// Trees between two reports of progress.
const STEP: u64 = 512;

/// At least so many random cases.
///
/// # Errors
/// [`ReportError`] when a tree cannot be built or a camera cannot be.
pub fn random(cases: u64, progress: &Progress) -> Result<Tally, ReportError> {
    let trees = cases.div_ceil(BOXES);
    let mut sum = Tally::default();
    for first in (0..trees).step_by(STEP as usize) {
        progress(&format!("random case {}", thousands(first * BOXES)));
        let step = first..(first + STEP).min(trees);
        let tallies = step.into_par_iter().map(tree);
        let tallies: Vec<Tally> = tallies.collect::<Result<_, _>>()?;
        sum += tallies.into_iter().sum();
    }
    Ok(sum)
}

fn tree(seed: u64) -> Result<Tally, ReportError> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let kind = Kind::ALL[rng.random_range(0..Kind::ALL.len())];
    let offset = 10_f64.powf(between(&mut rng, 0.0, 7.0));
    let at = Magnitude {
        scale: 10_f64.powf(between(&mut rng, -3.0, 5.0)),
        offset: vector(&mut rng, -offset, offset),
    };
    let stand = Stand::random(&mut rng, kind, at);
    let oracle = Oracle::new(&stand.camera);
    let boxes: Vec<_> = (0..BOXES)
        .map(|_| match rng.random_range(0..100) {
            0 => stand.touching(&oracle, &mut rng, true),
            1 => stand.touching(&oracle, &mut rng, false),
            _ => stand.aabb(&mut rng),
        })
        .collect();
    let far = stand.far_dist(&mut rng);
    let factor = between(&mut rng, 1.0, 4.0);
    let beyond = [Beyond::Show, Beyond::Hide][rng.random_range(0..2)];
    let lod = RangeLod::new(far, factor, rng.random_range(1..5), beyond).unwrap_or_default();
    Ok(examine(&city(&boxes)?, &stand.camera, &[lod])?)
}
