use std::cmp::Ordering;
use std::fmt;

use serde_json::value::RawValue;

/// A level of detail: `2`, `2.2` or, in `CityJSON` 1.0, the numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Lod {
    /// The number, and the refinement behind the dot.
    Level(u32, Option<u32>),
    /// A name of another kind; below every level.
    Named(String),
}

impl fmt::Display for Lod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Level(level, None) => write!(f, "{level}"),
            Self::Level(level, Some(refinement)) => write!(f, "{level}.{refinement}"),
            Self::Named(name) => write!(f, "{name:?}"),
        }
    }
}

impl Lod {
    pub(super) fn parse(text: &str) -> Self {
        let (level, refinement) = match text.split_once('.') {
            Some((level, refinement)) => (level.parse(), Some(refinement.parse())),
            None => (text.parse(), None),
        };
        match (level, refinement.transpose()) {
            (Ok(level), Ok(refinement)) => Self::Level(level, refinement),
            _ => Self::Named(text.to_owned()),
        }
    }

    /// Of a geometry's `lod`; `None` where it has none.
    pub(super) fn of(value: Option<&RawValue>) -> Option<Self> {
        let text = value?.get();
        match serde_json::from_str::<String>(text) {
            Ok(name) => Some(Self::parse(&name)),
            Err(_) => Some(Self::parse(text)),
        }
    }

    /// How well this answers to what was asked for: not at all, as a refinement of it, or by name.
    fn answers(&self, asked: &Self) -> Answer {
        match (asked, self) {
            _ if asked == self => Answer::Exactly,
            (Self::Level(a, Some(0)), Self::Level(b, None)) if a == b => Answer::Exactly,
            (Self::Level(a, None), Self::Level(b, Some(_))) if a == b => Answer::Refined,
            _ => Answer::No,
        }
    }

    /// Which of the levels of one city object is taken; `None` where there is none to take.
    pub(super) fn choose<'a>(
        lods: impl Iterator<Item = &'a Self>,
        asked: Option<&Self>,
    ) -> Option<&'a Self> {
        let Some(asked) = asked else {
            return lods.max_by(|a, b| a.order(b));
        };
        lods.map(|lod| (lod.answers(asked), lod))
            .filter(|(answer, _)| *answer != Answer::No)
            .max_by(|(a, x), (b, y)| a.cmp(b).then_with(|| x.order(y)))
            .map(|(_, lod)| lod)
    }

    pub(super) fn order(&self, other: &Self) -> Ordering {
        match (self, other) {
            (Self::Level(a, x), Self::Level(b, y)) => (a, x).cmp(&(b, y)),
            (Self::Level(..), Self::Named(_)) => Ordering::Greater,
            (Self::Named(_), Self::Level(..)) => Ordering::Less,
            (Self::Named(a), Self::Named(b)) => a.cmp(b),
        }
    }
}

#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Answer {
    No,
    Refined,
    Exactly,
}

#[cfg(test)]
mod tests {
    use super::Lod;

    #[test]
    fn the_level_asked_for_or_the_highest() {
        for (levels, asked, expected) in [
            ("1.2 1.3 2.2", None, Some("2.2")),
            ("0 2 10", None, Some("10")),
            ("rough 0", None, Some("0")),
            ("1.2 1.3 2.2", Some("1.2"), Some("1.2")),
            ("1.2 1.3 2.2", Some("1"), Some("1.3")),
            ("1 1.3", Some("1"), Some("1")),
            ("1 1.3", Some("1.0"), Some("1")),
            ("1.2 2.2", Some("1.3"), None),
            ("1 2", Some("1.2"), None),
            ("1 rough", Some("rough"), Some("rough")),
            ("1 2", Some("3"), None),
            ("", None, None),
        ] {
            let levels: Vec<Lod> = levels.split_whitespace().map(Lod::parse).collect();
            let asked = asked.map(Lod::parse);
            let chosen = Lod::choose(levels.iter(), asked.as_ref());
            assert_eq!(
                chosen.cloned(),
                expected.map(Lod::parse),
                "{levels:?} {asked:?}"
            );
        }
    }
}
