//! `--package`, `--allow-outside`, `--xacro` and `--step`: files and programs that a study may use outside its folder.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use perirobot_scene::objects::spec::SceneSpec;
use perirobot_scene::source::Sources;

/// The ROS packages of this machine, and the permissions to read other folders and to run programs.
#[derive(Default, clap::Args)]
#[command(next_help_heading = "Study")]
pub(super) struct PackageArgs {
    /// Folder of a robot's package:// meshes; repeatable, overrides the scene file's packages
    #[arg(long = "package", value_name = "NAME=DIR", value_parser = package)]
    packages: Vec<(String, PathBuf)>,
    /// Also read files outside the folders of the given file and of --package
    #[arg(long)]
    allow_outside: bool,
    /// Expand robots that are .xacro files with the program xacro of your path, which can run any code in them
    #[arg(long)]
    xacro: bool,
    /// Convert meshes that are .step or .stp files with the package cascadio of python3 on your path, or of
    /// PERIROBOT_PYTHON: `pip install cascadio numpy`
    #[arg(long)]
    step: bool,
}

impl PackageArgs {
    /// The sources for the files of a study or scene.
    pub(super) fn sources(&self, file: &Path) -> Sources {
        let beside = Sources::from_main(file);
        let sources = self.packages.iter().fold(beside, |all, (name, folder)| all.with_package(name, folder));
        let sources = if self.allow_outside { sources.allow_outside() } else { sources };
        let sources = if self.xacro { sources.allow_xacro() } else { sources };
        if self.step { sources.allow_step(&python()) } else { sources }
    }

    /// The same arguments as words of a command line.
    pub(super) fn words(&self) -> Vec<String> {
        let to_words =
            |(name, folder): &(String, PathBuf)| ["--package".into(), format!("{name}={}", folder.display())];
        let allowed =
            [(self.allow_outside, "--allow-outside"), (self.xacro, "--xacro"), (self.step, "--step")];
        let allowed = allowed.iter().filter(|(is_given, _)| *is_given).map(|(_, flag)| (*flag).to_string());
        self.packages.iter().flat_map(to_words).chain(allowed).collect()
    }

    /// Passes the packages to the robots of all scenes.
    pub(super) fn apply(&self, scenes: &mut [SceneSpec]) {
        let packages = self.packages.iter().map(|(name, folder)| (name.as_str(), Path::new(folder)));
        scenes.iter_mut().for_each(|scene| scene.use_packages(packages.clone()));
    }
}

/// The interpreter with cascadio. The Python package sets its own by PERIROBOT_PYTHON.
fn python() -> PathBuf {
    let usual = || OsString::from(if cfg!(windows) { "python" } else { "python3" });
    std::env::var_os("PERIROBOT_PYTHON").filter(|python| !python.is_empty()).unwrap_or_else(usual).into()
}

fn package(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.is_empty() && !folder.is_empty() => Ok((name.into(), folder.into())),
        _ => Err("must be a name, = and a folder, as in ur_description=../ur_description".into()),
    }
}
