//! The cell as it is drawn: the surfaces of its objects at a moment, and their sharp edges.

use std::borrow::Cow;
use std::collections::HashMap;

use glam::DVec3;
use perirobot_march::Result;
use perirobot_page::export::glb::faces;
use perirobot_scene::objects::build::build;
use perirobot_scene::objects::{Mesh, Role, Surface};

use super::Live;

/// Two faces that meet at a larger angle have an edge: its cosine, of 30°.
const SHARP: f64 = 0.866;

/// The objects of a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenery {
    /// Each of them that has a surface of its own.
    pub things: Vec<Thing>,
}

/// An object's surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Thing {
    /// The object's name.
    pub name: String,
    /// What it is.
    pub role: Role,
    /// Its corners, in metres.
    pub corners_m: Vec<[f32; 3]>,
    /// Its triangles, by their corners.
    pub faces: Vec<[u32; 3]>,
    /// Its sharp edges, by their corners.
    pub edges: Vec<[u32; 2]>,
}

impl Live {
    /// The surfaces of a moment, read again from their files.
    ///
    /// # Errors
    /// A moment that the study does not have; a file that cannot be read any more.
    pub fn scenery(&self, moment: usize) -> Result<Scenery> {
        let cell = self.fine()?;
        let (study, world) = (&cell.study, cell.world(moment)?);
        let scenes = build(&study.scenes[world.scene], &study.sources, study.voxel_size_m)?;
        let objects = scenes[world.snapshot].objects.iter().filter(|object| !object.tag_only);
        let thing = |object: &std::sync::Arc<perirobot_scene::objects::Object>| {
            let mesh = match &object.surface {
                Surface::Mesh(mesh) => Cow::Borrowed(mesh),
                Surface::Voxels { resolution_m, keys } => Cow::Owned(faces(*resolution_m, keys)),
            };
            Thing {
                name: object.name.clone(),
                role: object.role,
                corners_m: mesh.vertices.iter().map(|corner| corner.to_array().map(|x| x as f32)).collect(),
                faces: mesh.triangles.clone(),
                edges: sharp_edges(&mesh),
            }
        };
        Ok(Scenery { things: objects.map(thing).collect() })
    }
}

/// The edges at which two faces meet at a large angle, or that only one face has. Corners at the same place are one.
fn sharp_edges(mesh: &Mesh) -> Vec<[u32; 2]> {
    let mut first_at: HashMap<[u64; 3], u32> = HashMap::new();
    let place = |corner: &DVec3| (*corner + DVec3::ZERO).to_array().map(f64::to_bits);
    let same: Vec<u32> =
        (0..).zip(&mesh.vertices).map(|(number, at)| *first_at.entry(place(at)).or_insert(number)).collect();
    let mut beside: HashMap<[u32; 2], Vec<DVec3>> = HashMap::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| mesh.vertices[corner as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let corners = triangle.map(|corner| same[corner as usize]);
        for side in 0..3 {
            let (from, to) = (corners[side], corners[(side + 1) % 3]);
            beside.entry([from.min(to), from.max(to)]).or_default().push(normal);
        }
    }
    let is_sharp = |normals: &[DVec3]| match normals {
        [one, other] => one.dot(*other) < SHARP,
        _ => true,
    };
    let mut edges: Vec<[u32; 2]> =
        beside.into_iter().filter(|(_, normals)| is_sharp(normals)).map(|(edge, _)| edge).collect();
    edges.sort_unstable();
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box has twelve edges, its diagonals are none.
    #[test]
    fn a_box_has_twelve_edges() {
        let cube = faces(0.5, &[[0, 0, 0]]);
        assert_eq!((cube.vertices.len(), cube.triangles.len()), (24, 12));
        assert_eq!(sharp_edges(&cube).len(), 12);
        // Of two cubes side by side the four edges between them are flat.
        assert_eq!(sharp_edges(&faces(0.5, &[[0, 0, 0], [1, 0, 0]])).len(), 16);
    }
}
