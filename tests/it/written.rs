use std::io::Write as _;
use std::path::{Path, PathBuf};

use citylod::import::{ImportError, Imported, Options, Place, import};

pub fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures")
        .join(name)
}

/// The text of a `CityJSON` document with one building, `b1`.
pub fn solid() -> String {
    std::fs::read_to_string(fixture("cityjson/solid.city.json")).unwrap()
}

/// A footprint of 10 m × 10 m.
pub const SQUARE: &str = "[[1000,0],[1010,0],[1010,10],[1000,10],[1000,0]]";

/// A feature `f` with a polygon.
pub fn feature(properties: &str, coordinates: &str) -> String {
    format!(
        r#"{{"type":"Feature","id":"f","properties":{properties},"geometry":{{"type":"Polygon","coordinates":{coordinates}}}}}"#
    )
}

/// A file of the real cities, if they are at hand.
pub fn real(name: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("CITYLOD_DATA") else {
        // Not by `eprintln!`, which the test harness keeps to itself.
        let _ = writeln!(std::io::stderr(), "skipped: CITYLOD_DATA is not set");
        return None;
    };
    Some(Path::new(&folder).join(name))
}

pub fn import_one(path: &Path, options: &Options) -> Result<Imported, ImportError> {
    import(&[path.to_owned()], options, &|_, _| {})
}

/// Imports `content` as a file of this name.
pub fn import_content(name: &str, content: &[u8]) -> Result<Imported, ImportError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    import_one(&path, &Options::default())
}

/// Id, class, bounds and triangles of each object.
pub fn summary(imported: &Imported) -> Vec<(&str, &str, [f64; 6], u32)> {
    let objects = imported.scene.objects.iter();
    objects
        .map(|o| {
            (
                o.id.as_str(),
                o.class.as_str(),
                o.bounds.to_array(),
                o.triangles,
            )
        })
        .collect()
}

/// Object, place and text of each warning.
pub fn warnings(imported: &Imported) -> Vec<(String, String, String)> {
    let warnings = imported.warnings.iter();
    warnings
        .map(|w| {
            let object = w.object.as_deref().unwrap_or_default().to_owned();
            (object, w.place.to_string(), w.what.clone())
        })
        .collect()
}

/// Asserts that the warnings are about these objects and places and contain these words.
pub fn assert_warnings(imported: &Imported, expected: &[(&str, &str, &str)]) {
    let found = warnings(imported);
    let matches = |(f, e): (&(String, String, String), &(&str, &str, &str))| {
        f.0 == e.0 && f.1 == e.1 && f.2.contains(e.2)
    };
    assert!(
        found.len() == expected.len() && found.iter().zip(expected).all(matches),
        "found {found:#?}\nexpected {expected:#?}"
    );
}

/// Asserts that the file is refused at this place with these words.
pub fn assert_malformed(name: &str, content: &str, place: &Place, words: &str) {
    match import_content(name, content.as_bytes()) {
        Err(ImportError::Malformed {
            place: found,
            reason,
            ..
        }) => {
            assert_eq!(&found, place, "{content:.80}: {reason}");
            assert!(reason.contains(words), "{content:.80}: {reason}");
        }
        other => panic!("{content:.80}: expected an error at {place}, found {other:?}"),
    }
}

/// Bytes that mean something in JSON, or must not be in it.
const TELLING: &[u8] = b"[]{}\",:\\0-9.eEnN \n\x00\xff\x1e";

/// Imports a file over and over, cut off or with single bytes changed; nothing may panic.
pub fn damage(path: &Path, rounds: u32) {
    let whole = std::fs::read(path).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join(path.file_name().unwrap());
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for round in 0..rounds {
        let mut content = whole.clone();
        if round % 3 == 0 {
            content.truncate(random(whole.len()));
        } else {
            for _ in 0..=random(3) {
                let at = random(content.len());
                content[at] = TELLING[random(TELLING.len())];
            }
        }
        std::fs::write(&copy, &content).unwrap();
        match import_one(&copy, &Options::default()) {
            Ok(imported) => {
                for object in &imported.scene.objects {
                    assert!(object.bounds.min().is_finite() && object.bounds.max().is_finite());
                    assert!(object.footprint_area >= 0.0);
                }
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}
