use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::scene::Effects;

/// What a file declares; nothing without a file.
pub(super) fn declared(file: Option<&Path>) -> Result<Effects> {
    let Some(path) = file else {
        return Ok(Effects::default());
    };
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("{}: cannot read", path.display()))?;
    if text.trim().is_empty() {
        bail!(
            "{}: is empty; expected JSON such as {{\"haze\":{{\"visibility_m\":3000}}}}",
            path.display()
        );
    }
    Effects::from_json(&text).with_context(|| path.display().to_string())
}
