//! Loads meshes from files of all formats, for objects of scenes, for regions and for links of robots.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::gltf::Gltf;
use super::{Mesh, Up, collada, obj, stl};
use crate::source::{Sources, accepted_formats, is_step};
use perirobot_march::{Error, Result};

/// The endings of all that can be read, for messages.
pub const ENDINGS: &str = "a .glb, .gltf, .stl, .obj, .dae or .step file";

/// What a file is, by the ending of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// `.glb` or `.gltf`: metres, y up, and turned to z up when it is read.
    Gltf,
    /// `.stl`: states neither its unit nor its up axis.
    Stl,
    /// `.obj`: states neither.
    Obj,
    /// `.dae`: states both.
    Collada,
    /// `.step`, `.stp` or `.p21`: states its unit, and is converted to glTF without a turn.
    Step,
}

/// A file, and what the user says about it.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// The file.
    pub path: PathBuf,
    /// What it is.
    pub format: MeshFormat,
    /// Metres in one of its units; for a file that states its unit, a factor that corrects it.
    pub scale: f64,
    /// The up axis of a file that does not state it. That of a glTF is y by the format's rules, and z if it breaks them.
    pub up: Up,
}

impl MeshFormat {
    /// The format of a file of this name, if it can be read.
    pub fn from_path(path: &Path) -> Option<MeshFormat> {
        let ending = path.extension()?.to_string_lossy().to_lowercase();
        match ending.as_str() {
            "glb" | "gltf" => Some(MeshFormat::Gltf),
            "stl" => Some(MeshFormat::Stl),
            "obj" => Some(MeshFormat::Obj),
            "dae" => Some(MeshFormat::Collada),
            _ => is_step(path).then_some(MeshFormat::Step),
        }
    }
}

impl MeshFile {
    /// Reads the file: metres, z up. Of a glTF or STEP file, all nodes as they stand in it.
    ///
    /// # Errors
    /// Those of [`load_mesh`].
    pub fn load(&self, sources: &Sources) -> Result<Mesh> {
        let (mesh, up) = load_mesh(&self.path, sources)?;
        let (mut mesh, up) = (mesh.scale(self.scale), up.unwrap_or(self.up));
        mesh.vertices.iter_mut().for_each(|vertex| *vertex = z_up(*vertex, up));
        if self.format == MeshFormat::Gltf && self.is_glb_z_up(sources) {
            mesh.vertices.iter_mut().for_each(|vertex| *vertex = undo_z_up(*vertex));
        }
        Ok(mesh)
    }

    /// Whether it is a glTF that is z up as it is written, or a STEP file that is. A glTF breaks a rule with that, which a
    /// remark reports.
    pub(super) fn is_glb_z_up(&self, sources: &Sources) -> bool {
        let is_z_up = self.up == Up::Z && matches!(self.format, MeshFormat::Gltf | MeshFormat::Step);
        if is_z_up && self.format == MeshFormat::Gltf {
            sources.remark(&self.path, "is taken as z up by up = \"z\", against the rules of glTF");
        }
        is_z_up
    }
}

/// Reads the triangles of a file, in its own axes and numbers: metres where the format has a unit. With them
/// comes what is up, where the file says it.
///
/// # Errors
/// When the file cannot be read, is damaged, has no triangle, or its format is not known.
pub(crate) fn load_mesh(path: &Path, sources: &Sources) -> Result<(Mesh, Option<Up>)> {
    match MeshFormat::from_path(path) {
        Some(MeshFormat::Gltf) => Ok((Gltf::load(path, sources)?.whole()?, Some(Up::Z))),
        Some(MeshFormat::Step) => {
            let mut mesh = Gltf::load(path, sources)?.whole()?;
            mesh.vertices.iter_mut().for_each(|vertex| *vertex = undo_z_up(*vertex));
            Ok((mesh, None))
        }
        Some(MeshFormat::Stl) => Ok((stl::load(path, sources)?, None)),
        Some(MeshFormat::Obj) => Ok((obj::load(path, sources)?, None)),
        Some(MeshFormat::Collada) => {
            let (mesh, up) = collada::load(path, sources)?;
            Ok((mesh, Some(up)))
        }
        None => Err(Error::input(path, accepted_formats(path, ENDINGS))),
    }
}

/// A place of a glTF as it is written, not turned from y up to z up.
pub(super) fn undo_z_up(place: DVec3) -> DVec3 {
    DVec3::new(place.x, place.z, -place.y)
}

/// A place turned to z up, exactly.
pub(super) fn z_up(place: DVec3, up: Up) -> DVec3 {
    match up {
        Up::X => DVec3::new(-place.y, -place.z, place.x),
        Up::Y => DVec3::new(place.x, -place.z, place.y),
        Up::Z => place,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_up_becomes_z() {
        let turned = |up| [DVec3::new(1.0, 2.0, 3.0), DVec3::X, DVec3::Y, DVec3::Z].map(|v| z_up(v, up));
        for (up, expected) in
            [(Up::X, [-2.0, -3.0, 1.0]), (Up::Y, [1.0, -3.0, 2.0]), (Up::Z, [1.0, 2.0, 3.0])]
        {
            let vertices = turned(up);
            assert_eq!(vertices[0].to_array(), expected, "{up:?}");
            assert_eq!(vertices[1].cross(vertices[2]), vertices[3], "{up:?}: turned, not mirrored");
            assert_eq!(undo_z_up(z_up(DVec3::new(1.0, 2.0, 3.0), Up::Y)), DVec3::new(1.0, 2.0, 3.0));
        }
    }

    #[test]
    fn formats_are_told_by_the_ending() {
        let of = |name: &str| MeshFormat::from_path(Path::new(name));
        assert_eq!(["a.GLB", "b.gltf"].map(of), [Some(MeshFormat::Gltf); 2]);
        assert_eq!(
            ["a.stl", "a.Obj", "a.dae"].map(of),
            [MeshFormat::Stl, MeshFormat::Obj, MeshFormat::Collada].map(Some)
        );
        assert_eq!(["a.STEP", "b.stp", "c.p21"].map(of), [Some(MeshFormat::Step); 3]);
        assert_eq!(["a", "a.igs", "stl", ""].map(of), [None; 4]);
    }
}
