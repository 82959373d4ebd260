use std::io::Write as _;

use citylod::import::{ImportError, Options, Place};

use crate::written::{
    SQUARE, assert_malformed, assert_warnings, damage, feature, fixture, import_content,
    import_one, solid,
};

fn pointer(text: &str) -> Place {
    Place::Pointer(text.into())
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
        ("{}", pointer("/type"), "expected CityJSON or GeoJSON"),
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
            vec![(whole, "vertices not finite: 1")],
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
fn damaged_cityjson_never_panics() {
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
fn unusable_files_are_refused_at_their_place() {
    let line = Place::Line;
    let whole = feature("{}", &format!("[{SQUARE}]"));
    let half = &whole[..whole.len() / 2];
    for (text, place, words) in [
        ("", line(1, 1), "empty"),
        ("\n \n", line(3, 1), "empty"),
        ("kml", line(1, 1), "expected a GeoJSON object"),
        ("[]", line(1, 1), "expected a GeoJSON object"),
        ("{}", line(1, 1), "\"\" is no type of GeoJSON"),
        (
            "{\"type\":\"Topology\"}",
            line(1, 1),
            "\"Topology\" is no type",
        ),
        (
            "{\"type\":\"FeatureCollection\"}",
            line(1, 1),
            "without an array of `features`",
        ),
        (
            "{\"type\":\"FeatureCollection\",\"features\":{}}",
            line(1, 1),
            "without an array",
        ),
        ("{\"features\":[\n{},\n]}", line(2, 3), "trailing comma"),
        (
            "{\"features\":[\n{} {}]}",
            line(2, 4),
            "expected `,` or `]`",
        ),
        ("{\"features\":[\n{}\n", line(3, 1), "cut off"),
        (
            "{\"features\":[] \"a\":1}",
            line(1, 16),
            "expected `,` or `}`",
        ),
        ("{\"features\" []}", line(1, 13), "expected `:`"),
        ("{features:[]}", line(1, 2), "a member name in quotes"),
        (
            "{\"features\":[{\"a\":\nNaN}]}",
            line(2, 1),
            "expected value",
        ),
        ("{\"features\":[{\"a\":\n[1,2}]}", line(2, 5), "expected"),
        (
            "{\"features\":[]}x",
            line(1, 16),
            "expected a GeoJSON object",
        ),
        (
            "{\"features\":[{\"a\":\"\\x\"}]}",
            line(1, 21),
            "invalid escape",
        ),
        (
            "{\"features\":[{\"a\":\"\u{1}\"}]}",
            line(1, 19),
            "control character",
        ),
        (half, line(1, half.len() + 1), "cut off"),
    ] {
        assert_malformed("x.geojson", text, &place, words);
    }
    let refused = import_content("x.geojson", b"{\"features\":[\n{\"a\":\"\xff\"}]}");
    let Err(ImportError::Malformed { place, reason, .. }) = refused else {
        panic!("{refused:?}");
    };
    assert_eq!((place, reason.contains("UTF-8")), (line(2, 7), true));
}

#[test]
fn deep_nesting_does_not_overflow_the_stack() {
    let deep = format!("{}{}", "[".repeat(500_000), "]".repeat(500_000));
    let imported = import_content("x.geojson", feature("{}", &deep).as_bytes()).unwrap();
    assert_warnings(
        &imported,
        &[("f", "line 1, column 1", "not those of a Polygon")],
    );
    let mut nested = String::from(r#"{"type":"Point","coordinates":[]}"#);
    for _ in 0..5000 {
        nested = format!(r#"{{"type":"GeometryCollection","geometries":[{nested}]}}"#);
    }
    let refused = import_content("x.geojson", nested.as_bytes());
    assert!(
        matches!(refused, Err(ImportError::Malformed { .. })),
        "{refused:?}"
    );
}

#[test]
fn an_absurdly_large_feature_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.geojson.gz");
    let file = std::fs::File::create(&path).unwrap();
    let mut packer = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
    packer.write_all(b"{\"features\":[{\"type\":\"").unwrap();
    let megabyte = vec![b'x'; 1 << 20];
    for _ in 0..300 {
        packer.write_all(&megabyte).unwrap();
    }
    packer.write_all(b"\"}]}").unwrap();
    packer.finish().unwrap();
    let refused = import_one(&path, &Options::default());
    let Err(ImportError::Malformed { place, reason, .. }) = refused else {
        panic!("{refused:?}");
    };
    assert_eq!(place, Place::Line(1, 14));
    assert!(reason.contains("more than 268435456 bytes"), "{reason}");
}

#[test]
fn damaged_geojson_never_panics() {
    for name in [
        "collection.geojson",
        "metres.geojson",
        "records.geojsons",
        "lines.geojsonl",
        "doubtful.geojson",
    ] {
        damage(&fixture(&format!("geojson/{name}")), 1500);
    }
}
