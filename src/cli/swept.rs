//! The folder of a finished sweep and its study, for commands that look at single poses again.

use std::path::{Path, PathBuf};

use perirobot_decide::choose::as_swept;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;
use perirobot_sweep::scoring::reopen;

use super::packages::PackageArgs;

#[derive(clap::Args)]
#[command(next_help_heading = "Study")]
pub(super) struct SweptArgs {
    /// Folder written by `perirobot sweep` or `perirobot choose`; its study must be unchanged and in the same place
    #[arg(value_name = "DIR", help_heading = None::<&'static str>)]
    folder: PathBuf,
    /// The study file, if it was moved
    #[arg(long, value_name = "FILE")]
    study: Option<PathBuf>,
    #[command(flatten)]
    packages: PackageArgs,
}

impl SweptArgs {
    /// The folder.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The arguments with which a command on the study reads the same files.
    pub(super) fn words(&self) -> Vec<String> {
        self.packages.words()
    }

    /// The arguments with which a command on the folder reads the same files.
    pub(super) fn folder_words(&self) -> Vec<String> {
        let study = self.study.iter().flat_map(|file| ["--study".into(), file.display().to_string()]);
        study.chain(self.words()).collect()
    }

    /// Reads the study again, and makes its scenes ready.
    pub(super) fn load(&self) -> Result<(Study, Vec<World>)> {
        let place = StudyPlace { named: self.study.as_deref(), cure: ", or name the study: --study FILE" };
        let (study, worlds) = study_of(&self.folder, place, &self.packages)?;
        as_swept(&self.folder, study, worlds)
    }
}

/// Where to find the study of a folder.
pub(super) struct StudyPlace<'a> {
    /// The path given by the user, if the study was moved.
    pub(super) named: Option<&'a Path>,
    /// How the user can name another path.
    pub(super) cure: &'a str,
}

/// The study of a folder, and its scenes, prepared.
pub(super) fn study_of(
    folder: &Path,
    place: StudyPlace,
    packages: &PackageArgs,
) -> Result<(Study, Vec<World>)> {
    load(reopen::origin(folder)?, place, packages)
}

/// The study in a file, unless another one is named, and its scenes, prepared.
pub(super) fn load(
    (file, overrides): (PathBuf, Overrides),
    place: StudyPlace,
    packages: &PackageArgs,
) -> Result<(Study, Vec<World>)> {
    let file = place.named.map_or(file, Path::to_path_buf);
    if !file.exists() {
        let cure = place.cure;
        let what =
            format!("the study of this sweep is missing: run the command in the folder of the sweep{cure}");
        return Err(Error::input(file, what));
    }
    let mut study = Study::read(&file, &overrides, packages.sources(&file))?;
    packages.apply(&mut study.scenes);
    let worlds = World::prepare_all(&study)?;
    Ok((study, worlds))
}
