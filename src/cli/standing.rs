//! How the objects of a city stand on ground, and setting them on it.

use std::cell::LazyCell;
use std::fmt;

use anyhow::Result;

use super::text;
use crate::geom::{Aabb, DVec3};
use crate::index::{self, LodTree};
use crate::terrain::{Footing, HeightField, NearestGround, footing, ground_under};

/// Up to this far above the highest or below the lowest ground under it, an object stands on it:
/// what elevation of 10 to 30 m posts leaves open.
const TOLERANCE_M: f64 = 2.0;

/// What came of setting objects on ground.
#[derive(Debug, Default)]
pub(super) struct SetDown {
    /// How many have ground under them.
    pub(super) set: u64,
    /// The city, where any of them moved.
    pub(super) city: Option<LodTree>,
}

/// Sets the objects whose base is not known, or `all`, on the lowest ground under their boxes.
/// Heights and ids stay; a part that begins above its ground is set so far above it again.
/// Where there is no ground, those whose base is not known stand as high as the nearest ground that
/// is known, whatever ground was laid before: at 0 they would be far below a city in the hills, or
/// far above one in a pit. The others stay where they are.
pub(super) fn set_down(tree: &LodTree, field: &HeightField, all: bool) -> Result<SetDown> {
    let mut done = SetDown::default();
    if !all && tree.base_unknown_count() == 0 {
        return Ok(done);
    }
    let (mut scene, mut moved) = (tree.scene(), false);
    let nearest = LazyCell::new(|| NearestGround::of(field));
    let to_set = scene.objects.iter_mut().filter(|o| all || !o.base_known);
    for object in to_set {
        let under = ground_under(field, &object.bounds);
        let base = match under {
            Some([low, _]) => low + object.lift_m,
            None if object.base_known => continue,
            None => nearest.height(&object.bounds).unwrap_or_default() + object.lift_m,
        };
        done.set += u64::from(under.is_some());
        if object.bounds.min().z != base {
            object.bounds = standing_at(&object.bounds, base)?;
            moved = true;
        }
    }
    let city = moved.then(|| index::build(&scene, tree.promotion()));
    done.city = city.transpose()?;
    Ok(done)
}

/// Some objects, of which the first are named.
#[derive(Debug, Default)]
struct Names {
    count: u64,
    first: Vec<String>,
}

impl Names {
    fn add(&mut self, id: &str) {
        const MOST: usize = 5;
        self.count += 1;
        if self.first.len() < MOST {
            self.first.push(id.to_owned());
        }
    }
}

impl fmt::Display for Names {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.first.join(", "))?;
        match self.count - self.first.len() as u64 {
            0 => Ok(()),
            more => write!(f, " and {} more", text::grouped(more)),
        }
    }
}

/// The box with its base at this height.
fn standing_at(bounds: &Aabb, base: f64) -> Result<Aabb> {
    let (min, max) = (bounds.min(), bounds.max());
    let rise = DVec3::new(max.x, max.y, base + (max.z - min.z));
    Ok(Aabb::new(min.with_z(base), rise)?)
}

/// How the objects of a city stand on ground.
#[derive(Debug, Default)]
pub(super) struct Standing {
    /// Of those whose base does not meet it, the first ones.
    named: Vec<String>,
    above: u64,
    below: u64,
    /// Without ground under them: whose base is known, and whose base is not.
    without: [Names; 2],
}

impl Standing {
    pub(super) fn of(tree: &LodTree, field: &HeightField, most: usize) -> Result<Self> {
        let mut standing = Self::default();
        for object in (0..tree.object_count()).filter_map(|number| tree.object(number)) {
            let foot = object.bounds.min().z - object.lift_m;
            let gap = match footing(field, &standing_at(&object.bounds, foot)?, TOLERANCE_M) {
                Footing::Meets => continue,
                Footing::NoGround => {
                    standing.without[usize::from(!object.base_known)].add(&object.id);
                    continue;
                }
                Footing::Above(gap) => {
                    standing.above += 1;
                    format!("{} m above", text::metres(gap))
                }
                Footing::Below(gap) => {
                    standing.below += 1;
                    format!("{} m below", text::metres(gap))
                }
            };
            if standing.named.len() < most {
                standing.named.push(format!(
                    "warning: {}: its base is {gap} the ground under it",
                    object.id
                ));
            }
        }
        Ok(standing)
    }

    /// How many have no ground under them.
    pub(super) fn without(&self) -> u64 {
        self.without.iter().map(|names| names.count).sum()
    }

    /// A warning for each that is named, and what they come to.
    pub(super) fn lines(self, tree: &LodTree, field: &HeightField) -> Vec<String> {
        let Self {
            named: mut lines,
            above,
            below,
            without,
        } = self;
        let hidden = above + below - lines.len() as u64;
        if hidden > 0 {
            let all = above + below;
            let more = text::counted(hidden, "more object");
            lines.push(format!("and {more}; see them with --warnings {all}"));
        }
        let of = text::counted(tree.object_count().into(), "object");
        if above + below > 0 {
            lines.push(format!(
                "warning: of {of}, {} stand more than {TOLERANCE_M} m above the ground under them and {} more than that below; ground and city may count heights from different levels, and --drape sets every object on the ground",
                text::grouped(above),
                text::grouped(below)
            ));
        }
        let (from, to) = (corner(field, false), corner(field, true));
        let [known, unknown] = without;
        for (names, fate) in [
            (known, "stay where they are"),
            (unknown, "stand as high as the nearest ground that is known"),
        ] {
            if names.count > 0 {
                lines.push(format!(
                    "warning: of {of}, {} have no ground under them and {fate}; the ground reaches from {from} to {to}: {names}",
                    text::grouped(names.count)
                ));
            }
        }
        lines
    }
}

/// Why ground lies under none of the objects of a city.
pub(super) fn no_ground(tree: &LodTree, field: &HeightField) -> String {
    let (from, to) = (corner(field, false), corner(field, true));
    let grid = field.grid();
    let post = |column, row| DVec3::new(grid.x(column), grid.y(row), 0.0);
    let (first, last) = (post(0, 0), post(grid.columns() - 1, grid.rows() - 1));
    let is_over = |bounds: &Aabb| {
        (0..2).all(|axis| bounds.min()[axis] <= last[axis] && first[axis] <= bounds.max()[axis])
    };
    let mut objects = (0..tree.object_count()).filter_map(|number| tree.object(number));
    if field.heights().iter().all(|height| height.is_nan()) {
        format!("has no height anywhere: all its posts, from {from} to {to}, are no data")
    } else if objects.any(|object| is_over(&object.bounds)) {
        format!(
            "has no height under the city: of its posts, from {from} to {to}, those there are no data"
        )
    } else {
        format!(
            "lies under nothing of the city: it reaches from {from} to {to}, the city from {} to {}",
            text::point(tree.bounds().min(), " "),
            text::point(tree.bounds().max(), " ")
        )
    }
}

/// The south-west or north-east post.
fn corner(field: &HeightField, far: bool) -> String {
    let grid = field.grid();
    let (column, row) = if far {
        (grid.columns() - 1, grid.rows() - 1)
    } else {
        (0, 0)
    };
    format!(
        "{} {}",
        text::metres(grid.x(column)),
        text::metres(grid.y(row))
    )
}
