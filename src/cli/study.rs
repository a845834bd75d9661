//! The study of a command, and its overrides.

use std::path::{Path, PathBuf};

use perirobot_decide::choose::as_swept;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
#[cfg(feature = "report")]
use perirobot_scene::source::Sources;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::{World, case_warnings};
use perirobot_sweep::results::files::MANIFEST;

use super::packages::PackageArgs;
use super::swept::{self, StudyPlace};

// With this group, an optional study is present exactly if its file is given.
#[derive(clap::Args)]
#[command(next_help_heading = "Study")]
#[group(args = ["study"])]
pub(super) struct StudyArgs {
    /// The study file (TOML)
    #[arg(help_heading = None::<&'static str>)]
    study: PathBuf,
    /// Edge of a voxel in metres, instead of the study's
    #[arg(long, value_name = "METRES")]
    voxel_size: Option<f64>,
    /// Ideal sensors: no noise, no lost returns, no mounting error, overriding the study
    #[arg(long)]
    noiseless: bool,
    #[command(flatten)]
    packages: PackageArgs,
}

impl StudyArgs {
    /// A study without overrides.
    #[cfg(feature = "report")]
    pub(super) fn from_path(study: PathBuf) -> StudyArgs {
        StudyArgs { study, voxel_size: None, noiseless: false, packages: PackageArgs::default() }
    }

    /// Reads the study and prepares its scenes as far as possible, collecting all errors of the scenes. If the study
    /// itself is wrong, there are only its errors.
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
        if problems.is_empty() && !worlds.is_empty() {
            let warnings = case_warnings(&study, &worlds);
            worlds[0].warnings.extend(warnings);
        }
        Ok((study, worlds, problems))
    }

    /// The file.
    #[cfg(feature = "report")]
    pub(super) fn path(&self) -> &Path {
        &self.study
    }

    /// Reads the study from a given text instead of its file, and some of its files from given texts; a voxel size of
    /// the command line takes precedence.
    #[cfg(feature = "report")]
    pub(super) fn examine_text(
        &self,
        text: &str,
        files: &[(PathBuf, String)],
        voxel_size_m: Option<f64>,
    ) -> Result<Study, Vec<Error>> {
        let mut overrides = self.overrides();
        overrides.voxel_size_m = voxel_size_m.or(overrides.voxel_size_m);
        let sources = self.packages.sources(&self.study).with_file(&self.study, text.as_bytes().to_vec());
        let given = |sources: Sources, (path, text): &(PathBuf, String)| {
            sources.with_file(path, text.as_bytes().to_vec())
        };
        let sources = files.iter().fold(sources, given);
        let mut study = Study::examine(&self.study, &overrides, sources)?;
        self.packages.apply(&mut study.scenes);
        Ok(study)
    }

    /// The study and scenes of a folder of results; `None` if the argument is not such a folder. `place` locates the
    /// study.
    pub(super) fn load_folder(&self, place: StudyPlace) -> Result<Option<(Study, Vec<World>)>> {
        if !self.study.join(MANIFEST).exists() {
            if let Some(moved) = place.named {
                let what = format!("needs a folder of results, but {} is not one", self.study.display());
                return Err(Error::input(format!("--study {}", moved.display()), what));
            }
            return Ok(None);
        }
        if self.overrides() != Overrides::default() {
            let what = "is a folder of results with a fixed voxel size and noise: remove --voxel-size and --noiseless";
            return Err(Error::input(&self.study, what));
        }
        let (study, worlds) = swept::study_of(&self.study, place, &self.packages)?;
        as_swept(&self.study, study, worlds).map(Some)
    }

    fn overrides(&self) -> Overrides {
        Overrides { voxel_size_m: self.voxel_size, noiseless: self.noiseless }
    }

    /// Reads the study and prepares its scenes; prints warnings.
    pub(super) fn load(&self) -> Result<(Study, Vec<World>)> {
        self.load_unless(&|| None)
    }

    /// The same, which may be stopped.
    pub(super) fn load_unless(&self, progress: &dyn Progress) -> Result<(Study, Vec<World>)> {
        let study = self.read()?;
        let worlds = World::prepare_all_unless(&study, progress)?;
        super::warn(
            worlds.iter().map(|world| (world.name.as_str(), world.warnings.as_slice())),
            super::MOST_WARNINGS,
        );
        Ok((study, worlds))
    }

    /// The package arguments for a command on the folder of results.
    pub(super) fn package_words(&self) -> Vec<String> {
        self.packages.words()
    }

    /// The arguments with which another command reads the same study.
    pub(super) fn words(&self) -> Vec<String> {
        let size = self.voxel_size.iter().flat_map(|size| ["--voxel-size".into(), size.to_string()]);
        let noiseless = self.noiseless.then(|| "--noiseless".into());
        let study = [self.study.display().to_string()].into_iter();
        study.chain(size).chain(noiseless).chain(self.package_words()).collect()
    }

    /// The default folder of results: `out/`, the study's name and an ending.
    pub(super) fn usual_out(&self, ending: &str) -> PathBuf {
        let mut name = self.study.file_stem().unwrap_or_default().to_owned();
        name.push(ending);
        Path::new("out").join(name)
    }

    /// The folder of the study.
    pub(super) fn folder(&self) -> &Path {
        self.study.parent().unwrap_or(Path::new(""))
    }

    /// Reads only the study.
    pub(super) fn read(&self) -> Result<Study> {
        let overrides = self.overrides();
        let mut study = Study::read(&self.study, &overrides, self.packages.sources(&self.study))?;
        self.packages.apply(&mut study.scenes);
        Ok(study)
    }
}
