//! Which study is run, and what the command line says instead of it.

use std::path::{Path, PathBuf};

use perirobot::study::{Overrides, Study};
use perirobot::world::World;
use perirobot::{Error, Result};

use super::packages::PackageArgs;

#[derive(clap::Args)]
#[command(next_help_heading = "Study")]
pub(super) struct StudyArgs {
    /// The study file (TOML)
    #[arg(help_heading = None::<&'static str>)]
    study: PathBuf,
    /// Edge of a voxel in metres, instead of the study's
    #[arg(long, value_name = "METRES")]
    voxel_size: Option<f64>,
    /// Ideal sensors: no noise, no lost returns, no error of the mount, whatever the study says
    #[arg(long)]
    noiseless: bool,
    #[command(flatten)]
    packages: PackageArgs,
}

impl StudyArgs {
    /// Reads the study and makes ready what scenes can be, and tells everything that is wrong with them;
    /// nothing but what is wrong where the study itself is.
    pub(super) fn examine(&self) -> Result<(Study, Vec<World>, Vec<Error>), Vec<Error>> {
        let mut study = Study::examine(&self.study, &self.overrides(), self.packages.sources(&self.study))?;
        self.packages.apply(&mut study.scenes);
        let (mut worlds, mut problems) = (Vec::new(), Vec::new());
        for scene in 0..study.scenes.len() {
            match World::examine(&study, scene) {
                Ok(snapshots) => worlds.extend(snapshots),
                Err(all) => problems.extend(all),
            }
        }
        Ok((study, worlds, problems))
    }

    fn overrides(&self) -> Overrides {
        Overrides { voxel_size_m: self.voxel_size, noiseless: self.noiseless }
    }

    /// Reads the study and makes its scenes ready; warnings are printed.
    pub(super) fn load(&self) -> Result<(Study, Vec<World>)> {
        self.load_unless(&|| None)
    }

    /// The same, unless somebody says why to stop.
    pub(super) fn load_unless(
        &self,
        stop: &(dyn Fn() -> Option<String> + Sync),
    ) -> Result<(Study, Vec<World>)> {
        let study = self.read()?;
        let worlds = World::prepare_all_unless(&study, stop)?;
        super::warn(
            worlds.iter().map(|world| (world.name.as_str(), world.warnings.as_slice())),
            super::MOST_WARNINGS,
        );
        Ok((study, worlds))
    }

    /// Where the results of a sweep go that is told no folder.
    pub(super) fn usual_out(&self) -> PathBuf {
        Path::new("out").join(self.study.file_stem().unwrap_or_default())
    }

    /// Reads the study alone.
    pub(super) fn read(&self) -> Result<Study> {
        let overrides = self.overrides();
        let mut study = Study::read(&self.study, &overrides, self.packages.sources(&self.study))?;
        self.packages.apply(&mut study.scenes);
        Ok(study)
    }
}
