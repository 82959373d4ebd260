//! Files are replaced whole or not at all.

use std::fs::File;
use std::path::Path;

/// Replaces `path` by what `write` writes, or leaves it as it was.
///
/// Written under a temporary name in the same folder, synced, renamed.
///
/// # Errors
/// What the system says; `path` is then as it was.
pub fn replace_file(
    path: &Path,
    write: impl FnOnce(&mut File) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".citylod-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666)); // less the umask
    }
    // The temporary name, which its error would tell, helps nobody.
    let mut temporary = builder
        .tempfile_in(folder)
        .map_err(|error| std::io::Error::from(error.kind()))?;
    write(temporary.as_file_mut())?;
    temporary.as_file().sync_all()?;
    temporary.persist(path)?;
    Ok(())
}
