//! Writes a view as files for other programs: octovis, CloudCompare, numpy, Blender. Each format has a module here,
//! with a function from a view to bytes.

pub mod glb;
pub mod npz;
pub mod octomap;
pub mod points;
mod ros;

use perirobot_decide::view::View;
use perirobot_march::Result;
use perirobot_scene::objects::Scene;
use perirobot_sweep::results::columns::{pose_names, representation_names};

/// A file with a description.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportedFile {
    /// Its name in the folder.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// A short description.
    pub holds: String,
}

/// Identifies a view: its poses, scene and representation, and the repeat if there are several.
pub(crate) fn title(view: &View) -> [String; 4] {
    let (study, choice) = (view.study, &view.choice);
    let combination = &study.combinations[choice.combination];
    let repeat = if study.repeats > 1 { format!("repeat {}", choice.repeat) } else { String::new() };
    [
        pose_names(study, combination, choice.choice),
        view.world.title(study),
        representation_names(study, combination).swap_remove(choice.representation),
        repeat,
    ]
}

/// A folder name for a view, unique per view: letters, digits, hyphens and dots.
pub fn folder_name(view: &View) -> String {
    let parts = title(view).into_iter().filter(|part| !part.is_empty());
    parts.map(|part| file_name(&part)).collect::<Vec<_>>().join(".")
}

/// Passes every file of a view to `write`, one after the other. `scene` is the source of its world.
pub fn each_file(view: &View, scene: &Scene, mut take: impl FnMut(ExportedFile) -> Result<()>) -> Result<()> {
    let mut out = |name: String, bytes, holds: String| take(ExportedFile { name, bytes, holds });
    let counts = |(occupied, free)| format!("{occupied} voxels occupied, {free} free");
    let (octree, held) = octomap::labels(view)?;
    out("labels.bt".into(), octree.clone(), counts(held))?;
    let (bytes, held) = octomap::truth(view)?;
    out("truth.bt".into(), bytes, counts(held))?;
    let names = sensor_file_names(view);
    for (member, name) in view.members.iter().zip(&names) {
        let (bytes, held) = octomap::evidence(view, member)?;
        out(format!("evidence-{name}.bt"), bytes, counts(held))?;
    }
    for (member, name) in view.members.iter().zip(&names).filter(|(member, _)| member.cast.is_some()) {
        let returns = view.returns(member);
        let holds = format!("{} points", returns.len());
        out(format!("points-{name}.ply"), points::ply(view, member, &returns), holds.clone())?;
        out(format!("points-{name}.pcd"), points::pcd(view, member, &returns), holds)?;
    }
    let [x, y, z] = view.world.grid.size;
    out("view.npz".into(), npz::bytes(view)?, format!("{x} × {y} × {z} voxels"))?;
    let (bytes, nodes) = glb::bytes(view, scene)?;
    out("cell.glb".into(), bytes, format!("{nodes} objects and sensors"))?;
    ros::files(view, &octree)?.into_iter().try_for_each(take)
}

/// Unique file names for the sensors.
fn sensor_file_names(view: &View) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for member in &view.members {
        let name = file_name(&view.study.sensors[member.sensor].name);
        let again = (2..).map(|n| format!("{name}-{n}"));
        let free = std::iter::once(name.clone()).chain(again).find(|name| !names.contains(name));
        names.extend(free);
    }
    names
}

/// A name for any file system: letters, digits, hyphens and underscores.
pub(crate) fn file_name(name: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || c == '_' { c } else { '-' };
    let plain: String = name.chars().map(plain).collect();
    plain.split('-').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests;
