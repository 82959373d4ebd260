//! Whether the objects of one file, taken together, can be what the file says: a look at their
//! boxes when all are there.

use super::extents::FAR_M;
use super::utm::is_lon_lat;
use crate::geom::{Aabb, DVec3};
use crate::scene::SceneObject;

/// Half of the objects of a city are wider than this, m. Of one in degrees nearly all are
/// narrower: it is over a kilometre.
const NARROWEST_M: f64 = 0.01;
/// Half of the objects of a city are not so many times taller than wide. A house in degrees is,
/// with its height in metres, some ten thousand times.
const SLIMMEST: f64 = 100.0;
/// As a whole no city is narrower than this, m, and so many times taller.
const NARROWEST_CITY_M: f64 = 1.0;
const SLIMMEST_CITY: f64 = 50.0;
/// One object of so many may lie far from the rest.
const STRAYS: usize = 10;
/// So many times farther from the middle than the rest reach, and at least [`FAR_M`], lies
/// what is told of.
const FARTHER: f64 = 10.0;
/// Nothing that is higher than wide is higher than this, m.
const TALLEST_M: f64 = 1_000.0;

/// Positions that are taken as metres and look like degrees.
#[derive(Debug)]
pub(super) struct Degrees {
    /// They cannot be metres.
    pub(super) surely: bool,
    /// Why.
    what: String,
    /// Latitude stands before longitude.
    is_turned: bool,
    /// Latitude lies along z.
    is_upright: bool,
}

impl Degrees {
    /// Of a file that does not state its system.
    pub(super) fn of_unstated(&self) -> String {
        let turn = if self.is_upright { " and --up z" } else { "" };
        let way_out = if self.is_turned {
            "exchange the two, as latitude stands before longitude, and say so with --crs EPSG:4326"
                .to_owned()
        } else {
            format!("say so with --crs EPSG:4326{turn}")
        };
        let doubt = if self.surely {
            ""
        } else {
            ", if they are some"
        };
        format!(
            "coordinates look like degrees and would be taken as metres: {}; {way_out}{doubt}, or \
             reproject the file; if they are metres, name their system with --crs",
            self.what
        )
    }

    /// Of a file that lies in this system.
    pub(super) fn of_stated(&self, crs: &str) -> String {
        format!(
            "coordinates look like degrees, but {crs} is stated, which is taken to be in metres: \
             {}; state the system that they lie in, or reproject the file",
            self.what
        )
    }
}

/// Whether positions that are taken as metres look like degrees.
///
/// Law: a city in degrees with heights in metres, of objects as a city has them, is so surely; one
/// without heights, or in one piece, maybe.
pub(super) fn degrees(objects: &[SceneObject]) -> Option<Degrees> {
    let bounds = objects.iter().map(|object| object.bounds);
    let all = bounds.reduce(|all, bounds| all.union(&bounds))?;
    let axes = [[0, 1, 2], [0, 2, 1]];
    axes.into_iter().find_map(|axes| along(objects, &all, axes))
}

/// The same where the last of the axes points up.
fn along(objects: &[SceneObject], all: &Aabb, [x, y, up]: [usize; 3]) -> Option<Degrees> {
    let (low, high) = (all.min(), all.max());
    let is_straight = is_lon_lat(low[x], low[y]) && is_lon_lat(high[x], high[y]);
    let is_turned = is_lon_lat(low[y], low[x]) && is_lon_lat(high[y], high[x]);
    if !is_straight && !is_turned {
        return None;
    }
    let wide = |bounds: &Aabb| bounds.size()[x].max(bounds.size()[y]);
    let sizes = objects
        .iter()
        .map(|o| (wide(&o.bounds), o.bounds.size()[up]))
        .filter(|(width, _)| *width > 0.0);
    let (mut widths, mut heights): (Vec<f64>, Vec<f64>) = sizes.unzip();
    let (width, height) = (median(&mut widths)?, median(&mut heights)?);
    let is_upright = up != 2;
    let found = |surely, what| Degrees {
        surely,
        what,
        is_turned: !is_straight,
        is_upright,
    };
    let half = format!(
        "half of {} are no wider than {}",
        counted(widths.len()),
        length(width)
    );
    let (city_width, city_height) = (wide(all), all.size()[up]);
    if width < NARROWEST_M && height > SLIMMEST * width {
        let what = format!("{half}, and half are {} tall or more", length(height));
        Some(found(true, what))
    } else if is_upright {
        None
    } else if width < NARROWEST_M {
        Some(found(false, half))
    } else if city_width < NARROWEST_CITY_M && city_height > SLIMMEST_CITY * city_width {
        let (wide, tall) = (length(city_width), length(city_height));
        Some(found(
            false,
            format!("all together are {wide} wide and {tall} tall"),
        ))
    } else {
        None
    }
}

/// What is said of objects that lie far from all others.
pub(super) fn strays(objects: &[SceneObject]) -> Option<String> {
    let count = objects.len();
    if count < 3 {
        return None;
    }
    let mut centres = vec![0.0; count];
    let mut middle = |axis: usize| {
        for (centre, object) in centres.iter_mut().zip(objects) {
            *centre = object.bounds.center()[axis];
        }
        median(&mut centres).unwrap_or_default()
    };
    let middle = DVec3::new(middle(0), middle(1), middle(2));
    // How far each reaches: one vertex that is astray makes a box large.
    let reach = |object: &SceneObject| {
        let (low, high) = (object.bounds.min() - middle, object.bounds.max() - middle);
        low.abs().max(high.abs()).length()
    };
    let mut reaches: Vec<f64> = objects.iter().map(reach).collect();
    let rest = count - (count / STRAYS).max(1);
    let (_, usual, _) = reaches.select_nth_unstable_by(rest - 1, f64::total_cmp);
    let usual = *usual;
    let far = (usual * FARTHER).max(FAR_M);
    let strays = reaches[rest..].iter().filter(|reach| **reach > far).count();
    if strays == 0 {
        return None;
    }
    let farthest = objects
        .iter()
        .max_by(|a, b| reach(a).total_cmp(&reach(b)))?;
    let (lie, which) = match strays {
        1 => ("lies", format!("{:?}", farthest.id)),
        _ => ("lie", format!("the farthest, {:?},", farthest.id)),
    };
    Some(format!(
        "{strays} of {} {lie} far from the rest: {which} reaches {} from their middle, the others \
         mostly no more than {}; look for coordinates that are missing or mistyped",
        counted(count),
        length(reach(farthest)),
        length(usual)
    ))
}

/// What is said of objects that are taller than anything built.
pub(super) fn tall(objects: &[SceneObject]) -> Option<String> {
    let is_tall = |object: &&SceneObject| {
        let size = object.bounds.size();
        size.z > TALLEST_M && size.z > size.x.max(size.y)
    };
    let count = objects.iter().filter(is_tall).count();
    let height = |object: &SceneObject| object.bounds.size().z;
    let tall = objects.iter().filter(is_tall);
    let tallest = tall.max_by(|a, b| height(a).total_cmp(&height(b)))?;
    let (are, which) = match count {
        1 => ("is", format!("{:?}", tallest.id)),
        _ => ("are", format!("the tallest, {:?},", tallest.id)),
    };
    Some(format!(
        "{} {are} taller than {TALLEST_M} m: {which} has {:.0} m; look for heights \
         that are mistyped or in another unit than metres",
        counted(count),
        height(tallest)
    ))
}

/// The upper one of two; `None` of none.
fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

/// `1 object`, `2 objects`
fn counted(count: usize) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} object{plural}")
}

/// A length as people read it, to two digits or the metre.
fn length(metres: f64) -> String {
    let digits = |value: f64, unit: &str| {
        let places = (1.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
        format!("{value:.places$} {unit}")
    };
    match metres {
        m if m <= 0.0 => "0 m".to_owned(),
        m if m < 0.1 => digits(m * 1000.0, "mm"),
        m if m < 1000.0 => digits(m, "m"),
        m => digits(m / 1000.0, "km"),
    }
}

#[cfg(test)]
mod tests {
    use super::length;

    #[test]
    fn lengths_have_two_digits_or_more() {
        for (metres, expected) in [
            (0.0, "0 m"),
            (0.000_1, "0.10 mm"),
            (0.012, "12 mm"),
            (0.46, "0.46 m"),
            (9.26, "9.3 m"),
            (854.3, "854 m"),
            (454_321.0, "454 km"),
            (1_000.0, "1.0 km"),
        ] {
            assert_eq!(length(metres), expected);
        }
    }
}
