//! Strict reading of JSON: objects are objects, lists have their length, whole numbers are whole,
//! and every refusal names the member at fault.

use std::fmt::{self, Write as _};
use std::marker::PhantomData;

use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, Error, IgnoredAny, MapAccess, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::error::Category;

use super::plain::plain;
use super::problem::{Kind, Problem};

/// Reads a document.
///
/// # Errors
/// [`Problem`] with JSON pointer, line and column.
pub fn read<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Problem> {
    if let Ok(document) = serde_json::from_slice(bytes) {
        return Ok(document);
    }
    // Keeping track of the path costs time, so it is done only for what is refused.
    Err(explain::<T>(bytes))
}

fn explain<T: DeserializeOwned>(bytes: &[u8]) -> Problem {
    let mut source = serde_json::Deserializer::from_slice(bytes);
    let (pointer, member, error) = match serde_path_to_error::deserialize::<_, T>(&mut source) {
        Err(error) => {
            let path = error.path();
            (pointer(path), dotted(path), error.into_inner())
        }
        Ok(_) => match source.end() {
            Err(error) => (String::new(), String::new(), error),
            Ok(()) => return Problem::new(Kind::Internal, "a body was refused, then read"),
        },
    };
    // Taken off the end only: what was sent may hold these words too.
    let place = format!(" at line {} column {}", error.line(), error.column());
    let text = error.to_string();
    let detail = text.strip_suffix(&place).unwrap_or(&text);
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Problem::new(Kind::MalformedJson, "the body is empty: send a JSON object").at("");
    }
    let out_of_range = detail == "number out of range";
    let kind = match error.classify() {
        Category::Data => Kind::InvalidRequest,
        _ if out_of_range => Kind::InvalidRequest,
        _ => Kind::MalformedJson,
    };
    // Of these the path names the object that should have the member once.
    let unnamed = ["missing field `", "duplicate field `"]
        .iter()
        .find_map(|prefix| detail.strip_prefix(prefix));
    let pointer = match unnamed {
        Some(rest) => format!("{pointer}/{}", rest.trim_end_matches('`')),
        None => pointer,
    };
    Problem::new(kind, plain(detail, &member))
        .at(pointer)
        .on_line(error.line(), error.column())
}

fn pointer(path: &serde_path_to_error::Path) -> String {
    use serde_path_to_error::Segment;
    let mut pointer = String::new();
    for segment in path {
        pointer.push('/');
        match segment {
            Segment::Seq { index } => pointer.push_str(&index.to_string()),
            Segment::Map { key } => pointer.push_str(&token(key)),
            Segment::Enum { variant } => pointer.push_str(&token(variant)),
            Segment::Unknown => pointer.push('?'),
        }
    }
    // Where the path breaks off before a member was named.
    pointer.trim_end_matches("/?").to_owned()
}

/// The same for people: `camera.eye[1]`.
fn dotted(path: &serde_path_to_error::Path) -> String {
    use serde_path_to_error::Segment;
    let mut dotted = String::new();
    for segment in path {
        match segment {
            Segment::Seq { index } => {
                let _ = write!(dotted, "[{index}]");
            }
            Segment::Map { key: name } | Segment::Enum { variant: name } => {
                if !dotted.is_empty() {
                    dotted.push('.');
                }
                dotted.push_str(name);
            }
            Segment::Unknown => {}
        }
    }
    dotted
}

/// A member name as it stands in a JSON pointer (RFC 6901, section 3).
pub fn token(name: &str) -> String {
    name.replace('~', "~0").replace('/', "~1")
}

/// A `T` from an object only; derived structs would take a list for one too.
///
/// # Errors
/// Those of the deserializer.
pub fn object<'de, D: Deserializer<'de>, T: Deserialize<'de>>(source: D) -> Result<T, D::Error> {
    struct Object<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for Object<T> {
        type Value = T;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("an object")
        }
        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
            T::deserialize(MapAccessDeserializer::new(map))
        }
    }
    source.deserialize_map(Object(PhantomData))
}

/// A member that may be left out but not be null.
///
/// # Errors
/// Those of the deserializer.
pub fn given<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    source: D,
) -> Result<Option<T>, D::Error> {
    T::deserialize(source).map(Some)
}

/// Exactly `N` things.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct List<T, const N: usize>(pub [T; N]);

impl<'de, T: Deserialize<'de> + Copy + Default, const N: usize> Deserialize<'de> for List<T, N> {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Items<T, const N: usize>(PhantomData<T>);
        impl<'de, T: Deserialize<'de> + Copy + Default, const N: usize> Visitor<'de> for Items<T, N> {
            type Value = List<T, N>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a list of {N} numbers")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut items = [T::default(); N];
                for (at, item) in items.iter_mut().enumerate() {
                    match seq.next_element()? {
                        Some(value) => *item = value,
                        None => return Err(A::Error::invalid_length(at, &self)),
                    }
                }
                let mut length = N;
                while seq.next_element::<IgnoredAny>()?.is_some() {
                    length += 1;
                }
                if length > N {
                    return Err(A::Error::invalid_length(length, &self));
                }
                Ok(List(items))
            }
        }
        source.deserialize_seq(Items(PhantomData))
    }
}

/// A whole number of 32 bits; `2.0` is one, as JSON Schema has it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Whole(pub u32);

impl Whole {
    /// The number, if it is whole and fits.
    pub fn new(number: f64) -> Option<Self> {
        (number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number))
            .then_some(Self(number as u32))
    }
}

impl<'de> Deserialize<'de> for Whole {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        let number = f64::deserialize(source)?;
        Self::new(number).ok_or_else(|| {
            let expected = "a whole number from 0 to 4294967295";
            D::Error::invalid_value(Unexpected::Float(number), &expected)
        })
    }
}

/// One of a few words.
///
/// # Errors
/// Those of the deserializer.
pub fn keyword<'de, D: Deserializer<'de>, T: Copy>(
    source: D,
    names: &'static [&'static str],
    values: &[T],
) -> Result<T, D::Error> {
    struct Keyword<'a, T>(&'static [&'static str], &'a [T]);
    impl<T: Copy> Visitor<'_> for Keyword<'_, T> {
        type Value = T;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "one of {}", self.0.join(", "))
        }
        fn visit_str<E: Error>(self, word: &str) -> Result<T, E> {
            let at = self.0.iter().position(|&name| name == word);
            at.and_then(|at| self.1.get(at).copied())
                .ok_or_else(|| E::unknown_variant(word, self.0))
        }
    }
    source.deserialize_str(Keyword(names, values))
}

impl<T: Copy + Default, const N: usize> Default for List<T, N> {
    fn default() -> Self {
        Self([T::default(); N])
    }
}
