//! `--package`: where the packages of a robot's meshes are. What a package is for is `scene::urdf`'s affair.

use std::path::{Path, PathBuf};

use perirobot::study::SceneSpec;

/// Where ROS packages are on this machine.
#[derive(clap::Args)]
pub(super) struct PackageArgs {
    /// Where a robot's package:// meshes are; repeatable, overrides the scene file's packages
    #[arg(long = "package", value_name = "NAME=DIR", value_parser = package)]
    packages: Vec<(String, PathBuf)>,
}

impl PackageArgs {
    /// Tells the robots of all scenes.
    pub(super) fn apply(&self, scenes: &mut [SceneSpec]) {
        let packages = self.packages.iter().map(|(name, folder)| (name.as_str(), Path::new(folder)));
        scenes.iter_mut().for_each(|scene| scene.use_packages(packages.clone()));
    }
}

fn package(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.is_empty() && !folder.is_empty() => Ok((name.into(), folder.into())),
        _ => Err("must be a name, = and a folder, as in ur_description=../ur_description".into()),
    }
}
