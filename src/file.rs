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
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".citylod-");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666)); // less the umask
        }
        // The temporary name, which its error would tell, helps nobody.
        let temporary = builder
            .tempfile_in(folder)
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

/// Replaces two files that belong together: both are synced before either gets its name.
///
/// # Errors
/// What the system says. Both are then as they were, unless only the second name was refused.
pub fn finish_both(first: Replacement, second: Replacement) -> io::Result<()> {
    second.temporary.as_file().sync_all()?;
    first.finish()?;
    second.temporary.persist(second.path)?;
    Ok(())
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
        #[allow(
            unsafe_code,
            reason = "mapping a file is the one thing that needs it; the caller's duty is in the docs"
        )]
        // SAFETY: the map is only read, through slices that live no longer than it, and every
        // bit pattern is valid for the types it is read as. The caller keeps the file unchanged.
        let map = unsafe { Mmap::map(&file) }.map_err(io("cannot map"))?;
        let then = file.metadata().ok();
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
