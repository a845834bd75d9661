//! Opens a finished sweep again: its study is read and prepared again, and proven to be the same. Commands that examine
//! single poses start here.

use std::path::{Path, PathBuf};

use crate::results::journal::Shard;
use crate::results::manifest::Manifest;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

/// The study file of a sweep, at its original path, and the overrides of the command line.
pub fn origin(folder: &Path) -> Result<(PathBuf, Overrides)> {
    let Manifest { identity, provenance, .. } = Manifest::read(folder)?;
    let overrides = Overrides { voxel_size_m: Some(identity.voxel_size_m), noiseless: identity.noiseless };
    Ok((provenance.about.study.file.into(), overrides))
}

/// Whether the sweep in a folder has the same number of poses as a study.
pub fn has_poses_of(folder: &Path, study: &Study) -> bool {
    let swept = Manifest::read(folder).map(|manifest| manifest.identity.sensors).unwrap_or_default();
    swept.iter().map(|sensor| sensor.poses).eq(study.sensors.iter().map(|sensor| sensor.candidates.len()))
}

/// The study of a folder's sweep: a study with these worlds, or its chosen sets. Fails if it is neither, with the
/// differences.
pub fn as_swept(folder: &Path, study: Study, worlds: &[World]) -> Result<Study> {
    let then = Manifest::read(folder)?;
    let now = |study: &Study| Manifest::new(study, worlds, Shard::WHOLE, &[]);
    let mut manifest = now(&study);
    if then.fingerprint() == manifest.fingerprint() {
        return Ok(study);
    }
    if let Some(sets) = then.identity.study_of_sets(&study) {
        manifest = now(&sets);
        if then.fingerprint() == manifest.fingerprint() {
            return Ok(sets);
        }
    }
    let changes = then.changes(&manifest).join("; ");
    let what = format!("{} has changed since the sweep: {changes}; sweep again", study.path.display());
    Err(Error::input(folder, what))
}
