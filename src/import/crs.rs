//! Names of coordinate reference systems, and what positions in them are.

use std::path::Path;

use super::ImportError;

/// Geographic systems whose longitudes and latitudes differ from WGS 84 by no more than about
/// two metres, all over. With them those that add heights above the sea.
const NEAR_WGS84: &[&str] = &[
    "OGC:CRS84",
    "OGC:CRS84H",
    "EPSG:4326",
    "EPSG:4979",
    "EPSG:9518",
    "EPSG:9707", // WGS 84
    "EPSG:4258",
    "EPSG:4937",
    "EPSG:7422",
    "EPSG:7423",
    "EPSG:4171",
    "EPSG:4965", // ETRS89, France
    "EPSG:4269",
    "EPSG:6318",
    "EPSG:6319",
    "EPSG:6349",
    "EPSG:5498",
    "EPSG:4617", // NAD83
    "EPSG:4612",
    "EPSG:6668",
    "EPSG:6697", // Japan
    "EPSG:4283",
    "EPSG:7844",
    "EPSG:7843",
    "EPSG:4167", // Australia, New Zealand
    "EPSG:4490",
    "EPSG:4737",
    "EPSG:4757",
    "EPSG:4674",
    "EPSG:4148", // China, Korea, Singapore, South America, South Africa
];

/// Units that are the metre but for a few decimetres in a city, as a share of it.
const NEARLY: f64 = 1e-4;

/// What positions in a system are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Kind {
    /// Longitude and latitude.
    Degrees,
    Metres,
    /// In a plane too, but in this unit.
    Other(String),
    /// Metres along three axes from the middle of the earth.
    EarthCentred,
    /// Of this system nothing is known here.
    Unknown,
}

/// What positions in the system of this normalised name are.
pub(super) fn kind(crs: &str) -> Kind {
    if is_near_wgs84(crs) {
        return Kind::Degrees;
    }
    let Some(definition) = definition(crs) else {
        return Kind::Unknown;
    };
    let value = |key: &str| {
        let mut words = definition.split_whitespace();
        words.find_map(|word| word.strip_prefix(key))
    };
    let to_metre = value("+to_meter=").and_then(|number| number.parse::<f64>().ok());
    match (value("+proj="), to_metre, value("+units=")) {
        (Some("longlat"), ..) => Kind::Degrees,
        (Some("geocent"), ..) => Kind::EarthCentred,
        (_, Some(metres), _) if (metres - 1.0).abs() > NEARLY => {
            Kind::Other(format!("units of {metres} m"))
        }
        (_, None, Some("us-ft")) => Kind::Other("US survey feet".into()),
        (_, None, Some("ft")) => Kind::Other("feet".into()),
        (_, None, Some(unit)) if unit != "m" => Kind::Other(format!("units named {unit}")),
        _ => Kind::Metres,
    }
}

/// The horizontal part of a system as PROJ writes it, of an EPSG code that is known here.
fn definition(crs: &str) -> Option<String> {
    let code = crs.strip_prefix("EPSG:")?.parse().ok()?;
    let words = crs_definitions::from_code(code)?.proj4.split_whitespace();
    let horizontal: Vec<&str> = words.filter(|word| !word.starts_with("+vunits")).collect();
    Some(horizontal.join(" "))
}

/// Whether positions in one are positions in the other: the same name, the same horizontal part,
/// or degrees that can be read as those of WGS 84.
pub(super) fn agree(a: &str, b: &str) -> bool {
    a == b
        || (is_near_wgs84(a) && is_near_wgs84(b))
        || definition(a).is_some_and(|a| definition(b).as_ref() == Some(&a))
}

/// What is said of degrees of an older datum.
pub(super) fn older(crs: &str) -> String {
    format!(
        "longitudes and latitudes of {crs} are read as those of WGS 84; places may be off by some \
         hundred metres, reproject the file to EPSG:4326 to be exact"
    )
}

/// Why a file cannot be used whose positions are lengths, but not metres in a plane.
pub(super) fn refusal(path: &Path, crs: &str, what: &str, way_out: &str) -> ImportError {
    ImportError::Unsupported {
        path: path.to_owned(),
        feature: format!("{crs}, whose coordinates {what}"),
        way_out: way_out.to_owned(),
    }
}

/// What is said of a system of which nothing is known.
pub(super) fn unknown(crs: &str) -> String {
    format!(
        "nothing is known here of the system {crs}; coordinates are taken as metres: if they are \
         in another unit or in degrees, reproject the file to a system in metres with an EPSG code"
    )
}

/// Whether its degrees can be read as those of WGS 84.
pub(super) fn is_near_wgs84(crs: &str) -> bool {
    NEAR_WGS84.contains(&crs)
}

/// `EPSG:7415` out of the ways a name is written: as it is, as a URN
/// (`urn:ogc:def:crs:EPSG::7415`) or as a URL (`https://www.opengis.net/def/crs/EPSG/0/7415`).
/// A name of another kind stays as it is.
pub(super) fn normalised(name: &str) -> String {
    let name = name.trim();
    let lower = name.to_lowercase();
    let parts = if lower.starts_with("urn:ogc:def:crs:") {
        name.split(':').skip(4).collect::<Vec<_>>()
    } else if let Some(start) = lower.find("/def/crs/").filter(|_| lower.is_ascii()) {
        name[start + "/def/crs/".len()..].split('/').collect()
    } else {
        name.split(':').collect()
    };
    match parts[..] {
        [authority, code] | [authority, _, code] if is_word(authority) && is_word(code) => {
            format!("{}:{code}", authority.to_uppercase())
        }
        _ => name.to_owned(),
    }
}

fn is_word(part: &str) -> bool {
    !part.is_empty() && part.bytes().all(|b| b.is_ascii_alphanumeric())
}

#[cfg(test)]
mod tests {
    use super::{Kind, agree, kind, normalised};

    #[test]
    fn names_are_normalised() {
        for (given, expected) in [
            ("https://www.opengis.net/def/crs/EPSG/0/6677", "EPSG:6677"),
            ("http://www.opengis.net/def/crs/EPSG/0/7415", "EPSG:7415"),
            ("urn:ogc:def:crs:EPSG::7415", "EPSG:7415"),
            ("urn:ogc:def:crs:EPSG:6.18:7415", "EPSG:7415"),
            ("urn:ogc:def:crs:OGC:1.3:CRS84", "OGC:CRS84"),
            ("epsg:28992", "EPSG:28992"),
            (" EPSG:28992 ", "EPSG:28992"),
            ("our own grid", "our own grid"),
            ("", ""),
        ] {
            assert_eq!(normalised(given), expected, "{given:?}");
        }
    }

    #[test]
    fn what_positions_are_is_known_by_the_code() {
        for (crs, expected) in [
            ("EPSG:4326", Kind::Degrees),
            ("OGC:CRS84", Kind::Degrees),
            ("EPSG:6697", Kind::Degrees), // with heights
            ("EPSG:4123", Kind::Degrees), // an older datum
            ("EPSG:28992", Kind::Metres),
            ("EPSG:7415", Kind::Metres), // with heights
            ("EPSG:2056", Kind::Metres),
            ("EPSG:2263", Kind::Other("US survey feet".into())),
            ("EPSG:2222", Kind::Other("feet".into())),
            ("EPSG:4978", Kind::EarthCentred),
            ("EPSG:1", Kind::Unknown),
            ("EPSG:999999", Kind::Unknown),
            ("our own grid", Kind::Unknown),
        ] {
            assert_eq!(kind(crs), expected, "{crs}");
        }
    }

    #[test]
    fn names_of_one_plane_agree() {
        for (a, b, expected) in [
            ("our own grid", "our own grid", true),
            ("EPSG:7415", "EPSG:28992", true),
            ("EPSG:4326", "OGC:CRS84", true),
            ("EPSG:28992", "EPSG:2056", false),
            ("our own grid", "EPSG:2056", false),
            ("our own grid", "their own grid", false),
        ] {
            assert_eq!(agree(a, b), expected, "{a} {b}");
        }
    }
}
