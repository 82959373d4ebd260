//! Where streets, rivers and centres lie: an endless plan, the same for every size of city.

use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg32;

use super::quad::Quad;
use crate::geom::DVec2;

/// Mean distance of the lines of the street lattice, m. Four lines enclose a quarter.
pub(super) const QUARTER: f64 = 360.0;

/// No corner lies farther than this from its place in the unwarped lattice, m.
pub(super) const DISPLACEMENT: f64 = 920.0;

/// Mean distance of centres, m: one for about 50,000 objects.
const CENTRE_SPACING: f64 = 5600.0;

/// Rivers flow along every so many rows, the first one just south of the main centre.
const RIVER_ROWS: i32 = 29;
const FIRST_RIVER: i32 = -2;

/// What a line of the lattice carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Line {
    Street,
    Avenue,
    River,
}

impl Line {
    /// Distance from the line to the quarters on either side, m.
    pub(super) fn half_width(self) -> f64 {
        match self {
            Self::Street => 9.0,
            Self::Avenue => 19.0,
            Self::River => 85.0,
        }
    }
}

/// What a random number is drawn for, so that draws at one place are independent.
#[derive(Clone, Copy)]
enum Draw {
    Column,
    Row,
    Corner,
    Warp,
    Bend,
    Centre,
    Quarter,
}

/// The plan of one seed.
pub(super) struct Plan {
    seed: u64,
}

impl Plan {
    pub(super) fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// Randomness for everything inside quarter (i, j).
    pub(super) fn quarter_rng(&self, i: i32, j: i32) -> Pcg32 {
        self.rng(Draw::Quarter, i, j)
    }

    /// The line west of column i.
    pub(super) fn column(i: i32) -> Line {
        if i.rem_euclid(3) == 0 {
            Line::Avenue
        } else {
            Line::Street
        }
    }

    /// The line south of row j.
    pub(super) fn row(j: i32) -> Line {
        if (j - FIRST_RIVER).rem_euclid(RIVER_ROWS) == 0 {
            Line::River
        } else if j.rem_euclid(3) == 0 {
            Line::Avenue
        } else {
            Line::Street
        }
    }

    /// Where the lines west of column i and south of row j cross.
    pub(super) fn crossing(&self, i: i32, j: i32) -> DVec2 {
        let place = DVec2::new(f64::from(i) - 0.4, f64::from(j) - 0.4) * QUARTER;
        let lines = DVec2::new(
            self.pair(Draw::Column, i, 0).x,
            self.pair(Draw::Row, 0, j).x,
        );
        place
            + lines * (0.13 * QUARTER)
            + self.pair(Draw::Corner, i, j) * (0.04 * QUARTER)
            + self.drift(Draw::Warp, place / 1900.0) * 90.0
            + self.drift(Draw::Bend, place / 8000.0) * 500.0
    }

    /// The ground of quarter (i, j), lines and all.
    pub(super) fn cell(&self, i: i32, j: i32) -> Quad {
        Quad([(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.crossing(i, j)))
    }

    /// The part of quarter (i, j) left over by the lines around it.
    pub(super) fn quarter(&self, i: i32, j: i32) -> Quad {
        let cell = self.cell(i, j);
        let (width, depth) = cell.size();
        cell.piece(
            Self::column(i).half_width() / width..1.0 - Self::column(i + 1).half_width() / width,
            Self::row(j).half_width() / depth..1.0 - Self::row(j + 1).half_width() / depth,
        )
    }

    /// How urban it is at `p`: 1 in the middle of the main centre, near 0 in the suburbs.
    pub(super) fn urbanity(&self, p: DVec2) -> f64 {
        let fall = |distance: f64, radius: f64| {
            let d = distance / radius;
            1.0 / (1.0 + d * d)
        };
        let main = fall(p.length(), 700.0).max(0.3 * fall(p.length(), 2600.0));
        let home = (p / CENTRE_SPACING).round();
        let (home_i, home_j) = (home.x as i32, home.y as i32);
        let others = (home_i - 1..=home_i + 1)
            .flat_map(|i| (home_j - 1..=home_j + 1).map(move |j| (i, j)))
            .filter(|&cell| cell != (0, 0));
        others.fold(main, |most, (i, j)| {
            let mut rng = self.rng(Draw::Centre, i, j);
            let mut draw = || rng.random::<f64>();
            let jitter = DVec2::new(draw() - 0.5, draw() - 0.5) * 0.7;
            let center = (DVec2::new(f64::from(i), f64::from(j)) + jitter) * CENTRE_SPACING;
            let importance = draw() * draw();
            let core = fall(p.distance(center), 240.0 + 260.0 * importance);
            let ring = fall(p.distance(center), 1100.0 + 1200.0 * importance);
            let strength = 0.3 + 0.6 * importance;
            most.max(strength * core).max(0.35 * strength * ring)
        })
    }

    /// Smooth noise of unit wavelength, each component in [-1, 1).
    fn drift(&self, draw: Draw, p: DVec2) -> DVec2 {
        let floor = p.floor();
        let (i, j) = (floor.x as i32, floor.y as i32);
        let t = p - floor;
        let s = t * t * (DVec2::splat(3.0) - t * 2.0);
        Quad([(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.pair(draw, i, j)))
            .at(s.x, s.y)
    }

    /// Two numbers in [-1, 1) that belong to (i, j).
    fn pair(&self, draw: Draw, i: i32, j: i32) -> DVec2 {
        let mut rng = self.rng(draw, i, j);
        DVec2::new(rng.random::<f64>(), rng.random::<f64>()) * 2.0 - 1.0
    }

    fn rng(&self, draw: Draw, i: i32, j: i32) -> Pcg32 {
        let place = u64::from(i.cast_unsigned()) << 32 | u64::from(j.cast_unsigned());
        // Odd constants of splitmix64: neighbouring places must not give neighbouring states.
        let key = (self.seed ^ (draw as u64) << 56)
            .wrapping_mul(0xbf58_476d_1ce4_e5b9)
            .wrapping_add(place.wrapping_mul(0x94d0_49bb_1331_11eb));
        Pcg32::seed_from_u64((key ^ key >> 31).wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }
}
