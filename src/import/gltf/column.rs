//! One property of a property table, in its binary form.
//!
//! Source: OGC 3D Tiles 1.1, 3D Metadata Specification, "Binary Table Format".

use std::collections::BTreeMap;

use serde_json::Value;

use super::accessor::Reader;
use super::metadata::{Property, Schema, TableProperty};
use crate::import::ImportError;

/// The values of one property, checked so that each can be read.
pub(super) struct Column<'a> {
    bytes: &'a [u8],
    layout: Layout<'a>,
    property: &'a Property,
    scale: Option<f64>,
    offset: Option<f64>,
}

enum Layout<'a> {
    /// String `i` is `bytes[ends[i]..ends[i + 1]]`.
    Text {
        offsets: &'a [u8],
        kind: Number,
    },
    /// Bits, lowest first, so many a feature.
    Booleans {
        lanes: usize,
    },
    Numbers {
        kind: Number,
        lanes: usize,
    },
    Names {
        kind: Number,
        names: BTreeMap<i64, &'a str>,
    },
}

#[derive(Clone, Copy)]
enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Number {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "INT8" => Self::I8,
            "UINT8" => Self::U8,
            "INT16" => Self::I16,
            "UINT16" => Self::U16,
            "INT32" => Self::I32,
            "UINT32" => Self::U32,
            "INT64" => Self::I64,
            "UINT64" => Self::U64,
            "FLOAT32" => Self::F32,
            "FLOAT64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// What a normalized integer is divided by.
    fn largest(self) -> Option<f64> {
        Some(match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::I64 => i64::MAX as f64,
            Self::U64 => u64::MAX as f64,
            Self::F32 | Self::F64 => return None,
        })
    }

    /// The number at `index`; `None` past the end.
    fn at(self, bytes: &[u8], index: usize) -> Option<Value> {
        fn first<const N: usize>(bytes: &[u8]) -> Option<[u8; N]> {
            bytes.first_chunk().copied()
        }
        let bytes = bytes.get(index.checked_mul(self.size())?..)?;
        Some(match self {
            Self::I8 => i8::from_le_bytes(first(bytes)?).into(),
            Self::U8 => u8::from_le_bytes(first(bytes)?).into(),
            Self::I16 => i16::from_le_bytes(first(bytes)?).into(),
            Self::U16 => u16::from_le_bytes(first(bytes)?).into(),
            Self::I32 => i32::from_le_bytes(first(bytes)?).into(),
            Self::U32 => u32::from_le_bytes(first(bytes)?).into(),
            Self::I64 => i64::from_le_bytes(first(bytes)?).into(),
            Self::U64 => u64::from_le_bytes(first(bytes)?).into(),
            Self::F32 => f64::from(f32::from_le_bytes(first(bytes)?)).into(),
            Self::F64 => f64::from_le_bytes(first(bytes)?).into(),
        })
    }
}

impl<'a> Column<'a> {
    /// `None` for a kind of property that is not read, or whose bytes are missing.
    pub(super) fn open(
        reader: &Reader<'a>,
        schema: &'a Schema,
        property: &'a Property,
        stored: &'a TableProperty,
        rows: usize,
        place: &str,
    ) -> Result<Option<Self>, ImportError> {
        let view = |view: usize, field: &str| {
            let asked_by = format!("{place}/{field}");
            let (document, path) = (reader.document, reader.path);
            reader.buffers.view(document, view, &asked_by, path)
        };
        let Some(bytes) = view(stored.values, "values")? else {
            return Ok(None);
        };
        let layout = if property.kind == "STRING" {
            let Some(offsets) = stored.string_offsets else {
                return reader.fail(place, "strings without stringOffsets");
            };
            let kind = Number::named(&stored.string_offset_type);
            match (view(offsets, "stringOffsets")?, kind) {
                (Some(offsets), Some(kind)) if !property.array => Layout::Text { offsets, kind },
                _ => return Ok(None),
            }
        } else {
            match layout(schema, property) {
                Some(layout) => layout,
                None => return Ok(None),
            }
        };
        if !layout.fits(bytes, rows) {
            let reason = format!(
                "{rows} values do not fit into the {} bytes of the buffer view",
                bytes.len()
            );
            return reader.fail(format!("{place}/values"), reason);
        }
        let scale = stored.scale.as_ref().or(property.scale.as_ref());
        let offset = stored.offset.as_ref().or(property.offset.as_ref());
        if [scale, offset]
            .into_iter()
            .flatten()
            .any(|v| !v.is_number())
        {
            return Ok(None);
        }
        Ok(Some(Self {
            bytes,
            layout,
            property,
            scale: scale.and_then(Value::as_f64),
            offset: offset.and_then(Value::as_f64),
        }))
    }

    /// Whether its values are strings.
    pub(super) fn is_text(&self) -> bool {
        matches!(self.layout, Layout::Text { .. } | Layout::Names { .. })
    }

    /// The value of a row; `None` where there is none.
    pub(super) fn value(&self, row: usize) -> Option<Value> {
        let stored = self.stored(row);
        let missing = match (&stored, &self.property.no_data) {
            (None, _) => true,
            (Some(value), Some(no_data)) => is_same(value, no_data),
            (Some(_), None) => false,
        };
        if missing {
            return self.property.default.clone();
        }
        stored.map(|value| self.transformed(value))
    }

    fn stored(&self, row: usize) -> Option<Value> {
        match &self.layout {
            Layout::Text { offsets, kind } => {
                let (start, end) = span(*kind, offsets, row)?;
                let text = String::from_utf8_lossy(self.bytes.get(start..end)?);
                Some(Value::from(text))
            }
            Layout::Booleans { lanes } => {
                let bit = |i: usize| Some(self.bytes.get(i / 8)? >> (i % 8) & 1 == 1);
                self.lanes(*lanes, |lane| Some(bit(row * lanes + lane)?.into()))
            }
            Layout::Numbers { kind, lanes } => {
                self.lanes(*lanes, |lane| kind.at(self.bytes, row * lanes + lane))
            }
            Layout::Names { kind, names } => {
                let value = kind.at(self.bytes, row)?.as_i64()?;
                names.get(&value).map(|name| Value::from(*name))
            }
        }
    }

    /// A single value, or an array of them.
    fn lanes(&self, lanes: usize, value: impl Fn(usize) -> Option<Value>) -> Option<Value> {
        if lanes == 1 && !self.property.array {
            return value(0);
        }
        (0..lanes)
            .map(value)
            .collect::<Option<Vec<_>>>()
            .map(Value::from)
    }

    /// Normalized, scaled and offset, as the property says.
    fn transformed(&self, value: Value) -> Value {
        let Layout::Numbers { kind, .. } = self.layout else {
            return value;
        };
        let largest = kind.largest().filter(|_| self.property.normalized);
        if largest.is_none() && self.scale.is_none() && self.offset.is_none() {
            return value;
        }
        match value {
            Value::Array(values) => values.into_iter().map(|v| self.transformed(v)).collect(),
            value => {
                let number = value.as_f64().unwrap_or_default();
                let number = largest.map_or(number, |largest| (number / largest).max(-1.0));
                (number * self.scale.unwrap_or(1.0) + self.offset.unwrap_or(0.0)).into()
            }
        }
    }
}

impl Layout<'_> {
    /// Whether the values of all rows lie within `bytes`.
    fn fits(&self, bytes: &[u8], rows: usize) -> bool {
        let numbers = |kind: Number, lanes: usize| {
            let needed = rows.checked_mul(lanes)?.checked_mul(kind.size())?;
            Some(needed <= bytes.len())
        };
        match self {
            // Offsets that only grow keep all strings together no longer than the bytes.
            Self::Text { offsets, kind } => {
                let is_stored = (offsets.len() / kind.size()).checked_sub(1) >= Some(rows);
                let fits = |row| span(*kind, offsets, row).is_some_and(|s| s.1 <= bytes.len());
                Some(is_stored && (0..rows).all(fits))
            }
            Self::Booleans { lanes } => rows
                .checked_mul(*lanes)
                .map(|bits| bits.div_ceil(8) <= bytes.len()),
            Self::Numbers { kind, lanes } => numbers(*kind, *lanes),
            Self::Names { kind, .. } => numbers(*kind, 1),
        }
        .unwrap_or(false)
    }
}

/// Start and end of string `row`, in order.
fn span(kind: Number, offsets: &[u8], row: usize) -> Option<(usize, usize)> {
    let offset = |i| usize::try_from(kind.at(offsets, i)?.as_u64()?).ok();
    let (start, end) = (offset(row)?, offset(row + 1)?);
    (start <= end).then_some((start, end))
}

fn layout<'a>(schema: &'a Schema, property: &'a Property) -> Option<Layout<'a>> {
    let lanes = match property.kind.as_str() {
        "SCALAR" | "BOOLEAN" | "ENUM" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" | "MAT2" => 4,
        "MAT3" => 9,
        "MAT4" => 16,
        _ => return None,
    };
    let lanes = match (property.array, property.count) {
        (false, _) => lanes,
        (true, Some(count)) => count.checked_mul(lanes).filter(|lanes| *lanes > 0)?,
        (true, None) => return None,
    };
    match property.kind.as_str() {
        "BOOLEAN" => Some(Layout::Booleans { lanes }),
        "ENUM" if !property.array => {
            let enumeration = schema.enums.get(property.enum_type.as_deref()?)?;
            let values = enumeration.values.iter();
            Some(Layout::Names {
                kind: Number::named(&enumeration.value_type)?,
                names: values.map(|v| (v.value, v.name.as_str())).collect(),
            })
        }
        "ENUM" => None,
        _ => Some(Layout::Numbers {
            kind: Number::named(property.component_type.as_deref()?)?,
            lanes,
        }),
    }
}

/// Equal, whether written as `0` or as `0.0`.
fn is_same(a: &Value, b: &Value) -> bool {
    a == b || matches!((a.as_f64(), b.as_f64()), (Some(a), Some(b)) if a == b)
}
