use crate::import::json::{Arrays, Token};

/// The rings of the polygons of one feature; cleared and used again for the next.
#[derive(Debug, Default)]
pub(super) struct Rings {
    /// x, y and z; NaN where there is no z.
    pub(super) positions: Vec<[f64; 3]>,
    /// Where each ring ends in `positions`.
    ring_ends: Vec<usize>,
    /// Where each polygon ends in `ring_ends`.
    polygon_ends: Vec<usize>,
    /// Positions left out because they have fewer than two numbers.
    pub(super) too_short: usize,
}

/// What is wrong with the rings of a feature.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Faults {
    pub(super) open: usize,
    /// Rings of fewer than three distinct points.
    pub(super) degenerate: usize,
}

/// How many nested arrays there are around the numbers.
pub(super) const POLYGON_DEPTH: usize = 3;
pub(super) const MULTI_POLYGON_DEPTH: usize = 4;

impl Rings {
    pub(super) fn clear(&mut self) {
        self.positions.clear();
        self.ring_ends.clear();
        self.polygon_ends.clear();
        self.too_short = 0;
    }

    /// Adds the `coordinates` of a Polygon or a `MultiPolygon`. What cannot be a coordinate ends
    /// it: `false`, and what came before stays.
    pub(super) fn read(&mut self, coordinates: &str, position_depth: usize) -> bool {
        let mut depth = 0;
        let mut position = [f64::NAN; 3];
        let mut numbers = 0;
        let mut sound = true;
        for token in Arrays::new(coordinates) {
            match token {
                Token::Open if depth < position_depth => {
                    depth += 1;
                    numbers = 0;
                    position[2] = f64::NAN;
                }
                Token::Number(value) if depth == position_depth => {
                    // Beyond z there may be measures, which RFC 7946 lets a reader ignore.
                    if let Some(axis) = position.get_mut(numbers) {
                        *axis = value;
                    }
                    numbers += 1;
                }
                Token::Close => {
                    match position_depth - depth {
                        0 if numbers >= 2 => self.positions.push(position),
                        0 => self.too_short += 1,
                        1 => self.end_ring(),
                        2 => self.end_polygon(),
                        _ => {}
                    }
                    depth -= 1;
                }
                Token::Open | Token::Number(_) | Token::Other => {
                    sound = false;
                    break;
                }
            }
        }
        self.end_ring();
        self.end_polygon();
        sound
    }

    fn end_ring(&mut self) {
        if self.positions.len() > self.ring_ends.last().copied().unwrap_or(0) {
            self.ring_ends.push(self.positions.len());
        }
    }

    fn end_polygon(&mut self) {
        if self.ring_ends.len() > self.polygon_ends.last().copied().unwrap_or(0) {
            self.polygon_ends.push(self.ring_ends.len());
        }
    }

    fn rings(&self) -> impl Iterator<Item = &[[f64; 3]]> {
        let mut start = 0;
        self.ring_ends.iter().map(move |&end| {
            let ring = &self.positions[start..end];
            start = end;
            ring
        })
    }

    pub(super) fn faults(&self) -> Faults {
        let mut faults = Faults::default();
        for ring in self.rings() {
            faults.open += usize::from(!is_closed(ring));
            faults.degenerate += usize::from(!has_three_points(ring));
        }
        faults
    }

    /// Triangles of the flat polygons, or of the prisms over them: per polygon of k corners and
    /// h holes k + 2h − 2 for each of the two lids, and 2k for the walls.
    pub(super) fn triangles(&self, extruded: bool) -> u64 {
        let mut rings = self.rings();
        let mut start = 0;
        let mut triangles = 0;
        for &end in &self.polygon_ends {
            let corners: usize = rings
                .by_ref()
                .take(end - start)
                .map(|r| corners(r).len())
                .sum();
            let holes = end - start - 1;
            let lid = (corners + 2 * holes).saturating_sub(2);
            triangles += if extruded { 2 * lid + 2 * corners } else { lid };
            start = end;
        }
        triangles as u64
    }

    /// All positions but those that only close a ring.
    pub(super) fn corners(&self) -> impl Iterator<Item = &[f64; 3]> {
        self.rings().flat_map(corners)
    }
}

fn is_closed(ring: &[[f64; 3]]) -> bool {
    ring.len() > 1 && ring.first().map(|p| [p[0], p[1]]) == ring.last().map(|p| [p[0], p[1]])
}

/// The ring without the position that only closes it.
fn corners(ring: &[[f64; 3]]) -> &[[f64; 3]] {
    &ring[..ring.len() - usize::from(is_closed(ring))]
}

fn has_three_points(ring: &[[f64; 3]]) -> bool {
    // By bits, so that a missing z, which is NaN, equals a missing z.
    let differ = |a: &[f64; 3], b: &[f64; 3]| a.map(f64::to_bits) != b.map(f64::to_bits);
    let Some(second) = ring.iter().find(|p| differ(p, &ring[0])) else {
        return false;
    };
    ring.iter()
        .any(|p| differ(p, &ring[0]) && differ(p, second))
}
