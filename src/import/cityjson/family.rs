use std::borrow::Cow;
use std::collections::HashMap;

use serde::Deserialize;
use serde_json::value::RawValue;

use super::boundaries::Geometry;
use super::document::Entries;
use crate::import::Place;
use crate::import::collector::Collector;
use crate::import::json::{pointer, reason};

/// An entry of `CityObjects`.
#[derive(Default)]
pub(super) struct CityObject<'a> {
    pub(super) id: Cow<'a, str>,
    pub(super) class: Option<Cow<'a, str>>,
    pub(super) attributes: Option<&'a RawValue>,
    /// Each, or why it cannot be read.
    pub(super) geometry: Vec<Result<Geometry<'a>, String>>,
    parents: Vec<Cow<'a, str>>,
    children: Vec<Cow<'a, str>>,
}

/// The same as it is written, with its geometries read or still text.
#[derive(Deserialize)]
struct Entry<'a, G> {
    #[serde(rename = "type", borrow)]
    class: Option<Cow<'a, str>>,
    #[serde(borrow)]
    attributes: Option<&'a RawValue>,
    geometry: Option<Vec<G>>,
    #[serde(borrow)]
    parents: Option<Vec<Cow<'a, str>>>,
    #[serde(borrow)]
    children: Option<Vec<Cow<'a, str>>>,
}

impl<'a, G> Entry<'a, G> {
    fn object(
        self,
        id: Cow<'a, str>,
        read: impl FnMut(G) -> Result<Geometry<'a>, String>,
    ) -> CityObject<'a> {
        CityObject {
            id,
            class: self.class,
            attributes: self.attributes,
            geometry: self.geometry.into_iter().flatten().map(read).collect(),
            parents: self.parents.unwrap_or_default(),
            children: self.children.unwrap_or_default(),
        }
    }
}

const GROUP: &str = "CityObjectGroup";

impl CityObject<'_> {
    pub(super) fn is_group(&self) -> bool {
        self.class.as_deref() == Some(GROUP)
    }

    pub(super) fn pointer(&self) -> String {
        pointer("/CityObjects", &self.id)
    }

    /// How many city objects it names as its children.
    pub(super) fn children(&self) -> usize {
        self.children.len()
    }
}

/// The city objects of a document and the top-most one that each belongs to.
pub(super) struct Family<'a> {
    objects: Vec<CityObject<'a>>,
    /// (top-most object, object), sorted: so in document order of the top-most ones.
    members: Vec<(u32, u32)>,
}

impl<'a> Family<'a> {
    pub(super) fn of(entries: &Entries<'a>, collector: &mut Collector) -> Self {
        let objects: Vec<CityObject> = entries
            .0
            .iter()
            .map(|(id, value)| city_object(id.clone(), value, collector))
            .collect();
        let mut parents = parents(&objects, collector);
        break_cycles(&objects, &mut parents, collector);
        let members = members(&parents);
        Self { objects, members }
    }

    /// Each top-most object with all that belong to it, itself included.
    pub(super) fn groups(
        &self,
    ) -> impl Iterator<Item = (&CityObject<'a>, impl Iterator<Item = &CityObject<'a>>)> {
        self.members.chunk_by(|(a, _), (b, _)| a == b).map(|group| {
            let members = group.iter().map(|&(_, member)| self.at(member));
            (self.at(group[0].0), members)
        })
    }

    fn at(&self, index: u32) -> &CityObject<'a> {
        &self.objects[index as usize]
    }
}

fn city_object<'a>(
    id: Cow<'a, str>,
    value: &'a RawValue,
    collector: &mut Collector,
) -> CityObject<'a> {
    if let Ok(entry) = serde_json::from_str::<Entry<Geometry>>(value.get()) {
        return entry.object(id, Ok);
    }
    // Something in it is wrong: one by one, so that the other geometries are kept.
    match serde_json::from_str::<Entry<&RawValue>>(value.get()) {
        Ok(entry) => entry.object(id, |geometry| {
            serde_json::from_str(geometry.get()).map_err(|error| reason(&error))
        }),
        Err(error) => {
            collector.warn(
                Some(&id),
                Place::Pointer(pointer("/CityObjects", &id)),
                format!("{}; nothing of it can be read", reason(&error)),
            );
            CityObject {
                id,
                ..CityObject::default()
            }
        }
    }
}

/// The index of each object's parent: by its own `parents`, else by the other's `children`.
fn parents(objects: &[CityObject], collector: &mut Collector) -> Vec<Option<u32>> {
    let mut of = vec![None; objects.len()];
    if objects
        .iter()
        .all(|o| o.parents.is_empty() && o.children.is_empty())
    {
        return of;
    }
    let mut by_id = HashMap::with_capacity(objects.len());
    for (index, object) in objects.iter().enumerate() {
        by_id.entry(object.id.as_ref()).or_insert(index);
    }
    for (index, object) in objects.iter().enumerate() {
        let mut missing = None;
        for id in &object.parents {
            match by_id.get(id.as_ref()) {
                Some(&parent) if objects[parent].is_group() => {}
                Some(&parent) => of[index] = of[index].or(Some(parent as u32)),
                None => missing = missing.or(Some(id)),
            }
        }
        if let Some(id) = missing.filter(|_| of[index].is_none()) {
            collector.warn(
                Some(&object.id),
                Place::Pointer(object.pointer() + "/parents"),
                format!("its parent {id:?} is missing; kept as an object of its own"),
            );
        }
    }
    for (index, object) in objects.iter().enumerate().filter(|(_, o)| !o.is_group()) {
        for id in &object.children {
            if let Some(&child) = by_id.get(id.as_ref()).filter(|&&child| child != index) {
                of[child] = of[child].or(Some(index as u32));
            }
        }
    }
    of
}

/// Makes each member of a cycle a top-most object.
fn break_cycles(objects: &[CityObject], parents: &mut [Option<u32>], collector: &mut Collector) {
    // The walk that an object was last met on; 0 for none.
    let mut met = vec![0_u32; parents.len()];
    for start in 0..parents.len() {
        let walk = start as u32 + 1;
        let mut at = start;
        while met[at] == 0 {
            met[at] = walk;
            match parents[at] {
                Some(parent) => at = parent as usize,
                None => break,
            }
        }
        if met[at] != walk {
            continue;
        }
        while let Some(parent) = parents[at].take() {
            collector.warn(
                Some(&objects[at].id),
                Place::Pointer(objects[at].pointer() + "/parents"),
                "it is its own ancestor; kept as an object of its own",
            );
            at = parent as usize;
        }
    }
}

fn members(parents: &[Option<u32>]) -> Vec<(u32, u32)> {
    let mut top: Vec<Option<u32>> = vec![None; parents.len()];
    let mut path = Vec::new();
    let mut members = Vec::with_capacity(parents.len());
    for index in 0..parents.len() as u32 {
        let mut at = index;
        let root = loop {
            if let Some(root) = top[at as usize] {
                break root;
            }
            path.push(at);
            match parents[at as usize] {
                Some(parent) => at = parent,
                None => break at,
            }
        };
        for at in path.drain(..) {
            top[at as usize] = Some(root);
        }
        members.push((root, index));
    }
    members.sort_unstable();
    members
}
