//! Opens a finished sweep again: its study is read and made ready once more, and proven to be the same.
//! Commands that look at single poses afterwards begin here.

use std::path::{Path, PathBuf};

use crate::results::journal::Shard;
use crate::results::manifest::Manifest;
use crate::study::{Overrides, Study};
use crate::world::World;
use crate::{Error, Result};

/// The study file of a sweep, at its place when the sweep began, and what the command line overrode.
pub fn origin(folder: &Path) -> Result<(PathBuf, Overrides)> {
    let Manifest { identity, provenance, .. } = Manifest::read(folder)?;
    let overrides = Overrides { voxel_size_m: Some(identity.voxel_size_m), noiseless: identity.noiseless };
    Ok((provenance.about.study.file.into(), overrides))
}

/// Fails unless a study with its worlds is what was swept into a folder, naming what changed since.
pub fn same(folder: &Path, study: &Study, worlds: &[World]) -> Result<()> {
    let then = Manifest::read(folder)?;
    let now = Manifest::new(study, worlds, Shard::WHOLE, &[]);
    if then.fingerprint() == now.fingerprint() {
        return Ok(());
    }
    let changes = then.changes(&now).join("; ");
    let what = format!("{} is not what was swept: {changes}; sweep again", study.path.display());
    Err(Error::input(folder, what))
}
