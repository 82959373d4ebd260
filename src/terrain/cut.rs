//! A cut through the quadtree: which nodes are split, which are drawn.

use super::layout::Layout;
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

/// The states of a block's nodes as far down as any was reached, and for each node a bit for
/// every side whose midpoint it can spare, as far as any can.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct BlockCut {
    pub states: Vec<State>,
    spared: Vec<u8>,
}

/// A cut through the trees of all blocks.
///
/// Law: a node is split only if its parent is, and below a node that is not split all are
/// unreached.
#[derive(Debug, Clone, PartialEq)]
pub struct Cut {
    layout: Layout,
    blocks: Vec<Option<BlockCut>>,
}

impl State {
    /// Whether the node is drawn in parts.
    pub fn is_split(self) -> bool {
        matches!(self, Self::Split | Self::Kept)
    }
}

impl BlockCut {
    /// From the states of all nodes down to some level.
    pub fn new(states: Vec<State>) -> Self {
        Self {
            states,
            spared: Vec::new(),
        }
    }

    fn set(&mut self, node: Node, state: State) {
        if node.index() >= self.states.len() {
            if state == State::Unreached {
                return;
            }
            let level_end = level_start(node.level + 1);
            self.states.resize(level_end, State::Unreached);
        }
        self.states[node.index()] = state;
    }

    fn spare(&mut self, node: Node, side: usize) {
        if self.spared.is_empty() {
            self.spared.resize(self.states.len(), 0);
        }
        self.spared[node.index()] |= 1 << side;
    }

    /// The split nodes of a level, in the order of their numbers.
    fn splits(&self, root: Node, level: u32) -> impl Iterator<Item = Node> {
        let states = self.states.get(level_start(level)..level_start(level + 1));
        let numbered = (0..).zip(states.unwrap_or_default());
        let split = numbered.filter(|(_, state)| state.is_split());
        split.map(move |(number, _)| root.numbered(level, number))
    }

    /// All split nodes, coarse levels first.
    pub fn all_splits(&self, root: Node, levels: u32) -> impl Iterator<Item = Node> {
        (0..levels).flat_map(move |level| self.splits(root, level))
    }
}

impl Cut {
    pub(super) fn new(layout: &Layout, blocks: Vec<Option<BlockCut>>) -> Self {
        Self {
            layout: *layout,
            blocks,
        }
    }

    fn block_of(&self, node: Node) -> Option<&BlockCut> {
        self.blocks[self.layout.block_of(node)?].as_ref()
    }

    fn block_of_mut(&mut self, node: Node) -> Option<&mut BlockCut> {
        self.blocks[self.layout.block_of(node)?].as_mut()
    }

    /// The state of a node. Cells are unreached.
    pub fn state(&self, node: Node) -> State {
        let state = |block: &BlockCut| block.states.get(node.index()).copied();
        self.block_of(node).and_then(state).unwrap_or_default()
    }

    /// The state of the node or of the one above it that the cut ends at. In a block that was not
    /// looked at everything is hidden.
    pub fn cover(&self, node: Node) -> State {
        let above = std::iter::successors(Some(node), |node| node.parent());
        above
            .map(|node| self.state(node))
            .find(|state| *state != State::Unreached)
            .unwrap_or(State::Hidden)
    }

    pub(super) fn set(&mut self, node: Node, state: State) {
        if let Some(block) = self.block_of_mut(node) {
            block.set(node, state);
        }
    }

    /// Whether a split node does without the midpoint of a side, though it could be drawn.
    pub fn spares(&self, node: Node, side: usize) -> bool {
        let spared = |block: &BlockCut| block.spared.get(node.index()).copied();
        self.block_of(node).and_then(spared).unwrap_or_default() >> side & 1 == 1
    }

    pub(super) fn spare(&mut self, node: Node, side: usize) {
        if let Some(block) = self.block_of_mut(node) {
            block.spare(node, side);
        }
    }

    /// Levels of nodes that can be split.
    pub(super) fn levels(&self) -> std::ops::Range<u32> {
        0..self.layout.levels()
    }

    /// The split nodes of a level, block by block.
    pub fn splits(&self, level: u32) -> impl Iterator<Item = Node> {
        let levels = self.levels();
        let blocks = self.blocks().filter(move |_| levels.contains(&level));
        blocks.flat_map(move |(root, block)| block.splits(root, level))
    }

    /// The blocks that were looked at.
    pub(super) fn blocks(&self) -> impl Iterator<Item = (Node, &BlockCut)> {
        let numbered = self.blocks.iter().enumerate();
        numbered.filter_map(|(number, block)| Some((self.layout.block(number), block.as_ref()?)))
    }
}
