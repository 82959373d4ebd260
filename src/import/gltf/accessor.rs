//! Typed views of buffers, checked once when made so that reading cannot fail.

use std::path::Path;

use super::buffers::Buffers;
use super::document::{Accessor, Document, Sparse};
use crate::import::{ImportError, Place};

/// An accessor without bytes is all zeros, whatever its count: more than this is refused.
const MAX_ZEROS: usize = 1 << 24;

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The largest value: what a normalized integer is divided by.
    fn largest(self) -> f64 {
        match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::F32 => 1.0,
        }
    }

    fn is_index(self) -> bool {
        matches!(self, Self::U8 | Self::U16 | Self::U32)
    }
}

/// Elements of one kind at equal distances.
#[derive(Clone, Copy)]
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: Component,
}

impl Elements<'_> {
    /// 0 past the end, which the checks in [`Reader`] exclude.
    #[inline]
    fn value(&self, element: usize, lane: usize) -> f64 {
        fn first<const N: usize>(bytes: &[u8]) -> [u8; N] {
            bytes.first_chunk().copied().unwrap_or([0; N])
        }
        let at = element * self.stride + lane * self.component.size();
        let Some(bytes) = self.bytes.get(at..) else {
            return 0.0;
        };
        match self.component {
            Component::I8 => f64::from(i8::from_le_bytes(first(bytes))),
            Component::U8 => f64::from(u8::from_le_bytes(first(bytes))),
            Component::I16 => f64::from(i16::from_le_bytes(first(bytes))),
            Component::U16 => f64::from(u16::from_le_bytes(first(bytes))),
            Component::U32 => f64::from(u32::from_le_bytes(first(bytes))),
            Component::F32 => f64::from(f32::from_le_bytes(first(bytes))),
        }
    }
}

/// What an accessor stands for.
pub(super) struct Values<'a> {
    pub(super) count: usize,
    /// `None`: zeros.
    base: Option<Elements<'a>>,
    /// Replaced elements: (element, position in the replacement), by element.
    replaced: Vec<(usize, usize)>,
    replacement: Option<Elements<'a>>,
    /// 1 unless normalized.
    divisor: f64,
}

impl Values<'_> {
    /// One component of one element, normalized where the accessor says so.
    #[inline]
    pub(super) fn value(&self, element: usize, lane: usize) -> f64 {
        if !self.replaced.is_empty()
            && let Some(replacement) = self.replacement
            && let Ok(at) = self.replaced.binary_search_by_key(&element, |r| r.0)
        {
            return self.scaled(replacement.value(self.replaced[at].1, lane));
        }
        self.base
            .map_or(0.0, |base| self.scaled(base.value(element, lane)))
    }

    #[inline]
    fn scaled(&self, value: f64) -> f64 {
        if self.divisor == 1.0 {
            value
        } else {
            (value / self.divisor).max(-1.0)
        }
    }

    #[inline]
    pub(super) fn vector<const N: usize>(&self, element: usize) -> [f64; N] {
        std::array::from_fn(|lane| self.value(element, lane))
    }
}

/// The bytes, or the word of the file on what they span.
pub(super) enum Content<'a> {
    Values(Values<'a>),
    /// The bytes are missing or compressed.
    Missing,
}

/// Makes views of the accessors of one file.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a> {
    pub(super) document: &'a Document<'a>,
    pub(super) buffers: &'a Buffers<'a>,
    pub(super) path: &'a Path,
}

impl<'a> Reader<'a> {
    pub(super) fn fail<T>(
        &self,
        pointer: impl Into<String>,
        reason: impl Into<String>,
    ) -> Result<T, ImportError> {
        let place = Place::Pointer(pointer.into());
        Err(ImportError::malformed(self.path, place, reason))
    }

    /// The accessor `index`, which must be of `shape`; `asked_by` is where it is referred to.
    pub(super) fn accessor(
        &self,
        index: usize,
        shape: &str,
        asked_by: &dyn Fn() -> String,
    ) -> Result<&'a Accessor<'a>, ImportError> {
        let Some(accessor) = self.document.accessors.get(index) else {
            let count = self.document.accessors.len();
            let reason = format!("there is no accessor {index}; the file has {count}");
            return self.fail(asked_by(), reason);
        };
        if accessor.shape != shape {
            let reason = format!("is a {}; expected a {shape}", accessor.shape);
            return self.fail(format!("/accessors/{index}/type"), reason);
        }
        Ok(accessor)
    }

    pub(super) fn values(
        &self,
        index: usize,
        shape: &str,
        asked_by: &dyn Fn() -> String,
    ) -> Result<Content<'a>, ImportError> {
        let accessor = self.accessor(index, shape, asked_by)?;
        let at = |field: &str| format!("/accessors/{index}{field}");
        let component = self.component(accessor.component_type, &at("/componentType"))?;
        let lanes = lanes(shape);
        let base = match accessor.buffer_view {
            Some(view) => {
                let place = at("/bufferView");
                let Some(bytes) = self.buffers.view(self.document, view, &place, self.path)? else {
                    return Ok(Content::Missing);
                };
                let stride = self.stride(view, lanes * component.size())?;
                let span = (accessor.byte_offset, stride, lanes * component.size());
                Some(self.elements(bytes, span, component, accessor.count, &at("/count"))?)
            }
            None if accessor.count > MAX_ZEROS => {
                let reason = format!("{} elements without a buffer view", accessor.count);
                return self.fail(at("/count"), reason);
            }
            None => None,
        };
        let mut values = Values {
            count: accessor.count,
            base,
            replaced: Vec::new(),
            replacement: None,
            divisor: if accessor.normalized {
                component.largest()
            } else {
                1.0
            },
        };
        if let Some(sparse) = &accessor.sparse {
            let place = at("/sparse");
            if !self.replace(&mut values, sparse, component, lanes, &place)? {
                return Ok(Content::Missing);
            }
        }
        Ok(Content::Values(values))
    }

    /// Lays the sparse elements over `values`; `false` where their bytes are missing.
    fn replace(
        &self,
        values: &mut Values<'a>,
        sparse: &Sparse,
        component: Component,
        lanes: usize,
        place: &str,
    ) -> Result<bool, ImportError> {
        let count_place = format!("{place}/count");
        if sparse.count > values.count {
            let reason = format!("{} of {} elements", sparse.count, values.count);
            return self.fail(count_place, reason);
        }
        let indices_place = format!("{place}/indices");
        let index = self.component(sparse.indices.component_type, &indices_place)?;
        if !index.is_index() {
            return self.fail(indices_place, "an index is an unsigned integer");
        }
        let view = |view, field: &str| {
            let asked_by = format!("{place}/{field}/bufferView");
            self.buffers.view(self.document, view, &asked_by, self.path)
        };
        let (Some(index_bytes), Some(value_bytes)) = (
            view(sparse.indices.buffer_view, "indices")?,
            view(sparse.values.buffer_view, "values")?,
        ) else {
            return Ok(false);
        };
        let span = (sparse.indices.byte_offset, index.size(), index.size());
        let indices = self.elements(index_bytes, span, index, sparse.count, &count_place)?;
        let size = lanes * component.size();
        let span = (sparse.values.byte_offset, size, size);
        values.replacement =
            Some(self.elements(value_bytes, span, component, sparse.count, &count_place)?);
        values.replaced = (0..sparse.count)
            .map(|i| (indices.value(i, 0) as usize, i))
            .collect();
        values.replaced.sort_unstable();
        if values.replaced.last().is_some_and(|r| r.0 >= values.count) {
            let reason = format!("an index lies beyond the {} elements", values.count);
            return self.fail(indices_place, reason);
        }
        Ok(true)
    }

    fn component(&self, code: u32, place: &str) -> Result<Component, ImportError> {
        match Component::from_code(code) {
            Some(component) => Ok(component),
            None => self.fail(place, format!("{code} is not a component type of glTF 2.0")),
        }
    }

    fn stride(&self, view: usize, size: usize) -> Result<usize, ImportError> {
        match self.document.buffer_views[view].byte_stride {
            Some(stride) if stride < size => {
                let reason = format!("elements of {size} bytes do not fit into {stride}");
                self.fail(format!("/bufferViews/{view}/byteStride"), reason)
            }
            Some(stride) => Ok(stride),
            None => Ok(size),
        }
    }

    /// Checks that `count` elements of (offset, stride, size) lie within `bytes`.
    fn elements(
        &self,
        bytes: &'a [u8],
        (offset, stride, size): (usize, usize, usize),
        component: Component,
        count: usize,
        place: &str,
    ) -> Result<Elements<'a>, ImportError> {
        let end = match count.checked_sub(1) {
            None => Some(offset),
            Some(last) => last
                .checked_mul(stride)
                .and_then(|n| n.checked_add(offset)?.checked_add(size)),
        };
        let fits = end.is_some_and(|end| end <= bytes.len());
        if let Some(bytes) = bytes.get(offset..).filter(|_| fits) {
            return Ok(Elements {
                bytes,
                stride,
                component,
            });
        }
        let reason = format!(
            "{count} elements, {stride} bytes apart from byte {offset}, do not fit into the {} \
             bytes of the buffer view",
            bytes.len()
        );
        self.fail(place, reason)
    }

    /// An accessor of vertex or feature numbers.
    pub(super) fn is_index(&self, index: usize) -> bool {
        let accessor = self.document.accessors.get(index);
        accessor
            .and_then(|a| Component::from_code(a.component_type))
            .is_some_and(Component::is_index)
    }

    /// Why the bytes of an accessor cannot be read.
    pub(super) fn why_missing(&self, is_draco: bool, accessor: &Accessor) -> &'static str {
        let view = accessor.buffer_view;
        let view = view.and_then(|view| self.document.buffer_views.get(view));
        if is_draco {
            "its vertices are compressed (KHR_draco_mesh_compression)"
        } else if view.is_some_and(|view| view.extensions.meshopt.is_some()) {
            "its vertices are compressed (EXT_meshopt_compression)"
        } else {
            "its buffer is missing"
        }
    }

    /// What the file says the elements of a VEC3 span; `None` where it does not say.
    pub(super) fn range(&self, index: usize) -> Result<Option<[[f64; 3]; 2]>, ImportError> {
        let accessor = &self.document.accessors[index];
        let (Some(min), Some(max)) = (accessor.min, accessor.max) else {
            return Ok(None);
        };
        let divisor = match Component::from_code(accessor.component_type) {
            // The range is that of the stored integers.
            Some(component) if accessor.normalized => component.largest(),
            _ => 1.0,
        };
        let parse = |raw: &str, field: &str| match serde_json::from_str::<[f64; 3]>(raw) {
            Ok(corner) => Ok(corner
                .map(|value| (value / divisor).max(if divisor == 1.0 { f64::MIN } else { -1.0 }))),
            Err(error) => self.fail(format!("/accessors/{index}/{field}"), error.to_string()),
        };
        let (min, max) = (parse(min.get(), "min")?, parse(max.get(), "max")?);
        if min.iter().zip(&max).any(|(low, high)| low > high) {
            let reason = format!("the minimum {min:?} lies above the maximum {max:?}");
            return self.fail(format!("/accessors/{index}/min"), reason);
        }
        Ok(Some([min, max]))
    }
}

fn lanes(shape: &str) -> usize {
    match shape {
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 1,
    }
}
