//! Writes a scene as a binary glTF file that any viewer opens.
//!
//! Source: glTF 2.0 specification, Khronos, sections 3.4 (coordinates) and 4.4 (GLB layout).

use std::io::{self, Write};

use serde_json::json;

use crate::scene::{Scene, SceneObject};

/// Magic, version and length of the file.
const HEADER_BYTES: u64 = 12;
/// Length and type of a chunk.
const CHUNK_HEADER_BYTES: u64 = 8;
/// Corners of the unit box: bit 0 of the number is x, bit 1 is y, bit 2 is z.
const CORNERS: u8 = 8;
const POSITIONS_BYTES: usize = CORNERS as usize * 12;
/// Two triangles a side, counter-clockwise seen from outside.
#[rustfmt::skip]
const TRIANGLES: [[u8; 3]; 12] = [
    [0, 4, 6], [0, 6, 2], // -x
    [1, 3, 7], [1, 7, 5], // +x
    [0, 1, 5], [0, 5, 4], // -y
    [2, 6, 7], [2, 7, 3], // +y
    [0, 2, 3], [0, 3, 1], // -z
    [4, 5, 7], [4, 7, 6], // +z
];

/// Writes the boxes of `scene` as GLB: one shared unit box, and for each object a node with its
/// id as name, its class in `extras.class`, and the translation and scale of its box.
///
/// The file is y-up, as its specification says: scene (x, y, z) becomes (x, z, −y). Coordinates
/// stay absolute and keep every bit of their f64 in the text; viewers that read them as f32 round
/// them. Attributes and the coordinate reference system are not written.
///
/// # Errors
/// What `out` returns; [`io::ErrorKind::FileTooLarge`] when the scene takes more than the 4 GiB
/// of a GLB (about 25 million objects), in which case nothing was written.
pub fn write_glb(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    // The length comes before the text: it is counted in a first pass, not held in memory.
    let mut counter = Counter(0);
    write_json(scene, &mut counter)?;
    let padding = counter.0.next_multiple_of(4) - counter.0;
    let json_bytes = counter.0 + padding;
    let binary = unit_box();
    let total = HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + json_bytes + binary.len() as u64;
    let total = u32::try_from(total).map_err(|too_large| {
        io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("a GLB holds at most 4 GiB, this scene takes {total} bytes: {too_large}"),
        )
    })?;
    out.write_all(b"glTF")?;
    out.write_all(&2_u32.to_le_bytes())?;
    out.write_all(&total.to_le_bytes())?;
    out.write_all(&(json_bytes as u32).to_le_bytes())?;
    out.write_all(b"JSON")?;
    write_json(scene, out)?;
    out.write_all(&b"   "[..padding as usize])?;
    out.write_all(&(binary.len() as u32).to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    out.write_all(&binary)
}

/// Positions of the box from (0, 0, 0) to (1, 1, 1), then its triangles.
fn unit_box() -> Vec<u8> {
    let coordinates = (0..CORNERS).flat_map(|c| [c & 1, c >> 1 & 1, c >> 2 & 1]);
    let positions = coordinates.flat_map(|bit| f32::from(bit).to_le_bytes());
    positions.chain(TRIANGLES.into_iter().flatten()).collect()
}

fn write_json(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    let generator = concat!("citylod ", env!("CARGO_PKG_VERSION"));
    write!(
        out,
        r#"{{"asset":{{"version":"2.0","generator":"{generator}"}}"#
    )?;
    let index_bytes = TRIANGLES.as_flattened().len();
    let shared = [
        (
            "buffers",
            json!([{ "byteLength": POSITIONS_BYTES + index_bytes }]),
        ),
        (
            "bufferViews",
            json!([
                { "buffer": 0, "byteOffset": 0, "byteLength": POSITIONS_BYTES, "target": 34962 },
                { "buffer": 0, "byteOffset": POSITIONS_BYTES, "byteLength": index_bytes, "target": 34963 },
            ]),
        ),
        (
            "accessors",
            json!([
                { "bufferView": 0, "componentType": 5126, "count": CORNERS, "type": "VEC3",
                  "min": [0, 0, 0], "max": [1, 1, 1] },
                { "bufferView": 1, "componentType": 5121, "count": index_bytes, "type": "SCALAR" },
            ]),
        ),
        (
            "meshes",
            json!([{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }]),
        ),
    ];
    for (key, value) in shared {
        write!(out, r#","{key}":{value}"#)?;
    }
    // The format knows no empty arrays, but files without a scene.
    if scene.objects.is_empty() {
        return out.write_all(b"}");
    }
    out.write_all(br#","scene":0,"scenes":[{"nodes":["#)?;
    for index in 0..scene.objects.len() {
        write!(out, "{}{index}", if index == 0 { "" } else { "," })?;
    }
    out.write_all(br#"]}],"nodes":["#)?;
    for (index, object) in scene.objects.iter().enumerate() {
        out.write_all(if index == 0 { b"" } else { b"," })?;
        write_node(object, out)?;
    }
    out.write_all(b"]}")
}

fn write_node(object: &SceneObject, out: &mut dyn Write) -> io::Result<()> {
    let (min, max, size) = (
        object.bounds.min(),
        object.bounds.max(),
        object.bounds.size(),
    );
    // 0.0 - y, not -y, for no coordinate should read -0.
    let translation = [min.x, min.z, 0.0 - max.y];
    let scale = [size.x, size.z, size.y];
    out.write_all(br#"{"mesh":0,"name":"#)?;
    serde_json::to_writer(&mut *out, &object.id)?;
    out.write_all(br#","translation":"#)?;
    serde_json::to_writer(&mut *out, &translation)?;
    out.write_all(br#","scale":"#)?;
    serde_json::to_writer(&mut *out, &scale)?;
    out.write_all(br#","extras":{"class":"#)?;
    serde_json::to_writer(&mut *out, &object.class)?;
    out.write_all(b"}}")
}

/// Counts what is written to it.
struct Counter(u64);

impl Write for Counter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use gltf::Gltf;

    use super::*;
    use crate::geom::{Aabb, DVec3};
    use crate::scene::{CityParams, generate};

    fn written(scene: &Scene) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_glb(scene, &mut bytes).expect("memory takes it");
        bytes
    }

    fn city() -> Scene {
        generate(&CityParams {
            objects: 100,
            seed: 1,
        })
    }

    #[test]
    fn a_reader_of_the_format_accepts_it_and_finds_every_object() {
        let scene = city();
        let Gltf { document, blob } = Gltf::from_slice(&written(&scene)).expect("valid GLB");
        assert_eq!(document.meshes().len(), 1);
        let nodes: Vec<_> = document.default_scene().expect("a scene").nodes().collect();
        assert_eq!(nodes.len(), 100);
        for (node, object) in nodes.iter().zip(&scene.objects) {
            assert_eq!(node.name(), Some(object.id.as_str()));
            let class = node.extras().as_ref().expect("extras").get();
            assert_eq!(class, json!({ "class": object.class }).to_string());
            let matrix = glam::Mat4::from_cols_array_2d(&node.transform().matrix());
            let primitive = node
                .mesh()
                .and_then(|m| m.primitives().next())
                .expect("a mesh");
            let reader = primitive.reader(|_| blob.as_deref());
            let points = reader.read_positions().expect("positions").map(|p| {
                let p = matrix.transform_point3(p.into()).as_dvec3();
                DVec3::new(p.x, -p.z, p.y)
            });
            let bounds = Aabb::around(points);
            // One in 2²³ of coordinates below 1 km, twice rounded.
            let f32_m = 2.5e-4;
            assert!(bounds.min().abs_diff_eq(object.bounds.min(), f32_m));
            assert!(bounds.max().abs_diff_eq(object.bounds.max(), f32_m));
        }
    }

    #[test]
    fn triangles_face_outward_and_close_the_box() {
        let corner = |c: u8| DVec3::new((c & 1).into(), (c >> 1 & 1).into(), (c >> 2 & 1).into());
        let mut six_volumes = 0.0;
        for [a, b, c] in TRIANGLES.map(|t| t.map(corner)) {
            let normal = (b - a).cross(c - a);
            assert!(normal.dot(a - DVec3::splat(0.5)) > 0.0);
            six_volumes += a.dot(normal);
        }
        assert_eq!(six_volumes, 6.0);
    }

    #[test]
    fn text_keeps_every_bit_of_national_grid_coordinates() {
        let mut scene = city();
        scene.objects.truncate(1);
        let min = DVec3::new(6_000_000.1, -0.0, 0.1 + 0.2);
        let max = DVec3::new(6_000_010.7, 1.0 / 3.0, 12.0);
        scene.objects[0].bounds = Aabb::new(min, max).expect("a box");
        scene.objects[0].id = "\"é\n".into();
        let bytes = written(&scene);
        let (_, chunk) = bytes.split_at(20);
        let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
        let json: serde_json::Value = serde_json::from_slice(&chunk[..length]).expect("JSON");
        let node = &json["nodes"][0];
        assert_eq!(node["name"], "\"é\n");
        assert_eq!(node["translation"], json!([min.x, min.z, -max.y]));
        assert_eq!(node["scale"], json!([max.x - min.x, max.z - min.z, max.y]));
    }

    #[test]
    fn a_scene_without_objects_is_a_valid_file() {
        let document = Gltf::from_slice(&written(&Scene::default())).expect("valid GLB");
        assert_eq!(document.nodes().len(), 0);
    }
}
