use std::path::Path;

use citylod::import::{ImportError, Imported, Options, Place, import};
use proptest::prelude::*;
use serde_json::{Value, json};

/// One triangle: three f32 positions, then three u16 indices and padding.
fn binary() -> Vec<u8> {
    let positions = [0.0_f32, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0, -4.0];
    let mut bytes: Vec<u8> = positions.iter().flat_map(|p| p.to_le_bytes()).collect();
    bytes.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    bytes
}

fn document() -> Value {
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "roof", "mesh": 0, "children": [] }, { "name": "spare" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
              "min": [0, 0, -4], "max": [2, 3, 0] },
            { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 6 },
        ],
        "buffers": [{ "byteLength": 44 }],
    })
}

fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((total as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json.as_slice()), (b"BIN\0", binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

fn whole() -> Vec<u8> {
    glb(document().to_string().as_bytes(), &binary())
}

fn open_in(folder: &Path, name: &str, bytes: &[u8]) -> Result<Imported, ImportError> {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    import(&[path], &Options::default(), &|_, _| {})
}

fn open(name: &str, bytes: &[u8]) -> Result<Imported, ImportError> {
    open_in(tempfile::tempdir().unwrap().path(), name, bytes)
}

/// As [`open`], but one file for thousands of cases, which is much faster.
fn open_again(name: &str, bytes: &[u8]) {
    let _ = open_in(Path::new(env!("CARGO_TARGET_TMPDIR")), name, bytes);
}

fn place_of(result: Result<Imported, ImportError>) -> Place {
    match result {
        Err(ImportError::Malformed { place, .. }) => place,
        other => panic!("expected a malformed file, got {other:?}"),
    }
}

type Break = fn(&mut Value);

/// What is done to the document, and the place that must be named.
const DEFECTS: &[(Break, &str)] = &[
    (|j| j["nodes"][0]["mesh"] = json!(7), "/nodes/0/mesh"),
    (|j| j["nodes"][0]["mesh"] = json!("0"), "/nodes/0/mesh"),
    (|j| j["nodes"][0]["mesh"] = json!(-1), "/nodes/0/mesh"),
    (
        |j| j["nodes"][0]["children"] = json!([1, 5]),
        "/nodes/0/children/1",
    ),
    (
        |j| j["nodes"][0]["children"] = json!([0]),
        "/nodes/0/children/0",
    ),
    (
        |j| j["nodes"][0]["children"] = json!([1, 1]),
        "/nodes/0/children/1",
    ),
    (
        |j| {
            j["nodes"][0]["children"] = json!([1]);
            j["nodes"][1]["children"] = json!([0]);
        },
        "/nodes/1/children/0",
    ),
    (
        |j| {
            j["nodes"][0]["children"] = json!([1]);
            j["scenes"][0]["nodes"] = json!([0, 1]);
        },
        "/scenes/0/nodes/1",
    ),
    (|j| j["nodes"] = json!(5), "/nodes"),
    (
        |j| j["nodes"][0]["matrix"] = json!([1, 2, 3]),
        "/nodes/0/matrix",
    ),
    (
        |j| j["nodes"][0]["translation"] = json!([1, 2, "3"]),
        "/nodes/0/translation/2",
    ),
    (
        |j| j["nodes"][0]["rotation"] = json!([0, 0, 0, 0]),
        "/nodes/0/rotation",
    ),
    (|j| j["scene"] = json!(3), "/scene"),
    (
        |j| j["scenes"][0]["nodes"] = json!([0, 0]),
        "/scenes/0/nodes/1",
    ),
    (
        |j| j["scenes"][0]["nodes"] = json!([99]),
        "/scenes/0/nodes/0",
    ),
    (
        |j| j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9),
        "/meshes/0/primitives/0/attributes/POSITION",
    ),
    (
        |j| j["meshes"][0]["primitives"][0]["indices"] = json!(9),
        "/meshes/0/primitives/0/indices",
    ),
    (
        |j| j["accessors"][0]["type"] = json!("VEC2"),
        "/accessors/0/type",
    ),
    (
        |j| j["accessors"][0]["componentType"] = json!(1),
        "/accessors/0/componentType",
    ),
    (
        |j| j["accessors"][1]["componentType"] = json!(5126),
        "/accessors/1/componentType",
    ),
    (
        |j| j["accessors"][0]["count"] = json!(4),
        "/accessors/0/count",
    ),
    (
        |j| j["accessors"][0]["count"] = json!(u64::MAX),
        "/accessors/0/count",
    ),
    (
        |j| {
            j["accessors"][0] =
                json!({ "componentType": 5126, "type": "VEC3", "count": 1_u64 << 60 });
        },
        "/accessors/0/count",
    ),
    (
        |j| j["accessors"][0]["byteOffset"] = json!(4),
        "/accessors/0/count",
    ),
    (
        |j| j["accessors"][0]["bufferView"] = json!(8),
        "/accessors/0/bufferView",
    ),
    (
        |j| j["bufferViews"][0]["buffer"] = json!(8),
        "/bufferViews/0/buffer",
    ),
    (
        |j| j["bufferViews"][0]["byteLength"] = json!(99),
        "/bufferViews/0/byteLength",
    ),
    (
        |j| j["bufferViews"][0]["byteOffset"] = json!(u64::MAX),
        "/bufferViews/0/byteLength",
    ),
    (
        |j| j["bufferViews"][0]["byteStride"] = json!(4),
        "/bufferViews/0/byteStride",
    ),
    (
        |j| j["buffers"][0]["byteLength"] = json!(1_u64 << 40),
        "/buffers/0/byteLength",
    ),
    // The third index, 2, is one too many for two vertices.
    (|j| j["accessors"][0]["count"] = json!(2), "/accessors/1"),
    (
        |j| {
            j["buffers"] = json!([{ "byteLength": 44, "uri": "gone.bin" }]);
            j["accessors"][0]["min"] = json!([3, 0, -4]);
        },
        "/accessors/0/min",
    ),
    (
        |j| {
            j["buffers"] = json!([{ "byteLength": 44, "uri": "gone.bin" }]);
            j["accessors"][0]["max"] = json!([3, null, -4]);
        },
        "/accessors/0/max",
    ),
    (|j| j["asset"] = json!({}), "/asset"),
];

#[test]
fn each_defect_of_the_document_is_told_by_its_pointer() {
    for (defect, pointer) in DEFECTS {
        let mut json = document();
        defect(&mut json);
        let bytes = glb(json.to_string().as_bytes(), &binary());
        let place = place_of(open("broken.glb", &bytes));
        assert_eq!(place, Place::Pointer((*pointer).to_owned()));
    }
}

#[test]
fn broken_containers_and_texts_are_told_by_their_position() {
    let whole = whole();
    let cut = |length: usize| place_of(open("cut.glb", &whole[..length]));
    assert_eq!(cut(0), Place::Byte(0));
    assert_eq!(cut(6), Place::Byte(6));
    assert_eq!(cut(40), Place::Byte(40));
    assert_eq!(cut(whole.len() - 1), Place::Byte(whole.len() as u64 - 1));
    let mut long_chunk = whole.clone();
    long_chunk[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(place_of(open("a.glb", &long_chunk)), Place::Byte(12));
    let mut not_json = whole;
    not_json[16] = b'X';
    assert_eq!(place_of(open("a.glb", &not_json)), Place::Byte(16));
    let broken = glb(b"{ \"asset\": }", &[]);
    assert_eq!(place_of(open("a.glb", &broken)), Place::Byte(31));
    let broken = b"{ \"asset\":\n  nothing }";
    assert_eq!(place_of(open("a.gltf", broken)), Place::Line(2, 4));
}

/// Far beyond what recursion would stand.
const DEPTH: usize = 100_000;

#[test]
fn deep_nesting_is_refused_as_text_and_walked_as_nodes() {
    let deep = format!("{{\"nodes\":{}", "[".repeat(100_000));
    assert_eq!(
        place_of(open("deep.gltf", deep.as_bytes())),
        Place::Pointer("/nodes/0/0".into())
    );
    let mut json = document();
    let nodes = (0..DEPTH).map(|i| json!({ "children": [i + 1], "translation": [0, 1, 0] }));
    let leaf = json!({ "name": "top", "mesh": 0 });
    json["nodes"] = nodes.chain([leaf]).collect();
    let imported = open("deep.glb", &glb(json.to_string().as_bytes(), &binary())).unwrap();
    assert_eq!(imported.scene.objects[0].bounds.min().z, DEPTH as f64);
}

#[test]
fn buffers_outside_the_folder_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("city");
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(folder.path().join("secret.bin"), binary()).unwrap();
    std::fs::write(inner.join("own.bin"), binary()).unwrap();
    let mut uris = vec![
        "../secret.bin".to_owned(),
        "%2e%2e/secret.bin".to_owned(),
        "x/..%2F../secret.bin".to_owned(),
        "..\\secret.bin".to_owned(),
        "/etc/passwd".to_owned(),
        "%2Fetc/passwd".to_owned(),
        "file:///etc/passwd".to_owned(),
        "file%3A///etc/passwd".to_owned(),
        "http://localhost/own.bin".to_owned(),
        "own.bin%00".to_owned(),
        ".".to_owned(),
        "data:application/octet-stream,plain".to_owned(),
        "data:application/octet-stream;base64,?!".to_owned(),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../secret.bin", inner.join("link.bin")).unwrap();
        uris.push("link.bin".to_owned());
    }
    for uri in uris {
        let mut json = document();
        json["buffers"] = json!([{ "byteLength": 44, "uri": uri }]);
        let place = place_of(open_in(&inner, "a.gltf", json.to_string().as_bytes()));
        assert_eq!(place, Place::Pointer("/buffers/0/uri".to_owned()), "{uri}");
    }
    let mut json = document();
    json["buffers"] = json!([{ "byteLength": 44, "uri": "./own.bin" }]);
    let imported = open_in(&inner, "a.gltf", json.to_string().as_bytes()).unwrap();
    assert!(imported.warnings.is_empty(), "{:?}", imported.warnings);
}

#[test]
fn unknown_requirements_are_named_with_a_way_out() {
    let mut json = document();
    json["extensionsRequired"] = json!(["KHR_materials_unlit", "ACME_splats"]);
    let error = open("a.gltf", json.to_string().as_bytes()).unwrap_err();
    assert!(matches!(error, ImportError::Unsupported { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("ACME_splats") && text.contains("KHR_draco_mesh_compression"));
    json["extensionsRequired"] = json!([]);
    json["asset"]["version"] = json!("1.0");
    let error = open("a.gltf", json.to_string().as_bytes()).unwrap_err();
    assert!(matches!(error, ImportError::Unsupported { .. }), "{error}");
}

#[test]
fn vertices_that_are_not_finite_are_warned_of() {
    let json = document().to_string();
    let mut one = binary();
    one[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
    let imported = open("a.glb", &glb(json.as_bytes(), &one)).unwrap();
    assert_eq!(
        imported.scene.objects[0].bounds.max().to_array(),
        [0.0, 4.0, 3.0]
    );
    assert_eq!(imported.warnings[0].object.as_deref(), Some("roof"));
    let mut all = binary();
    for at in (0..36).step_by(4) {
        all[at..at + 4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    }
    let imported = open("a.glb", &glb(json.as_bytes(), &all)).unwrap();
    assert!(imported.scene.objects.is_empty());
    assert_eq!(imported.warnings[0].object.as_deref(), Some("roof"));
}

fn primitive(json: &mut Value) -> &mut Value {
    &mut json["meshes"][0]["primitives"][0]
}

#[test]
fn feature_ids_in_a_texture_leave_one_object_with_a_warning() {
    let mut json = document();
    let ids = json!([{ "featureCount": 2, "texture": { "index": 0 } }]);
    primitive(&mut json)["extensions"] = json!({ "EXT_mesh_features": { "featureIds": ids } });
    let imported = open("a.glb", &glb(json.to_string().as_bytes(), &binary())).unwrap();
    assert_eq!(imported.scene.objects[0].id, "roof");
    assert!(imported.warnings[0].what.contains("texture"));
}

#[test]
fn implicit_feature_ids_make_each_vertex_an_object() {
    let mut json = document();
    let ids = json!([{ "featureCount": 3, "nullFeatureId": 1 }]);
    primitive(&mut json)["extensions"] = json!({ "EXT_mesh_features": { "featureIds": ids } });
    let imported = open("a.glb", &glb(json.to_string().as_bytes(), &binary())).unwrap();
    let objects = imported.scene.objects.iter();
    let found: Vec<_> = objects.map(|o| (o.id.as_str(), o.triangles)).collect();
    assert_eq!(found, [("roof", 0), ("roof/0", 1), ("roof/2", 0)]);
}

#[test]
fn a_feature_without_a_row_keeps_its_geometry_with_a_warning() {
    let mut json = document();
    let ids = json!([{ "featureCount": 3, "propertyTable": 0 }]);
    primitive(&mut json)["extensions"] = json!({ "EXT_mesh_features": { "featureIds": ids } });
    json["extensions"] = json!({ "EXT_structural_metadata": {
        "schema": { "id": "s", "classes": { "c": {} } },
        "propertyTables": [{ "class": "c", "count": 2 }],
    } });
    let imported = open("a.glb", &glb(json.to_string().as_bytes(), &binary())).unwrap();
    assert_eq!(imported.scene.objects.len(), 3);
    assert_eq!(imported.warnings[0].object.as_deref(), Some("roof/2"));
}

#[test]
fn meshopt_placeholders_are_replaced_by_their_range() {
    let mut json = document();
    json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    json["buffers"] = json!([{ "byteLength": 44 }, { "byteLength": 44 }]);
    for view in 0..2 {
        json["bufferViews"][view]["buffer"] = json!(1);
        json["bufferViews"][view]["extensions"] =
            json!({ "EXT_meshopt_compression": { "buffer": 0, "byteLength": 9, "count": 3 } });
    }
    let imported = open("a.glb", &glb(json.to_string().as_bytes(), &binary())).unwrap();
    let object = &imported.scene.objects[0];
    assert_eq!(object.bounds.size().to_array(), [2.0, 4.0, 3.0]);
    assert_eq!(object.triangles, 1);
    assert!(
        imported.warnings[0]
            .what
            .contains("EXT_meshopt_compression")
    );
}

#[test]
fn a_small_file_cannot_ask_for_boundless_work() {
    let mut json = document();
    json["accessors"][0] = json!({ "componentType": 5126, "type": "VEC3", "count": 1 << 24 });
    primitive(&mut json)
        .as_object_mut()
        .unwrap()
        .remove("indices");
    let primitives = vec![primitive(&mut json).clone(); 2000];
    json["meshes"][0]["primitives"] = json!(primitives);
    let started = std::time::Instant::now();
    let place = place_of(open("a.glb", &glb(json.to_string().as_bytes(), &binary())));
    assert!(matches!(place, Place::Pointer(p) if p.starts_with("/meshes/0/primitives/")));
    assert!(started.elapsed().as_secs() < 20);
}

#[test]
fn a_file_without_meshes_is_an_empty_scene_with_a_warning() {
    let imported = open("a.gltf", br#"{"asset":{"version":"2.0"}}"#).unwrap();
    assert!(imported.scene.objects.is_empty());
    assert_eq!(imported.warnings[0].place, Place::File);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// Flipped bytes, in the JSON or in the numbers, and a cut never bring the reader down.
    #[test]
    fn any_mutation_is_read_or_refused(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = whole();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        open_again("mutated.glb", &bytes);
    }

    /// Any number in any field of the document is read or refused.
    #[test]
    fn any_number_anywhere_is_read_or_refused(
        field in any::<prop::sample::Index>(),
        number in prop::sample::select(vec![0_u64, 1, 2, 3, 255, 65_535, 1 << 31, 1 << 40, u64::MAX]),
    ) {
        let mut json = document();
        let pointers = numbers(&json, "");
        let pointer = &pointers[field.index(pointers.len())];
        *json.pointer_mut(pointer).unwrap() = json!(number);
        open_again("numbers.glb", &glb(json.to_string().as_bytes(), &binary()));
    }
}

/// Pointers of all numbers.
fn numbers(value: &Value, pointer: &str) -> Vec<String> {
    match value {
        Value::Number(_) => vec![pointer.to_owned()],
        Value::Array(values) => (0..)
            .zip(values)
            .flat_map(|(i, value): (usize, _)| numbers(value, &format!("{pointer}/{i}")))
            .collect(),
        Value::Object(map) => map
            .iter()
            .flat_map(|(key, value)| numbers(value, &format!("{pointer}/{key}")))
            .collect(),
        _ => Vec::new(),
    }
}
