//! The parts of a glTF document that say what there is and where it lies.
//!
//! Read by a model of our own rather than by the `gltf` crate: node placements are taken as f64,
//! so that earth-centred and national-grid translations keep their digits; values of the wrong
//! kind get a JSON pointer; and what is not used (materials, images, animations) costs nothing.
//!
//! Source: glTF 2.0 specification, section 5 "Properties Reference".

use std::collections::BTreeMap;

use compact_str::CompactString;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::value::RawValue;

use super::metadata::StructuralMetadata;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document<'a> {
    pub(super) asset: Asset,
    #[serde(default)]
    pub(super) extensions_required: Vec<CompactString>,
    pub(super) scene: Option<usize>,
    #[serde(default)]
    pub(super) scenes: Vec<Scene>,
    #[serde(default, borrow)]
    pub(super) nodes: Vec<Node<'a>>,
    #[serde(default)]
    pub(super) meshes: Vec<Mesh>,
    #[serde(default, borrow)]
    pub(super) accessors: Vec<Accessor<'a>>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(default, borrow)]
    pub(super) buffers: Vec<Buffer<'a>>,
    #[serde(default)]
    pub(super) extensions: RootExtensions,
}

#[derive(Deserialize)]
pub(super) struct Asset {
    pub(super) version: CompactString,
}

#[derive(Default, Deserialize)]
pub(super) struct RootExtensions {
    #[serde(rename = "CESIUM_RTC")]
    pub(super) rtc: Option<Rtc>,
    #[serde(rename = "EXT_structural_metadata")]
    pub(super) metadata: Option<StructuralMetadata>,
}

/// `CESIUM_RTC`: what all positions are relative to, in the z-up system around the model.
#[derive(Deserialize)]
pub(super) struct Rtc {
    pub(super) center: [f64; 3],
}

#[derive(Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub(super) nodes: Vec<usize>,
}

#[derive(Deserialize)]
pub(super) struct Node<'a> {
    pub(super) name: Option<CompactString>,
    pub(super) mesh: Option<usize>,
    #[serde(default)]
    pub(super) children: Vec<usize>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
    #[serde(borrow)]
    pub(super) extras: Option<&'a RawValue>,
    #[serde(default)]
    pub(super) extensions: NodeExtensions,
}

#[derive(Default, Deserialize)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(super) instancing: Option<Instancing>,
}

/// `EXT_mesh_gpu_instancing`: accessors by attribute.
#[derive(Deserialize)]
pub(super) struct Instancing {
    pub(super) attributes: BTreeMap<CompactString, usize>,
}

#[derive(Deserialize)]
pub(super) struct Mesh {
    pub(super) name: Option<CompactString>,
    pub(super) primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: BTreeMap<CompactString, usize>,
    pub(super) indices: Option<usize>,
    #[serde(default = "triangles")]
    pub(super) mode: u32,
    #[serde(default)]
    pub(super) extensions: PrimitiveExtensions,
}

fn triangles() -> u32 {
    super::mesh::TRIANGLES
}

#[derive(Default, Deserialize)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub(super) draco: Option<IgnoredAny>,
    #[serde(rename = "EXT_mesh_features")]
    pub(super) features: Option<MeshFeatures>,
}

/// `EXT_mesh_features`.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MeshFeatures {
    pub(super) feature_ids: Vec<FeatureIds>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct FeatureIds {
    pub(super) attribute: Option<u32>,
    pub(super) texture: Option<IgnoredAny>,
    pub(super) null_feature_id: Option<u64>,
    pub(super) property_table: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor<'a> {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u32,
    pub(super) count: usize,
    #[serde(rename = "type")]
    pub(super) shape: CompactString,
    #[serde(default)]
    pub(super) normalized: bool,
    /// Parsed only where the vertices cannot be read: it is in most accessors and rarely needed.
    #[serde(borrow)]
    pub(super) min: Option<&'a RawValue>,
    #[serde(borrow)]
    pub(super) max: Option<&'a RawValue>,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Deserialize)]
pub(super) struct Sparse {
    pub(super) count: usize,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    pub(super) byte_stride: Option<usize>,
    #[serde(default)]
    pub(super) extensions: BufferViewExtensions,
}

/// Where either is given and the plain bytes are missing, the content is compressed.
#[derive(Default, Deserialize)]
pub(super) struct BufferViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub(super) meshopt: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer<'a> {
    /// A raw JSON string: a `data:` URI may be nearly the whole file.
    #[serde(borrow)]
    pub(super) uri: Option<&'a RawValue>,
    pub(super) byte_length: usize,
}
