use std::path::Path;

use citylod::effects::terrain::Land;
use citylod::geom::{DVec2, DVec3};
use citylod::index::{self, LodTree, Promotion};
use citylod::scene::{Effects, Scene, SceneObject};
use citylod::terrain::pyramid::{Pyramid, Tiling, write};
use citylod::terrain::{Grid, HeightField};

use crate::support::object;

/// Posts 10 m apart from (−500, −500) on: level, but for a ridge 60 m high from west to east along
/// y = 0.
pub fn ridge() -> HeightField {
    let grid = Grid::new(101, 101, DVec2::splat(-500.0), DVec2::splat(10.0)).unwrap();
    let heights = (0..101 * 101).map(|at| {
        let (x, y) = (grid.x(at % 101), grid.y(at / 101));
        // Not quite level, so that every post counts.
        let rough = ((x * 0.013).sin() + (y * 0.021).cos()) * 0.5;
        ((60.0 - y.abs() * 0.5).max(0.0) + rough) as f32
    });
    HeightField::new(grid, heights.collect()).unwrap()
}

/// A field as the ground in a file.
pub fn land(field: &HeightField, folder: &Path) -> Land {
    let path = folder.join("city.terrain");
    let tiling = Tiling::new(*field.grid());
    let height = |column, row| field.height(column, row);
    write(&path, &tiling, None, height, &|_, _| {}).unwrap();
    Land::new(Pyramid::open_verified(&path).unwrap()).unwrap()
}

/// Two rows of houses, south and north of the ridge, and a tower behind it.
pub fn houses() -> Vec<SceneObject> {
    let house = |side: f64, at: i32| {
        let name = if side < 0.0 { "south" } else { "north" };
        let place = DVec3::new(f64::from(at) * 30.0, side * 200.0, 0.0);
        object(format!("{name}{at}"), place, DVec3::new(10.0, 10.0, 8.0))
    };
    let rows = [-1.0, 1.0].into_iter();
    let mut houses: Vec<SceneObject> = rows
        .flat_map(|side| (-5..=5).map(move |at| house(side, at)))
        .collect();
    let place = DVec3::new(0.0, 250.0, 0.0);
    houses.push(object("tower", place, DVec3::new(20.0, 20.0, 300.0)));
    houses
}

/// Houses that declare these effects.
pub fn city(effects: Effects) -> LodTree {
    let scene = Scene {
        objects: houses(),
        effects,
        ..Scene::default()
    };
    index::build(&scene, Promotion::Largest).unwrap()
}
