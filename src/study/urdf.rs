//! What a scene file says of a robot from a URDF: the file, which of its geometry, where its packages are,
//! and its joint values. The URDF itself is read by `scene`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::Place;
use crate::Result;
use crate::scene::spec::UrdfSpec;
use crate::scene::urdf::{Geometry, JointValues};

/// The keys of an object that belong to its `urdf`.
pub(super) struct UrdfFile<'a> {
    pub(super) urdf: Option<&'a PathBuf>,
    pub(super) geometry: Option<Geometry>,
    pub(super) packages: Option<&'a BTreeMap<String, PathBuf>>,
    pub(super) joints_deg: Option<&'a BTreeMap<String, f64>>,
    pub(super) joints_m: Option<&'a BTreeMap<String, f64>>,
}

impl UrdfFile<'_> {
    /// Checks the keys; paths are taken from the folder of the scene file.
    pub(super) fn check(&self, at: &Place, folder: &Path) -> Option<Result<UrdfSpec>> {
        let Some(path) = self.urdf else {
            let alone = self.geometry.is_some()
                || self.packages.is_some()
                || self.joints_deg.is_some()
                || self.joints_m.is_some();
            let what =
                "geometry, packages, joints_deg and joints_m belong to a urdf: give one, or take them away";
            return alone.then(|| Err(at.says(what)));
        };
        let packages = self.packages.into_iter().flatten().map(|(name, path)| (name, folder.join(path)));
        Some(joints(at, self.joints_deg, self.joints_m).map(|joints| UrdfSpec {
            path: folder.join(path),
            geometry: self.geometry.unwrap_or_default(),
            packages: packages.collect(),
            joints,
            recorded: None,
        }))
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
