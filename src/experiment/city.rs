//! The cities experiments look at, and where they are looked at from.

use std::path::{Path, PathBuf};

use super::ReportError;
use super::exact::Camera;
use crate::frame;
use crate::geom::{DVec3, DepthRange, Orientation, Projection, View};
use crate::import;
use crate::index::{self, LodTree, Promotion};
use crate::scene::{CityParams, Scene, generate};

/// As many objects as in Gong's test.
pub(super) const GONG_OBJECTS: u32 = 23_951;
pub(super) const SEED: u64 = 1;
/// Spreads places evenly without lining them up.
pub(super) const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// A generated city.
pub(super) fn generated_scene(objects: u32) -> Scene {
    generate(&CityParams {
        objects,
        seed: SEED,
    })
}

/// The tree of a generated city.
pub(super) fn generated(objects: u32) -> Result<LodTree, ReportError> {
    Ok(index::build(
        &generated_scene(objects),
        Promotion::default(),
    )?)
}

/// The real city of as many objects as Gong's in the folder that `CITYLOD_DATA` names, where
/// there is one.
pub(super) fn real() -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("CITYLOD_DATA")?);
    let path = folder.join("cityjson/tokyo-minato-23951.city.json.gz");
    path.is_file().then_some(path)
}

/// The tree of a city in a file: opened, or imported and built.
pub(super) fn from_file(path: &Path) -> Result<LodTree, ReportError> {
    if path.extension().is_some_and(|e| e == "citylod") {
        return Ok(LodTree::open_verified(path)?);
    }
    let imported = import::import(&[path.to_owned()], &import::Options::default(), &|_, _| {})?;
    Ok(index::build(&imported.scene, Promotion::default())?)
}

/// A city's name in tables: that of its file, without what tells the format.
pub(super) fn name(path: &Path) -> String {
    let name = path
        .file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy();
    let end = name.find('.').filter(|&dot| dot > 0).unwrap_or(name.len());
    name[..end].to_owned()
}

/// Level views a little above the roofs, from `places` places about the densest part in four
/// directions each: "the viewpoint close to the ground, the line of sight level" (Gong, 2.3).
pub(super) fn level_views(tree: &LodTree, places: u32) -> Result<Vec<View>, ReportError> {
    let cameras = level_cameras(tree, places).into_iter();
    cameras.map(|camera| Ok(camera.view()?)).collect()
}

/// What [`level_views`] are made from.
pub(super) fn level_cameras(tree: &LodTree, places: u32) -> Vec<Camera> {
    const HEIGHT_M: f64 = 60.0;
    let middle = densest(tree);
    let size = tree.bounds().size();
    let spread = size.x.min(size.y) * 0.06;
    let depth = DepthRange::default();
    (0_u32..)
        .zip(spiral(middle, spread, places))
        .flat_map(|(place, eye)| {
            let turn = f64::from(place) * GOLDEN_ANGLE;
            let eye = eye.with_z(tree.bounds().min().z + HEIGHT_M);
            (0..4).map(move |quarter| {
                let heading = turn + f64::from(quarter) * std::f64::consts::FRAC_PI_2;
                let target = eye + DVec3::new(heading.cos(), heading.sin(), 0.0);
                Camera::Posed {
                    eye,
                    orientation: Orientation::LookAt {
                        target,
                        up: DVec3::Z,
                    },
                    projection: Projection::Perspective { fov_y_deg: 60.0 },
                    depth,
                    viewport: [1920, 1080],
                }
            })
        })
        .collect()
}

/// `places` places within `spread` metres about a middle.
pub(super) fn spiral(middle: DVec3, spread: f64, places: u32) -> impl Iterator<Item = DVec3> {
    (0..places).map(move |place| {
        let turn = f64::from(place) * GOLDEN_ANGLE;
        let out = spread * (f64::from(place) / f64::from(places)).sqrt();
        middle + DVec3::new(turn.cos() * out, turn.sin() * out, 0.0)
    })
}

/// The densest part on the map, z 0.
pub(super) fn densest(tree: &LodTree) -> DVec3 {
    frame::densest(tree).unwrap_or_default().with_z(0.0)
}
