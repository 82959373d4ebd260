use std::collections::BTreeMap;
use std::fmt::Write as _;

use citylod::import::Options;

use crate::written::{assert_warnings, fixture, import_content, import_one, real, solid, summary};

const BOX: [f64; 6] = [1000.0, 2000.0, 3.0, 1010.0, 2020.0, 8.0];

fn city(name: &str) -> citylod::import::Imported {
    import_one(&fixture(&format!("cityjson/{name}")), &Options::default()).unwrap()
}

#[test]
fn a_solid_becomes_an_object() {
    let imported = city("solid.city.json");
    assert_eq!(summary(&imported), [("b1", "Building", BOX, 12)]);
    assert_eq!(imported.scene.crs.as_deref(), Some("EPSG:6677"));
    let object = &imported.scene.objects[0];
    assert_eq!(object.footprint_area, 200.0);
    assert_eq!(
        object.attributes.as_ref().unwrap().get(),
        r#"{"name":"one"}"#
    );
    assert_warnings(&imported, &[]);
}

#[test]
fn the_order_of_members_does_not_matter() {
    let imported = city("vertices-first.city.json");
    assert_eq!(summary(&imported), [("b1", "Building", BOX, 12)]);
}

#[test]
fn version_1_0_without_transform() {
    let imported = city("version-1.0.city.json");
    let bounds = [0.5, 0.5, 0.0, 2.5, 1.5, 4.0];
    assert_eq!(summary(&imported), [("tree", "+Topiary", bounds, 2)]);
    assert_eq!(imported.scene.crs.as_deref(), Some("EPSG:7415"));
}

#[test]
fn every_type_of_geometry() {
    let imported = city("types.city.json");
    let triangles: Vec<_> = summary(&imported).iter().map(|s| (s.0, s.3)).collect();
    assert_eq!(
        triangles,
        [
            ("points", 0),
            ("lines", 0),
            ("surfaces", 8),
            ("composite", 2),
            ("solid", 12),
            ("solids", 5),
            ("composite solids", 4),
        ]
    );
    assert_warnings(&imported, &[]);
}

#[test]
fn parts_are_folded_into_the_top_most_object() {
    let imported = city("parts.city.json");
    let objects: Vec<_> = summary(&imported).iter().map(|s| (s.0, s.1, s.3)).collect();
    assert_eq!(
        objects,
        [
            ("whole", "Building", 3),
            ("orphan", "BuildingPart", 0),
            ("a", "Building", 0),
            ("b", "Building", 0),
        ]
    );
    let whole = &imported.scene.objects[0];
    assert_eq!(
        whole.bounds.to_array(),
        [1000.0, 2000.0, 3.0, 1010.0, 2020.0, 28.0]
    );
    assert_eq!(
        whole.attributes.as_ref().unwrap().get(),
        r#"{"of":"the whole"}"#
    );
    assert_warnings(
        &imported,
        &[
            (
                "orphan",
                "/CityObjects/orphan/parents",
                "\"gone\" is missing",
            ),
            ("a", "/CityObjects/a/parents", "its own ancestor"),
            ("b", "/CityObjects/b/parents", "its own ancestor"),
            ("block", "/CityObjects/block", "its 1 members are objects"),
            ("empty", "/CityObjects/empty", "has geometry; left out"),
        ],
    );
}

#[test]
fn the_level_asked_for_is_taken() {
    let missing = "it has no geometry of level of detail";
    for (lod, objects, lost) in [
        (None, vec![("both", 4), ("one", 1)], vec![]),
        (Some("1.2"), vec![("both", 2)], vec!["one"]),
        (Some("1"), vec![("both", 0), ("one", 1)], vec![]),
        (Some("2.2"), vec![("both", 4)], vec!["one"]),
    ] {
        let options = Options {
            lod: lod.map(Into::into),
            ..Options::default()
        };
        let imported = import_one(&fixture("cityjson/levels.city.json"), &options).unwrap();
        let found: Vec<_> = summary(&imported).iter().map(|s| (s.0, s.3)).collect();
        assert_eq!(found, objects, "{lod:?}");
        let places: Vec<_> = lost.iter().map(|l| format!("/CityObjects/{l}")).collect();
        let lost: Vec<_> = lost
            .iter()
            .zip(&places)
            .map(|(id, place)| (*id, place.as_str(), missing))
            .collect();
        assert_warnings(&imported, &lost);
    }
}

/// One word about the file, not one about each object.
#[test]
fn a_level_that_no_object_has_is_told_once() {
    let options = Options {
        lod: Some("abc".into()),
        ..Options::default()
    };
    let imported = import_one(&fixture("cityjson/levels.city.json"), &options).unwrap();
    assert!(imported.scene.objects.is_empty());
    let [warning] = imported.warnings.as_slice() else {
        panic!("{:?}", imported.warnings);
    };
    assert_eq!(warning.object, None);
    for word in ["\"abc\"", "all 2 left out", "1.2", "2.2"] {
        assert!(warning.what.contains(word), "{word}: {}", warning.what);
    }
}

#[test]
fn templates_are_placed() {
    let imported = city("templates.city.json");
    let bounds = [1100.0, 2200.0, 10.0, 1100.0, 2203.0, 12.0];
    assert_eq!(
        summary(&imported),
        [("tree", "SolitaryVegetationObject", bounds, 1)]
    );
    let place = "/CityObjects/stump";
    let geometry = format!("{place}/geometry/0");
    assert_warnings(
        &imported,
        &[
            ("stump", &geometry, "template 9 is missing; there are 1"),
            ("stump", place, "not one of its vertices"),
        ],
    );
}

#[test]
fn a_sequence_is_read_line_by_line() {
    let imported = city("sequence.city.jsonl");
    assert_eq!(
        summary(&imported),
        [
            (
                "first",
                "Building",
                [1000.0, 2000.0, 3.0, 1001.0, 2001.0, 4.0],
                0
            ),
            (
                "second",
                "Bridge",
                [1005.0, 2000.0, 3.0, 1006.0, 2001.0, 4.0],
                0
            ),
        ]
    );
}

#[test]
fn names_of_any_kind_survive() {
    let imported = city("names.city.json");
    let ids: Vec<_> = summary(&imported).iter().map(|s| s.0).collect();
    assert_eq!(ids, ["", "twice", "twice~2", "千代田/東~\"京\""]);
    assert_warnings(
        &imported,
        &[
            (
                "千代田/東~\"京\"",
                "/CityObjects/千代田~1東~0\"京\"/geometry/0",
                "1 of its vertex indices out of range, the first 99, with 8 vertices",
            ),
            ("twice", "the file", "imported as \"twice~2\""),
        ],
    );
    let long = "長".repeat(10_000);
    let text = solid().replace("b1", &long);
    let imported = import_content("long.city.json", text.as_bytes()).unwrap();
    assert_eq!(imported.scene.objects[0].id, long);
}

#[test]
fn a_long_line_of_ancestors_is_followed() {
    let count = 100_000;
    let mut text =
        String::from(r#"{"type":"CityJSON","version":"1.0","vertices":[[1,2,3]],"CityObjects":{"#);
    for i in 1..count {
        let _ = write!(
            text,
            r#""{i}":{{"type":"BuildingPart","parents":["{}"]}},"#,
            i - 1
        );
    }
    text +=
        r#""0":{"type":"Building","geometry":[{"type":"MultiPoint","lod":1,"boundaries":[0]}]}}}"#;
    let imported = import_content("x.city.json", text.as_bytes()).unwrap();
    assert_eq!(
        summary(&imported),
        [("0", "Building", [1.0, 2.0, 3.0, 1.0, 2.0, 3.0], 0)]
    );
    assert_warnings(&imported, &[]);
}

#[test]
fn a_gzipped_file_is_unpacked() {
    use std::io::Write as _;
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(solid().as_bytes()).unwrap();
    let packed = packer.finish().unwrap();
    let imported = import_content("x.city.json.gz", &packed).unwrap();
    assert_eq!(summary(&imported), [("b1", "Building", BOX, 12)]);
    let cut = import_content("x.city.json.gz", &packed[..packed.len() / 2]);
    assert!(cut.is_err());
}

#[test]
fn real_cities_have_their_objects() {
    for (name, crs, counts) in [
        (
            "delft.json",
            Some("EPSG:7415"),
            vec![
                ("Bridge", 3),
                ("Building", 160),
                ("GenericCityObject", 54),
                ("LandUse", 81),
                ("PlantCover", 126),
                ("Road", 143),
                ("WaterBody", 3),
            ],
        ),
        (
            "zurich_subset_lod2.json",
            Some("EPSG:2056"),
            vec![("Building", 49)],
        ),
        ("multi_lod.json", None, vec![("Building", 10)]),
        ("rotterdam_subset.json", None, vec![("Building", 16)]),
        ("DH_01_subs.city.json", None, vec![("Building", 4)]),
        (
            "multisurface_with_material.json",
            None,
            vec![("CityFurniture", 1)],
        ),
        ("vienna.city.jsonl", None, vec![("Building", 149)]),
        (
            "geomtemplate.city.jsonl",
            Some("EPSG:7415"),
            vec![("SolitaryVegetationObject", 1)],
        ),
        (
            "railway.city.jsonl",
            None,
            vec![("Bridge", 1), ("CityFurniture", 1)],
        ),
        (
            "tokyo-minato-23951.city.json.gz",
            Some("EPSG:6677"),
            vec![("Building", 23_951)],
        ),
    ] {
        let Some(path) = real(&format!("cityjson/{name}")) else {
            return;
        };
        let imported = import_one(&path, &Options::default()).unwrap();
        let mut found = BTreeMap::new();
        for object in &imported.scene.objects {
            *found.entry(object.class.as_str()).or_insert(0) += 1;
        }
        assert_eq!(found.into_iter().collect::<Vec<_>>(), counts, "{name}");
        assert_eq!(imported.scene.crs.as_deref(), crs, "{name}");
        assert_warnings(&imported, &[]);
    }
}

#[test]
fn real_buildings_have_each_of_their_levels() {
    let Some(path) = real("cityjson/multi_lod.json") else {
        return;
    };
    let triangles = |lod: Option<&str>| -> u32 {
        let options = Options {
            lod: lod.map(Into::into),
            ..Options::default()
        };
        let imported = import_one(&path, &options).unwrap();
        assert_eq!(imported.scene.objects.len(), 10, "{lod:?}");
        imported.scene.objects.iter().map(|o| o.triangles).sum()
    };
    assert_eq!(triangles(None), triangles(Some("2.2")));
    assert_eq!(triangles(Some("1")), triangles(Some("1.3")));
    assert!(triangles(Some("1.2")) < triangles(Some("2.2")));
}
