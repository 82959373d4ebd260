//! The hard cases of DESIGN.md, section 5, by name.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::place::{Kind, Magnitude, Stand, between, vector};
use super::{Tally, city, examine};
use crate::experiment::ReportError;
use crate::experiment::exact::Oracle;
use crate::geom::{Aabb, DVec3};
use crate::index::LodTree;
use crate::lod::{Beyond, RangeLod, Selection, retrieve};

/// Sizes of scenes, m, and where they lie: at the origin, in a national grid, earth-centred,
/// and farther off.
const MAGNITUDES: [Magnitude; 7] = [
    magnitude(1e-3, [0.0, 0.0, 0.0]),
    magnitude(1.0, [0.0, 0.0, 0.0]),
    magnitude(1e3, [0.0, 0.0, 0.0]),
    magnitude(1e3, [460_000.25, 5_400_000.5, 120.125]),
    magnitude(1e-3, [4_014_743.1, 411_334.7, 4_922_395.3]),
    magnitude(1e3, [4_014_743.1, 411_334.7, 4_922_395.3]),
    magnitude(1e5, [1e7, -1e7, 1e7]),
];

/// Down to where f32 and f64 underflow, in squares or altogether.
const TINY: [Magnitude; 7] = [
    magnitude(1e-12, [0.0, 0.0, 0.0]),
    magnitude(1e-19, [0.0, 0.0, 0.0]),
    magnitude(1e-22, [0.0, 0.0, 0.0]),
    magnitude(1e-38, [0.0, 0.0, 0.0]),
    magnitude(1e-155, [0.0, 0.0, 0.0]),
    magnitude(1e-305, [0.0, 0.0, 0.0]),
    magnitude(1e-318, [0.0, 0.0, 0.0]),
];

const fn magnitude(scale: f64, offset: [f64; 3]) -> Magnitude {
    Magnitude {
        scale,
        offset: DVec3::from_array(offset),
    }
}

/// Boxes of a tree, and cameras it is seen through.
const BOXES: usize = 96;
const CAMERAS: usize = 8;

/// A hard case: what makes boxes and settings for a camera.
struct Case {
    name: &'static str,
    /// Any kind where it does not matter.
    kind: Option<Kind>,
    magnitudes: &'static [Magnitude],
    boxes: fn(&Stand, &Oracle, &mut Pcg64Mcg, Magnitude) -> Vec<Aabb>,
    ranges: fn(&LodTree, &Stand, &mut Pcg64Mcg) -> Vec<RangeLod>,
}

const CASES: &[Case] = &[
    case("touching a plane from outside", None, |s, o, rng, _| {
        many(|| s.touching(o, rng, true))
    }),
    case("touching a plane from inside", None, |s, o, rng, _| {
        many(|| s.touching(o, rng, false))
    }),
    case(
        "touching a rational plane",
        Some(Kind::Aligned),
        |s, o, rng, _| {
            many(|| {
                let farthest = rng.random();
                s.touching(o, rng, farthest)
            })
        },
    ),
    case("flat boxes", None, |s, o, rng, _| {
        many(|| thinned(s, o, rng, 1))
    }),
    case("line boxes", None, |s, o, rng, _| {
        many(|| thinned(s, o, rng, 2))
    }),
    case("point boxes", None, |s, o, rng, _| {
        many(|| thinned(s, o, rng, 3))
    }),
    case("boxes around the eye", None, |s, _, rng, at| {
        many(|| {
            let part = |rng: &mut Pcg64Mcg| vector(rng, 0.0, at.scale) * small(rng);
            let (low, high) = (s.eye - part(rng), s.eye + part(rng));
            Aabb::around([s.eye, low, high])
        })
    }),
    case("a box larger than the scene", None, |s, _, rng, at| {
        let mut boxes = many(|| s.aabb(rng));
        for power in [1.0, 3.0, 9.0] {
            let half = DVec3::splat(at.scale * 10_f64.powf(power));
            boxes.push(Aabb::around([s.eye - half, s.eye + half]));
            boxes.push(Aabb::around([s.eye, s.eye - half]));
        }
        boxes
    }),
    case("identical boxes", None, |s, o, rng, _| {
        vec![s.touching(o, rng, true); BOXES]
    }),
    case("one object", None, |s, o, rng, _| {
        let farthest = rng.random();
        vec![s.touching(o, rng, farthest)]
    }),
    case("no object", None, |_, _, _, _| Vec::new()),
    case("eye 10,000 km away", Some(Kind::FarAway), about),
    case("opening of 0.01 degrees", Some(Kind::Narrow), about),
    case("opening of 179.9 degrees", Some(Kind::Wide), about),
    case("near 1e-6 without far", Some(Kind::Close), about),
    case("orthographic", Some(Kind::Orthographic), about),
    case("off-axis", Some(Kind::OffAxis), about),
    case("view-projection matrix", Some(Kind::Matrix), about),
    case("quaternion", Some(Kind::Quaternion), about),
    case("up along the line of sight", Some(Kind::Steep), about),
    Case {
        name: "exactly at a range's border",
        kind: Some(Kind::Aligned),
        magnitudes: &MAGNITUDES,
        boxes: |s, _, rng, at| {
            let unit = at.scale / 8.0;
            many(|| {
                let low = s.eye + vector(rng, -9.0, 9.0).round() * unit;
                Aabb::around([low, low + vector(rng, 0.0, 3.0).round() * unit])
            })
        },
        ranges: |tree, s, rng| {
            let boxes = tree.arrays().node_boxes;
            let mut distance = || {
                let node = boxes.get(rng.random_range(0..boxes.len().max(1)));
                node.and_then(|b| Aabb::from_array(*b).ok())
                    .map_or(0.0, |b| b.distance(s.eye))
            };
            let (a, b, c) = (distance(), distance(), distance());
            settings([
                (a, 1.0, 1),
                (b, 2.0, 3),
                (c.next_up(), 1.0, 2),
                (c.next_down(), 1.5, 1),
            ])
        },
    },
    Case {
        name: "far_dist 0, tiny and infinite",
        kind: None,
        magnitudes: &MAGNITUDES,
        boxes: about,
        ranges: |_, _, _| {
            settings([
                (0.0, 2.5, 3),
                (f64::MIN_POSITIVE, 2.0, 2),
                (1e-30, 1e30, 3),
                (f64::INFINITY, 2.0, 2),
            ])
        },
    },
    Case {
        name: "dist_factor at and near 1",
        kind: None,
        magnitudes: &MAGNITUDES,
        boxes: about,
        ranges: |_, s, rng| {
            let far = s.far_dist(rng);
            let above = 1.0 + f64::EPSILON;
            settings([
                (far, 1.0, 5),
                (far, above, 5),
                (far, 1.000_001, 4),
                (far, 1.0, 1),
            ])
        },
    },
    Case {
        name: "denormals",
        magnitudes: &TINY,
        ..case("", None, |s, o, rng, _| {
            let mut boxes = about(s, o, rng, TINY[0]);
            for b in boxes.iter_mut().step_by(3) {
                let tiny = DVec3::splat(f64::from_bits(rng.random_range(1..1 << 40)));
                *b = Aabb::around([b.min() * between(rng, 0.0, 1.0).round(), tiny]);
            }
            boxes
        })
    },
    case("negative zero", Some(Kind::Aligned), |s, _, rng, _| {
        many(|| {
            let b = s.aabb(rng);
            let zero = [-0.0, 0.0][usize::from(rng.random::<bool>())];
            let axis = rng.random_range(0..3);
            let (mut low, mut high) = (b.min(), b.max());
            low[axis] = low[axis].min(zero);
            high[axis] = if low[axis] < 0.0 { -0.0 } else { zero };
            low[axis] = low[axis].min(high[axis]);
            Aabb::around([low, high])
        })
    }),
];

const fn case(
    name: &'static str,
    kind: Option<Kind>,
    boxes: fn(&Stand, &Oracle, &mut Pcg64Mcg, Magnitude) -> Vec<Aabb>,
) -> Case {
    Case {
        name,
        kind,
        magnitudes: &MAGNITUDES,
        boxes,
        ranges: |_, s, rng| {
            let far = s.far_dist(rng);
            settings([(far, 2.5, 4), (far, between(rng, 1.0, 4.0), 2)])
        },
    }
}

fn many(make: impl FnMut() -> Aabb) -> Vec<Aabb> {
    std::iter::repeat_with(make).take(BOXES).collect()
}

fn about(s: &Stand, o: &Oracle, rng: &mut Pcg64Mcg, _: Magnitude) -> Vec<Aabb> {
    many(|| match rng.random_range(0..4) {
        0 => s.touching(o, rng, true),
        1 => s.touching(o, rng, false),
        _ => s.aabb(rng),
    })
}

fn small(rng: &mut Pcg64Mcg) -> f64 {
    10_f64.powf(between(rng, -12.0, 1.0))
}

/// A touching box without extent along so many axes.
fn thinned(s: &Stand, o: &Oracle, rng: &mut Pcg64Mcg, axes: usize) -> Aabb {
    let farthest = rng.random();
    let b = s.touching(o, rng, farthest);
    let (low, mut high) = (b.min(), b.max());
    let first = rng.random_range(0..3);
    for k in 0..axes {
        high[(first + k) % 3] = low[(first + k) % 3];
    }
    Aabb::around([low, high])
}

fn settings<const N: usize>(settings: [(f64, f64, u32); N]) -> Vec<RangeLod> {
    let make = |(n, &(far, factor, levels)): (usize, &(f64, f64, u32))| {
        let beyond = [Beyond::Hide, Beyond::Show][n % 2];
        RangeLod::new(far, factor, levels, beyond).ok()
    };
    settings.iter().enumerate().filter_map(make).collect()
}

/// Every hard case at every magnitude, each with what came of it.
///
/// # Errors
/// [`ReportError`] when a tree cannot be built or a camera cannot be.
pub fn adversarial() -> Result<Vec<(&'static str, Tally)>, ReportError> {
    let mut tallies: Vec<_> = CASES
        .par_iter()
        .enumerate()
        .map(|(n, case)| Ok((case.name, case.run(n as u64)?)))
        .collect::<Result<_, ReportError>>()?;
    tallies.push(("a million identical boxes", a_million_identical_boxes()?));
    tallies.push(("threads, runs and order", threads_and_order()?));
    Ok(tallies)
}

impl Case {
    fn run(&self, number: u64) -> Result<Tally, ReportError> {
        let rounds = self.magnitudes.par_iter().enumerate();
        let rounds = rounds.map(|(m, &at)| {
            let mut rng = Pcg64Mcg::seed_from_u64(number * 100 + m as u64);
            let mut sum = Tally::default();
            for camera in 0..CAMERAS {
                let kind = self
                    .kind
                    .unwrap_or(Kind::ALL[(camera + m) % Kind::ALL.len()]);
                let stand = Stand::random(&mut rng, kind, at);
                let oracle = Oracle::new(&stand.camera);
                let tree = city(&(self.boxes)(&stand, &oracle, &mut rng, at))?;
                let ranges = (self.ranges)(&tree, &stand, &mut rng);
                sum += examine(&tree, &stand.camera, &ranges)?;
                sum.cases += u64::from(tree.object_count() == 0);
            }
            Ok(sum)
        });
        let tallies: Vec<Tally> = rounds.collect::<Result<_, ReportError>>()?;
        Ok(tallies.into_iter().sum())
    }
}

fn a_million_identical_boxes() -> Result<Tally, ReportError> {
    let mut rng = Pcg64Mcg::seed_from_u64(1_000_000);
    let at = MAGNITUDES[3];
    let stand = Stand::random(&mut rng, Kind::Usual, at);
    let b = stand.touching(&Oracle::new(&stand.camera), &mut rng, true);
    let tree = city(&vec![b; 1_000_000])?;
    let ranges = settings([(b.distance(stand.eye), 2.0, 3), (at.scale, 1.0, 1)]);
    Ok(examine(&tree, &stand.camera, &ranges)?)
}

/// Trees from boxes in any order, built and asked by one thread and by two, are one tree and give
/// one answer.
fn threads_and_order() -> Result<Tally, ReportError> {
    let mut tally = Tally::default();
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    for (round, kind) in Kind::ALL.into_iter().enumerate() {
        let at = MAGNITUDES[round % MAGNITUDES.len()];
        let stand = Stand::random(&mut rng, kind, at);
        let boxes: Vec<Aabb> = (0..700).map(|_| stand.aabb(&mut rng)).collect();
        let lod = settings([(stand.far_dist(&mut rng), 2.0, 3)]);
        let view = stand.camera.view()?;
        let answer = |threads: usize, turned: usize| -> Result<_, ReportError> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let ask = || {
                let tree = super::city_turned(&boxes, turned)?;
                let mut selection = Selection::default();
                let mut answer = Vec::new();
                for lod in &lod {
                    retrieve(&tree, &view, lod, &mut selection);
                    answer.push((selection.ranges().to_vec(), selection.error_px().to_bits()));
                }
                Ok((tree.revision(), answer))
            };
            // Without threads of one's own the same is asked of those there are.
            match pool {
                Ok(pool) => pool.install(ask),
                Err(_) => ask(),
            }
        };
        let one = answer(1, 0)?;
        tally.cases += boxes.len() as u64;
        for (threads, turned) in [(1, 0), (2, 0), (1, 350), (2, 13)] {
            tally.mismatches += u64::from(answer(threads, turned)? != one);
        }
    }
    Ok(tally)
}
