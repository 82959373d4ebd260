//! Coordinate reference systems by their EPSG code, as PROJ writes them.

use proj4rs::proj::Proj;

/// How longitudes and latitudes are written that are taken for those of WGS 84.
const DEGREES: &str = "+proj=longlat +datum=WGS84 +no_defs";

/// Projections that are of use near a meridian only.
const LOCAL: [&str; 5] = [
    "+proj=tmerc",
    "+proj=sterea",
    "+proj=somerc",
    "+proj=krovak",
    "+proj=cass",
];

/// A system with east and north in metres.
///
/// Of a compound system, such as EPSG:7415, this is the horizontal part, EPSG:28992: heights are
/// left as they are.
#[derive(Debug)]
pub(super) struct System {
    proj: Proj,
    definition: String,
}

impl System {
    /// The system of a name such as `EPSG:28992`; `None` where it is not known, is none of a
    /// plane, or has another unit than the metre.
    pub fn named(name: &str) -> Option<Self> {
        let definition = definition(name)?;
        let metric = definition.contains("+units=m") && !definition.contains("+to_meter");
        let proj = Proj::from_proj_string(&definition).ok()?;
        metric.then_some(Self { proj, definition })
    }

    /// The system of longitudes and latitudes, in radians.
    pub fn degrees() -> Option<Proj> {
        Proj::from_proj_string(DEGREES).ok()
    }

    pub fn proj(&self) -> &Proj {
        &self.proj
    }

    /// Where it is most exact, degrees, for systems of a narrow zone or a small country.
    pub fn meridian(&self) -> Option<f64> {
        let number = |key| {
            let words = self.definition.split_whitespace();
            let mut values = words.filter_map(|word: &str| word.strip_prefix(key));
            values.next()?.parse::<f64>().ok()
        };
        match number("+zone=") {
            Some(zone) => Some(zone * 6.0 - 183.0),
            None if LOCAL.iter().any(|p| self.definition.contains(p)) => number("+lon_0="),
            None => None,
        }
    }
}

/// Whether the coordinates of a system of this name are known to be degrees.
pub(super) fn has_degrees(name: &str) -> bool {
    let is_of_globe = |definition: String| definition.contains("+proj=longlat");
    name.starts_with("OGC:CRS84") || definition(name).is_some_and(is_of_globe)
}

/// The horizontal part of a system, as PROJ writes it.
pub(super) fn definition(name: &str) -> Option<String> {
    let code = name.strip_prefix("EPSG:")?.parse().ok()?;
    let known = crs_definitions::from_code(code)?;
    let words = known.proj4.split_whitespace();
    let horizontal: Vec<&str> = words.filter(|word| !word.starts_with("+vunits")).collect();
    Some(horizontal.join(" "))
}

/// Whether positions in one are positions in the other: the same name, or the same horizontal
/// part.
pub(super) fn same_plane(a: &str, b: &str) -> bool {
    a == b || definition(a).is_some_and(|a| Some(a) == definition(b))
}
