//! The traversal: breadth first from the blocks down, two queues, one level at a time.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use super::cut::{BlockCut, Cut, State};
use super::judge::Judge;
use super::quadtree::{Node, level_start};

/// One thread or all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Workers {
    /// The calling thread.
    #[default]
    One,
    /// As many as the current rayon pool has.
    Pool,
}

/// Subtrees in the queue that threads take work from, unless the blocks have no more: so many
/// that none is long idle, where the ground is rough in one place only, and so large that
/// judging them costs more than handing them over.
const SHARES: usize = 256;
/// Subtrees that are worth a thread.
const LEAST_SHARES: usize = 4;
/// Levels of a subtree that is handed over, at least.
const LEAST_LEVELS: u32 = 3;

impl Judge<'_> {
    /// The cut as the criterion alone makes it, without regard to neighbours.
    ///
    /// With several threads, the calling one walks through the coarsest levels and fills a queue
    /// with the nodes below them, from which all take one at a time and walk on. A node is judged
    /// by itself, and subtrees do not overlap, so the result is the same.
    ///
    /// Source: D, section 2.3 (a producer, consumers, and a queue of nodes).
    pub fn refine(&self, workers: Workers) -> Cut {
        let layout = self.ground.layout();
        let roots = (0..layout.block_count()).map(|number| layout.block(number));
        let levels = layout.levels();
        let blocks = match workers {
            Workers::One => roots.map(|root| self.walk(root, levels).0).collect(),
            Workers::Pool => self.shared(&roots.collect::<Vec<_>>()),
        };
        // A block out of view is as good as one that was never looked at.
        let seen = |states: Vec<State>| (states[0] != State::Hidden).then(|| BlockCut::new(states));
        Cut::new(layout, blocks.into_iter().map(seen).collect())
    }

    /// Breadth first from a node down to level `end`: the nodes of a level are judged, the
    /// children of those that are split wait in the second queue, and the queues are swapped.
    ///
    /// Gives the states of all nodes from this one down to the deepest reached, numbered as if it
    /// were a block, and the nodes of level `end` that wait.
    ///
    /// Source: A, section 1.3.
    fn walk(&self, from: Node, end: u32) -> (Vec<State>, Vec<Node>) {
        let cells = self.ground.layout().levels();
        let mut states = Vec::new();
        let (mut current, mut next) = (vec![from], Vec::new());
        for level in from.level..end {
            if current.is_empty() {
                break;
            }
            let below = level - from.level;
            states.resize(level_start(below + 1), State::Unreached);
            for node in current.drain(..) {
                let state = self.state(node);
                let place = Node {
                    level: below,
                    ..node
                };
                states[place.index()] = state;
                if state == State::Split && level + 1 < cells {
                    next.extend((0..4).map(|quarter| node.child(quarter)));
                }
            }
            std::mem::swap(&mut current, &mut next);
        }
        (states, current)
    }

    /// The states of all blocks, by all threads.
    fn shared(&self, roots: &[Node]) -> Vec<Vec<State>> {
        let levels = self.ground.layout().levels();
        let enough = |top: u32| roots.len() << (2 * top) >= SHARES;
        let top = (0..levels.saturating_sub(LEAST_LEVELS)).find(|&top| enough(top));
        let top = top.unwrap_or(levels.saturating_sub(LEAST_LEVELS));
        let mut blocks = Vec::with_capacity(roots.len());
        let mut queue = Vec::new();
        for (number, &root) in roots.iter().enumerate() {
            let (states, waiting) = self.walk(root, top);
            blocks.push(states);
            queue.extend(waiting.into_iter().map(|node| (number, node)));
        }
        let next = AtomicUsize::new(0);
        let consume = || {
            let mut walked = Vec::new();
            while let Some(&(number, node)) = queue.get(next.fetch_add(1, Ordering::Relaxed)) {
                walked.push((number, node, self.walk(node, levels).0));
            }
            walked
        };
        let consumers = rayon::current_num_threads().min(queue.len() / LEAST_SHARES);
        // New threads, which the system puts on idle cores; those of a pool it wakes where they
        // slept, which may be one core for all of them, longer than a frame takes.
        let walked = thread::scope(|scope| {
            let others: Vec<_> = (1..consumers).map(|_| scope.spawn(consume)).collect();
            let mut walked = consume();
            for other in others {
                walked.extend(other.join().unwrap_or_else(|panic| resume_unwind(panic)));
            }
            walked
        });
        for (number, node, states) in walked {
            graft(&mut blocks[number], node, &states);
        }
        blocks
    }
}

/// Puts the states of a subtree into its block, row by row.
fn graft(block: &mut Vec<State>, node: Node, subtree: &[State]) {
    let mut below = 0;
    while level_start(below) < subtree.len() {
        let side = 1_usize << below;
        let first = Node {
            level: node.level + below,
            x: node.x << below,
            y: node.y << below,
        };
        let end = level_start(first.level + 1);
        block.resize(end.max(block.len()), State::Unreached);
        let rows = subtree[level_start(below)..].chunks_exact(side);
        let places = block[first.index()..].chunks_mut(1 << first.level);
        for (row, place) in rows.take(side).zip(places) {
            place[..side].copy_from_slice(row);
        }
        below += 1;
    }
}
