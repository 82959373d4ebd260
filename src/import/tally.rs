//! What became of objects that are not in the scene as they should be, counted by the reason.

/// What became of an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// It is not in the scene.
    LeftOut,
    /// It is there, but of no height.
    KeptFlat,
}

/// So many came to the same for the same reason, over all files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tally {
    /// How many.
    pub count: u64,
    /// What their format calls one of them: `feature`, `object`, `instance`.
    pub noun: &'static str,
    /// What became of them.
    pub fate: Fate,
    /// Why, in a few words.
    pub reason: &'static str,
}

/// All that were counted, in the order in which the reasons came up.
#[derive(Debug, Default)]
pub(super) struct Tallies(pub(super) Vec<Tally>);

impl Tallies {
    /// One more.
    pub(super) fn count(&mut self, noun: &'static str, fate: Fate, reason: &'static str) {
        let same = |t: &&mut Tally| t.noun == noun && t.fate == fate && t.reason == reason;
        match self.0.iter_mut().find(same) {
            Some(tally) => tally.count += 1,
            None => self.0.push(Tally {
                count: 1,
                noun,
                fate,
                reason,
            }),
        }
    }
}
