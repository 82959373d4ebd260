//! `GeoJSON` (RFC 7946) footprints, extruded by a height property.
//!
//! A feature collection, a feature, a geometry, or any number of them one after the other, with
//! or without record separators (RFC 8142). Features are split off the stream one by one, so that
//! memory follows the objects and not the file.
//!
//! - Longitude and latitude are projected to one zone of UTM: that of the files before, else that
//!   of the first position. A file whose `crs` names a projected system, or whose first position
//!   cannot be degrees, is taken to hold metres; where it names none, with a warning. One that
//!   names a system in feet or an earth-centred one is refused. Features over
//!   15 degrees from the zone or from the latitude of the first one near it are left out; where
//!   those are more than are kept, the file is refused.
//! - A footprint stands on its lowest z, else on 0 with its base marked as not known, and rises by
//!   its height: the property the caller names, else `height`, `measuredHeight`,
//!   `building:height`, `h`, else 3 m for each of `building:levels`; one that is 0 gives way to the
//!   next. Without any of these it is kept flat, with a warning. What has `min_height`,
//!   `building:min_height` or `building:min_level` begins so far above the ground and ends at its
//!   height above the ground.
//! - Object id: the feature's `id`, else the property `id`, `gml_id`, `gml:id`, `@id`, `fid` or
//!   `OBJECTID`, else `feature-N`, N counted from 0. Class: the property `class` or `type`, else
//!   `Building`. All properties are kept as attributes.

mod feature;
mod properties;
mod rings;
mod rise;
mod system;

use serde::Deserialize;
use serde_json::error::Category;

use super::collector::Collector;
use super::json::{Next, Splitter, pointer, reason};
use super::source::Source;
use super::{ImportError, Options, Place, crs};
use feature::{Features, Rejected};

/// No feature of a city is larger; one that is would take all memory.
const LARGEST_FEATURE_BYTES: usize = 256 << 20;

pub(super) fn read(
    source: &Source,
    options: &Options,
    collector: &mut Collector,
    report: &dyn Fn(u64),
) -> Result<(), ImportError> {
    let mut stream = Splitter::new(source, report, LARGEST_FEATURE_BYTES)?;
    let mut features = Features::new(options, collector);
    features.system.tell(features.collector)?;
    let mut empty = true;
    loop {
        let start = stream.skip_space(0)?;
        stream.consume(start);
        match stream.byte(0)? {
            Some(b'{') => document(&mut stream, &mut features)?,
            Some(_) => return Err(stream.malformed(0, "expected a GeoJSON object, i.e. `{`")),
            None if empty => return Err(stream.malformed(0, "the file is empty")),
            None => {
                return features.end();
            }
        }
        empty = false;
    }
}

/// Members of the object at hand that were passed.
#[derive(Default)]
struct Head {
    kind: String,
    crs: Option<String>,
}

/// Reads the object that begins at 0 of the stream and goes on behind it.
fn document(stream: &mut Splitter, features: &mut Features) -> Result<(), ImportError> {
    let mut head = Head::default();
    let mut next = stream.first(1, b'}')?;
    while let Next::Item(at) = next {
        let (key, value) = stream.member(at)?;
        if key == "features" && stream.byte(value)? == Some(b'[') && head.kind != "Feature" {
            stream.consume(value + 1);
            return collection(stream, features, &head);
        }
        let end = stream.value_end(value)?;
        head.note(&key, stream.text(value, end)?);
        next = stream.next(end, b'}')?;
    }
    let Next::End(end) = next else { return Ok(()) };
    if head.kind == "FeatureCollection" {
        return Err(stream.malformed(0, "a FeatureCollection without an array of `features`"));
    }
    settle_crs(features, head.crs.as_deref())?;
    let place = stream.place(0);
    add(stream, features, end, place)?;
    stream.consume(end);
    Ok(())
}

/// Reads the features behind `[` and the rest of the collection.
fn collection(
    stream: &mut Splitter,
    features: &mut Features,
    head: &Head,
) -> Result<(), ImportError> {
    settle_crs(features, head.crs.as_deref())?;
    let mut index = 0_usize;
    let mut next = stream.first(0, b']')?;
    while let Next::Item(at) = next {
        stream.consume(at);
        let end = stream.value_end(0)?;
        add(
            stream,
            features,
            end,
            Place::Pointer(pointer("/features", index)),
        )?;
        index += 1;
        stream.consume(end);
        next = stream.next(0, b']')?;
    }
    if let Next::End(end) = next {
        stream.consume(end);
    }
    rest(stream, features, head)
}

/// Passes what follows the features of a collection.
fn rest(stream: &mut Splitter, features: &mut Features, head: &Head) -> Result<(), ImportError> {
    let mut tail = Head::default();
    let mut next = stream.next(0, b'}')?;
    while let Next::Item(at) = next {
        stream.consume(at);
        let (key, value) = stream.member(0)?;
        let end = stream.value_end(value)?;
        tail.note(&key, stream.text(value, end)?);
        if key == "features" {
            let what = "a second array of `features` is ignored; join them";
            features.collector.warn(None, stream.place(0), what);
        }
        stream.consume(end);
        next = stream.next(0, b'}')?;
    }
    match tail.crs.filter(|crs| Some(crs) != head.crs.as_ref()) {
        Some(crs) if !crs.is_empty() => features.system.state_late(&crs, features.collector)?,
        crs => settle_crs(features, crs.as_deref())?,
    }
    if let Next::End(end) = next {
        stream.consume(end);
    }
    Ok(())
}

impl Head {
    fn note(&mut self, key: &str, value: &str) {
        match key {
            "type" => self.kind = serde_json::from_str(value).unwrap_or_default(),
            "crs" => self.crs = crs_name(value),
            _ => {}
        }
    }
}

/// The name in a `crs` member of `GeoJSON` 2008; empty where it gives none.
fn crs_name(value: &str) -> Option<String> {
    #[derive(Deserialize)]
    struct Crs {
        properties: Name,
    }
    #[derive(Deserialize)]
    struct Name {
        name: String,
    }
    let crs: Option<Crs> = match serde_json::from_str(value) {
        Ok(crs) => crs,
        Err(_) => return Some(String::new()),
    };
    crs.map(|c| crs::normalised(&c.properties.name))
}

fn settle_crs(features: &mut Features, crs: Option<&str>) -> Result<(), ImportError> {
    match crs {
        None => {}
        Some("") => features.collector.warn(
            None,
            Place::Pointer("/crs".into()),
            "has no name; read as if it were not there",
        ),
        Some(crs) => features.system.state(crs, features.collector)?,
    }
    Ok(())
}

/// Hands over the feature that ends at `end`.
fn add(
    stream: &Splitter,
    features: &mut Features,
    end: usize,
    place: Place,
) -> Result<(), ImportError> {
    let whole = !matches!(place, Place::Pointer(_));
    match features.add(stream.text(0, end)?, place.clone()) {
        Ok(()) => Ok(()),
        Err(Rejected::Import(error)) => Err(error),
        Err(Rejected::Kind(kind)) if whole => Err(stream.malformed(
            0,
            format!("{kind:?} is no type of GeoJSON; expected a FeatureCollection, a Feature or a geometry"),
        )),
        Err(Rejected::Kind(kind)) => {
            let what = format!("{kind:?} is no type of a feature; left out");
            features.leave_out(place, what);
            Ok(())
        }
        Err(Rejected::Json(error)) if error.classify() == Category::Data => {
            let at = stream.place_of(0, &error);
            features.leave_out(place, format!("{}, at {at}; left out", reason(&error)));
            Ok(())
        }
        Err(Rejected::Json(error)) => Err(stream.syntax(0, &error)),
    }
}
