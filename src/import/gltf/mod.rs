//! glTF 2.0, as JSON or as GLB: every node with a mesh is an object, or as many objects as the
//! mesh has features or the node has instances.
//!
//! Source: Khronos glTF 2.0 specification and the extensions in [`HANDLED`].

mod accessor;
mod buffers;
mod column;
mod container;
mod document;
mod features;
mod graph;
mod instances;
mod mesh;
mod metadata;
mod objects;

use super::collector::Collector;
use super::placing::Placing;
use super::source::Source;
use super::{ImportError, Options, Place, Up};

use accessor::Reader;
use buffers::Buffers;
use container::Container;
use document::Document;
use objects::Objects;

/// Extensions that a file may require: what they say is used, or has no bearing on where an object
/// lies.
const HANDLED: [&str; 12] = [
    "CESIUM_RTC",
    "CESIUM_primitive_outline",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_structural_metadata",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "MSFT_texture_dds",
];
/// Extensions whose names begin so concern colour only.
const COLOUR: [&str; 4] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "EXT_lights_",
];

pub(super) fn read(
    source: &Source,
    options: &Options,
    collector: &mut Collector,
    report: &dyn Fn(u64),
) -> Result<(), ImportError> {
    let path = source.path();
    let bytes = source.bytes(report)?;
    let container = Container::open(&bytes, path)?;
    let document = container.document(path)?;
    check_version(&document, source)?;
    check_extensions(&document, source)?;
    let buffers = Buffers::open(&document, container.binary, path, collector)?;
    let reader = Reader {
        document: &document,
        buffers: &buffers,
        path,
    };
    let placed = graph::placed(&reader, options.up.unwrap_or(Up::Y))?;
    if placed.iter().all(|p| document.nodes[p.node].mesh.is_none()) {
        collector.warn(None, Place::File, "no node of the scene has a mesh");
    }
    let way_out = "reproject the file to a system in metres";
    let placing = Placing::of(None, Place::File, way_out, collector)?;
    let mut objects = Objects::new(reader, placing, collector);
    placed.iter().try_for_each(|placed| objects.node(placed))
}

fn check_version(document: &Document, source: &Source) -> Result<(), ImportError> {
    let version = &document.asset.version;
    if version.starts_with("2.") {
        return Ok(());
    }
    Err(ImportError::Unsupported {
        path: source.path().to_owned(),
        feature: format!("glTF {version:?}"),
        way_out: "convert the file to glTF 2.0".to_owned(),
    })
}

fn check_extensions(document: &Document, source: &Source) -> Result<(), ImportError> {
    let is_known = |name: &str| {
        HANDLED.contains(&name) || COLOUR.iter().any(|prefix| name.starts_with(prefix))
    };
    let mut required = document.extensions_required.iter();
    match required.find(|name| !is_known(name)) {
        None => Ok(()),
        Some(name) => Err(ImportError::Unsupported {
            path: source.path().to_owned(),
            feature: format!("the glTF extension {name}"),
            way_out: format!(
                "export without it; handled are {}, {}* (compressed meshes by the minimum and \
                 maximum of their positions)",
                HANDLED.join(", "),
                COLOUR.join("*, ")
            ),
        }),
    }
}
