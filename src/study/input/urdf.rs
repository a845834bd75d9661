//! What a scene file says of a robot from a URDF: the file, which of its geometry, where its packages are,
//! and its joint values. The URDF itself is read by `scene`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::diagnostics::Place;
use perirobot_march::Result;
use perirobot_scene::objects::spec::UrdfSpec;
use perirobot_scene::objects::urdf::{GeometryUse, JointValues, is_xacro};

/// The keys of an object that belong to its `urdf`.
pub(super) struct UrdfFile<'a> {
    pub(super) urdf: Option<&'a PathBuf>,
    pub(super) geometry: Option<GeometryUse>,
    pub(super) packages: Option<&'a BTreeMap<String, PathBuf>>,
    pub(super) joints_deg: Option<&'a BTreeMap<String, f64>>,
    pub(super) joints_m: Option<&'a BTreeMap<String, f64>>,
    pub(super) xacro_args: Option<&'a BTreeMap<String, String>>,
}

const XACRO_ARGS: &str = "xacro_args belong to a file that ends in .xacro";

impl UrdfFile<'_> {
    /// Checks the keys; paths are taken from the folder of the scene file.
    pub(super) fn check(&self, at: &Place, folder: &Path) -> Option<Result<UrdfSpec>> {
        let Some(path) = self.urdf else {
            let alone = self.geometry.is_some()
                || self.packages.is_some()
                || self.joints_deg.is_some()
                || self.joints_m.is_some();
            if self.xacro_args.is_some() {
                return Some(Err(at.says(XACRO_ARGS)));
            }
            let what =
                "geometry, packages, joints_deg and joints_m belong to a urdf: give one, or take them away";
            return alone.then(|| Err(at.says(what)));
        };
        let packages = self.packages.into_iter().flatten().map(|(name, path)| (name, folder.join(path)));
        let checked = || {
            Ok(UrdfSpec {
                path: folder.join(path),
                geometry: self.geometry.unwrap_or_default(),
                packages: packages.collect(),
                joints: joints(at, self.joints_deg, self.joints_m)?,
                xacro_args: self.xacro_args(at, path)?,
                recorded: None,
            })
        };
        Some(checked())
    }

    /// The arguments of a xacro.
    fn xacro_args(&self, at: &Place, path: &Path) -> Result<BTreeMap<String, String>> {
        let args = self.xacro_args.cloned().unwrap_or_default();
        if self.xacro_args.is_some() && !is_xacro(path) {
            return Err(at.says(XACRO_ARGS));
        }
        let is_name = |name: &str| {
            name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
                && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        match args.iter().find(|(name, value)| !is_name(name) || value.contains(char::is_control)) {
            Some((name, value)) => Err(at.key("xacro_args").wrong(
                name,
                format!("{value:?}"),
                "names have letters, digits and _, and values no control characters",
            )),
            None => Ok(args),
        }
    }
}

/// Joint values by the joints' names; the robot says which joints there are.
pub(super) fn joints(
    at: &Place,
    joints_deg: Option<&BTreeMap<String, f64>>,
    joints_m: Option<&BTreeMap<String, f64>>,
) -> Result<JointValues> {
    let checked = |key: &str, values: Option<&BTreeMap<String, f64>>| {
        let at = at.key(key);
        let value = |(name, value): (&String, &f64)| {
            Ok((name.clone(), at.number(name, *value, -1e6..=1e6, "a number from -1000000 to 1000000")?))
        };
        values.into_iter().flatten().map(value).collect::<Result<BTreeMap<_, _>>>()
    };
    Ok(JointValues {
        angles_deg: checked("joints_deg", joints_deg)?,
        travels_m: checked("joints_m", joints_m)?,
    })
}
