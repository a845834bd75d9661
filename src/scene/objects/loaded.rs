//! The files of a scene while it is built: what is read once for all its objects and snapshots is kept.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use wildmatch::WildMatch;

use super::bvh::Bvh;
use super::gltf::{Clip, Gltf, NodeMesh, WhichClip};
use super::joint_table::JointTable;
use super::keypoints::Keypoints;
use super::mannequin;
use super::spec::PersonFile;
use super::{Object, Surface};
use crate::source::Sources;
use perirobot_march::error::{Issue, Site};
use perirobot_march::{Error, Result};

/// Most triangles that are held while a scene is built, counted for each shape at each of its places: about 5
/// GB. A ball, which takes one line of a scene file, has a quarter of a million, and may move through ten
/// thousand snapshots.
const MOST_TRIANGLES: usize = 200_000_000;

/// The files of a scene; what is read once for all objects and snapshots is kept.
pub(super) struct SceneFiles<'a> {
    pub(super) sources: &'a Sources,
    /// Of [`MOST_TRIANGLES`].
    pub(super) triangles_left: usize,
    pub(super) gltf: HashMap<PathBuf, Rc<Gltf>>,
    pub(super) layers: HashMap<(PathBuf, Vec<String>), Rc<Vec<NodeMesh>>>,
    pub(super) clips: HashMap<(PathBuf, WhichClip), Rc<Clip>>,
    pub(super) motions: HashMap<PathBuf, Rc<Bvh>>,
    pub(super) joint_tables: HashMap<PathBuf, Rc<JointTable>>,
}

impl<'a> SceneFiles<'a> {
    pub(super) fn new(sources: &'a Sources) -> SceneFiles<'a> {
        let (gltf, layers, clips, motions, joint_tables) = Default::default();
        SceneFiles { sources, triangles_left: MOST_TRIANGLES, gltf, layers, clips, motions, joint_tables }
    }

    /// The nodes of a glTF file, at a time of one of its animations if there is one.
    pub(super) fn gltf_nodes(
        &mut self,
        path: &Path,
        animated: Option<&(WhichClip, f64)>,
    ) -> Result<Vec<NodeMesh>> {
        match animated {
            None => self.gltf(path)?.parts(None),
            Some((which, time_s)) => {
                let clip = self.clip(path, which)?;
                self.gltf(path)?.parts(Some((&clip, *time_s)))
            }
        }
        .map_err(with_key("mesh"))
    }

    /// The nodes of a STEP file with their layers, which these patterns select.
    pub(super) fn step_layers(&mut self, path: &Path, patterns: &[WildMatch]) -> Result<Vec<NodeMesh>> {
        let key = (path.to_path_buf(), patterns.iter().map(WildMatch::pattern).collect());
        if let Some(nodes) = self.layers.get(&key) {
            return Ok(nodes.to_vec());
        }
        let nodes = Gltf::step_layers(path, patterns, self.sources).map_err(with_key("mesh"))?;
        self.layers.insert(key, Rc::new(nodes.clone()));
        Ok(nodes)
    }

    /// The joints of a person of whom a body can be drawn.
    pub(super) fn person(&mut self, person: &PersonFile) -> Result<Keypoints> {
        let joints = match person {
            PersonFile::Joints(file) => file.read(self.sources)?,
            PersonFile::Motion(file) => self.motion(&file.path)?.keypoints(file)?,
        };
        mannequin::require_body(joints, person.path())
    }

    pub(super) fn motion(&mut self, path: &Path) -> Result<Rc<Bvh>> {
        read_once(&mut self.motions, path, || Bvh::load(path, self.sources))
    }

    pub(super) fn joint_table(&mut self, path: &Path) -> Result<Rc<JointTable>> {
        read_once(&mut self.joint_tables, path, || JointTable::load(path, self.sources))
    }

    pub(super) fn spend(&mut self, part: &Object) -> Result<()> {
        let Surface::Mesh(mesh) = &part.surface else { return Ok(()) };
        let left = self.triangles_left.checked_sub(mesh.triangles.len()).ok_or_else(|| {
            let what = format!("with it, the scene unfolds to more than {MOST_TRIANGLES} triangles");
            let cure = "simplify its meshes, take larger voxels, or split the recording";
            Issue::too_large(what).with_advice(cure)
        })?;
        self.triangles_left = left;
        Ok(())
    }

    pub(super) fn gltf(&mut self, path: &Path) -> Result<Rc<Gltf>> {
        read_once(&mut self.gltf, path, || Gltf::load(path, self.sources).map_err(with_key("mesh")))
    }

    pub(super) fn clip(&mut self, path: &Path, which: &WhichClip) -> Result<Rc<Clip>> {
        let key = (path.to_path_buf(), which.clone());
        if let Some(clip) = self.clips.get(&key) {
            return Ok(clip.clone());
        }
        let clip = self.gltf(path)?.clip(which);
        let clip = Rc::new(clip.map_err(|e| e.with_place("snapshots.animation.clip"))?);
        self.clips.insert(key, clip.clone());
        Ok(clip)
    }
}

/// What a file holds, read if it was not read before.
fn read_once<T>(
    files: &mut HashMap<PathBuf, Rc<T>>,
    path: &Path,
    read: impl FnOnce() -> Result<T>,
) -> Result<Rc<T>> {
    if let Some(file) = files.get(path) {
        return Ok(file.clone());
    }
    let file = Rc::new(read()?);
    files.insert(path.into(), file.clone());
    Ok(file)
}

/// The joints of a person of whom a body can be drawn.
///
/// # Errors
/// When the file cannot be read, or too few joints are known to draw any part of a body.
pub fn read_person(person: &PersonFile, sources: &Sources) -> Result<Keypoints> {
    SceneFiles::new(sources).person(person)
}

/// A loader's message begins with the file, the value of this key.
pub(super) fn with_key(key: &'static str) -> impl Fn(Error) -> Error {
    move |e| e.with_place(Site::Key(key.into()))
}
