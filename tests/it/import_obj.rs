use std::path::{Path, PathBuf};

use citylod::import::{ImportError, Imported, Options, Place, Up, import};
use geo::{Area, ConvexHull, MultiPoint, Point};
use proptest::prelude::*;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures/obj")
        .join(name)
}

fn read(name: &str) -> Imported {
    import(&[fixture(name)], &Options::default(), &|_, _| {}).unwrap()
}

fn open(text: &[u8]) -> Result<Imported, ImportError> {
    open_in(tempfile::tempdir().unwrap().path(), "town.obj", text)
}

/// As [`open`], but one file for thousands of cases, which is much faster.
fn open_again(name: &str, text: &[u8]) -> Result<Imported, ImportError> {
    open_in(Path::new(env!("CARGO_TARGET_TMPDIR")), name, text)
}

fn open_in(folder: &Path, name: &str, text: &[u8]) -> Result<Imported, ImportError> {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    import(&[path], &Options::default(), &|_, _| {})
}

fn ids(imported: &Imported) -> Vec<&str> {
    let objects = imported.scene.objects.iter();
    objects.map(|object| object.id.as_str()).collect()
}

#[test]
fn each_o_is_an_object_in_full_precision() {
    let imported = read("objects.obj");
    assert_eq!(ids(&imported), ["Rathaus Süd", "Rathaus Süd~2", "line"]);
    let [second, first, line] = imported.scene.objects.as_slice() else {
        panic!("expected three objects");
    };
    assert_eq!(
        first.bounds.to_array(),
        [
            500_000.123,
            5_200_000.456,
            0.0,
            500_010.123,
            5_200_020.456,
            12.5
        ]
    );
    assert!((first.footprint_area - 200.0).abs() < 1e-6);
    assert_eq!(first.triangles, 3);
    assert_eq!(first.class, "Building");
    assert_eq!(second.bounds.to_array(), [0.0, 0.0, 0.0, 1.0, 2.0, 0.0]);
    assert_eq!((second.footprint_area, second.triangles), (1.0, 2));
    assert_eq!(line.bounds.to_array(), [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    assert_eq!((line.footprint_area, line.triangles), (0.0, 0));
    let warned: Vec<_> = imported
        .warnings
        .iter()
        .map(|w| (w.object.as_deref(), w.place.clone()))
        .collect();
    assert_eq!(
        warned,
        [
            (None, Place::File), // the first lies far from the others
            (Some("only vertices"), Place::Line(13, 1)),
            (Some("Rathaus Süd"), Place::Line(18, 1)),
            (Some("Rathaus Süd"), Place::File), // its id repeats
        ]
    );
}

#[test]
fn each_g_is_an_object_where_no_o_is() {
    let imported = read("groups.obj");
    assert_eq!(ids(&imported), ["wei\u{fffd}es Haus", "object-2"]);
    assert!(imported.warnings.is_empty(), "{:?}", imported.warnings);
    let bounds = |i: usize| imported.scene.objects[i].bounds.to_array();
    assert_eq!(bounds(0), [0.0, 0.0, 0.0, 4.0, 3.0, 0.0]);
    assert_eq!(bounds(1), [0.0, 0.0, 0.0, 4.0, 0.0, 5.0]);
}

#[test]
fn a_file_without_names_is_one_object_named_after_it() {
    assert_eq!(ids(&read("bare.obj")), ["bare"]);
}

#[test]
fn up_y_turns_the_city() {
    let options = Options {
        up: Some(Up::Y),
        ..Options::default()
    };
    let imported = import(&[fixture("bare.obj")], &options, &|_, _| {}).unwrap();
    let bounds = imported.scene.objects[0].bounds.to_array();
    assert_eq!(bounds, [0.0, -2.0, 0.0, 1.0, 0.0, 1.0]);
}

#[test]
fn an_element_may_name_a_vertex_further_down() {
    let imported = open(b"o a\nf 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
    assert_eq!(imported.scene.objects[0].footprint_area, 0.5);
}

#[test]
fn vertices_alone_are_not_lost_silently() {
    let imported = open(b"v 1 2 3\nv 2 2 3\n").unwrap();
    assert!(imported.scene.objects.is_empty());
    assert_eq!(imported.warnings[0].object.as_deref(), Some("town"));
}

#[test]
fn vertices_that_are_not_finite_are_warned_of() {
    let imported = open(b"v nan 0 0\nv 1e999 0 0\nv 0 -inf 0\no lost\nf 1 2 3\n").unwrap();
    assert!(imported.scene.objects.is_empty());
    assert_eq!(imported.warnings[0].object.as_deref(), Some("lost"));
}

#[test]
fn unknown_statements_are_told_once() {
    let imported = open(b"v 0 0 0\ncurv2 1\ncurv2 2\nvt 0 0\np 1\n").unwrap();
    let places: Vec<_> = imported.warnings.iter().map(|w| &w.place).collect();
    assert_eq!(places, [&Place::Line(2, 1)]);
}

#[test]
fn each_defect_is_told_by_line_and_column() {
    let defects: &[(&[u8], Place)] = &[
        (b"", Place::File),
        (b"# nothing\no a\n", Place::File),
        (b"v 1 2", Place::Line(1, 6)),
        (b"v 1 2 # 3", Place::Line(1, 10)),
        (b"\n  v 1 zwei 3\n", Place::Line(2, 7)),
        (b"v 1 \xff 3\n", Place::Line(1, 5)),
        (b"v 0 0 0\r\nv 1 \\\r\n \\\r\n x 3\r\n", Place::Line(4, 2)),
        (b"v 0 0 0\nf 1 1", Place::Line(2, 6)),
        (b"v 0 0 0\nf 1 1 2", Place::Line(2, 7)),
        (b"v 0 0 0\nf 1 1 0", Place::Line(2, 7)),
        (b"v 0 0 0\nf 1 1 -2", Place::Line(2, 7)),
        (b"v 0 0 0\nf 1 1 -0", Place::Line(2, 7)),
        (b"v 0 0 0\nf 1 /2 1", Place::Line(2, 5)),
        (b"v 0 0 0\nf 1 1 99999999999999999999999", Place::Line(2, 7)),
        (b"v 0 0 0\nf 1 1 1.5", Place::Line(2, 7)),
        (b"v 0 0 0\nf -1 -1 -99999999999999999999", Place::Line(2, 9)),
        (b"v 0 0 0\nl 1", Place::Line(2, 4)),
        (b"v 0 0 0\np", Place::Line(2, 2)),
    ];
    for (text, expected) in defects {
        let shown = String::from_utf8_lossy(text);
        match open(text) {
            Err(ImportError::Malformed { place, .. }) => assert_eq!(place, *expected, "{shown:?}"),
            other => panic!("{shown:?} gave {other:?}"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// Flipped bytes and a cut never bring the reader down.
    #[test]
    fn any_mutation_is_read_or_refused(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = include_bytes!("../../fixtures/obj/objects.obj").to_vec();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let _ = open_again("mutated.obj", &bytes);
    }
}

proptest! {
    /// The area is that of the convex hull, whatever repeats or lies on a line.
    #[test]
    fn footprint_is_the_area_of_the_convex_hull(
        points in prop::collection::vec((-40_i32..40, -40_i32..40), 1..60),
    ) {
        let vertices = points.iter().map(|(x, y)| format!("v 3{:05}.125 {}.5 7\n", x + 50, y + 50));
        let elements = (1..=points.len()).map(|i| format!("p {i}\n"));
        let text: String = vertices.chain(elements).collect();
        let imported = open_again("hull.obj", text.as_bytes()).unwrap();
        let points: MultiPoint = points
            .iter()
            .map(|(x, y)| Point::new(f64::from(*x), f64::from(*y)))
            .collect();
        let expected = points.convex_hull().unsigned_area();
        prop_assert!((imported.scene.objects[0].footprint_area - expected).abs() < 1e-9);
    }
}
