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

use std::cmp::Ordering;
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
    /// How far a level reaches, m; those finer than the finest as far as that.
    pub fn of_level(&self, level: u32) -> f64 {
        self.near_m * f64::from(self.finest.saturating_sub(level)).exp2()
    }

    /// Whether a tile is within so many ranges of the eye.
    fn holds(&self, layout: &Layout, eye: DVec2, node: Node, ranges: f64) -> bool {
        let away = distance(layout, eye, node);
        away.is_some_and(|away| away <= ranges * self.of_level(node.level))
    }

    /// The first `most` tiles in range: coarse levels first, within a level the nearest first,
    /// ties by row and column. Takes time and memory for these, not for all that are in range.
    pub fn wanted(&self, layout: &Layout, eye: DVec2, most: usize) -> Vec<Node> {
        let mut wanted = Vec::new();
        for level in 0..=self.finest.min(layout.levels()) {
            let left = most - wanted.len();
            if left == 0 {
                break;
            }
            let mut nearest = self.nearest(layout, eye, level, left);
            nearest
                .sort_by(|(a_m, a), (b_m, b)| a_m.total_cmp(b_m).then((a.y, a.x).cmp(&(b.y, b.x))));
            wanted.extend(nearest.into_iter().take(left).map(|(_, node)| node));
        }
        wanted
    }

    /// At least the first `most` tiles of a level that are in range, with their distances: those
    /// in a range that is doubled until it holds enough.
    fn nearest(&self, layout: &Layout, eye: DVec2, level: u32, most: usize) -> Vec<(f64, Node)> {
        let grid = layout.grid();
        let far = DVec2::new(grid.x(grid.columns() - 1), grid.y(grid.rows() - 1));
        let outside = eye.distance(eye.clamp(grid.origin(), far));
        let whole = (eye - grid.origin()).abs().max((eye - far).abs()).length();
        let most_m = self.of_level(level).min(whole);
        let mut within = layout.side_m(level);
        loop {
            let range_m = (outside + within).min(most_m);
            let found = in_range(layout, eye, level, range_m);
            // Not `<`, so that an eye that is nowhere ends it too.
            if found.len() >= most || range_m.partial_cmp(&most_m) != Some(Ordering::Less) {
                return found;
            }
            within *= 2.0;
        }
    }
}

/// The tiles of a level within a range, with their distances.
fn in_range(layout: &Layout, eye: DVec2, level: u32, range_m: f64) -> Vec<(f64, Node)> {
    let (grid, cells) = (layout.grid(), f64::from(layout.cells(level)));
    let nodes = layout.blocks().map(|blocks| u64::from(blocks) << level);
    if nodes.contains(&0) {
        return Vec::new();
    }
    // Nodes that the range may touch along one axis, one more at either end for rounding.
    let span = |axis: usize| {
        let side_m = grid.spacing()[axis] * cells;
        let at = (eye[axis] - grid.origin()[axis]) / side_m;
        let last = nodes[axis] as f64 - 1.0;
        let end = |at: f64| at.clamp(0.0, last) as u32;
        end(at - range_m / side_m - 1.0)..=end(at + range_m / side_m + 1.0)
    };
    let all = span(1).flat_map(|y| span(0).map(move |x| Node { level, x, y }));
    all.filter_map(|node| Some((distance(layout, eye, node)?, node)))
        .filter(|(away, _)| *away <= range_m)
        .collect()
}

/// Horizontal distance from the eye to the nearest point of a node, m; `None` where folding has
/// left no area, as there is nothing to draw.
fn distance(layout: &Layout, eye: DVec2, node: Node) -> Option<f64> {
    let (posts, grid) = (layout.posts(node), layout.grid());
    if posts.is_flat() {
        return None;
    }
    let corner = |[column, row]: [u32; 2]| DVec2::new(grid.x(column), grid.y(row));
    let nearest = eye.clamp(corner(posts.first), corner(posts.last));
    Some(eye.distance(nearest))
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
        let most = match self.keep {
            Keep::All => usize::MAX,
            Keep::Fifo { tiles } => tiles.max(1),
        };
        let mut wanted = reach.wanted(layout, eye, most.saturating_add(self.resident.len()));
        wanted.retain(|node| !self.resident.contains(node));
        wanted.truncate(most);
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
        let now = |held| reach.holds(layout, eye, held, 1.0);
        let mut done = 0;
        for node in reach.wanted(layout, eye + motion, tiles.saturating_add(self.len())) {
            if done == tiles || !self.has_room(now) {
                break;
            }
            if self.held(node).is_none() {
                self.load(node, &mut read, now)?;
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
