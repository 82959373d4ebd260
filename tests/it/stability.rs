use citylod::experiment::exact::{Answer, Camera, Dyadic, Enclosure, Oracle, compare_distance};
use citylod::experiment::stability::{adversarial, random};
use citylod::geom::{Aabb, DVec3, DepthRange, Orientation, Projection};
use std::cmp::Ordering;

/// Every hard case keeps every promise.
#[test]
fn hard_cases_are_stable() {
    const LEAST: u64 = 100_000;
    let mut cases = 0;
    let tallies = adversarial().unwrap();
    let broken: Vec<_> = tallies.iter().filter(|(_, t)| !t.is_clean()).collect();
    assert!(broken.is_empty(), "{broken:#?}");
    for (name, tally) in &tallies {
        assert!(tally.cases > 0, "{name} asks nothing");
        if !name.contains("million") {
            cases += tally.cases;
        }
    }
    assert!(cases >= LEAST, "{cases} adversarial cases");
}

/// A first part of what the experiment goes through.
#[test]
fn random_cases_are_stable() {
    let tally = random(100_000, &|_| {}).unwrap();
    assert!(tally.is_clean(), "{tally:?}");
    assert!(
        tally.cases >= 100_000 && tally.meeting > 20_000 && tally.inside > 1_000,
        "{tally:?}"
    );
    assert!(tally.kept_outside > 100, "{tally:?}");
}

/// Looks along x from the origin through a square pyramid of 90°, from 1 m on.
fn pyramid(far: Option<f64>) -> Oracle {
    Oracle::new(&Camera::Posed {
        eye: DVec3::ZERO,
        orientation: Orientation::LookAt {
            target: DVec3::X * 3.0,
            up: DVec3::Z * 7.0,
        },
        projection: Projection::Perspective { fov_y_deg: 90.0 },
        depth: DepthRange { near: 1.0, far },
        viewport: [640, 640],
    })
}

fn aabb(min: [f64; 3], max: [f64; 3]) -> Aabb {
    Aabb::new(min.into(), max.into()).unwrap()
}

/// The oracle knows what can be seen with the naked eye, touching included.
#[test]
fn the_oracle_decides_what_is_plain() {
    use Answer::{No, Yes};
    let open = pyramid(None);
    let closed = pyramid(Some(4.0));
    let after = 1.0 + f64::EPSILON;
    let cases = [
        // A point on the near plane, and just before it.
        ([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], Yes, Yes),
        ([0.5, 0.0, 0.0], [1.0_f64.next_down(), 0.0, 0.0], No, No),
        // On a side plane, and just beyond; on an edge of the pyramid.
        ([3.0, 3.0, 0.0], [3.0, 3.0, 0.0], Yes, Yes),
        ([3.0, 3.0 * after, 0.0], [3.0, 9.0, 0.0], No, No),
        ([2.0, 2.0, -2.0], [2.0, 2.0, 2.0], Yes, Yes),
        ([2.0, 2.0, 2.0], [2.0, 3.0, 3.0], Yes, No),
        ([2.0, 2.0, 2.0 * after], [2.0, 3.0, 3.0], No, No),
        // Around everything, and without a corner inside.
        ([-9.0, -9.0, -9.0], [99.0, 99.0, 99.0], Yes, No),
        ([2.0, -9.0, -0.5], [3.0, 9.0, 0.5], Yes, No),
        ([-9.0, -9.0, -9.0], [0.0, 9.0, 9.0], No, No),
    ];
    for (min, max, meets, inside) in cases {
        let b = aabb(min, max);
        for oracle in [&open, &closed] {
            assert_eq!(oracle.relation(&b), [meets, inside], "{b:?}");
            assert_eq!(oracle.meets_exactly(&b), meets, "{b:?}");
            assert_eq!(oracle.contains_exactly(&b), inside, "{b:?}");
        }
    }
    let beyond = aabb([4.0_f64.next_up(), 0.0, 0.0], [5.0, 0.0, 0.0]);
    assert_eq!(open.meets(&beyond), Yes);
    assert_eq!(closed.meets(&beyond), No);
    // Beyond none of the planes: an edge that passes by a corner of the near face, x + y < 2
    // there, and the pyramid's y ≤ x with x ≥ 1.
    let steep = Oracle::new(&Camera::Posed {
        eye: DVec3::ZERO,
        orientation: Orientation::LookAt {
            target: DVec3::new(1.0, 1.0, 0.0),
            up: DVec3::Z,
        },
        projection: Projection::OffAxis {
            left: -1.0,
            right: 1.0,
            bottom: -1.0,
            top: 1.0,
        },
        depth: DepthRange {
            near: 2.0_f64.sqrt() * 5.0,
            far: None,
        },
        viewport: [640, 640],
    });
    // In plan the frustum is the quarter x, y ≥ 0 beyond x + y = 10.
    let passing = aabb([-9.0, 4.0, 0.0], [0.0_f64.next_down(), 99.0, 1.0]);
    assert_eq!(steep.meets(&passing), No);
    let touching = aabb([-9.0, 11.0, 0.0], [0.0, 99.0, 1.0]);
    assert_eq!(steep.meets(&touching), Yes);
}

/// Roots and tangents lie between their bounds, and these lie close.
#[test]
fn enclosures_enclose() {
    for x in [2.0, 3.0, 1e-300, 5e-324, 1e300, 0.1, 12345.678] {
        let square = Dyadic::from(x);
        for bits in [60, 128, 700] {
            let root = Enclosure::sqrt(&square, bits);
            assert!(&root.low * &root.low <= square && square <= &root.high * &root.high);
            let width = &root.high - &root.low;
            assert!(
                width.shifted(i64::from(bits) - 2) < root.high,
                "{x} to {bits} bits"
            );
        }
    }
    let exact = Enclosure::sqrt(&(&Dyadic::from(0.375) * &Dyadic::from(0.375)), 64);
    assert!(exact.is_exact() && exact.low == Dyadic::from(0.375));
    assert!(Enclosure::tan_half_degrees(90.0, 64).is_exact());
    // tan 30° = 1/√3, tan 22.5° = √2 − 1, tan 15° = 2 − √3.
    let three = Enclosure::tan_half_degrees(60.0, 300);
    let square = |x: &Dyadic| &(x * x) * &Dyadic::from(3);
    assert!(square(&three.low) < Dyadic::from(1) && Dyadic::from(1) < square(&three.high));
    let eighth = Enclosure::tan_half_degrees(45.0, 300);
    let square = |x: &Dyadic| &(x + &Dyadic::from(1)) * &(x + &Dyadic::from(1));
    assert!(square(&eighth.low) < Dyadic::from(2) && Dyadic::from(2) < square(&eighth.high));
    for degrees in [1e-300, 0.01, 1.0, 75.5, 179.9, 180.0_f64.next_down()] {
        let [wide, close] = [64, 512].map(|bits| Enclosure::tan_half_degrees(degrees, bits));
        assert!(wide.low <= close.low && close.low < close.high && close.high <= wide.high);
        let width = &wide.high - &wide.low;
        assert!(width.shifted(60) < wide.high, "{degrees}");
        let tangent = (degrees.to_radians() / 2.0).tan();
        let ratio = wide.low.floor_f64() / tangent;
        // π itself is rounded in f64, which shows next to 180°.
        assert!(
            (ratio - 1.0).abs() < if degrees > 179.99 { 1.0 } else { 1e-12 },
            "{degrees}"
        );
    }
}

/// Numbers go to f64 and back, rounded towards the side asked for.
#[test]
fn dyadic_numbers_round_outward() {
    for x in [
        0.0,
        1.0,
        -0.1,
        5e-324,
        -5e-324,
        f64::MIN_POSITIVE,
        f64::MAX,
        -1e300,
        1e-310,
    ] {
        let exact = Dyadic::from(x);
        assert_eq!((exact.floor_f64(), exact.ceil_f64()), (x, x));
        let above = &exact + &Dyadic::from(1).shifted(-1200);
        assert_eq!((above.floor_f64(), above.ceil_f64()), (x, x.next_up()));
        let below = &exact - &Dyadic::from(1).shifted(-1200);
        assert_eq!((below.floor_f64(), below.ceil_f64()), (x.next_down(), x));
    }
    let huge = Dyadic::from(1).shifted(1024);
    assert_eq!(
        (huge.floor_f64(), huge.ceil_f64()),
        (f64::MAX, f64::INFINITY)
    );
}

/// Distances are compared as real numbers.
#[test]
fn distances_compare_exactly() {
    let b = aabb([3.0, 4.0, 12.0], [5.0, 5.0, 15.0]);
    let order = |distance| compare_distance(&b, DVec3::ZERO, distance);
    assert_eq!(order(13.0), Ordering::Equal);
    assert_eq!(order(13.0_f64.next_up()), Ordering::Less);
    assert_eq!(order(13.0_f64.next_down()), Ordering::Greater);
    assert_eq!(order(f64::INFINITY), Ordering::Less);
    let tiny = aabb([1e-200, 0.0, 0.0], [1.0, 1.0, 1.0]);
    assert_eq!(
        compare_distance(&tiny, DVec3::ZERO, 1e-201),
        Ordering::Greater
    );
    assert_eq!(
        compare_distance(&tiny, DVec3::splat(1e-200), 0.0),
        Ordering::Equal
    );
}
