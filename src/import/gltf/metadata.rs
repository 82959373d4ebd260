//! `EXT_structural_metadata`: what the file says of each feature.

use std::collections::BTreeMap;

use compact_str::CompactString;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::value::{RawValue, to_raw_value};
use serde_json::{Map, Value};

use super::accessor::Reader;
use super::column::Column;
use super::container::escaped;
use crate::import::collector::Collector;
use crate::import::{ImportError, Place};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct StructuralMetadata {
    schema: Option<Schema>,
    schema_uri: Option<IgnoredAny>,
    #[serde(default)]
    property_tables: Vec<PropertyTable>,
}

#[derive(Deserialize)]
pub(super) struct Schema {
    #[serde(default)]
    classes: BTreeMap<String, Class>,
    #[serde(default)]
    pub(super) enums: BTreeMap<String, Enumeration>,
}

#[derive(Deserialize)]
struct Class {
    #[serde(default)]
    properties: BTreeMap<String, Property>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Property {
    #[serde(rename = "type")]
    pub(super) kind: CompactString,
    pub(super) component_type: Option<CompactString>,
    pub(super) enum_type: Option<CompactString>,
    #[serde(default)]
    pub(super) array: bool,
    pub(super) count: Option<usize>,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) offset: Option<Value>,
    pub(super) scale: Option<Value>,
    pub(super) no_data: Option<Value>,
    pub(super) default: Option<Value>,
    semantic: Option<CompactString>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Enumeration {
    #[serde(default = "uint16")]
    pub(super) value_type: CompactString,
    pub(super) values: Vec<EnumerationValue>,
}

#[derive(Deserialize)]
pub(super) struct EnumerationValue {
    pub(super) name: CompactString,
    pub(super) value: i64,
}

fn uint16() -> CompactString {
    CompactString::const_new("UINT16")
}

#[derive(Deserialize)]
struct PropertyTable {
    class: CompactString,
    count: usize,
    #[serde(default)]
    properties: BTreeMap<String, TableProperty>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TableProperty {
    pub(super) values: usize,
    pub(super) string_offsets: Option<usize>,
    #[serde(default = "uint32")]
    pub(super) string_offset_type: CompactString,
    pub(super) offset: Option<Value>,
    pub(super) scale: Option<Value>,
}

fn uint32() -> CompactString {
    CompactString::const_new("UINT32")
}

/// What a table says of one feature.
#[derive(Default)]
pub(super) struct Row {
    pub(super) id: Option<CompactString>,
    pub(super) class: Option<CompactString>,
    pub(super) attributes: Option<Box<RawValue>>,
}

/// The tables of one file, opened when first asked for.
#[derive(Default)]
pub(super) struct Tables<'a> {
    open: BTreeMap<usize, Option<Table<'a>>>,
}

struct Table<'a> {
    count: usize,
    columns: Vec<(&'a str, Column<'a>)>,
    id: Option<usize>,
    class: Option<usize>,
}

/// Names of a column that identifies a feature, the surest first, in lower case.
const ID_NAMES: [&str; 12] = [
    "id",
    "gmlid",
    "gml_id",
    "gml:id",
    "identificatie",
    "identifier",
    "uuid",
    "guid",
    "globalid",
    "objectid",
    "building_id",
    "name",
];
const CLASS_NAMES: [&str; 2] = ["class", "type"];

impl<'a> Tables<'a> {
    /// What table `table` says of feature `feature`; `None` where it says nothing.
    pub(super) fn row(
        &mut self,
        reader: &Reader<'a>,
        (table, feature): (usize, u64),
        collector: &mut Collector,
    ) -> Result<Option<Row>, ImportError> {
        let table = match self.open.entry(table) {
            std::collections::btree_map::Entry::Occupied(entry) => entry.into_mut(),
            std::collections::btree_map::Entry::Vacant(entry) => {
                let opened = Table::open(reader, table, collector)?;
                entry.insert(opened)
            }
        };
        let row = usize::try_from(feature).ok();
        Ok(table
            .as_ref()
            .zip(row)
            .and_then(|(table, row)| table.row(row)))
    }
}

impl<'a> Table<'a> {
    fn open(
        reader: &Reader<'a>,
        index: usize,
        collector: &mut Collector,
    ) -> Result<Option<Self>, ImportError> {
        const EXTENSION: &str = "/extensions/EXT_structural_metadata";
        let place = format!("{EXTENSION}/propertyTables/{index}");
        let metadata = reader.document.extensions.metadata.as_ref();
        let tables = metadata.map_or(&[][..], |m| &m.property_tables);
        let Some(table) = tables.get(index) else {
            let count = tables.len();
            return reader.fail(
                place,
                format!("there is no such table; the file has {count}"),
            );
        };
        let Some(schema) = metadata.and_then(|m| m.schema.as_ref()) else {
            if metadata.is_some_and(|m| m.schema_uri.is_some()) {
                let place = Place::Pointer(format!("{EXTENSION}/schemaUri"));
                let what = "a schema outside the file is not read; features have no attributes";
                collector.warn(None, place, what);
            }
            return Ok(None);
        };
        let Some(class) = schema.classes.get(table.class.as_str()) else {
            let reason = format!("the schema has no class {:?}", table.class);
            return reader.fail(format!("{place}/class"), reason);
        };
        let mut columns = Vec::new();
        for (name, stored) in &table.properties {
            let place = format!("{place}/properties/{}", escaped(name));
            let Some(property) = class.properties.get(name) else {
                return reader.fail(place, "the class has no such property");
            };
            let column = Column::open(reader, schema, property, stored, table.count, &place)?;
            if let Some(column) = column {
                columns.push((name.as_str(), column));
                continue;
            }
            let kind = described(property);
            let what = format!("a property of type {kind} is not read; features lack it");
            collector.warn(None, Place::Pointer(place), what);
        }
        Ok(Some(Self {
            count: table.count,
            id: id_column(&columns, class),
            class: named(&columns, &CLASS_NAMES),
            columns,
        }))
    }

    fn row(&self, row: usize) -> Option<Row> {
        if row >= self.count {
            return None;
        }
        let mut attributes = Map::new();
        for (name, column) in &self.columns {
            if let Some(value) = column.value(row) {
                attributes.insert((*name).to_owned(), value);
            }
        }
        let text = |column: Option<usize>| {
            let (name, _) = self.columns[column?];
            let text = attributes.get(name)?.as_str()?;
            (!text.is_empty()).then(|| CompactString::from(text))
        };
        Some(Row {
            id: text(self.id),
            class: text(self.class),
            attributes: to_raw_value(&attributes).ok(),
        })
    }
}

/// The column that its meaning or its name says is the identifier.
fn id_column(columns: &[(&str, Column)], class: &Class) -> Option<usize> {
    let means_id = |(name, column): &(&str, Column)| {
        let property = class.properties.get(*name);
        let semantic = property.and_then(|p| p.semantic.as_deref());
        column.is_text() && semantic == Some("ID")
    };
    let by_meaning = columns.iter().position(means_id);
    by_meaning.or_else(|| named(columns, &ID_NAMES))
}

fn named(columns: &[(&str, Column)], names: &[&str]) -> Option<usize> {
    let find = |wanted: &&str| {
        let mut columns = columns.iter();
        columns.position(|(name, column)| column.is_text() && name.eq_ignore_ascii_case(wanted))
    };
    names.iter().find_map(find)
}

fn described(property: &Property) -> String {
    let array = if property.array { "array of " } else { "" };
    match &property.component_type {
        Some(component) => format!("{array}{} {component}", property.kind),
        None => format!("{array}{}", property.kind),
    }
}
