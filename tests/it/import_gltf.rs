use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use citylod::geom::{Aabb, DVec3};
use citylod::import::{Imported, Options, Place, Up, import};
use citylod::scene::SceneObject;

/// Twice the rounding of an f64 at 6,400,000 m, after a turn and a few sums.
const ROUNDING_M: f64 = 4e-9;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures/gltf")
        .join(name)
}

fn read(name: &str) -> Imported {
    read_with(name, &Options::default())
}

fn read_with(name: &str, options: &Options) -> Imported {
    import(&[fixture(name)], options, &|_, _| {}).unwrap()
}

fn ids(imported: &Imported) -> Vec<&str> {
    let objects = imported.scene.objects.iter();
    objects.map(|object| object.id.as_str()).collect()
}

fn assert_box(object: &SceneObject, min: [f64; 3], max: [f64; 3]) {
    let bounds = object.bounds;
    let off = (bounds.min() - DVec3::from_array(min)).abs();
    let off = off.max((bounds.max() - DVec3::from_array(max)).abs());
    assert!(
        off.max_element() <= ROUNDING_M,
        "{}: {bounds:?}, expected {min:?} to {max:?}",
        object.id
    );
}

#[test]
fn large_placements_keep_their_digits() {
    let imported = read("placement.gltf");
    assert_eq!(ids(&imported), ["turned", "node-2", "shed"]);
    assert!(imported.warnings.is_empty(), "{:?}", imported.warnings);
    let (x, y, z) = (4_014_743.25, 500_000.062_5, 6_400_000.123);
    let [turned, doubled, shed] = imported.scene.objects.as_slice() else {
        panic!("expected three objects");
    };
    // A quarter turn about the vertical: what lay north lies west.
    assert_box(turned, [x - 4.0, y, z], [x, y + 2.0, z + 3.0]);
    assert_box(doubled, [x + 10.0, y, z], [x + 14.0, y + 8.0, z + 6.0]);
    assert_box(shed, [x, y, z], [x + 2.0, y + 12.0, z + 3.0]);
    assert!((shed.footprint_area - 12.0).abs() < 1e-6);
    assert_eq!([turned.triangles, shed.triangles], [1, 1]);
    assert_eq!(turned.class, "Bridge");
    assert_eq!(shed.class, "Building");
    let attributes = turned.attributes.as_ref().unwrap();
    let attributes: serde_json::Value = serde_json::from_str(attributes.get()).unwrap();
    assert_eq!(attributes["year"], 1932);
}

#[test]
fn up_z_is_taken_as_it_is() {
    let options = Options {
        up: Some(Up::Z),
        ..Options::default()
    };
    let imported = read_with("external.gltf", &options);
    assert_box(
        &imported.scene.objects[0],
        [0.0, 0.0, -4.0],
        [2.0, 3.0, 0.0],
    );
}

#[test]
fn features_are_objects_with_their_row_of_the_table() {
    let imported = read("features.gltf");
    // What is of no feature stays, under the name of the node.
    assert_eq!(ids(&imported), ["tile", "NL.1", "NL.22"]);
    let [rest, first, second] = imported.scene.objects.as_slice() else {
        panic!("expected three objects");
    };
    assert_box(rest, [20.0, 0.0, 0.0], [21.0, 1.0, 3.0]);
    assert_box(first, [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]);
    assert_box(second, [10.0, 0.0, 0.0], [11.0, 1.0, 2.0]);
    assert_eq!([first.triangles, second.triangles], [1, 1]);
    assert_eq!([&*first.class, &*second.class], ["Bridge", "Building"]);
    assert_eq!(
        first.attributes.as_ref().unwrap().get(),
        r#"{"class":"Bridge","height":3.5,"identificatie":"NL.1","listed":false,"rgb":[1,2,3]}"#
    );
    assert_eq!(
        second.attributes.as_ref().unwrap().get(),
        r#"{"class":"Building","floors":12,"height":0.3333333333333333,"identificatie":"NL.22","listed":true,"rgb":[4,5,6]}"#
    );
    let [warning] = imported.warnings.as_slice() else {
        panic!("expected one warning: {:?}", imported.warnings);
    };
    let table = "/extensions/EXT_structural_metadata/propertyTables/0/properties/tags";
    assert_eq!(warning.place, Place::Pointer(table.to_owned()));
}

#[test]
fn quantized_and_sparse_positions_are_unpacked() {
    let imported = read("quantized-sparse.gltf");
    assert_box(&imported.scene.objects[0], [0.0, 0.0, 0.0], [2.0, 4.0, 3.0]);
    assert_eq!(imported.scene.objects[0].footprint_area, 4.0);
}

#[test]
fn vertices_that_cannot_be_read_are_replaced_by_their_range_with_a_warning() {
    for (name, why) in [
        ("draco.gltf", "compressed (KHR_draco_mesh_compression)"),
        ("missing-buffer.gltf", "buffer is missing"),
    ] {
        let imported = read(name);
        let object = &imported.scene.objects[0];
        assert_box(object, [0.0, 0.0, 0.0], [2.0, 4.0, 3.0]);
        assert_eq!(
            (object.footprint_area, object.triangles),
            (8.0, 1),
            "{name}"
        );
        let warned = imported.warnings.iter();
        let warned = warned.filter(|w| w.object.as_deref() == Some("roof"));
        assert!(warned.clone().any(|w| w.what.contains(why)), "{name}");
    }
}

#[test]
fn a_missing_buffer_file_is_named() {
    let imported = read("missing-buffer.gltf");
    let place = Place::Pointer("/buffers/0/uri".to_owned());
    let mut warnings = imported.warnings.iter();
    let warning = warnings.find(|w| w.place == place).unwrap();
    assert!(warning.what.contains("nowhere.bin"), "{warning}");
}

#[test]
fn a_buffer_beside_the_file_is_read() {
    let imported = read("external.gltf");
    assert!(imported.warnings.is_empty(), "{:?}", imported.warnings);
    assert_eq!(imported.scene.objects[0].footprint_area, 4.0);
}

#[test]
fn every_instance_is_an_object_about_the_stated_centre() {
    let imported = read("instances-rtc.gltf");
    assert_eq!(ids(&imported), ["roof/0", "roof/1"]);
    let (x, y, z) = (4_014_743.25, 308_214.5, 4_932_000.123);
    let [first, second] = imported.scene.objects.as_slice() else {
        panic!("expected two objects");
    };
    assert_box(first, [x, y, z], [x + 2.0, y + 4.0, z + 3.0]);
    assert_box(
        second,
        [x + 100.0, y + 50.0, z],
        [x + 102.0, y + 54.0, z + 3.0],
    );
}

#[test]
fn gzip_changes_nothing() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("placement.gltf.gz");
    let file = std::fs::File::create(&path).unwrap();
    let mut packed = flate2::write::GzEncoder::new(file, flate2::Compression::default());
    let bytes = std::fs::read(fixture("placement.gltf")).unwrap();
    packed.write_all(&bytes).unwrap();
    packed.finish().unwrap();
    let unpacked = read("placement.gltf");
    let packed = import(&[path], &Options::default(), &|_, _| {}).unwrap();
    assert_eq!(ids(&packed), ids(&unpacked));
}

/// The folder with real cities, where there is one.
fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("CITYLOD_DATA").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: CITYLOD_DATA is not set");
    }
    folder
}

#[test]
fn each_tile_of_sibbe_has_its_features() {
    let Some(data) = data() else { return };
    let folder = data.join("glb/3dbag-sibbe/content");
    for (name, features) in [("1_1_0.glb", 23), ("2_2_3.glb", 220), ("2_3_2.glb", 171)] {
        let imported = import(&[folder.join(name)], &Options::default(), &|_, _| {}).unwrap();
        assert_eq!(imported.scene.objects.len(), features, "{name}");
        let told: Vec<&str> = imported.warnings.iter().map(|w| w.what.as_str()).collect();
        assert!(
            matches!(told[..], [tilted] if tilted.contains("degrees from level")),
            "{told:?}"
        );
        assert!(
            ids(&imported)
                .iter()
                .all(|id| id.starts_with("NL.IMBAG.Pand."))
        );
        let bounds = imported.scene.objects.iter();
        let bounds = bounds.fold(Aabb::EMPTY, |all, object| all.union(&object.bounds));
        let (expected, triangles) = independent(&folder.join(name));
        assert_eq!(bounds, expected, "{name}");
        let objects = imported.scene.objects.iter();
        assert_eq!(
            objects.map(|o| u64::from(o.triangles)).sum::<u64>(),
            triangles
        );
    }
}

/// Bounds and triangles of a tile of one node, by the `gltf` crate. The node turns z up to y up
/// and the import turns it back: the vertices come out as they are stored.
fn independent(path: &Path) -> (Aabb, u64) {
    let gltf::Gltf { document, blob } = gltf::Gltf::open(path).unwrap();
    let mesh = document.meshes().next().unwrap();
    let primitive = mesh.primitives().next().unwrap();
    let reader = primitive.reader(|_| blob.as_deref());
    let positions = reader.read_positions().unwrap();
    let bounds = Aabb::around(positions.map(|p| DVec3::from_array(p.map(f64::from))));
    let indices = reader.read_indices().unwrap().into_u32().count();
    (bounds, indices as u64 / 3)
}

/// The OBJ has three decimals; the GLB f32 vertices and a translation of three decimals.
const TOLERANCE_M: f64 = 0.002;

#[test]
fn tokyo_is_the_same_city_as_glb_and_as_obj() {
    let Some(data) = data() else { return };
    let open = |name: &str| import(&[data.join(name)], &Options::default(), &|_, _| {}).unwrap();
    let glb = open("glb/tokyo-chiyoda-11581.glb");
    let obj = open("obj/tokyo-chiyoda-11581.obj");
    assert_eq!(glb.scene.objects.len(), 11_581);
    assert_eq!(obj.scene.objects.len(), 11_581);
    let triangles = |city: &Imported| {
        let objects = city.scene.objects.iter();
        objects.map(|o| u64::from(o.triangles)).sum::<u64>()
    };
    assert_eq!([triangles(&glb), triangles(&obj)], [264_660; 2]);
    let by_id: BTreeMap<_, _> = obj.scene.objects.iter().map(|o| (&o.id, o)).collect();
    let mut shift = None;
    for object in &glb.scene.objects {
        let other = by_id[&object.id];
        let off = object.bounds.size() - other.bounds.size();
        assert!(
            off.abs().max_element() < TOLERANCE_M,
            "{}: {off}",
            object.id
        );
        let moved = other.bounds.center() - object.bounds.center();
        let off = moved - *shift.get_or_insert(moved);
        assert!(
            off.abs().max_element() < TOLERANCE_M,
            "{}: {off}",
            object.id
        );
        let tolerance_m2 = TOLERANCE_M * (object.bounds.size().length() * 4.0);
        let off = (object.footprint_area - other.footprint_area).abs();
        assert!(off < tolerance_m2, "{}: {off} m²", object.id);
    }
}
