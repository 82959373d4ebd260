use citylod::import::{Classes, ImportError, Imported, Options, import};

use crate::desk::Desk;
use crate::written::{fixture, import_one, real};

/// One `PlantCover`, one Road, two `LandUse` and three Building.
const TYPES: &str = "cityjson/types.city.json";

fn types(classes: Classes) -> Result<Imported, ImportError> {
    let options = Options {
        classes,
        ..Options::default()
    };
    import_one(&fixture(TYPES), &options)
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(ToString::to_string).collect()
}

fn ids(imported: &Imported) -> Vec<&str> {
    let objects = imported.scene.objects.iter();
    objects.map(|object| object.id.as_str()).collect()
}

#[test]
fn classes_are_chosen_or_left_out() {
    let all = [
        "points",
        "lines",
        "surfaces",
        "composite",
        "solid",
        "solids",
        "composite solids",
    ];
    for (classes, expected) in [
        (Classes::All, &all[..]),
        (Classes::Only(names(&["Building"])), &all[4..]),
        (Classes::Only(names(&["Road", "LandUse"])), &all[1..4]),
        (Classes::Except(names(&["Building"])), &all[..4]),
        (
            Classes::Except(names(&["PlantCover", "Road", "LandUse"])),
            &all[4..],
        ),
        (
            Classes::Except(names(&["PlantCover", "Road", "LandUse", "Building"])),
            &[],
        ),
    ] {
        assert_eq!(
            ids(&types(classes.clone()).unwrap()),
            expected,
            "{classes:?}"
        );
    }
}

#[test]
fn a_class_that_there_is_not_is_refused_with_those_there_are() {
    for classes in [
        Classes::Only(names(&["Building", "building"])),
        Classes::Except(names(&["building"])),
    ] {
        let error = types(classes).unwrap_err().to_string();
        assert_eq!(
            error,
            "no object is of the class \"building\"; the classes of the files are Building, \
             LandUse, PlantCover, Road"
        );
    }
    // Where there is no object there is no class to name.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none.geojson");
    std::fs::write(&path, r#"{"type":"FeatureCollection","features":[]}"#).unwrap();
    let options = Options {
        classes: Classes::Only(names(&["Building"])),
        ..Options::default()
    };
    assert_eq!(ids(&import_one(&path, &options).unwrap()), [""; 0]);
}

/// A class counts that occurs in any of the files; objects that are left out lie nowhere and are
/// not complained of.
#[test]
fn what_is_left_out_is_not_told_of() {
    let folder = tempfile::tempdir().unwrap();
    let square = |x: f64| {
        let far = x + 9.0;
        format!("[[{x},0],[{far},0],[{far},9]]") // not closed
    };
    let files = [("a", "House", 0.0), ("b", "Slab", 5e6)].map(|(id, class, x)| {
        let path = folder.path().join(format!("{id}.geojson"));
        let text = format!(
            r#"{{"type":"Feature","id":"{id}","properties":{{"height":3,"class":"{class}"}},"geometry":{{"type":"Polygon","coordinates":[{}]}}}}"#,
            square(x + 1000.0)
        );
        std::fs::write(&path, text).unwrap();
        path
    });
    let take = |classes| {
        let options = Options {
            classes,
            ..Options::default()
        };
        import(&files, &options, &|_, _| {})
    };
    assert!(matches!(
        take(Classes::All),
        Err(ImportError::FarApart { .. })
    ));
    for classes in [
        Classes::Only(names(&["House"])),
        Classes::Except(names(&["Slab"])),
    ] {
        let imported = take(classes).unwrap();
        assert_eq!(ids(&imported), ["a"]);
        let told: Vec<_> = imported
            .warnings
            .iter()
            .map(|w| w.object.as_deref())
            .collect();
        assert_eq!(told, [None, Some("a")], "metres, and not closed");
    }
}

#[test]
fn classes_are_typed_once_or_several_times() {
    let desk = Desk::new();
    let classes = |options: &str| {
        let objects = desk.imported(&[TYPES], options);
        let mut classes: Vec<String> = objects
            .iter()
            .map(|object| object["class"].as_str().unwrap().to_owned())
            .collect();
        classes.sort();
        classes.dedup();
        classes
    };
    assert_eq!(classes("--class Road --class LandUse"), ["LandUse", "Road"]);
    assert_eq!(
        classes("--except-class LandUse --except-class Building"),
        ["PlantCover", "Road"]
    );
    std::fs::copy(fixture(TYPES), desk.path("types.city.json")).unwrap();
    let import = "import types.city.json -o a.citylod";
    desk.refuses(
        &format!("{import} --class Tower"),
        1,
        &["Tower", "PlantCover, Road"],
    );
    desk.refuses(
        &format!("{import} --class Road --except-class LandUse"),
        2,
        &["--class", "--except-class"],
    );
    let none = "--except-class Road --except-class LandUse --except-class Building --except-class PlantCover";
    desk.refuses(
        &format!("{import} {none}"),
        1,
        &["no object is left of the classes"],
    );
    desk.refuses(
        "import a.asc --into a.citylod --class Road",
        2,
        &["--class", "cannot be used with"],
    );
    assert!(!desk.path("a.citylod").exists());
}

#[test]
fn the_land_use_of_delft_can_be_left_out() {
    let Some(path) = real("cityjson/delft.json") else {
        return;
    };
    let options = Options {
        classes: Classes::Except(names(&["LandUse"])),
        ..Options::default()
    };
    let imported = import_one(&path, &options).unwrap();
    assert_eq!(imported.scene.objects.len(), 570 - 81);
    assert!(imported.scene.objects.iter().all(|o| o.class != "LandUse"));
}
