//! Names of coordinate reference systems.

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
