//! What is said of a frame: everything in the first answer, then what is not as it was in the
//! answer before.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use super::super::problem::{Kind, Problem};
use super::super::visible::Tail;

/// An answer.
#[derive(Debug, Serialize)]
pub struct Answer<'a> {
    pub seq: u32,
    /// Where the client begins from the empty set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub revision: Option<&'a str>,
    pub count: u32,
    #[serde(serialize_with = "pairs")]
    pub add: &'a [Range<u32>],
    #[serde(serialize_with = "pairs")]
    pub remove: &'a [Range<u32>],
    #[serde(flatten)]
    pub news: News<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feedback: Option<Chosen>,
}

/// What the controller chose.
#[derive(Debug, Serialize)]
pub struct Chosen {
    pub far_dist_m: f64,
}

fn pairs<S: Serializer>(ranges: &[Range<u32>], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(ranges.iter().map(|range| [range.start, range.end]))
}

/// The answer as it is sent.
///
/// # Errors
/// 500; numbers and strings into memory: there is nothing to fail.
pub fn text(answer: &impl Serialize) -> Result<String, Problem> {
    serde_json::to_string(answer).map_err(|error| defect(&error))
}

fn defect(error: &serde_json::Error) -> Problem {
    Problem::new(Kind::Internal, error.to_string())
}

/// The members of an answer beside its objects, in full.
#[derive(Debug, Deserialize)]
pub struct Members {
    lod: Map<String, Value>,
    effects: Map<String, Value>,
    stats: Map<String, Value>,
}

/// Those that the client does not know.
#[derive(Debug, Serialize)]
pub struct News<'a> {
    lod: BTreeMap<&'a str, &'a Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    effects: Option<&'a Map<String, Value>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stats: Option<&'a Map<String, Value>>,
}

/// The bound belongs to the frame: every answer has it.
const ALWAYS: &str = "error_px";

/// What an effect took: never as before, and no reason to tell of it anew.
const TOOK: &str = "took_us";

/// Tells which others there are: where it changes, `lod` is said anew as a whole.
const MODE: &str = "mode";

impl Members {
    /// Those of a frame.
    ///
    /// # Errors
    /// As [`text`].
    pub fn of(tail: &Tail) -> Result<Self, Problem> {
        serde_json::to_value(tail)
            .and_then(serde_json::from_value)
            .map_err(|error| defect(&error))
    }

    /// What is new to a client that was told `before`, or nothing yet. `stats` never are as they
    /// were, and come with the first answer and where they are `wanted`.
    pub fn news(&self, before: Option<&Self>, wanted: bool) -> News<'_> {
        let same_mode = before.filter(|before| before.lod.get(MODE) == self.lod.get(MODE));
        let known = |name: &str, value: &Value| {
            name != ALWAYS && same_mode.is_some_and(|before| before.lod.get(name) == Some(value))
        };
        let lod = self.lod.iter().filter(|(name, value)| !known(name, value));
        News {
            lod: lod.map(|(name, value)| (name.as_str(), value)).collect(),
            effects: Some(&self.effects)
                .filter(|effects| before.is_none_or(|before| !same(&before.effects, effects))),
            stats: Some(&self.stats).filter(|_| wanted || before.is_none()),
        }
    }
}

/// Whether effects did the same, whatever they took.
fn same(before: &Map<String, Value>, now: &Map<String, Value>) -> bool {
    fn did(ran: &Value) -> impl Iterator<Item = (&String, &Value)> {
        let members = ran.as_object().into_iter().flatten();
        members.filter(|(name, _)| *name != TOOK)
    }
    before.len() == now.len()
        && before
            .iter()
            .all(|(effect, ran)| now.get(effect).is_some_and(|other| did(ran).eq(did(other))))
}
