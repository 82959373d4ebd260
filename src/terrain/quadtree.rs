//! Numbers of quadtree nodes: within a block, and across all blocks of a level.

/// A quarter of a node, counter-clockwise from the south-west. Corner k of a node is the outer
/// corner of its quarter k; side k runs from corner k to corner k + 1: south, east, north, west.
pub type Quarter = usize;

/// Row and column of each quarter within its parent.
pub const QUARTERS: [[u32; 2]; 4] = [[0, 0], [0, 1], [1, 1], [1, 0]];

/// A node of the forest of blocks. Level 0 are the blocks themselves; on level L each block has
/// 2^L × 2^L nodes, and `x`, `y` count them from the south-west of the whole ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Node {
    /// 0 is a whole block.
    pub level: u32,
    /// From the west.
    pub x: u32,
    /// From the south.
    pub y: u32,
}

impl Node {
    /// The node of the level above that holds this one; `None` for a block.
    pub fn parent(self) -> Option<Self> {
        (self.level > 0).then(|| Self {
            level: self.level - 1,
            x: self.x / 2,
            y: self.y / 2,
        })
    }

    /// One of the four quarters.
    #[must_use]
    pub fn child(self, quarter: Quarter) -> Self {
        let [row, column] = QUARTERS[quarter];
        Self {
            level: self.level + 1,
            x: 2 * self.x + column,
            y: 2 * self.y + row,
        }
    }

    /// Which quarter of its parent this is.
    pub fn quarter(self) -> Quarter {
        match (self.x % 2, self.y % 2) {
            (0, 0) => 0,
            (1, 0) => 1,
            (1, 1) => 2,
            _ => 3,
        }
    }

    /// The node of the same level across a side; `None` to the west and south of the ground.
    /// To the east and north it may lie beyond it.
    pub fn across(self, side: usize) -> Option<Self> {
        let (x, y) = match side {
            0 => (Some(self.x), self.y.checked_sub(1)),
            1 => (self.x.checked_add(1), Some(self.y)),
            2 => (Some(self.x), self.y.checked_add(1)),
            _ => (self.x.checked_sub(1), Some(self.y)),
        };
        Some(Self {
            level: self.level,
            x: x?,
            y: y?,
        })
    }

    /// The node of a number on a level of this block; see [`Node::number`].
    #[must_use]
    pub fn numbered(self, level: u32, number: u32) -> Self {
        let side = 1 << level;
        Self {
            level,
            x: (self.x << level) + number % side,
            y: (self.y << level) + number / side,
        }
    }

    /// Its number within its block, row by row from the south-west, per level from 0.
    pub fn number(self) -> u32 {
        let within = (1 << self.level) - 1;
        ((self.y & within) << self.level) + (self.x & within)
    }

    /// Where it stands among all nodes of its block, coarse levels first.
    pub fn index(self) -> usize {
        level_start(self.level) + self.number() as usize
    }
}

/// Number of a child on the level below.
///
/// Source: A, equation (1), which is garbled in print: child (dr, dc) of node N on level L is
/// 2N + dc + (⌊N/2^L⌋ + dr)·2^(L+1).
pub fn child_number(number: u32, level: u32, [dr, dc]: [u32; 2]) -> u32 {
    2 * number + dc + (((number >> level) + dr) << (level + 1))
}

/// How many nodes the levels above `level` have in one block: where the level starts in a flat
/// array.
pub fn level_start(level: u32) -> usize {
    ((1 << (2 * level as usize)) - 1) / 3
}
