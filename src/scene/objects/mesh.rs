//! Moves, joins and measures triangle meshes, and welds equal corners so that closed bodies share vertices.

use std::collections::HashMap;

use glam::{DAffine3, DQuat, DVec3};

use super::Mesh;

impl Mesh {
    /// Adds another mesh's triangles; its vertices stay its own.
    ///
    /// # Panics
    /// Past 2^32 vertices, which would need 96 GiB of memory first.
    pub fn append(&mut self, other: &Mesh) {
        let base = vertex_index(self.vertices.len());
        vertex_index(self.vertices.len() + other.vertices.len());
        self.vertices.extend_from_slice(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + base)));
    }

    /// The mesh turned about the origin, then moved: a point p becomes `rotation * p + translation`.
    #[must_use]
    pub fn transform(mut self, rotation: DQuat, translation: DVec3) -> Mesh {
        for vertex in &mut self.vertices {
            *vertex = rotation * *vertex + translation;
        }
        self
    }

    /// The mesh under a transform; one that mirrors turns the triangles inside out, so they are turned back.
    #[must_use]
    pub(super) fn place(&self, transform: &DAffine3) -> Mesh {
        let mut mesh = self.clone();
        for vertex in &mut mesh.vertices {
            *vertex = transform.transform_point3(*vertex);
        }
        if transform.matrix3.determinant() < 0.0 {
            mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        mesh
    }

    /// The mesh scaled about the origin, as for a file in millimetres.
    #[must_use]
    pub(crate) fn scale(mut self, factor: f64) -> Mesh {
        for vertex in &mut self.vertices {
            *vertex *= factor;
        }
        self
    }

    /// Smallest and largest coordinates of the vertices; nothing for a mesh without vertices.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let first = *self.vertices.first()?;
        Some(self.vertices.iter().fold((first, first), |(low, high), v| (low.min(*v), high.max(*v))))
    }
}

fn vertex_index(count: usize) -> u32 {
    u32::try_from(count).expect("a mesh has fewer than 2^32 vertices")
}

/// Collects triangles, giving equal positions one vertex. Files split corners for normals and textures (or,
/// in STL, always); without this no body from a file would be closed.
#[derive(Default)]
pub(super) struct Welder {
    mesh: Mesh,
    index: HashMap<[u64; 3], u32>,
}

impl Welder {
    /// Adds a triangle unless two of its corners coincide: it covers nothing, and in a strip it joins parts
    /// that do not touch.
    pub(super) fn triangle(&mut self, corners: [DVec3; 3]) {
        if corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0] {
            return;
        }
        let triangle = corners.map(|corner| self.vertex(corner));
        self.mesh.triangles.push(triangle);
    }

    fn vertex(&mut self, position: DVec3) -> u32 {
        // -0.0 + 0.0 is 0.0, so both zeros are the same corner.
        let position = position + DVec3::ZERO;
        *self.index.entry(position.to_array().map(f64::to_bits)).or_insert_with(|| {
            self.mesh.vertices.push(position);
            vertex_index(self.mesh.vertices.len() - 1)
        })
    }

    pub(super) fn finish(self) -> Mesh {
        self.mesh
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::collections::HashMap;

    use super::*;

    /// Panics unless every edge is used equally often in both directions, as on a closed, oriented surface.
    #[track_caller]
    pub(crate) fn assert_closed(mesh: &Mesh) {
        let mut balance: HashMap<(u32, u32), i32> = HashMap::new();
        for t in &mesh.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                assert_ne!(a, b, "a triangle without area: {t:?}");
                *balance.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
            }
        }
        let open = balance.iter().find(|(_, count)| **count != 0);
        assert_eq!(open, None, "an open or wrongly turned edge");
    }

    /// Six times the enclosed volume is the sum of triple products; positive when faces look outward.
    pub(crate) fn volume(mesh: &Mesh) -> f64 {
        let corner = |i: u32| mesh.vertices[i as usize];
        mesh.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
    }

    #[test]
    fn appended_triangles_keep_their_corners() {
        let triangle = Mesh { vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y], triangles: vec![[0, 1, 2]] };
        let mut both = triangle.clone();
        both.append(&triangle.clone().transform(DQuat::IDENTITY, DVec3::Z).scale(2.0));
        assert_eq!(both.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(both.vertices[4], DVec3::new(2.0, 0.0, 2.0));
        assert_eq!(both.bounds(), Some((DVec3::ZERO, DVec3::splat(2.0))));
        assert_eq!(Mesh::default().bounds(), None);
    }

    #[test]
    fn welding_joins_equal_corners_and_drops_slivers() {
        let mut welder = Welder::default();
        welder.triangle([DVec3::ZERO, DVec3::X, DVec3::Y]);
        welder.triangle([DVec3::X, DVec3::new(-0.0, 0.0, -0.0), DVec3::Z]);
        welder.triangle([DVec3::X, DVec3::X, DVec3::Z]);
        let mesh = welder.finish();
        assert_eq!(mesh.vertices.len(), 4);
        assert_eq!(mesh.triangles, [[0, 1, 2], [1, 0, 3]]);
    }
}
