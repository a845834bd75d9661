//! Writes bodies as one binary STL file, the same bytes every time; normals are left to the reader.

use perirobot_scene::objects::Mesh;

/// The bytes of an STL file. Its header names the program and `axes`, in words: the format knows neither unit nor axes.
pub(crate) fn bytes(bodies: &[Mesh], axes: &str) -> Vec<u8> {
    let corners = bodies.iter().flat_map(|body| {
        body.triangles.iter().map(|t| t.map(|i| body.vertices[i as usize].as_vec3().to_array()))
    });
    let corners: Vec<[[f32; 3]; 3]> = corners.collect();
    let header = format!("perirobot tests/input/generated_meshes.rs; {axes}");
    let mut bytes = format!("{header:<80}").into_bytes();
    bytes.extend((corners.len() as u32).to_le_bytes());
    for triangle in corners {
        bytes.extend([0; 12]);
        bytes.extend(triangle.as_flattened().iter().flat_map(|x| (x + 0.0).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}
