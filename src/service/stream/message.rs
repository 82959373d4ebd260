//! What the client says: members of a request, each of which holds until it is said anew, and how
//! the last frame went.

use serde::{Deserialize, Deserializer};

use super::super::json::{self, Whole, object};
use super::super::problem::Problem;
use super::super::visible::request::{Camera, Effects, Lod};
use super::feedback::Feedback;

/// One message.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Message {
    /// Comes back with the answer.
    pub seq: Whole,
    /// Where it is seen from.
    #[serde(default, deserialize_with = "given_object")]
    pub camera: Option<Camera>,
    /// The knobs.
    #[serde(default, deserialize_with = "given_object")]
    pub lod: Option<Lod>,
    /// What is asked of the effects.
    #[serde(default, deserialize_with = "json::given")]
    pub effects: Option<Effects>,
    /// Whether each answer is to tell what it took.
    #[serde(default, deserialize_with = "json::given")]
    pub stats: Option<bool>,
    /// Of the last frame; holds for this message alone.
    #[serde(default, deserialize_with = "given_object")]
    pub feedback: Option<Feedback>,
}

fn given_object<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    source: D,
) -> Result<Option<T>, D::Error> {
    object(source).map(Some)
}

/// A message as a JSON object.
struct Body(Message);

impl<'de> Deserialize<'de> for Body {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        object(source).map(Self)
    }
}

/// Reads a message.
///
/// # Errors
/// What is wrong with it, and its `seq` where it has one.
pub fn read(text: &str) -> Result<Message, (Option<u32>, Problem)> {
    #[derive(Deserialize)]
    struct Numbered {
        seq: Whole,
    }
    let Body(message) = json::read(text.as_bytes()).map_err(|problem| {
        let numbered: Option<Numbered> = serde_json::from_str(text).ok();
        (numbered.map(|numbered| numbered.seq.0), problem)
    })?;
    Ok(message)
}
