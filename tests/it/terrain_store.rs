use std::convert::Infallible;

use citylod::geom::DVec2;
use citylod::terrain::pyramid::Tiling;
use citylod::terrain::{Grid, Keep, Layout, Node, Reach, TileStore};
use proptest::prelude::*;

fn tiling() -> Tiling {
    let grid = Grid::new(150, 90, DVec2::new(1000.0, 500.0), DVec2::new(10.0, 20.0)).unwrap();
    Tiling::with_levels(Layout::with_levels(grid, 6), 4)
}

fn reach(near_m: f64) -> Reach {
    Reach {
        near_m,
        finest: tiling().finest(),
    }
}

/// All tiles there are, with their rectangles worked out by hand: the raster reaches from 1000 to
/// 2490 east and from 500 to 2280 north.
fn all() -> Vec<(Node, [f64; 4])> {
    let tiling = tiling();
    let nodes = (0..=tiling.finest()).flat_map(|level| tiling.tiles(level));
    nodes
        .map(|node| {
            let (side_x, side_y) = (
                640.0 / f64::from(1 << node.level),
                1280.0 / f64::from(1 << node.level),
            );
            let (x, y) = (f64::from(node.x), f64::from(node.y));
            let west = 1000.0 + x * side_x;
            let south = 500.0 + y * side_y;
            (
                node,
                [
                    west,
                    south,
                    (west + side_x).min(2490.0),
                    (south + side_y).min(2280.0),
                ],
            )
        })
        .filter(|(_, [west, south, east, north])| west < east && south < north)
        .collect()
}

/// What the store is said to do, on plain lists.
#[derive(Default)]
struct Model {
    capacity: Option<usize>,
    held: Vec<Node>,
    resident: Vec<Node>,
    read: u64,
}

fn away([west, south, east, north]: [f64; 4], eye: DVec2) -> f64 {
    let outside = |at: f64, low: f64, high: f64| (low - at).max(at - high).max(0.0);
    outside(eye.x, west, east).hypot(outside(eye.y, south, north))
}

impl Model {
    fn range(node: Node, near_m: f64) -> f64 {
        near_m * f64::from(1 << (tiling().finest() - node.level))
    }

    fn wanted(eye: DVec2, near_m: f64) -> Vec<Node> {
        let mut found: Vec<(u32, f64, u32, u32)> = all()
            .into_iter()
            .map(|(node, rectangle)| (node, away(rectangle, eye)))
            .filter(|&(node, away)| away <= Self::range(node, near_m))
            .map(|(node, away)| (node.level, away, node.y, node.x))
            .collect();
        found.sort_by(|a, b| a.partial_cmp(b).unwrap());
        found
            .into_iter()
            .map(|(level, _, y, x)| Node { level, x, y })
            .collect()
    }

    fn has(&self, node: Node) -> bool {
        self.held.contains(&node) || self.resident.contains(&node)
    }

    fn load(&mut self, node: Node, spared: &[Node]) {
        if let Some(capacity) = self.capacity {
            while self.held.len() >= capacity {
                let victim = self
                    .held
                    .iter()
                    .position(|n| !spared.contains(n))
                    .unwrap_or(0);
                self.held.remove(victim);
            }
        }
        self.held.push(node);
        self.read += 1;
    }

    fn move_to(&mut self, eye: DVec2, near_m: f64) {
        let rectangles = all();
        self.held.retain(|node| {
            let rectangle = rectangles.iter().find(|(n, _)| n == node).unwrap().1;
            away(rectangle, eye) <= 2.0 * Self::range(*node, near_m)
        });
        let mut wanted = Self::wanted(eye, near_m);
        wanted.retain(|node| !self.resident.contains(node));
        wanted.truncate(self.capacity.unwrap_or(usize::MAX));
        for &node in &wanted {
            if !self.has(node) {
                self.load(node, &wanted);
            }
        }
    }

    fn read_ahead(&mut self, eye: DVec2, motion: DVec2, near_m: f64, tiles: usize) -> usize {
        let now = Self::wanted(eye, near_m);
        let mut done = 0;
        for node in Self::wanted(eye + motion, near_m) {
            let full = self.capacity.is_some_and(|c| self.held.len() >= c);
            if done == tiles || full && self.held.iter().all(|n| now.contains(n)) {
                break;
            }
            if !self.has(node) {
                self.load(node, &now);
                done += 1;
            }
        }
        done
    }
}

#[derive(Debug, Clone)]
enum Deed {
    Move(DVec2),
    Ask(usize),
    Ahead(DVec2, DVec2, usize),
    Reside(usize, usize),
    Release,
}

fn place() -> impl Strategy<Value = DVec2> {
    (500.0..3000.0, 0.0..2800.0).prop_map(DVec2::from)
}

fn deed() -> impl Strategy<Value = Deed> {
    prop_oneof![
        4 => place().prop_map(Deed::Move),
        3 => (0_usize..1000).prop_map(Deed::Ask),
        2 => (place(), (-400.0..400.0, -400.0..400.0), 0_usize..9)
            .prop_map(|(eye, motion, n)| Deed::Ahead(eye, motion.into(), n)),
        1 => (0_usize..1000, 0_usize..6).prop_map(|(from, n)| Deed::Reside(from, n)),
        1 => Just(Deed::Release),
    ]
}

#[allow(clippy::unnecessary_wraps, reason = "a reader may fail")]
fn name(node: Node) -> Result<String, Infallible> {
    Ok(format!("{node:?}"))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    /// The store holds and reads what plain lists say it should, whatever is done to it.
    #[test]
    fn a_store_is_its_model(
        capacity in prop_oneof![Just(None), (1_usize..40).prop_map(Some)],
        near_m in 50.0..500.0,
        deeds in prop::collection::vec(deed(), 1..60),
    ) {
        let tiling = tiling();
        let layout = *tiling.layout();
        let nodes: Vec<Node> = all().into_iter().map(|(node, _)| node).collect();
        let keep = capacity.map_or(Keep::All, |tiles| Keep::Fifo { tiles });
        let (mut store, mut model) = (TileStore::new(keep), Model { capacity, ..Model::default() });
        for deed in deeds {
            match deed {
                Deed::Move(eye) => {
                    store.move_to(&layout, &reach(near_m), eye, name).unwrap();
                    model.move_to(eye, near_m);
                }
                Deed::Ask(at) => {
                    let node = nodes[at % nodes.len()];
                    let tile = store.tile(node, name).unwrap();
                    prop_assert_eq!(tile.as_str(), format!("{node:?}"));
                    if !model.has(node) {
                        model.load(node, &[]);
                    }
                }
                Deed::Ahead(eye, motion, n) => {
                    let done = store.read_ahead(&layout, &reach(near_m), (eye, motion), n, name);
                    prop_assert_eq!(done.unwrap(), model.read_ahead(eye, motion, near_m, n));
                }
                Deed::Reside(from, n) => {
                    let chosen: Vec<Node> = nodes.iter().copied().cycle().skip(from % nodes.len()).take(n).collect();
                    store.keep_resident(chosen.iter().copied(), name).unwrap();
                    for node in chosen {
                        model.read += u64::from(!model.has(node));
                        model.held.retain(|&n| n != node);
                        if !model.resident.contains(&node) {
                            model.resident.push(node);
                        }
                    }
                }
                Deed::Release => {
                    store.release_resident();
                    model.resident.sort();
                    for node in std::mem::take(&mut model.resident) {
                        model.load(node, &[]);
                        model.read -= 1;
                    }
                }
            }
            for &node in &nodes {
                prop_assert_eq!(store.held(node).is_some(), model.has(node), "{:?}", node);
                prop_assert_eq!(store.is_resident(node), model.resident.contains(&node));
            }
            prop_assert_eq!(store.len(), model.held.len() + model.resident.len());
            prop_assert_eq!(store.counts().read, model.read);
            if let Some(capacity) = capacity {
                prop_assert!(model.held.len() <= capacity);
            }
        }
    }

    /// After a move all tiles in range are held, as many as there is room for.
    #[test]
    fn what_is_in_range_is_held(eyes in prop::collection::vec(place(), 1..20), near_m in 50.0..400.0) {
        let layout = *tiling().layout();
        let mut store = TileStore::new(Keep::D);
        for eye in eyes {
            store.move_to(&layout, &reach(near_m), eye, name).unwrap();
            for node in Model::wanted(eye, near_m) {
                prop_assert!(store.held(node).is_some());
            }
            let before = store.counts().read;
            store.move_to(&layout, &reach(near_m), eye, name).unwrap();
            prop_assert_eq!(store.counts().read, before, "read again without moving");
        }
    }
}

/// Tiles that were read ahead are not read when the eye gets there.
#[test]
fn reading_ahead_leaves_nothing_to_read_on_arrival() {
    let layout = *tiling().layout();
    let reach = reach(100.0);
    let mut store = TileStore::new(Keep::D);
    let (mut eye, motion) = (DVec2::new(1100.0, 700.0), DVec2::new(60.0, 35.0));
    store.move_to(&layout, &reach, eye, name).unwrap();
    let mut ahead = 0;
    for _ in 0..20 {
        ahead += store
            .read_ahead(&layout, &reach, (eye, motion), usize::MAX, name)
            .unwrap();
        let before = store.counts().read;
        eye += motion;
        store.move_to(&layout, &reach, eye, name).unwrap();
        assert_eq!(store.counts().read, before);
    }
    assert!(ahead > 20, "{ahead} tiles read ahead");
    assert!(store.counts().dropped > 0);
}

/// A failed read is reported, and nothing is kept of it.
#[test]
fn a_failed_read_is_tried_again() {
    let layout = *tiling().layout();
    let mut store: TileStore<u32> = TileStore::new(Keep::D);
    let node = Node {
        level: 1,
        x: 1,
        y: 0,
    };
    assert_eq!(store.tile(node, |_| Err("broken")), Err("broken"));
    assert!(store.held(node).is_none() && store.is_empty());
    let eye = DVec2::new(1200.0, 800.0);
    assert_eq!(
        store.move_to(&layout, &reach(100.0), eye, |_| Err("broken")),
        Err("broken")
    );
    assert_eq!(
        store.keep_resident([node], |_| Err("broken")),
        Err("broken")
    );
    assert!(store.is_empty());
    assert_eq!(
        store.tile(node, |_| Ok::<_, &str>(7)).map(|tile| *tile),
        Ok(7)
    );
}

/// A store for 300 tiles asks for no more, however large the ground and the range are.
#[test]
fn a_bounded_store_lists_no_more_than_it_holds() {
    let side = Grid::MOST_POSTS;
    let grid = Grid::new(side, side, DVec2::ZERO, DVec2::ONE).unwrap();
    let tiling = Tiling::new(grid);
    let layout = *tiling.layout();
    let far = f64::from(side);
    for near_m in [1e9, 1e300, f64::INFINITY] {
        for eye in [
            DVec2::splat(far / 2.0),
            DVec2::new(far * 0.9, -1e4),
            DVec2::ZERO,
            DVec2::splat(f64::NAN),
        ] {
            let reach = Reach {
                near_m,
                finest: tiling.finest(),
            };
            let mut store = TileStore::new(Keep::D);
            store.move_to(&layout, &reach, eye, name).unwrap();
            let ahead = (eye, DVec2::splat(1e3));
            store.read_ahead(&layout, &reach, ahead, 4, name).unwrap();
            let expected = if eye.is_nan() { 0 } else { 300 };
            assert_eq!(store.len(), expected, "{near_m} {eye}");
        }
    }
}

/// Levels that are not there have a range, as far as the finest, and no tiles.
#[test]
fn levels_beyond_the_last_do_no_harm() {
    let layout = *tiling().layout();
    let eye = DVec2::new(1200.0, 800.0);
    let deep = Reach {
        near_m: 1.0,
        finest: u32::MAX,
    };
    assert_eq!(deep.of_level(u32::MAX), 1.0);
    assert!(deep.of_level(0) > 1e300);
    let wanted = deep.wanted(&layout, eye, usize::MAX);
    assert!(wanted.iter().all(|node| node.level <= layout.levels()));
    assert!(wanted.len() > 100);
}
