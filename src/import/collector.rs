use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use compact_str::CompactString;

use super::extents::Extents;
use super::named_height::NamedHeight;
use super::tally::{Fate, Tallies};
use super::{Classes, ImportError, Imported, Options, Place, Source, crs, sense};
use crate::scene::{Renamed, Scene, SceneObject};

/// Something in a usable file that was changed or left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// The file.
    pub path: Arc<PathBuf>,
    /// The object, where it has a name.
    pub object: Option<CompactString>,
    /// Where in the file.
    pub place: Place,
    /// What was found and what was done about it.
    pub what: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.path.display())?;
        match (&self.object, &self.place) {
            (Some(id), Place::File) => write!(f, "object {id:?}: ")?,
            (Some(id), place) => write!(f, "object {id:?} at {place}: ")?,
            (None, Place::File) => {}
            (None, place) => write!(f, "at {place}: ")?,
        }
        f.write_str(&self.what)
    }
}

/// Takes what the formats hand over.
#[derive(Debug, Default)]
pub(super) struct Collector {
    classes: Classes,
    /// Classes of all objects, of those that are not taken too.
    found: BTreeSet<CompactString>,
    /// Ids of the current file whose objects were not taken.
    untaken: BTreeSet<CompactString>,
    /// The system of files that state none, as the caller says.
    told_crs: Option<String>,
    scene: Scene,
    warnings: Vec<Warning>,
    /// Those about the objects of a file as a whole.
    overall: Vec<Warning>,
    tallies: Tallies,
    path: Arc<PathBuf>,
    /// Whether features have the height that the caller names.
    pub(super) named_height: NamedHeight,
    /// The current file is the last one.
    files: Extents,
    /// How many warnings, and how many objects, there were before the current file.
    warned_before: usize,
    taken_before: usize,
}

impl Collector {
    /// For objects of the classes that are asked for.
    pub(super) fn new(options: &Options) -> Self {
        Self {
            classes: options.classes.clone(),
            told_crs: options.crs.as_deref().map(crs::normalised),
            ..Self::default()
        }
    }

    /// The next objects come from this file.
    ///
    /// # Errors
    /// [`ImportError::LooksLikeDegrees`], of the file before.
    pub(super) fn begin(&mut self, source: &Source) -> Result<(), ImportError> {
        self.end_file()?;
        self.path = Arc::new(source.path().to_owned());
        self.files.begin(Arc::clone(&self.path));
        self.warned_before = self.warnings.len();
        self.taken_before = self.scene.objects.len();
        Ok(())
    }

    /// The objects of the current file lie in this system.
    pub(super) fn crs(&mut self, crs: &str) -> Result<(), ImportError> {
        match &self.scene.crs {
            Some(expected) if expected != crs => Err(ImportError::CrsMismatch {
                path: self.path.to_path_buf(),
                found: crs.to_owned(),
                expected: expected.clone(),
            }),
            _ => {
                self.files.state();
                self.scene.crs = Some(crs.to_owned());
                Ok(())
            }
        }
    }

    /// The system of files that state none, as the caller says.
    pub(super) fn told_crs(&self) -> Option<&str> {
        self.told_crs.as_deref()
    }

    /// # Errors
    /// [`ImportError::CrsContradicted`] where the current file states another system than the
    /// caller does.
    pub(super) fn contradict(&self, found: &str) -> Result<(), ImportError> {
        match self.told_crs() {
            Some(told) if !crs::agree(found, told) => Err(ImportError::CrsContradicted {
                path: self.path.to_path_buf(),
                found: found.to_owned(),
                told: told.to_owned(),
            }),
            _ => Ok(()),
        }
    }

    /// The current file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// What is assumed of where the current file lies, should it not come to say so.
    pub(super) fn assume(&mut self, what: String) {
        self.files.assume(what);
    }

    /// What looks wrong with the current file, should it not come to say where it lies.
    pub(super) fn suspect(&mut self, what: String) {
        self.files.suspect(what);
    }

    /// The system of the objects so far, where one was stated.
    pub(super) fn known_crs(&self) -> Option<&str> {
        self.scene.crs.as_deref()
    }

    /// Takes an object, if it is of a class that is asked for, and tells whether it did.
    pub(super) fn object(&mut self, object: SceneObject) -> bool {
        if !self.found.contains(&object.class) {
            self.found.insert(object.class.clone());
        }
        if !self.classes.take(&object.class) {
            self.untaken.insert(object.id);
            self.left_out("object", "of a class that was not asked for");
            return false;
        }
        self.files.add(&object.bounds);
        self.scene.objects.push(object);
        true
    }

    /// One that is not in the scene, for this reason, is counted.
    pub(super) fn left_out(&mut self, noun: &'static str, reason: &'static str) {
        self.tallies.count(noun, Fate::LeftOut, reason);
    }

    /// One that should have a height and has none, for this reason, is counted.
    pub(super) fn kept_flat(&mut self, noun: &'static str, reason: &'static str) {
        self.tallies.count(noun, Fate::KeptFlat, reason);
    }

    pub(super) fn warn(&mut self, object: Option<&str>, place: Place, what: impl Into<String>) {
        self.warnings.push(Warning {
            path: Arc::clone(&self.path),
            object: object.map(CompactString::from),
            place,
            what: what.into(),
        });
    }

    /// Puts one warning of the current file in the place of those of its objects that say `what`.
    pub(super) fn condense(&mut self, what: &str, instead: String) {
        let path = Arc::clone(&self.path);
        let mut at = 0;
        let first = self.warned_before;
        self.warnings.retain(|warning| {
            at += 1;
            at <= first || !warning.what.starts_with(what)
        });
        let warning = Warning {
            path,
            object: None,
            place: Place::File,
            what: instead,
        };
        self.warnings.insert(first, warning);
    }

    /// Forgets what was said of objects of the current file that were not taken, and looks at those
    /// that were.
    fn end_file(&mut self) -> Result<(), ImportError> {
        let mut untaken = std::mem::take(&mut self.untaken);
        for taken in &self.scene.objects[self.taken_before..] {
            untaken.remove(&taken.id); // ids may repeat
        }
        let said = self.warnings.split_off(self.warned_before);
        let holds = |warning: &Warning| match &warning.object {
            Some(id) => !untaken.contains(id),
            None => true,
        };
        self.warnings.extend(said.into_iter().filter(holds));
        self.look_over()
    }

    /// Whether the objects of the current file make sense together.
    fn look_over(&mut self) -> Result<(), ImportError> {
        let objects = &self.scene.objects[self.taken_before..];
        let degrees = match (sense::degrees(objects), &self.scene.crs) {
            (None, _) => None,
            _ if self.files.is_suspected() => None, // it is told already
            (Some(degrees), Some(crs)) if self.files.is_stated() => Some(degrees.of_stated(crs)),
            (Some(degrees), _) if degrees.surely => {
                return Err(ImportError::LooksLikeDegrees {
                    path: self.path.to_path_buf(),
                    what: degrees.of_unstated(),
                });
            }
            (Some(degrees), _) => Some(degrees.of_unstated()),
        };
        let doubts = [degrees, sense::strays(objects), sense::tall(objects)];
        let told = doubts.into_iter().flatten().map(|what| Warning {
            path: Arc::clone(&self.path),
            object: None,
            place: Place::File,
            what,
        });
        self.overall.extend(told);
        Ok(())
    }

    /// # Errors
    /// [`ImportError::NoSuchClass`], [`ImportError::FarApart`],
    /// [`ImportError::LooksLikeDegrees`].
    pub(super) fn finish(mut self) -> Result<Imported, ImportError> {
        self.end_file()?;
        self.classes.check(&self.found)?;
        let doubts = self.files.doubts(self.scene.crs.as_deref())?;
        let tilted = self.files.tilted();
        // First, where no number of other warnings hides them.
        let overall = std::mem::take(&mut self.overall);
        let first = tilted.chain(doubts).chain(overall);
        self.warnings.splice(0..0, first);
        let renamed = if self.ids_repeat() {
            self.scene.canonicalize()
        } else {
            Vec::new() // objects stay in file order
        };
        for Renamed { from, to } in renamed {
            let what = format!("its id is taken; imported as {to:?}");
            self.warn(Some(&from), Place::File, what);
        }
        Ok(Imported {
            scene: self.scene,
            warnings: self.warnings,
            tallies: self.tallies.0,
            unused: Vec::new(),
        })
    }

    fn ids_repeat(&self) -> bool {
        let mut ids: Vec<&str> = self.scene.objects.iter().map(|o| o.id.as_str()).collect();
        ids.sort_unstable();
        ids.windows(2).any(|pair| pair[0] == pair[1])
    }
}
