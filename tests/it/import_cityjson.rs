use std::collections::BTreeMap;
use std::fmt::Write as _;

use citylod::import::{ImportError, Options, Place};

use crate::written::{
    assert_malformed, assert_warnings, damage, fixture, import_content, import_one, real, summary,
};

const BOX: [f64; 6] = [1000.0, 2000.0, 3.0, 1010.0, 2020.0, 8.0];

fn pointer(text: &str) -> Place {
    Place::Pointer(text.into())
}

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
        (Some("3"), vec![], vec!["both", "one"]),
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
    assert_eq!(ids, ["twice", "twice", "千代田/東~\"京\"", ""]);
    assert_warnings(
        &imported,
        &[(
            "千代田/東~\"京\"",
            "/CityObjects/千代田~1東~0\"京\"/geometry/0",
            "1 of its vertex indices out of range, the first 99, with 8 vertices",
        )],
    );
    let long = "長".repeat(10_000);
    let text = solid().replace("b1", &long);
    let imported = import_content("long.city.json", text.as_bytes()).unwrap();
    assert_eq!(imported.scene.objects[0].id, long);
}

fn solid() -> String {
    std::fs::read_to_string(fixture("cityjson/solid.city.json")).unwrap()
}

#[test]
fn unusable_documents_are_refused_at_their_place() {
    let transform = r#""transform":{"scale":[0.001,0.001,0.001],"translate":[1000,2000,3]},"#;
    let deep = format!("{}1{}", "[".repeat(1000), "]".repeat(1000));
    let line = Place::Line;
    for (from, to, place, words) in [
        (
            "\"CityJSON\"",
            "\"FeatureCollection\"",
            pointer("/type"),
            "expected \"CityJSON\"",
        ),
        ("\"CityJSON\"", "7", line(1, 9), "expected"),
        (transform, "", pointer("/transform"), "is missing"),
        (
            "[1000,2000,3]",
            "[1000,2000]",
            pointer("/transform"),
            "invalid length 2",
        ),
        (
            "[1000,2000,3]",
            "[1000,2000,1e999]",
            pointer("/transform"),
            "out of range",
        ),
        (
            "[1000,2000,3]",
            "[1000,2000,NaN]",
            line(1, 100),
            "expected value",
        ),
        ("[0.001,", "[0,", pointer("/transform/scale"), "zero"),
        (
            "\"CityObjects\":",
            "\"Objects\":",
            pointer("/CityObjects"),
            "is missing",
        ),
        (
            "\"CityObjects\":{",
            "\"CityObjects\":3,\"x\":{",
            line(3, 15),
            "expected an object",
        ),
        (
            "\"vertices\":",
            "\"points\":",
            pointer("/vertices"),
            "is missing",
        ),
        (
            "[10000,0,0]",
            "[10000,0]",
            pointer("/vertices/1"),
            "three numbers",
        ),
        (
            "[10000,0,0]",
            "[10000,0,0,0]",
            pointer("/vertices/1"),
            "three numbers",
        ),
        (
            "[10000,0,0]",
            "null",
            pointer("/vertices/1"),
            "three numbers",
        ),
        (
            "[10000,0,0]",
            "[10000,0,inf]",
            line(5, 30),
            "expected value",
        ),
        (
            "[10000,0,0]",
            deep.as_str(),
            pointer("/vertices/1"),
            "three numbers",
        ),
        ("[[0,0,0],", "{\"a\":[],\"b\":[", line(5, 26), "expected"),
        ("]}]}},", "]}]}", line(5, 0), ""),
    ] {
        let text = solid().replace(from, to);
        assert_ne!(text, solid(), "{from}");
        if words.is_empty() || matches!(place, Place::Line(5, 26)) {
            // Where a bracket is missing the end of the value is a guess; that it is refused is not.
            let refused = import_content("x.city.json", text.as_bytes());
            assert!(
                matches!(refused, Err(ImportError::Malformed { .. })),
                "{to}"
            );
        } else {
            assert_malformed("x.city.json", &text, &place, words);
        }
    }
}

#[test]
fn what_is_no_cityjson_is_refused() {
    let line = Place::Line;
    for (text, place, words) in [
        ("", line(1, 1), "empty"),
        (" \n\n ", line(3, 2), "empty"),
        ("<CityModel/>", line(1, 1), "expected a CityJSON object"),
        ("[1]", line(1, 1), "expected a CityJSON object"),
        ("{}", pointer("/type"), "expected \"CityJSON\""),
        ("{\"type\":\n\"CityJSON\",", line(2, 12), "cut off"),
    ] {
        assert_malformed("x.city.json", text, &place, words);
    }
}

#[test]
fn other_versions_are_refused() {
    for version in ["\"0.9\"", "\"3.0\"", "\"2\"", "\"\""] {
        let text = solid().replace("\"2.0\"", version);
        let refused = import_content("x.city.json", text.as_bytes());
        assert!(
            matches!(refused, Err(ImportError::Unsupported { .. })),
            "{version}"
        );
    }
}

#[test]
fn a_bad_feature_is_found_in_its_line() {
    let text = std::fs::read_to_string(fixture("cityjson/sequence.city.jsonl")).unwrap();
    let name = "x.city.jsonl";
    let cut = &text[..text.len() - 20];
    let end = cut.lines().last().unwrap().len() + 1;
    assert_malformed(name, cut, &Place::Line(4, end), "cut off");
    let broken = text.replace("\"Bridge\"", "Bridge");
    let at = broken.lines().nth(3).unwrap().find(":Bridge").unwrap() + 2;
    assert_malformed(name, &broken, &Place::Line(4, at), "expected value");
    let broken = text.replace("[5000,0,0]", "[5000,0,\"0\"]");
    assert_malformed(name, &broken, &pointer("/vertices/0"), "feature on line 4");
    let foreign = text.replace(
        "CityJSONFeature\",\"id\":\"second",
        "Feature\",\"id\":\"second",
    );
    let imported = import_content(name, foreign.as_bytes()).unwrap();
    assert_warnings(
        &imported,
        &[("", "line 4, column 1", "expected \"CityJSONFeature\"")],
    );
}

#[test]
fn bad_geometry_is_a_warning() {
    let deep = format!("{}0{}", "[".repeat(200_000), "]".repeat(200_000));
    let place = "/CityObjects/b1/geometry/0";
    let whole = "/CityObjects/b1";
    let none = "not one of its vertices";
    for (from, to, expected) in [
        (
            "[[0,3,2,1]]",
            "[[0,3,2,8]]",
            vec![(place, "out of range, the first 8")],
        ),
        (
            "[[0,3,2,1]]",
            "[[0,3,2,-1]]",
            vec![(place, "out of range, the first -1")],
        ),
        (
            "[[0,3,2,1]]",
            "[[0,3,2,4294967296]]",
            vec![(place, "the first 4294967296")],
        ),
        (
            "[[0,3,2,1]]",
            "[[0,3,2,1e999]]",
            vec![(place, "the first inf")],
        ),
        (
            "[[0,3,2,1]]",
            deep.as_str(),
            vec![(place, "not 4 arrays"), (whole, none)],
        ),
        (
            "[[0,3,2,1]]",
            "\"all\"",
            vec![(place, "not 4 arrays"), (whole, none)],
        ),
        (
            "\"Solid\"",
            "\"Sphere\"",
            vec![(place, "no type of geometry"), (whole, none)],
        ),
        (
            "\"Solid\"",
            "[]",
            vec![(place, "expected"), (whole, "has geometry")],
        ),
        (
            "\"boundaries\"",
            "\"limits\"",
            vec![(place, "no boundaries"), (whole, none)],
        ),
        (
            "\"geometry\":[",
            "\"geometry\":3,\"x\":[",
            vec![
                (whole, "nothing of it can be read"),
                (whole, "no type"),
                (whole, "has geometry"),
            ],
        ),
        (
            "[10000,0,0]",
            "[1e308,1e999,0]",
            vec![(whole, "1 vertices not finite")],
        ),
        (
            "\"type\":\"Building\",",
            "",
            vec![(whole, "no type; taken as GenericCityObject")],
        ),
    ] {
        let text = solid().replace(from, to);
        assert_ne!(text, solid(), "{from}");
        let imported = import_content("x.city.json", text.as_bytes()).unwrap();
        let expected: Vec<_> = expected.iter().map(|(p, w)| ("b1", *p, *w)).collect();
        assert_warnings(&imported, &expected);
        let lost = expected
            .iter()
            .any(|(_, _, w)| *w == none || *w == "has geometry");
        assert_eq!(imported.scene.objects.len(), usize::from(!lost), "{to:.80}");
    }
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
fn damaged_files_never_panic() {
    for name in [
        "types.city.json",
        "parts.city.json",
        "templates.city.json",
        "sequence.city.jsonl",
        "names.city.json",
    ] {
        damage(&fixture(&format!("cityjson/{name}")), 1500);
    }
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
