//! What was read of the ground, kept for the next frame.
//!
//! Two policies over one structure. A keeps all that was read, one store a level, and looks there
//! before it reads ([`Keep::All`], [`TileStore::tile`]). D keeps at most 300 tiles: what comes into
//! range of the eye is loaded, what is beyond twice that is dropped, and where room is wanted the
//! tile that came first goes first ([`Keep::Fifo`], [`TileStore::move_to`]).
//!
//! D names one range for its one resolution. In a pyramid each coarser level reaches twice as far,
//! so that with distance the ground gets coarser and does not end.
//!
//! Reads no clock and starts no thread: who has time to spare gives it by calling
//! [`TileStore::read_ahead`].
//!
//! Sources: A, sections 1.2 and 1.3; D, section 3.2.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use super::layout::Layout;
use super::quadtree::Node;
use crate::geom::DVec2;

/// How much is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// Everything that was read and lies within twice its range.
    All,
    /// At most so many tiles beside the resident ones, at least 1.
    Fifo {
        /// D keeps 300.
        tiles: usize,
    },
}

impl Keep {
    /// As many as D keeps.
    pub const D: Self = Self::Fifo { tiles: 300 };
}

/// Where tiles are wanted: within `near_m` of the eye on the finest level, and twice as far with
/// each level above. Distances are horizontal, to the nearest point of a tile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Range on the finest level, m.
    pub near_m: f64,
    /// The finest level of tiles; 0 where there is one level.
    pub finest: u32,
}

impl Reach {
    /// How far a level reaches, m.
    pub fn of_level(&self, level: u32) -> f64 {
        self.near_m * f64::from(1_u32 << (self.finest - level.min(self.finest)))
    }

    /// Whether a tile is within so many ranges of the eye.
    fn holds(&self, layout: &Layout, eye: DVec2, node: Node, ranges: f64) -> bool {
        distance(layout, eye, node) <= ranges * self.of_level(node.level)
    }

    /// The tiles in range, coarse levels first, within a level the nearest first, ties by row and
    /// column.
    pub fn wanted(&self, layout: &Layout, eye: DVec2) -> Vec<Node> {
        let mut wanted = Vec::new();
        for level in 0..=self.finest {
            let first = wanted.len();
            self.add_level(layout, eye, level, &mut wanted);
            let by_distance = |a: &Node, b: &Node| {
                let [a_m, b_m] = [a, b].map(|&node| distance(layout, eye, node));
                a_m.total_cmp(&b_m).then((a.y, a.x).cmp(&(b.y, b.x)))
            };
            wanted[first..].sort_by(by_distance);
        }
        wanted
    }

    fn add_level(&self, layout: &Layout, eye: DVec2, level: u32, wanted: &mut Vec<Node>) {
        let (grid, range) = (layout.grid(), self.of_level(level));
        let cells = f64::from(1_u32 << (layout.levels() - level));
        let nodes = layout.blocks().map(|blocks| u64::from(blocks) << level);
        // Nodes that the range may touch along one axis, one more at either end for rounding.
        let span = |axis: usize| {
            let at = (eye[axis] - grid.origin()[axis]) / (grid.spacing()[axis] * cells);
            let reach = range / (grid.spacing()[axis] * cells);
            let last = nodes[axis] as f64 - 1.0;
            let from = (at - reach - 1.0).clamp(0.0, last.max(0.0)) as u32;
            let to = (at + reach + 1.0).clamp(0.0, last.max(0.0)) as u32;
            from..=to
        };
        if nodes.contains(&0) {
            return;
        }
        for y in span(1) {
            let row = span(0).map(|x| Node { level, x, y });
            wanted.extend(row.filter(|&node| self.holds(layout, eye, node, 1.0)));
        }
    }
}

/// Horizontal distance from the eye to the nearest point of a node, m; infinite where folding has
/// left no area, as there is nothing to draw.
fn distance(layout: &Layout, eye: DVec2, node: Node) -> f64 {
    let (posts, grid) = (layout.posts(node), layout.grid());
    if posts.is_flat() {
        return f64::INFINITY;
    }
    let corner = |[column, row]: [u32; 2]| DVec2::new(grid.x(column), grid.y(row));
    let nearest = eye.clamp(corner(posts.first), corner(posts.last));
    eye.distance(nearest)
}

/// What a store has done since it was made.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StoreCounts {
    /// Tiles asked for.
    pub asked: u64,
    /// Of these, found in the store.
    pub found: u64,
    /// Tiles read, whether asked for or ahead.
    pub read: u64,
    /// Tiles dropped.
    pub dropped: u64,
    /// The most tiles held at once, resident ones included.
    pub most: usize,
}

/// Tiles by level and node. `T` is what a tile is to its reader: heights, a whole block, or
/// vertices ready to draw.
///
/// Laws: a tile is read again only after it was dropped; beside the resident tiles no more than
/// [`Keep`] says are held; resident tiles are never dropped.
#[derive(Debug)]
pub struct TileStore<T> {
    keep: Keep,
    /// A's stores, one a level.
    levels: Vec<BTreeMap<Node, Arc<T>>>,
    /// D's queue, oldest first; resident tiles are not in it.
    history: VecDeque<Node>,
    resident: BTreeSet<Node>,
    counts: StoreCounts,
}

impl<T> TileStore<T> {
    /// An empty store.
    pub fn new(keep: Keep) -> Self {
        Self {
            keep,
            levels: Vec::new(),
            history: VecDeque::new(),
            resident: BTreeSet::new(),
            counts: StoreCounts::default(),
        }
    }

    /// A tile from the store of its level, or else from the reader, kept for the next time.
    ///
    /// # Errors
    /// Those of `read`; nothing is kept then.
    pub fn tile<E>(
        &mut self,
        node: Node,
        read: impl FnOnce(Node) -> Result<T, E>,
    ) -> Result<Arc<T>, E> {
        self.counts.asked += 1;
        if let Some(tile) = self.held(node) {
            let tile = Arc::clone(tile);
            self.counts.found += 1;
            return Ok(tile);
        }
        self.load(node, read, |_| false)
    }

    /// A tile, if it is held.
    pub fn held(&self, node: Node) -> Option<&Arc<T>> {
        self.levels.get(node.level as usize)?.get(&node)
    }

    /// Follows the eye: drops what is beyond twice the range, then loads what is in range and not
    /// held, in the order of [`Reach::wanted`] and no more than fits. Room is made by dropping the
    /// tile that came first of those not in range.
    ///
    /// # Errors
    /// Those of `read`; what was loaded before stays.
    pub fn move_to<E>(
        &mut self,
        layout: &Layout,
        reach: &Reach,
        eye: DVec2,
        mut read: impl FnMut(Node) -> Result<T, E>,
    ) -> Result<(), E> {
        for node in std::mem::take(&mut self.history) {
            if reach.holds(layout, eye, node, 2.0) {
                self.history.push_back(node);
            } else {
                self.drop_tile(node);
            }
        }
        let mut wanted = reach.wanted(layout, eye);
        wanted.retain(|node| !self.resident.contains(node));
        if let Keep::Fifo { tiles } = self.keep {
            wanted.truncate(tiles.max(1));
        }
        let spared: BTreeSet<Node> = wanted.iter().copied().collect();
        for node in wanted {
            if self.held(node).is_none() {
                self.load(node, &mut read, |held| spared.contains(&held))?;
            }
        }
        Ok(())
    }

    /// Loads tiles that will be in range when the eye has moved on by `motion`, at most `tiles` of
    /// them, without dropping any that are in range now. Returns how many it read: fewer than
    /// `tiles` when nothing is left to do.
    ///
    /// # Errors
    /// Those of `read`; what was loaded before stays.
    pub fn read_ahead<E>(
        &mut self,
        layout: &Layout,
        reach: &Reach,
        (eye, motion): (DVec2, DVec2),
        tiles: usize,
        mut read: impl FnMut(Node) -> Result<T, E>,
    ) -> Result<usize, E> {
        let now: BTreeSet<Node> = reach.wanted(layout, eye).into_iter().collect();
        let mut done = 0;
        for node in reach.wanted(layout, eye + motion) {
            if done == tiles || !self.has_room(|held| now.contains(&held)) {
                break;
            }
            if self.held(node).is_none() {
                self.load(node, &mut read, |held| now.contains(&held))?;
                done += 1;
            }
        }
        Ok(done)
    }

    /// Holds these tiles from now on, whatever the eye does: A's simulation region, whose ground
    /// stays in memory at full detail. They do not count against [`Keep::Fifo`].
    ///
    /// # Errors
    /// Those of `read`; what was loaded before stays.
    pub fn keep_resident<E>(
        &mut self,
        nodes: impl IntoIterator<Item = Node>,
        mut read: impl FnMut(Node) -> Result<T, E>,
    ) -> Result<(), E> {
        for node in nodes {
            if self.held(node).is_none() {
                let tile = read(node)?;
                self.put(node, tile);
            }
            self.history.retain(|&held| held != node);
            self.resident.insert(node);
        }
        Ok(())
    }

    /// Lets the resident tiles go: they become the newest of the others.
    pub fn release_resident(&mut self) {
        for node in std::mem::take(&mut self.resident) {
            self.make_room(|_| false);
            self.history.push_back(node);
        }
    }

    /// Whether a tile is resident.
    pub fn is_resident(&self, node: Node) -> bool {
        self.resident.contains(&node)
    }

    /// Tiles held, resident ones included.
    pub fn len(&self) -> usize {
        self.history.len() + self.resident.len()
    }

    /// Whether none is held.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What was done so far.
    pub fn counts(&self) -> StoreCounts {
        self.counts
    }

    fn load<E>(
        &mut self,
        node: Node,
        read: impl FnOnce(Node) -> Result<T, E>,
        spared: impl Fn(Node) -> bool,
    ) -> Result<Arc<T>, E> {
        let tile = read(node)?;
        self.make_room(spared);
        self.history.push_back(node);
        Ok(self.put(node, tile))
    }

    fn put(&mut self, node: Node, tile: T) -> Arc<T> {
        let tile = Arc::new(tile);
        let level = node.level as usize;
        if self.levels.len() <= level {
            self.levels.resize_with(level + 1, BTreeMap::new);
        }
        self.levels[level].insert(node, Arc::clone(&tile));
        self.counts.read += 1;
        let held = self.levels.iter().map(BTreeMap::len).sum();
        self.counts.most = self.counts.most.max(held);
        tile
    }

    /// Whether one more can be held without dropping a spared one.
    fn has_room(&self, spared: impl Fn(Node) -> bool) -> bool {
        match self.keep {
            Keep::All => true,
            Keep::Fifo { tiles } => {
                self.history.len() < tiles.max(1) || self.history.iter().any(|&n| !spared(n))
            }
        }
    }

    /// Drops the tile that came first, of those not spared if there are any, until one more fits.
    fn make_room(&mut self, spared: impl Fn(Node) -> bool) {
        let Keep::Fifo { tiles } = self.keep else {
            return;
        };
        while self.history.len() >= tiles.max(1) {
            let first = self.history.iter().position(|&node| !spared(node));
            let Some(node) = self.history.remove(first.unwrap_or(0)) else {
                return;
            };
            self.drop_tile(node);
        }
    }

    fn drop_tile(&mut self, node: Node) {
        if let Some(level) = self.levels.get_mut(node.level as usize) {
            level.remove(&node);
        }
        self.counts.dropped += 1;
    }
}
