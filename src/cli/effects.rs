use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::scene::Effects;

/// What a file declares for a city that is made now, and so has no ground yet.
pub(super) fn declared_anew(file: Option<&Path>) -> Result<Effects> {
    let effects = declared(file)?;
    if let (Some(file), Some(_)) = (file, effects.terrain) {
        let file = file.display();
        bail!(
            "{file}: declares terrain, and the city has no ground yet; leave terrain out, and declare it when its ground is laid: citylod import ELEVATION --into CITY --effects {file}"
        );
    }
    Ok(effects)
}

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
