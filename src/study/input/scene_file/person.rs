//! What a scene says of the file of a person's joints: its order, its unit, its bones.

use std::collections::BTreeMap;
use std::path::Path;

use crate::diagnostics::Place;
use crate::keys::{Unit, UpFile};
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_scene::objects::Up;
use perirobot_scene::objects::bvh::{BONES, MotionFile};
use perirobot_scene::objects::keypoints::{JointLayout, KeypointFile};
use perirobot_scene::objects::spec::{PersonFile, SurfaceSpec};
use perirobot_scene::source::ending;

/// The keys beside a file of a person's joints.
pub(crate) struct PersonKeys<'a> {
    pub(crate) layout: Option<JointLayout>,
    pub(crate) unit: Option<Unit>,
    pub(crate) up: Option<UpFile>,
    pub(crate) bones: Option<&'a BTreeMap<String, String>>,
}

impl PersonKeys<'_> {
    /// A table or a motion, by the ending of its name. A motion begins with its first frame.
    pub(crate) fn check(&self, at: &Place, key: &str, path: &Path) -> Result<PersonFile> {
        if !is_motion(path) {
            if self.bones.is_some() {
                return Err(at.says("bones belong to motion capture").with_advice("a .bvh file"));
            }
            return self.joints(at, key, path).map(PersonFile::Joints);
        }
        if self.layout.is_some() {
            return Err(at
                .says("layout belongs to tables of joints")
                .with_advice("a .bvh file has bones, with names"));
        }
        let Some(Unit(scale)) = self.unit else {
            let cure = "add unit = \"cm\", \"m\", \"in\", or how many metres it is";
            return Err(at.says("a .bvh file does not say its unit").with_advice(cure));
        };
        let bones = self.bones.cloned().unwrap_or_default();
        if let Some(joint) = bones.keys().find(|joint| !BONES.contains(&joint.as_str())) {
            let place = at.key("bones").key(joint);
            return Err(place.wrap(Issue::unknown(&BONES)));
        }
        Ok(PersonFile::Motion(MotionFile {
            path: at.folder().join(path),
            scale,
            up: if self.up == Some(UpFile::Z) { Up::Z } else { Up::Y },
            bones,
            time_s: 0.0,
            centred: false,
        }))
    }

    /// A table.
    pub(super) fn joints(&self, at: &Place, key: &str, path: &Path) -> Result<KeypointFile> {
        let converter = match &*ending(path) {
            "fbx" | "blend" | "glb" | "gltf" | "dae" | "usd" | "usda" | "usdc" | "usdz" => {
                "Blender imports it and exports .bvh (File > Export > Motion Capture)"
            }
            "npz" | "npy" | "pkl" | "json" => {
                "write its joints as text, as numpy.savetxt does with delimiter=\",\""
            }
            _ => "",
        };
        if !converter.is_empty() {
            let rule = format!("must be a table of joints (.csv) or a motion (.bvh): {converter}");
            return Err(at.wrong(key, format!("{path:?}"), &rule));
        }
        match is_motion(path) {
            true => Err(at.wrong(
                key,
                format!("{path:?}"),
                "must be a table of joints (.csv): motion capture is a mannequin that moves by animation = { times_s }",
            )),
            false => Ok(KeypointFile { path: at.folder().join(path), layout: self.layout.unwrap_or_default() }),
        }
    }

    /// Refuses keys where no file of a person's joints is.
    pub(super) fn belong(&self, at: &Place, surface: &SurfaceSpec, has_keypoints: bool) -> Result<()> {
        let is_mannequin = matches!(surface, SurfaceSpec::Mannequin(_));
        if self.bones.is_some() && !is_mannequin {
            return Err(at.says("bones belong to a mannequin").with_advice("one from motion capture (.bvh)"));
        }
        if self.layout.is_some() && !is_mannequin && !has_keypoints {
            return Err(at
                .says("layout belongs to mannequin or keypoints")
                .with_advice("give one, or take it away"));
        }
        Ok(())
    }
}

fn is_motion(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("bvh"))
}
