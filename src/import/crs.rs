//! Names of coordinate reference systems.

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

/// Geographic systems of older datums, which lie up to some hundred metres beside WGS 84.
const OLDER: &[&str] = &[
    "EPSG:4149",
    "EPSG:4150", // Switzerland
    "EPSG:4230", // ED50
    "EPSG:4265", // Italy
    "EPSG:4267", // NAD27
    "EPSG:4275", // France
    "EPSG:4277", // Great Britain
    "EPSG:4284", // Pulkovo 1942
    "EPSG:4289", // Netherlands
    "EPSG:4301", // Tokyo
    "EPSG:4312", // Austria
    "EPSG:4314", // Germany
    "EPSG:4322", // WGS 72
    "EPSG:4618", // SAD69
];

/// Whether positions in the system of this normalised name are degrees.
pub(super) fn is_geographic(crs: &str) -> bool {
    is_near_wgs84(crs) || OLDER.contains(&crs)
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
    use super::normalised;

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
}
