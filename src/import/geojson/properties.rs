use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use compact_str::CompactString;
use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;

/// Where a height is looked for when the caller names no property, the best first.
const HEIGHTS: [&str; 4] = ["height", "measuredHeight", "building:height", "h"];
const LEVELS: &str = "building:levels";
/// Where it is looked for how far above the ground a part begins.
const MIN_HEIGHTS: [&str; 2] = ["min_height", "building:min_height"];
const MIN_LEVEL: &str = "building:min_level";
const METRES_A_LEVEL: f64 = 3.0;
const METRES_A_FOOT: f64 = 0.3048;

/// Where an id is looked for when the feature has none, the best first.
const IDS: [&str; 6] = ["id", "gml_id", "gml:id", "@id", "fid", "OBJECTID"];
const CLASSES: [&str; 2] = ["class", "type"];
/// What OpenStreetMap exports say in `type`: of the element, not of the thing.
const ELEMENTS: [&str; 5] = ["multipolygon", "boundary", "way", "relation", "node"];

/// Where a height is looked for, for people.
pub(super) fn usual_heights() -> String {
    let names = HEIGHTS.join(", ");
    format!("in {names} or {LEVELS} (--height names another property)")
}

/// What the properties of a feature say that matters here.
#[derive(Debug, Default)]
pub(super) struct Properties<'a> {
    ids: [Option<&'a RawValue>; IDS.len()],
    classes: [Option<&'a RawValue>; CLASSES.len()],
    heights: [Option<&'a RawValue>; HEIGHTS.len()],
    levels: Option<&'a RawValue>,
    min_heights: [Option<&'a RawValue>; MIN_HEIGHTS.len()],
    min_level: Option<&'a RawValue>,
    named: Option<&'a RawValue>,
}

/// What is known of the height of a feature.
#[derive(Debug, PartialEq)]
pub(super) enum Height {
    Metres(f64),
    Missing,
    /// There is a value, but not of a height: the property and the value.
    Unusable(String, String),
}

impl<'a> Properties<'a> {
    /// Of a JSON object; `height` is the property the caller named.
    pub(super) fn read(text: &'a str, height: Option<&str>) -> serde_json::Result<Self> {
        let mut parser = serde_json::Deserializer::from_str(text);
        parser.deserialize_map(Wanted { height })
    }

    pub(super) fn id(&self) -> Option<CompactString> {
        self.ids.iter().flatten().find_map(|v| name(v))
    }

    pub(super) fn class(&self) -> Option<CompactString> {
        self.classes
            .iter()
            .flatten()
            .filter_map(|v| string(v))
            .find(|c| !c.is_empty() && !ELEMENTS.contains(&c.as_ref()))
            .map(CompactString::from)
    }

    /// Of the property `named` by the caller, else of the first usual one that has a value which
    /// is not 0, else 0 where one has that.
    pub(super) fn height(&self, named: Option<&str>) -> Height {
        match named {
            Some(property) => height_of(property, self.named, 1.0).unwrap_or(Height::Missing),
            None => first_of(&HEIGHTS, &self.heights, LEVELS, self.levels),
        }
    }

    /// How far above the ground it begins, as `OpenStreetMap` has it: what is above the ground
    /// from there up to its height.
    pub(super) fn min_height(&self) -> Height {
        first_of(&MIN_HEIGHTS, &self.min_heights, MIN_LEVEL, self.min_level)
    }

    /// Whether there is the property that the caller named, whatever its value.
    pub(super) fn has_named(&self) -> bool {
        self.named.is_some()
    }

    fn keep(&mut self, key: &str, value: &'a RawValue, height: Option<&str>) {
        let place = |keys: &[&str]| keys.iter().position(|k| *k == key);
        if height == Some(key) {
            self.named = Some(value);
        }
        if let Some(at) = place(&HEIGHTS) {
            self.heights[at] = Some(value);
        } else if let Some(at) = place(&IDS) {
            self.ids[at] = Some(value);
        } else if let Some(at) = place(&CLASSES) {
            self.classes[at] = Some(value);
        } else if let Some(at) = place(&MIN_HEIGHTS) {
            self.min_heights[at] = Some(value);
        } else if key == LEVELS {
            self.levels = Some(value);
        } else if key == MIN_LEVEL {
            self.min_level = Some(value);
        }
    }
}

/// The names of the properties in a JSON object.
pub(super) fn names(text: &str) -> impl Iterator<Item = CompactString> {
    let members: serde_json::Result<BTreeMap<CompactString, &RawValue>> =
        serde_json::from_str(text);
    members.unwrap_or_default().into_keys()
}

/// A name given as a string or as a number.
pub(super) fn name(value: &RawValue) -> Option<CompactString> {
    match value.get().as_bytes().first()? {
        b'"' => string(value)
            .filter(|s| !s.is_empty())
            .map(CompactString::from),
        b'-' | b'0'..=b'9' => Some(value.get().into()),
        _ => None,
    }
}

fn string(value: &RawValue) -> Option<Cow<'_, str>> {
    #[derive(Deserialize)]
    struct Text<'a>(#[serde(borrow)] Cow<'a, str>);
    serde_json::from_str::<Text>(value.get()).ok().map(|t| t.0)
}

/// The first height that is not 0, among those in metres and then that in levels; 0 where one is
/// that and no other has a value.
fn first_of(
    names: &[&str],
    values: &[Option<&RawValue>],
    levels_name: &str,
    levels: Option<&RawValue>,
) -> Height {
    let in_metres = names.iter().zip(values).map(|(n, v)| height_of(n, *v, 1.0));
    let in_levels = std::iter::once_with(|| height_of(levels_name, levels, METRES_A_LEVEL));
    let mut zero = Height::Missing;
    for height in in_metres.chain(in_levels).flatten() {
        if height != Height::Metres(0.0) {
            return height;
        }
        zero = height;
    }
    zero
}

/// `None` where there is no value.
fn height_of(property: &str, value: Option<&RawValue>, unit_m: f64) -> Option<Height> {
    let text = value?.get();
    if text == "null" || text == "\"\"" {
        return None;
    }
    let unusable = || Height::Unusable(property.to_owned(), excerpt(text));
    let metres = match text.as_bytes().first() {
        Some(b'"') => string(value?).and_then(|s| length(&s)),
        _ => text.parse().ok(),
    };
    Some(match metres.map(|m| m * unit_m) {
        Some(m) if m.is_finite() && m >= 0.0 => Height::Metres(m),
        _ => unusable(),
    })
}

/// `12`, `12.5`, `12 m` or `40 ft` in metres.
fn length(text: &str) -> Option<f64> {
    let text = text.trim();
    let end = text
        .find(|c: char| !matches!(c, '0'..='9' | '.' | '-' | '+' | 'e' | 'E'))
        .unwrap_or(text.len());
    let number: f64 = text[..end].parse().ok()?;
    match text[end..].trim() {
        "" | "m" | "metre" | "metres" | "meter" | "meters" => Some(number),
        "ft" | "feet" | "'" => Some(number * METRES_A_FOOT),
        _ => None,
    }
}

fn excerpt(text: &str) -> String {
    const LONGEST: usize = 40;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

struct Wanted<'h> {
    height: Option<&'h str>,
}

/// A key, borrowed where it has no escapes.
#[derive(Deserialize)]
struct Key<'a>(#[serde(borrow)] Cow<'a, str>);

impl<'de> Visitor<'de> for Wanted<'_> {
    type Value = Properties<'de>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("properties: an object")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Properties<'de>, M::Error> {
        let mut properties = Properties::default();
        while let Some(Key(key)) = map.next_key()? {
            properties.keep(&key, map.next_value()?, self.height);
        }
        Ok(properties)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_in_the_ways_they_are_written() {
        let unusable =
            |property: &str, value: &str| Height::Unusable(property.into(), value.into());
        for (text, named, expected) in [
            (r#"{"height":12.5}"#, None, Height::Metres(12.5)),
            (r#"{"height":"12.5"}"#, None, Height::Metres(12.5)),
            (r#"{"height":"12 m"}"#, None, Height::Metres(12.0)),
            (r#"{"height":"10 ft"}"#, None, Height::Metres(3.048)),
            (r#"{"h":1,"measuredHeight":2}"#, None, Height::Metres(2.0)),
            (r#"{"building:levels":"4"}"#, None, Height::Metres(12.0)),
            (r#"{"height":null,"h":7}"#, None, Height::Metres(7.0)),
            (r#"{"height":0,"h":7}"#, None, Height::Metres(7.0)),
            (
                r#"{"height":"0 m","building:levels":2}"#,
                None,
                Height::Metres(6.0),
            ),
            (
                r#"{"height":0,"building:levels":""}"#,
                None,
                Height::Metres(0.0),
            ),
            (r#"{"top":0,"h":7}"#, Some("top"), Height::Metres(0.0)),
            (r#"{"height":1,"top":9}"#, Some("top"), Height::Metres(9.0)),
            (r#"{"height":1}"#, Some("top"), Height::Missing),
            (r#"{"he\u0069ght":3}"#, None, Height::Metres(3.0)),
            ("{}", None, Height::Missing),
            (r#"{"height":-1}"#, None, unusable("height", "-1")),
            (r#"{"height":1e999}"#, None, unusable("height", "1e999")),
            (r#"{"height":"tall"}"#, None, unusable("height", "\"tall\"")),
            (r#"{"height":[3]}"#, None, unusable("height", "[3]")),
        ] {
            let height = Properties::read(text, named).map(|p| p.height(named));
            assert_eq!(height.ok(), Some(expected), "{text}");
        }
    }

    #[test]
    fn where_parts_begin() {
        let metres = Height::Metres;
        for (text, lift) in [
            (
                r#"{"min_height":"4 m","building:min_level":9}"#,
                metres(4.0),
            ),
            (r#"{"building:min_height":5}"#, metres(5.0)),
            (r#"{"min_height":0,"building:min_level":"3"}"#, metres(9.0)),
            (r#"{"height":4}"#, Height::Missing),
        ] {
            let found = Properties::read(text, None).map(|p| p.min_height());
            assert_eq!(found.ok(), Some(lift), "{text}");
        }
    }

    #[test]
    fn ids_and_classes() {
        for (text, id, class) in [
            (r#"{"gml_id":"b","id":7}"#, Some("7"), None),
            (
                r#"{"@id":"way/3","type":"multipolygon"}"#,
                Some("way/3"),
                None,
            ),
            (r#"{"id":"","class":"Bridge"}"#, None, Some("Bridge")),
            (r#"{"id":{},"class":3,"type":"Tower"}"#, None, Some("Tower")),
        ] {
            let found = Properties::read(text, None).ok();
            let found = found.map(|p| (p.id(), p.class()));
            assert_eq!(
                found,
                Some((id.map(Into::into), class.map(Into::into))),
                "{text}"
            );
        }
    }
}
