//! `CityJSON` 1.0, 1.1 and 2.0, and `CityJSONSeq`: one document, or a first line with the
//! transform and a feature on each of the others.
//!
//! - One object per top-most city object. Its parts (city objects with `parents`) are folded into
//!   it: bounds, footprint and triangles are over all of them; id, class and attributes are its
//!   own. The members of a `CityObjectGroup` are no parts of it and stay objects.
//! - Each city object is taken in one level of detail: the highest it has, or the one asked for.
//!   `1.2` is taken by that name only; `1` is `1`, or else the highest of `1.0` to `1.3`. An
//!   object without the level asked for is left out with a warning.
//! - A geometry that cannot be used is left out with a warning that points at it; so is each
//!   vertex index out of range. The object stays if any vertex is left.

mod boundaries;
mod document;
mod family;
mod geometry;
mod lod;
mod template;

use serde_json::error::Category;

use super::collector::Collector;
use super::json::{Splitter, reason};
use super::placing::Placing;
use super::source::Source;
use super::{ImportError, Options, Place, crs};
use document::{Document, Transform};
use family::Family;
use geometry::Objects;
use template::Templates;

const REPROJECT: &str = "reproject the file to a system in metres, for one with \
     `cjio FILE crs_reproject CODE save NEW`";

pub(super) fn read(
    source: &Source,
    options: &Options,
    collector: &mut Collector,
    report: &dyn Fn(u64),
) -> Result<(), ImportError> {
    let mut stream = Splitter::new(source, report, source.largest_value())?;
    let first = stream.skip_space(0)?;
    stream.consume(first);
    match stream.byte(0)? {
        Some(b'{') => {}
        Some(_) => return Err(stream.malformed(0, "expected a CityJSON object, i.e. `{`")),
        None => return Err(stream.malformed(0, "the file is empty")),
    }
    let end = stream.value_end(0)?;
    let document = parse(&stream, end)?;
    let mut city = City::open(&stream, &document, options)?;
    let found = document.reference_system();
    let found = found.map(|name| crs::normalised(&name));
    let place = Place::Pointer("/metadata/referenceSystem".into());
    city.made.placing = Placing::of(found.as_deref(), place, REPROJECT, collector)?;
    city.objects(&stream, &document, collector)?;
    drop(document);
    stream.consume(end);
    loop {
        let start = stream.skip_space(0)?;
        stream.consume(start);
        match stream.byte(0)? {
            Some(b'{') => {}
            Some(_) => return Err(stream.malformed(0, "expected a CityJSONFeature, i.e. `{`")),
            None => {
                city.made.end(collector);
                return Ok(());
            }
        }
        let end = stream.value_end(0)?;
        city.feature(&stream, end, collector)?;
        stream.consume(end);
    }
}

/// What holds for the whole file, and buffers that are used again for each part of it.
struct City {
    transform: Transform,
    made: Objects,
}

impl City {
    fn open(
        stream: &Splitter,
        document: &Document,
        options: &Options,
    ) -> Result<Self, ImportError> {
        match document.kind.as_deref() {
            Some("CityJSON") => {}
            None => {
                let reason = "has no `type`; expected CityJSON or GeoJSON";
                return Err(ImportError::malformed(
                    stream.path(),
                    Place::Pointer("/type".into()),
                    reason,
                ));
            }
            Some(other) => {
                let reason = format!("`type` is {other:?}; expected \"CityJSON\"");
                return Err(at_pointer(stream, "/type", reason));
            }
        }
        let version = document.version.as_deref().unwrap_or_default();
        if !["1.0", "1.1", "2.0"]
            .iter()
            .any(|known| version == *known || version.starts_with(&format!("{known}.")))
        {
            return Err(ImportError::Unsupported {
                path: stream.path().to_owned(),
                feature: format!("CityJSON version {version:?}"),
                way_out: "1.0, 1.1 and 2.0 are; `cjio FILE upgrade save NEW` converts".into(),
            });
        }
        let transform = Transform::read(document.transform, version.starts_with("1.0"))
            .map_err(|(pointer, reason)| at_pointer(stream, pointer, reason))?;
        let templates = Templates::read(document.templates)
            .map_err(|(pointer, reason)| at_pointer(stream, &pointer, reason))?;
        Ok(Self {
            transform,
            made: Objects::new(options.lod.as_deref(), templates),
        })
    }

    fn feature(
        &mut self,
        stream: &Splitter,
        end: usize,
        collector: &mut Collector,
    ) -> Result<(), ImportError> {
        match parse(stream, end) {
            Ok(feature) if feature.kind.as_deref() == Some("CityJSONFeature") => {
                self.objects(stream, &feature, collector)
            }
            Ok(other) => {
                let what = format!(
                    "`type` is {:?}; expected \"CityJSONFeature\"; left out",
                    other.kind.as_deref().unwrap_or_default()
                );
                collector.warn(None, stream.place(0), what);
                collector.left_out("feature", "not of the type CityJSONFeature");
                Ok(())
            }
            Err(error) => Err(error),
        }
    }

    fn objects(
        &mut self,
        stream: &Splitter,
        document: &Document,
        collector: &mut Collector,
    ) -> Result<(), ImportError> {
        let Some(entries) = &document.city_objects else {
            return Err(at_pointer(stream, "/CityObjects", "is missing"));
        };
        if document.vertices.is_none() && !entries.0.is_empty() {
            return Err(at_pointer(stream, "/vertices", "is missing"));
        }
        self.made
            .vertices(document.vertices, &self.transform)
            .map_err(|(pointer, reason)| at_pointer(stream, &pointer, reason))?;
        self.made.place(collector)?;
        let family = Family::of(entries, collector);
        for (root, members) in family.groups() {
            self.made.add(root, members, collector);
        }
        Ok(())
    }
}

/// The value from 0 to `end` of the stream.
fn parse<'a>(stream: &'a Splitter, end: usize) -> Result<Document<'a>, ImportError> {
    serde_json::from_str(stream.text(0, end)?).map_err(|error| match error.classify() {
        Category::Data => {
            ImportError::malformed(stream.path(), stream.place_of(0, &error), reason(&error))
        }
        _ => stream.syntax(0, &error),
    })
}

fn at_pointer(stream: &Splitter, pointer: &str, reason: impl Into<String>) -> ImportError {
    let reason = reason.into();
    let place = Place::Pointer(pointer.to_owned());
    match stream.place(0) {
        Place::Line(line, _) if line > 1 => ImportError::malformed(
            stream.path(),
            place,
            format!("{reason} (in the feature on line {line})"),
        ),
        _ => ImportError::malformed(stream.path(), place, reason),
    }
}
