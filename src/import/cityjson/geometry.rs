use std::borrow::Cow;

use compact_str::CompactString;
use glam::DMat4;
use serde_json::value::RawValue;

use super::boundaries::{Boundaries, Geometry, INSTANCE, POINTS, depth_of, points};
use super::document::Transform;
use super::family::CityObject;
use super::lod::Lod;
use super::template::Templates;
use crate::geom::DVec3;
use crate::import::collector::Collector;
use crate::import::json::pointer;
use crate::import::placing::Placing;
use crate::import::shape::Shape;
use crate::import::{ImportError, Place};

/// The class of a city object that does not say what it is.
const CLASS: &str = "GenericCityObject";
const NO_LEVEL: &str = "it has no geometry of level of detail";

/// Makes scene objects of city objects over the vertices of one document or feature.
#[derive(Default)]
pub(super) struct Objects {
    asked: Option<Lod>,
    /// Where a level is asked for: the levels of the objects without it, and how many there are.
    there: Vec<Lod>,
    without: usize,
    /// An object has the level asked for.
    has_asked: bool,
    templates: Templates,
    pub(super) placing: Placing,
    /// In scene coordinates.
    vertices: Vec<DVec3>,
    /// The last object that took each vertex; every face of a solid names it again.
    taken_by: Vec<u32>,
    object: u32,
    shape: Shape,
}

/// What the city objects of one group came to.
#[derive(Default)]
struct Tally {
    /// The levels there are, where one is asked for.
    lods: Vec<Lod>,
    geometries: usize,
    taken: usize,
}

impl Objects {
    pub(super) fn new(asked: Option<&str>, templates: Templates) -> Self {
        Self {
            asked: asked.map(Lod::parse),
            templates,
            ..Self::default()
        }
    }

    /// The next objects lie over these vertices.
    pub(super) fn vertices(
        &mut self,
        text: Option<&RawValue>,
        transform: &Transform,
    ) -> Result<(), (String, String)> {
        points(text, "/vertices", &mut self.vertices)?;
        for vertex in &mut self.vertices {
            *vertex = transform.apply(*vertex);
        }
        self.taken_by.clear();
        self.taken_by.resize(self.vertices.len(), 0);
        self.object = 0;
        Ok(())
    }

    /// Brings the vertices into scene coordinates.
    pub(super) fn place(&mut self, collector: &mut Collector) -> Result<(), ImportError> {
        self.placing.place(&mut self.vertices, collector)
    }

    /// Hands over the object made of `root` and its `members`, or a warning that there is none.
    pub(super) fn add<'a, 'b: 'a>(
        &mut self,
        root: &CityObject,
        members: impl Iterator<Item = &'a CityObject<'b>>,
        collector: &mut Collector,
    ) {
        self.shape.clear();
        self.object += 1;
        let mut tally = Tally::default();
        for member in members {
            self.city_object(root, member, &mut tally, collector);
        }
        self.has_asked |= tally.taken > 0;
        if self.shape.not_finite() > 0 {
            let what = format!(
                "vertices {}: {}; left out",
                self.placing.fault(),
                self.shape.not_finite()
            );
            warn(root, root.pointer(), what, collector);
        }
        if root.class.is_none() {
            let what = format!("it has no type; taken as {CLASS}");
            warn(root, root.pointer(), what, collector);
        }
        let class = root.class.as_deref().unwrap_or(CLASS);
        let attributes = root.attributes.filter(|a| a.get().starts_with('{'));
        let object = self.shape.object(
            CompactString::from(root.id.as_ref()),
            CompactString::from(class),
            attributes.map(ToOwned::to_owned),
        );
        if let Some(object) = object {
            collector.object(object);
        } else {
            let (what, reason) = self.why_none(root, &tally);
            if let Some(reason) = reason {
                collector.left_out("object", reason);
            }
            warn(root, root.pointer(), what, collector);
        }
    }

    /// To be called behind the last object of a file.
    pub(super) fn end(&mut self, collector: &mut Collector) {
        let Some(asked) = self.asked.as_ref().filter(|_| !self.has_asked) else {
            return;
        };
        if self.without > 0 {
            self.there.sort_by(Lod::order);
            let what = format!(
                "no object has geometry of level of detail {asked}; {}; all {} left out",
                levels(&self.there),
                self.without
            );
            collector.condense(NO_LEVEL, what);
        }
    }

    /// What is said of an object that is none, and in a few words where it was to be one.
    fn why_none(&mut self, root: &CityObject, tally: &Tally) -> (String, Option<&'static str>) {
        match &self.asked {
            _ if root.is_group() => {
                let what = format!(
                    "a group without geometry; its {} members are objects of their own",
                    root.children()
                );
                (what, None)
            }
            _ if tally.geometries == 0 => {
                let what = "neither it nor a part of it has geometry; left out";
                (what.into(), Some("no geometry"))
            }
            Some(asked) if tally.taken == 0 => {
                self.without += 1;
                for lod in &tally.lods {
                    note(&mut self.there, lod);
                }
                let what = format!("{NO_LEVEL} {asked}; {}; left out", levels(&tally.lods));
                (what, Some("no geometry of the level of detail asked for"))
            }
            _ => {
                let what = "not one of its vertices can be used; left out";
                (what.into(), Some("no vertex that can be used"))
            }
        }
    }

    /// Takes the chosen level of one city object.
    fn city_object(
        &mut self,
        root: &CityObject,
        member: &CityObject,
        tally: &mut Tally,
        collector: &mut Collector,
    ) {
        let place = |index| pointer(&(member.pointer() + "/geometry"), index);
        let mut readable = Vec::with_capacity(member.geometry.len());
        for (index, geometry) in member.geometry.iter().enumerate() {
            match geometry {
                Ok(geometry) => readable.push((index, self.lod(geometry), geometry)),
                Err(reason) => {
                    warn(root, place(index), format!("{reason}; left out"), collector);
                }
            }
        }
        tally.geometries += readable.len();
        if self.asked.is_some() {
            for lod in readable.iter().filter_map(|(_, lod, _)| lod.as_ref()) {
                note(&mut tally.lods, lod);
            }
        }
        let lods = readable.iter().filter_map(|(_, lod, _)| lod.as_ref());
        // Geometries without a level stand in where no level is chosen.
        let chosen = Lod::choose(lods, self.asked.as_ref()).cloned();
        for (index, lod, geometry) in readable {
            if lod == chosen {
                tally.taken += 1;
                if let Some(problem) = self.take(geometry) {
                    warn(root, place(index), problem, collector);
                }
            }
        }
    }

    fn lod(&self, geometry: &Geometry) -> Option<Lod> {
        Lod::of(geometry.lod).or_else(|| {
            let instance = geometry.kind == INSTANCE;
            let template = self.templates.at(geometry.template).ok();
            template.filter(|_| instance)?.lod.clone()
        })
    }

    /// Adds the geometry to the shape; what is wrong with it, if anything.
    fn take(&mut self, geometry: &Geometry) -> Option<String> {
        let Some(boundaries) = geometry.boundaries else {
            return Some("it has no boundaries; left out".into());
        };
        if geometry.kind == INSTANCE {
            return self.instance(geometry, boundaries).err();
        }
        let Some(depth) = depth_of(&geometry.kind) else {
            return Some(format!(
                "{:?} is no type of geometry; left out",
                geometry.kind
            ));
        };
        let Self {
            vertices,
            taken_by,
            object,
            shape,
            ..
        } = self;
        let found = Boundaries::walk(boundaries.get(), depth, vertices.len(), |index| {
            if taken_by[index] != *object {
                taken_by[index] = *object;
                shape.vertex(vertices[index]);
            }
        });
        shape.triangles(found.triangles);
        found.problem
    }

    /// Puts a template where the instance says.
    fn instance(&mut self, geometry: &Geometry, boundaries: &RawValue) -> Result<(), String> {
        let template = self
            .templates
            .at(geometry.template)
            .map_err(|problem| problem + "; left out")?;
        let mut reference = None;
        let found = Boundaries::walk(boundaries.get(), POINTS, self.vertices.len(), |index| {
            reference = reference.or(Some(index));
        });
        let Some(reference) = reference else {
            let problem = found.problem.map(Cow::from);
            return Err(problem
                .unwrap_or("no reference point; left out".into())
                .into());
        };
        let matrix = match &geometry.matrix {
            Some(rows) => DMat4::from_cols_array(rows).transpose(),
            None => DMat4::IDENTITY,
        };
        for &vertex in &template.vertices {
            self.shape
                .vertex(matrix.transform_point3(vertex) + self.vertices[reference]);
        }
        self.shape.triangles(template.triangles);
        match &template.problem {
            Some(problem) => Err(format!(
                "template {}: {problem}",
                geometry.template.unwrap_or_default()
            )),
            None => Ok(()),
        }
    }
}

fn note(lods: &mut Vec<Lod>, lod: &Lod) {
    if !lods.contains(lod) {
        lods.push(lod.clone());
    }
}

/// The levels there are, for people.
fn levels(lods: &[Lod]) -> String {
    let names: Vec<String> = lods.iter().map(ToString::to_string).collect();
    match names.as_slice() {
        [] => "no level is stated".into(),
        names => format!("there is {}", names.join(", ")),
    }
}

fn warn(root: &CityObject, place: String, what: String, collector: &mut Collector) {
    collector.warn(Some(&root.id), Place::Pointer(place), what);
}
