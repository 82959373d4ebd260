//! A cut through the quadtree: which nodes are split, which are drawn.

use super::ground::Ground;
use super::quadtree::{Node, level_start};

/// What a node is in a cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum State {
    /// Below a node that is not split, or in a block that was not looked at.
    #[default]
    Unreached,
    /// Not split and to be drawn: it may be in view and has no hole.
    Drawn,
    /// Not split and not drawn: out of view, or without ground.
    Hidden,
    /// Drawn in parts; may be taken back where neighbours are too coarse.
    Split,
    /// Drawn in parts whatever the neighbours: they follow.
    Kept,
}

/// The states of a block's nodes that have a record, the split ones by level, and for each node a
/// bit for every side whose midpoint it can spare.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct BlockCut {
    pub states: Vec<State>,
    pub splits: Vec<Vec<Node>>,
    pub spared: Vec<u8>,
}

/// A cut through the trees of all blocks.
///
/// Law: a node is split only if its parent is, and below a node that is not split all are
/// unreached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cut {
    levels: u32,
    blocks: Vec<Option<BlockCut>>,
}

impl State {
    /// Whether the node is drawn in parts.
    pub fn is_split(self) -> bool {
        matches!(self, Self::Split | Self::Kept)
    }
}

impl BlockCut {
    pub fn new(levels: u32) -> Self {
        Self {
            states: vec![State::Unreached; level_start(levels)],
            splits: vec![Vec::new(); levels as usize],
            spared: vec![0; level_start(levels)],
        }
    }
}

impl Cut {
    pub(super) fn new(ground: &Ground, blocks: Vec<Option<BlockCut>>) -> Self {
        Self {
            levels: ground.layout().levels(),
            blocks,
        }
    }

    /// The state of a node that is no cell.
    pub fn state(&self, ground: &Ground, node: Node) -> State {
        let number = ground.layout().block_of(node);
        let block = number.and_then(|number| self.blocks[number].as_ref());
        block.map_or(State::Unreached, |block| block.states[node.index()])
    }

    /// The state of the node or of the one above it that the cut ends at. In a block that was not
    /// looked at everything is hidden.
    pub fn cover(&self, ground: &Ground, node: Node) -> State {
        let above = std::iter::successors(Some(node), |node| node.parent());
        above
            .map(|node| self.state(ground, node))
            .find(|state| *state != State::Unreached)
            .unwrap_or(State::Hidden)
    }

    pub(super) fn set(&mut self, ground: &Ground, node: Node, state: State) {
        let number = ground.layout().block_of(node);
        if let Some(block) = number.and_then(|number| self.blocks[number].as_mut()) {
            block.states[node.index()] = state;
        }
    }

    /// Whether a split node does without the midpoint of a side, though it could be drawn.
    pub fn spares(&self, ground: &Ground, node: Node, side: usize) -> bool {
        let number = ground.layout().block_of(node);
        let block = number.and_then(|number| self.blocks[number].as_ref());
        block.is_some_and(|block| block.spared[node.index()] >> side & 1 == 1)
    }

    pub(super) fn spare(&mut self, ground: &Ground, node: Node, side: usize) {
        let number = ground.layout().block_of(node);
        if let Some(block) = number.and_then(|number| self.blocks[number].as_mut()) {
            block.spared[node.index()] |= 1 << side;
        }
    }

    /// Notes that a node is split now; its state is set elsewhere.
    pub(super) fn note_split(&mut self, ground: &Ground, node: Node) {
        let number = ground.layout().block_of(node);
        if let Some(block) = number.and_then(|number| self.blocks[number].as_mut()) {
            block.splits[node.level as usize].push(node);
        }
    }

    /// Levels of nodes that can be split.
    pub(super) fn levels(&self) -> std::ops::Range<u32> {
        0..self.levels
    }

    /// The split nodes of a level, block by block.
    pub fn splits(&self, level: u32) -> impl Iterator<Item = Node> {
        let blocks = self.blocks.iter().flatten();
        blocks.flat_map(move |block| block.splits[level as usize].iter().copied())
    }

    /// Forgets the split nodes that are no longer.
    pub(super) fn retain_splits(&mut self) {
        for block in self.blocks.iter_mut().flatten() {
            let states = &block.states;
            for nodes in &mut block.splits {
                nodes.retain(|node| states[node.index()].is_split());
            }
        }
    }

    /// Numbers of the blocks that were looked at.
    pub(super) fn blocks(&self) -> impl Iterator<Item = (usize, &BlockCut)> {
        let numbered = self.blocks.iter().enumerate();
        numbered.filter_map(|(number, block)| Some((number, block.as_ref()?)))
    }
}
