//! Two cities that take turns, and what their cameras should see.

use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result};
use citylod::geom::{DVec3, DepthRange, Orientation, Projection, View};
use citylod::index::{self, LodTree, Promotion};
use citylod::lod::{Beyond, Lod, RangeLod, Selection, select};
use citylod::scene::{CityParams, generate};

/// The scene's name, from its file.
pub const SCENE: &str = "town";

/// What clients know.
pub struct World {
    cities: [LodTree; 2],
    path: PathBuf,
    turn: AtomicUsize,
    address: OnceLock<SocketAddr>,
}

/// One frame of a flight.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    pub eye: [f64; 3],
    pub target: [f64; 3],
    pub far_dist_m: f64,
}

impl World {
    /// Makes the cities and saves the first.
    pub fn new(objects: u32, folder: &Path) -> Result<Self> {
        let city = |seed| {
            let scene = generate(&CityParams { objects, seed });
            index::build(&scene, Promotion::Tallest)
        };
        let path = folder.join(SCENE).with_extension("citylod");
        let world = Self {
            cities: [city(1)?, city(2)?],
            path,
            turn: AtomicUsize::new(0),
            address: OnceLock::new(),
        };
        world.cities[0].save(&world.path)?;
        Ok(world)
    }

    /// Where the city is saved.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Puts the other city there.
    pub fn replace(&self) -> Result<()> {
        let turn = self.turn.fetch_add(1, Ordering::Relaxed) + 1;
        self.cities[turn % 2].save(&self.path)?;
        Ok(())
    }

    /// States where the service listens.
    pub fn set_address(&self, address: SocketAddr) {
        self.address.get_or_init(|| address);
    }

    /// Where the service listens.
    pub fn address(&self) -> Result<SocketAddr> {
        self.address.get().copied().context("not started")
    }

    /// What a camera sees in the city of this revision.
    pub fn seen(&self, revision: &str, pose: &Pose) -> Result<BTreeSet<u32>> {
        let city = self.cities.iter().find(|city| city.revision() == revision);
        let view = View::new(
            DVec3::from_array(pose.eye),
            Orientation::LookAt {
                target: DVec3::from_array(pose.target),
                up: DVec3::Z,
            },
            Projection::Perspective { fov_y_deg: 60.0 },
            DepthRange::default(),
            [1920, 1080],
        )?;
        let lod = RangeLod::new(pose.far_dist_m, 2.5, 4, Beyond::Show)?;
        let mut selection = Selection::default();
        let city = city.with_context(|| format!("no city has revision {revision}"))?;
        select(city, &view, &Lod::Range(lod), &mut selection);
        Ok(selection.objects().collect())
    }

    /// An object of the first city.
    pub fn id(&self, number: u32) -> String {
        let city = &self.cities[0];
        let id = city.id(number % city.object_count().max(1));
        id.unwrap_or_default().into_owned()
    }
}

impl Pose {
    /// A smooth flight: around the centre at 20 m/s, each number on its own circle.
    pub fn at(number: u32, seconds: f64) -> Self {
        let radius = 300.0 + f64::from(number % 40) * 30.0;
        let angle = f64::from(number) * 2.4 + seconds * 20.0 / radius;
        let (sin, cos) = angle.sin_cos();
        let height = 40.0 + f64::from(number % 7) * 40.0;
        Self {
            eye: [radius * cos, radius * sin, height],
            target: [
                0.5 * radius * (angle + 1.0).cos(),
                0.5 * radius * (angle + 1.0).sin(),
                20.0,
            ],
            far_dist_m: 300.0 + f64::from(number % 5) * 100.0,
        }
    }

    /// The members of a request.
    pub fn json(&self) -> String {
        let Self {
            eye: [ex, ey, ez],
            target: [tx, ty, tz],
            far_dist_m,
        } = self;
        format!(
            r#""camera":{{"eye":[{ex},{ey},{ez}],"target":[{tx},{ty},{tz}]}},"lod":{{"far_dist_m":{far_dist_m}}}"#
        )
    }
}
