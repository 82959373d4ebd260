use std::borrow::Cow;

use compact_str::{CompactString, format_compact};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::properties::{self, Properties};
use super::rings::{MULTI_POLYGON_DEPTH, POLYGON_DEPTH, Rings};
use super::rise::{KEPT_FLAT, NO_HEIGHT, Rise};
use super::system::System;
use crate::import::collector::Collector;
use crate::import::shape::Shape;
use crate::import::utm::FARTHEST_DEG;
use crate::import::{ImportError, Options, Place};

const CLASS: &str = "Building";
/// What one of them is called.
const NOUN: &str = "feature";

/// A feature, or a geometry that stands for one.
#[derive(Deserialize)]
pub(super) struct Feature<'a> {
    #[serde(rename = "type", borrow)]
    kind: Option<Cow<'a, str>>,
    #[serde(borrow)]
    id: Option<&'a RawValue>,
    #[serde(borrow)]
    properties: Option<&'a RawValue>,
    #[serde(borrow)]
    geometry: Option<Geometry<'a>>,
    #[serde(borrow)]
    coordinates: Option<&'a RawValue>,
    #[serde(borrow)]
    geometries: Option<Vec<Geometry<'a>>>,
}

#[derive(Deserialize)]
struct Geometry<'a> {
    #[serde(rename = "type", borrow)]
    kind: Cow<'a, str>,
    #[serde(borrow)]
    coordinates: Option<&'a RawValue>,
    #[serde(borrow)]
    geometries: Option<Vec<Geometry<'a>>>,
}

const GEOMETRIES: [&str; 7] = [
    "Point",
    "MultiPoint",
    "LineString",
    "MultiLineString",
    "Polygon",
    "MultiPolygon",
    "GeometryCollection",
];

impl<'a> Feature<'a> {
    /// `Err` with what it says to be, when that is neither a feature nor a geometry.
    fn geometry(self) -> Result<Option<Geometry<'a>>, Option<Cow<'a, str>>> {
        match self.kind {
            Some(kind) if kind == "Feature" => Ok(self.geometry),
            Some(kind) if GEOMETRIES.contains(&kind.as_ref()) => Ok(Some(Geometry {
                kind,
                coordinates: self.coordinates,
                geometries: self.geometries,
            })),
            kind => Err(kind),
        }
    }
}

/// Why nothing was made of a value.
pub(super) enum Rejected {
    /// Its members have types they must not have.
    Json(serde_json::Error),
    /// It says to be this, which is neither a feature nor a geometry.
    Kind(String),
    Import(ImportError),
}

/// Makes an object of each feature of one file.
pub(super) struct Features<'a, 'c> {
    pub(super) options: &'a Options,
    pub(super) collector: &'c mut Collector,
    pub(super) system: System,
    pub(super) count: usize,
    rings: Rings,
    shape: Shape,
    problems: Vec<String>,
    /// Why the current feature is left out if it is, and why it is flat if it is.
    lost: Option<&'static str>,
    flat_for: Option<&'static str>,
    /// A feature had a height.
    has_height: bool,
    /// How many were kept flat for want of one.
    flat: usize,
    /// How many became objects, and how many did not as they lie too far from those.
    kept: usize,
    far: usize,
}

impl<'a, 'c> Features<'a, 'c> {
    pub(super) fn new(options: &'a Options, collector: &'c mut Collector) -> Self {
        Self {
            options,
            collector,
            system: System::default(),
            count: 0,
            rings: Rings::default(),
            shape: Shape::default(),
            problems: Vec::new(),
            lost: None,
            flat_for: None,
            has_height: false,
            flat: 0,
            kept: 0,
            far: 0,
        }
    }

    /// Hands over the object of a feature, or a warning that there is none.
    pub(super) fn add(&mut self, text: &str, place: Place) -> Result<(), Rejected> {
        let feature: Feature = serde_json::from_str(text).map_err(Rejected::Json)?;
        let raw = feature.properties.filter(|p| p.get().starts_with('{'));
        if raw.is_none() && feature.properties.is_some() {
            self.problems
                .push("its properties are no object; left out".into());
        }
        let height = self.options.height.as_deref();
        let properties = match raw.map(|p| Properties::read(p.get(), height)) {
            Some(read) => read.map_err(Rejected::Json)?,
            None => Properties::default(),
        };
        if height.is_some() {
            self.look_for_height(&properties, raw);
        }
        let id = feature
            .id
            .and_then(properties::name)
            .or_else(|| properties.id())
            .unwrap_or_else(|| format_compact!("feature-{}", self.count));
        let geometry = feature
            .geometry()
            .map_err(|kind| Rejected::Kind(kind.unwrap_or_default().into_owned()))?;
        self.count += 1;
        self.rings.clear();
        if let Some(geometry) = &geometry {
            self.read_rings(geometry);
        } else {
            self.problems.push("it has no geometry".into());
            self.lost = Some("no geometry");
        }
        self.shape(&properties).map_err(Rejected::Import)?;
        let class = properties
            .class()
            .unwrap_or(CompactString::const_new(CLASS));
        self.hand_over(&id, class, raw, place);
        Ok(())
    }

    /// Whether it has the height that the caller names, and what it has instead.
    fn look_for_height(&mut self, properties: &Properties, raw: Option<&RawValue>) {
        let named = &mut self.collector.named_height;
        if properties.has_named() {
            named.find();
        } else if named.is_sought() {
            let names = raw.map(|raw| properties::names(raw.get()));
            named.miss(names.into_iter().flatten());
        }
    }

    /// To be called behind the last feature.
    pub(super) fn end(&mut self) -> Result<(), ImportError> {
        if self.far > self.kept
            && let Some((from, way_out)) = self.system.apart()
        {
            return Err(ImportError::FarFeatures {
                path: self.collector.path().to_owned(),
                far: self.far,
                of: self.count,
                degrees: FARTHEST_DEG,
                from,
                way_out,
            });
        }
        if !self.has_height && self.flat > 0 {
            self.condense_flat();
        }
        Ok(())
    }

    /// Says once what is so of all features.
    fn condense_flat(&mut self) {
        let wanted = match self.options.height.as_deref() {
            Some(named) => format!("in the property {named:?}"),
            None => properties::usual_heights(),
        };
        let all = counted(self.flat, "feature");
        let what = format!("no feature has a height {wanted}; {all} kept flat");
        self.collector.condense(KEPT_FLAT, what);
    }

    /// Warns of a feature of which nothing can be read.
    pub(super) fn leave_out(&mut self, place: Place, what: String) {
        let id = format_compact!("feature-{}", self.count);
        self.count += 1;
        self.problems.clear();
        self.collector.left_out(NOUN, "cannot be read");
        self.collector.warn(Some(&id), place, what);
    }

    fn read_rings(&mut self, geometry: &Geometry) {
        let depth = match geometry.kind.as_ref() {
            "Polygon" => POLYGON_DEPTH,
            "MultiPolygon" => MULTI_POLYGON_DEPTH,
            "GeometryCollection" => {
                for member in geometry.geometries.iter().flatten() {
                    self.read_rings(member);
                }
                return;
            }
            other => {
                self.lost = Some("neither a Polygon nor a MultiPolygon");
                let problem = format!("a {other} is no footprint and is not taken");
                if !self.problems.contains(&problem) {
                    self.problems.push(problem);
                }
                return;
            }
        };
        let sound = geometry
            .coordinates
            .is_some_and(|c| self.rings.read(c.get(), depth));
        if !sound {
            self.problems.push(format!(
                "its coordinates are not those of a {}: {depth} arrays nested around numbers",
                geometry.kind
            ));
        }
    }

    /// The prism over the rings.
    fn shape(&mut self, properties: &Properties) -> Result<(), ImportError> {
        self.shape.clear();
        if self.rings.positions.is_empty() {
            return Ok(());
        }
        self.system.settle(&self.rings.positions, self.collector)?;
        let (ground, highest) = self.heights_of_positions().unwrap_or_else(|| {
            self.shape.base_is_unknown();
            (0.0, 0.0)
        });
        let named = self.options.height.as_deref();
        let rise = Rise::of(properties, named, [ground, highest], &mut self.problems);
        let (base, top) = (rise.base, rise.top);
        self.shape.begins_above(rise.lift);
        self.has_height |= rise.has_height;
        self.flat += usize::from(rise.flat_for == Some(NO_HEIGHT));
        self.flat_for = rise.flat_for;
        let mut last = None;
        for &position in self.rings.corners() {
            let vertex = self.system.place(position, base);
            self.shape.vertex(vertex);
            if vertex.is_finite() {
                last = Some(vertex);
            }
        }
        if last.is_none() && self.rings.corners().any(|&p| self.system.is_far(p)) {
            self.far += 1;
            self.lost = Some("too far from the others");
        }
        // One vertex carries the top: the others would only repeat the outline.
        if let Some(vertex) = last.filter(|_| top > base) {
            self.shape.vertex(vertex.with_z(top));
        }
        self.shape.triangles(self.rings.triangles(rise.is_extruded));
        self.note_faults();
        Ok(())
    }

    /// Lowest and highest z; `None` where no position has one.
    fn heights_of_positions(&self) -> Option<(f64, f64)> {
        let heights = self.rings.positions.iter().map(|p| p[2]);
        let (low, high) = heights
            .filter(|z| z.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| {
                (low.min(z), high.max(z))
            });
        (low <= high).then_some((low, high))
    }

    fn note_faults(&mut self) {
        let faults = self.rings.faults();
        for (count, what) in [
            (faults.open, "not closed"),
            (faults.degenerate, "of fewer than three distinct points"),
        ] {
            if count > 0 {
                self.problems
                    .push(format!("{} {what}", counted(count, "ring")));
            }
        }
        let mut drop = |count: usize, what: &str| {
            if count > 0 {
                let positions = counted(count, "position");
                self.problems.push(format!("{positions} {what}, dropped"));
            }
        };
        drop(self.rings.too_short, "of fewer than two numbers");
        let not_finite = self.shape.not_finite();
        if not_finite > 0 {
            drop(not_finite, &self.system.fault());
        }
    }

    fn hand_over(
        &mut self,
        id: &CompactString,
        class: CompactString,
        attributes: Option<&RawValue>,
        place: Place,
    ) {
        let object = self
            .shape
            .object(id.clone(), class, attributes.map(ToOwned::to_owned));
        let lost = object.is_none();
        let (why_lost, why_flat) = (self.lost.take(), self.flat_for.take());
        if let Some(object) = object {
            self.kept += 1;
            let is_taken = self.collector.object(object);
            if let Some(reason) = why_flat.filter(|_| is_taken) {
                self.collector.kept_flat(NOUN, reason);
            }
        } else {
            let reason = why_lost.unwrap_or("no position that can be used");
            self.collector.left_out(NOUN, reason);
        }
        if lost && self.problems.is_empty() {
            self.problems.push("it has no positions".into());
        }
        if !self.problems.is_empty() {
            let fate = if lost { "; left out" } else { "" };
            let what = self.problems.join("; ") + fate;
            self.collector.warn(Some(id), place, what);
            self.problems.clear();
        }
    }
}

fn counted(count: usize, noun: &str) -> String {
    if count == 1 {
        format!("1 {noun}")
    } else {
        format!("{count} {noun}s")
    }
}
