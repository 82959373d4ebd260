//! Files are replaced whole or not at all, and mapped.

use std::fs::{self, File, Metadata};
use std::io::{self, ErrorKind};
use std::ops::Deref;
use std::path::{Path, PathBuf};

use memmap2::Mmap;
use tempfile::NamedTempFile;

/// A file that will take the place of another, under a temporary name in the same folder. Dropped
/// before [`Replacement::finish`] it is gone, and nothing has changed.
#[derive(Debug)]
pub struct Replacement {
    temporary: NamedTempFile,
    path: PathBuf,
}

impl Replacement {
    /// An empty file beside `path`, for what is to stand there.
    ///
    /// # Errors
    /// What the system says.
    pub fn of(path: &Path) -> io::Result<Self> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666)); // less the umask
        }
        // The temporary name, which its error would tell, helps nobody.
        let temporary = builder
            .tempfile_in(folder_of(path))
            .map_err(|error| io::Error::from(error.kind()))?;
        Ok(Self {
            temporary,
            path: path.to_owned(),
        })
    }

    /// What to write to.
    pub fn file(&mut self) -> &mut File {
        self.temporary.as_file_mut()
    }

    /// Where it is until it is finished.
    pub fn path(&self) -> &Path {
        self.temporary.path()
    }

    /// Syncs the file and gives it its name.
    ///
    /// # Errors
    /// What the system says; what was there before is there still.
    pub fn finish(self) -> io::Result<()> {
        self.temporary.as_file().sync_all()?;
        self.temporary.persist(self.path)?;
        Ok(())
    }
}

/// Replaces `path` by what `write` writes, or leaves it as it was.
///
/// # Errors
/// What the system says; `path` is then as it was.
pub fn replace(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let mut new = Replacement::of(path)?;
    write(new.file())?;
    new.finish()
}

/// Why two files were not replaced.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot write", path.display())]
pub struct NotReplaced {
    /// Which of them could not be.
    pub path: PathBuf,
    /// What the system says.
    pub source: io::Error,
}

/// Replaces two files that belong together: both are synced before either gets its name, and where
/// the second name is refused, what was at the first is put back.
///
/// # Errors
/// [`NotReplaced`]; both are then as they were. Where what was at the first could not be put back,
/// the error names the file that has it.
pub fn finish_both(first: Replacement, second: Replacement) -> Result<(), NotReplaced> {
    let refused = |path: &Path| {
        let path = path.to_owned();
        move |source| NotReplaced { path, source }
    };
    let path = first.path.clone();
    second
        .temporary
        .as_file()
        .sync_all()
        .map_err(refused(&second.path))?;
    let former = second_name(&path).map_err(refused(&path))?;
    first.finish().map_err(refused(&path))?;
    let Err(error) = second.temporary.persist(&second.path) else {
        return Ok(());
    };
    match put_back(former, &path) {
        Ok(()) => Err(refused(&second.path)(error.error)),
        Err(again) => Err(refused(&path)(again)),
    }
}

/// What is at `path` under a name of its own beside it, gone when dropped; `None` where there is
/// nothing.
fn second_name(path: &Path) -> io::Result<Option<NamedTempFile<()>>> {
    if !path.exists() {
        return Ok(None);
    }
    if path.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    let made = builder.make_in(folder_of(path), |name| match fs::hard_link(path, name) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => {
            // Not every file system has links, and not every file may be linked to.
            fs::copy(path, name).map(|_| ())
        }
        linked => linked,
    });
    made.map(Some)
        .map_err(|error| io::Error::from(error.kind()))
}

/// Gives what [`second_name`] kept its own name again.
fn put_back(former: Option<NamedTempFile<()>>, path: &Path) -> io::Result<()> {
    let Some(former) = former else {
        return fs::remove_file(path);
    };
    former.persist(path).map_err(|refused| {
        let error = refused.error;
        match refused.file.into_temp_path().keep() {
            Ok(kept) => {
                io::Error::other(format!("what was there is now {}: {error}", kept.display()))
            }
            Err(_) => error,
        }
    })
}

/// What names of temporary files begin with.
const PREFIX: &str = ".citylod-";

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A file that is read as if it were memory.
#[derive(Debug)]
pub struct Mapped {
    map: Mmap,
    /// The file, wherever its name leads by now, and what it was when it was mapped.
    file: File,
    then: Option<Metadata>,
}

/// Why a file cannot be mapped.
#[derive(Debug)]
pub enum MapError {
    /// There is nothing in it.
    Empty,
    /// The system, or what it is, forbids it.
    Io {
        /// What was tried.
        action: &'static str,
        /// What is said of it.
        source: io::Error,
    },
}

impl Mapped {
    /// Maps a file. It must not be changed in place while it is mapped; a [`Replacement`] does
    /// not.
    ///
    /// # Errors
    /// [`MapError`] for what cannot be opened, and for folders, pipes and devices, which are not
    /// waited for.
    pub fn open(path: &Path) -> Result<Self, MapError> {
        let io = |action| move |source| MapError::Io { action, source };
        let metadata = path.metadata().map_err(io("cannot open"))?;
        if metadata.is_dir() {
            return Err(io("cannot open")(ErrorKind::IsADirectory.into()));
        }
        if !metadata.is_file() {
            let what = "it is a pipe or a device, which cannot be mapped; save it to a file first";
            return Err(io("cannot open")(io::Error::other(what)));
        }
        if metadata.len() == 0 {
            return Err(MapError::Empty);
        }
        let file = File::open(path).map_err(io("cannot open"))?;
        let then = file.metadata().ok();
        #[allow(
            unsafe_code,
            reason = "mapping a file is the one thing that needs it; the caller's duty is in the docs"
        )]
        // SAFETY: the map is only read, through slices that live no longer than it, and every
        // bit pattern is valid for the types it is read as. The caller keeps the file unchanged.
        let map = unsafe { Mmap::map(&file) }.map_err(io("cannot map"))?;
        Ok(Self { map, file, then })
    }

    /// Whether length or time of the file are not what they were; false where the file cannot
    /// tell.
    pub fn is_written_into(&self) -> bool {
        let (Some(then), Ok(now)) = (&self.then, self.file.metadata()) else {
            return false;
        };
        then.len() != now.len() || then.modified().ok() != now.modified().ok()
    }
}

impl Deref for Mapped {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.map
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    fn replacement(path: &Path, content: &str) -> Replacement {
        let mut new = Replacement::of(path).expect("a file beside it");
        new.file().write_all(content.as_bytes()).expect("room");
        new
    }

    /// Names and contents of all files of a folder.
    fn files(folder: &Path) -> Vec<(String, String)> {
        let entries = fs::read_dir(folder).expect("a folder").flatten();
        let files = entries.filter(|entry| entry.path().is_file());
        let mut files: Vec<_> = files
            .map(|entry| {
                let content = fs::read_to_string(entry.path()).expect("text");
                (entry.file_name().to_string_lossy().into_owned(), content)
            })
            .collect();
        files.sort();
        files
    }

    #[test]
    fn two_files_are_replaced_both_or_neither() {
        let folder = tempfile::tempdir().expect("a folder");
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        let both = || finish_both(replacement(&a, "new a"), replacement(&b, "new b"));
        let named = |a: &str, b: &str| {
            let files = [("a", a), ("b", b)].map(|(name, text)| (name.into(), text.into()));
            files.to_vec() as Vec<(String, String)>
        };
        both().expect("nothing is in the way");
        assert_eq!(files(folder.path()), named("new a", "new b"));
        fs::write(&a, "old a").expect("room");
        fs::write(&b, "old b").expect("room");
        both().expect("nothing is in the way");
        assert_eq!(files(folder.path()), named("new a", "new b"));
        // A folder cannot be replaced by a file.
        fs::write(&a, "old a").expect("room");
        fs::remove_file(&b).expect("a file");
        fs::create_dir(&b).expect("room");
        let refused = both().expect_err("a folder is in the way");
        assert_eq!(refused.path, b);
        assert_eq!(files(folder.path()), [("a".into(), "old a".into())]);
        fs::remove_file(&a).expect("a file");
        both().expect_err("a folder is in the way");
        assert_eq!(files(folder.path()), []);
        fs::create_dir(&a).expect("room");
        assert_eq!(both().expect_err("another").path, a);
        assert_eq!(files(folder.path()), []);
    }
}
