//! Where a frame gets its tiles from, and the frame: A's breadth-first walk with two queues.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::experiment::ReportError;
use crate::geom::{Aabb, DVec2, DVec3, Relation, View};
use crate::terrain::pyramid::{Pyramid, PyramidError, Tiling};
use crate::terrain::{Criterion, Keep, Knobs, Node, Reach, Seen, StoreCounts, TileStore};

/// Tiles that are read ahead in a frame, at most.
const AHEAD: usize = 4;
/// Frames that the eye is thought ahead.
const FRAMES_AHEAD: f64 = 10.0;

/// A tile as a renderer takes it: corners of triangles, relative to the south-west one, m.
#[derive(Debug, PartialEq)]
pub(super) struct Drawn {
    pub vertices: Vec<[f32; 3]>,
}

impl Drawn {
    fn new(tiling: &Tiling, level: u32, heights: impl Iterator<Item = f32>) -> Self {
        let side = tiling.tile_side();
        let step = tiling.layout().grid().spacing() * f64::from(tiling.stride(level));
        let vertex = |(at, z): (usize, f32)| {
            let (column, row) = ((at % side) as f64, (at / side) as f64);
            [(column * step.x) as f32, (row * step.y) as f32, z]
        };
        Self {
            vertices: heights.enumerate().map(vertex).collect(),
        }
    }
}

/// The ways to come by a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// Each from a file of its own, opened, read and closed every time: what A compares with.
    Files,
    /// Each from the pyramid, checked and read anew every time.
    Anew,
    /// Kept in stores by level: A.
    Stores,
    /// Kept in a queue of 300, loaded in range of the eye and ahead of it: D.
    Queue,
}

impl Way {
    pub(super) const ALL: [Self; 4] = [Self::Files, Self::Anew, Self::Stores, Self::Queue];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Files => "files",
            Self::Anew => "anew",
            Self::Stores => "stores",
            Self::Queue => "queue",
        }
    }
}

/// Tiles of a pyramid in one of the ways.
pub(super) struct Supply<'a> {
    way: Way,
    pyramid: &'a Pyramid,
    files: &'a Path,
    store: TileStore<Drawn>,
    reach: Reach,
    last_eye: Option<DVec2>,
    asked: u64,
}

impl<'a> Supply<'a> {
    /// With nothing read yet. `files` is the folder that [`export`] wrote.
    pub(super) fn new(way: Way, pyramid: &'a Pyramid, files: &'a Path) -> Self {
        let finest = pyramid.tiling().finest();
        let keep = match way {
            Way::Queue => Keep::D,
            _ => Keep::All,
        };
        Self {
            way,
            pyramid,
            files,
            store: TileStore::new(keep),
            reach: Reach {
                near_m: 2.0 * pyramid.tiling().layout().side_m(finest),
                finest,
            },
            last_eye: None,
            asked: 0,
        }
    }

    /// With so many times the range.
    pub(super) fn reaching(mut self, times: f64) -> Self {
        self.reach.near_m *= times;
        self
    }

    /// What the store has done; nothing where there is none.
    pub(super) fn counts(&self) -> StoreCounts {
        self.store.counts()
    }

    /// Tiles read from disk so far.
    pub(super) fn read(&self) -> u64 {
        match self.way {
            Way::Files | Way::Anew => self.asked,
            Way::Stores | Way::Queue => self.store.counts().read,
        }
    }

    /// Follows the eye, where that is the way.
    fn follow(&mut self, eye: DVec3) -> Result<(), PyramidError> {
        if self.way != Way::Queue {
            return Ok(());
        }
        let (pyramid, eye) = (self.pyramid, eye.truncate());
        let (layout, read) = (pyramid.tiling().layout(), |node| drawn(pyramid, node));
        self.store.move_to(layout, &self.reach, eye, read)?;
        let motion = (eye - self.last_eye.unwrap_or(eye)) * FRAMES_AHEAD;
        let ahead = (eye, motion);
        self.store
            .read_ahead(layout, &self.reach, ahead, AHEAD, read)?;
        self.last_eye = Some(eye);
        Ok(())
    }

    fn tile(&mut self, node: Node) -> Result<Arc<Drawn>, ReportError> {
        let pyramid = self.pyramid;
        self.asked += 1;
        Ok(match self.way {
            Way::Files => Arc::new(from_file(pyramid.tiling(), self.files, node)?),
            Way::Anew => Arc::new(drawn(pyramid, node)?),
            Way::Stores | Way::Queue => self.store.tile(node, |node| drawn(pyramid, node))?,
        })
    }

    /// The tiles to draw for a view, ready to draw.
    ///
    /// Queue 1 holds the nodes of a level, queue 2 those of the next. A node that comes out of
    /// queue 1 is dropped if it is out of view, else supplied; where the criterion says so its
    /// children go into queue 2; else it is drawn.
    ///
    /// Source: A, section 1.3.
    pub(super) fn frame(
        &mut self,
        view: &View,
        knobs: &Knobs,
    ) -> Result<Vec<(Node, Arc<Drawn>)>, ReportError> {
        self.follow(view.eye())?;
        let (pyramid, tiling) = (self.pyramid, self.pyramid.tiling());
        let mut now: Vec<Node> = tiling.tiles(0).collect();
        let mut next = Vec::new();
        let mut frame = Vec::new();
        while !now.is_empty() {
            for node in now.drain(..) {
                let record = pyramid.record(node);
                if !record.has_ground() {
                    continue;
                }
                let bounds = bounds(tiling, node, [record.low, record.high]);
                if view.frustum().relation(&bounds) == Relation::Outside {
                    continue;
                }
                let tile = self.tile(node)?;
                let seen = Seen {
                    record: &record,
                    to_eye: view.eye() - bounds.center(),
                    side: tiling.layout().side_m(node.level),
                    block_side: tiling.layout().side_m(0),
                };
                if node.level < tiling.finest() && Criterion::Roughness.splits(&seen, knobs) {
                    next.extend((0..4).map(|quarter| node.child(quarter)));
                } else {
                    frame.push((node, tile));
                }
            }
            std::mem::swap(&mut now, &mut next);
        }
        Ok(frame)
    }
}

fn drawn(pyramid: &Pyramid, node: Node) -> Result<Drawn, PyramidError> {
    let heights = pyramid.tile(node)?.heights;
    Ok(Drawn::new(
        pyramid.tiling(),
        node.level,
        heights.into_iter(),
    ))
}

fn bounds(tiling: &Tiling, node: Node, [low, high]: [f32; 2]) -> Aabb {
    let (posts, grid) = (tiling.layout().posts(node), tiling.layout().grid());
    let corner =
        |[column, row]: [u32; 2], z: f32| DVec3::new(grid.x(column), grid.y(row), z.into());
    Aabb::around([corner(posts.first, low), corner(posts.last, high)])
}

/// A's index of tiles: a folder a level, a file a node, named by its number.
fn file_of(folder: &Path, tiling: &Tiling, node: Node) -> PathBuf {
    let block = tiling.layout().block_of(node).unwrap_or_default();
    let number = (block << (2 * node.level)) + node.number() as usize;
    folder.join(node.level.to_string()).join(number.to_string())
}

/// Writes every tile to a file of its own.
pub(super) fn export(pyramid: &Pyramid, folder: &Path) -> Result<(), ReportError> {
    let tiling = pyramid.tiling();
    for level in 0..=tiling.finest() {
        let path = folder.join(level.to_string());
        let made = std::fs::create_dir_all(&path);
        made.map_err(|source| ReportError::Write { path, source })?;
        for node in tiling.tiles(level) {
            let heights = pyramid.tile(node)?.heights;
            let path = file_of(folder, tiling, node);
            let written = std::fs::write(&path, bytemuck::cast_slice(&heights));
            written.map_err(|source| ReportError::Write { path, source })?;
        }
    }
    Ok(())
}

fn from_file(tiling: &Tiling, folder: &Path, node: Node) -> Result<Drawn, ReportError> {
    let path = file_of(folder, tiling, node);
    let mut bytes = Vec::with_capacity(tiling.tile_posts() * 4);
    let read = File::open(&path).and_then(|mut file| file.read_to_end(&mut bytes));
    read.map_err(|source| {
        ReportError::Pyramid(PyramidError::Io {
            path,
            action: "cannot read",
            source,
        })
    })?;
    let (heights, _) = bytes.as_chunks();
    let heights = heights.iter().map(|&h| f32::from_ne_bytes(h));
    Ok(Drawn::new(tiling, node.level, heights))
}
