//! From a checked scene file to a scene: reads the meshes, tessellates the bodies and puts each object where it
//! stands. Every file is read here and nowhere else.

use glam::DVec3;
use wildmatch::WildMatch;

use super::{Mesh, Object, Optical, Role, Scene, Surface, gltf, mannequin, octomap, primitive, stl};
use crate::study::{NodeRule, ObjectSpec, SceneSpec, SurfaceSpec};
use crate::{Error, Result};

/// Reads a scene. Curved bodies stay within an eighth of a voxel of their true surface.
pub fn build(spec: &SceneSpec, voxel_size_m: f64) -> Result<Scene> {
    let mut objects = Vec::new();
    for object in &spec.objects {
        build_object(object, voxel_size_m / 8.0, &mut objects)
            .map_err(|e| Error::input(format!("{}: object {:?}", spec.path.display(), object.name), e))?;
    }
    if objects.is_empty() {
        return Err(Error::input(
            spec.path.display(),
            "nodes: every part of every object is ignored, nothing is left",
        ));
    }
    Ok(Scene { name: spec.name.clone(), objects })
}

fn build_object(object: &ObjectSpec, sag_m: f64, objects: &mut Vec<Object>) -> Result<()> {
    // A loader's message begins with the file, the value of this key.
    let at = |key: &'static str| move |e: Error| Error::Input(format!("{key} = {e}"));
    let mesh = match &object.surface {
        SurfaceSpec::Box { size_m } => primitive::cuboid(*size_m),
        SurfaceSpec::Room { size_m } => primitive::room(*size_m),
        SurfaceSpec::Plane { size_m } => primitive::plane(*size_m),
        SurfaceSpec::Sphere { radius_m } => primitive::sphere(*radius_m, sag_m),
        SurfaceSpec::Cylinder { radius_m, height_m } => primitive::cylinder(*radius_m, *height_m, sag_m),
        SurfaceSpec::Capsule { radius_m, length_m } => primitive::capsule(*radius_m, *length_m, sag_m),
        SurfaceSpec::Mannequin(path) => {
            mannequin::body(&mannequin::read_keypoints(path).map_err(at("mannequin"))?, sag_m)
        }
        SurfaceSpec::Stl { path, scale, y_up } => {
            let mesh = stl::load(path).map_err(at("mesh"))?.scaled(*scale);
            if *y_up { z_up(mesh) } else { mesh }
        }
        SurfaceSpec::Octomap(path) => {
            let map = octomap::read(path).map_err(at("octomap"))?;
            let surface = Surface::Voxels { resolution_m: map.resolution_m, keys: map.occupied };
            objects.push(placed(object, object.name.clone(), object.role, object.optical, surface));
            return Ok(());
        }
        SurfaceSpec::Gltf(path) => return gltf_parts(object, gltf::load(path).map_err(at("mesh"))?, objects),
    };
    objects.push(solid(object, object.name.clone(), object.role, object.optical, mesh));
    Ok(())
}

/// A glTF file becomes one object for the nodes that no rule names, under the object's own name, and one for each
/// rule, named `object/pattern`. A node follows the first rule that matches it or a node above it.
fn gltf_parts(object: &ObjectSpec, nodes: Vec<gltf::NodeMesh>, objects: &mut Vec<Object>) -> Result<()> {
    let rules: Vec<WildMatch> = object.nodes.iter().map(|rule| WildMatch::new(&rule.r#match)).collect();
    let mut rest = Mesh::default();
    let mut parts = vec![Mesh::default(); rules.len()];
    let mut matched = vec![false; rules.len()];
    for node in &nodes {
        let covers = |rule: &WildMatch| node.names.iter().any(|name| rule.matches(name));
        for (seen, rule) in matched.iter_mut().zip(&rules) {
            *seen |= covers(rule);
        }
        match rules.iter().position(covers) {
            Some(rule) => parts[rule].append(&node.mesh),
            None => rest.append(&node.mesh),
        }
    }
    if let Some(rule) = matched.iter().position(|&seen| !seen) {
        let mut names: Vec<&str> =
            nodes.iter().filter_map(|node| node.names.last()).map(String::as_str).collect();
        names.truncate(12);
        return Err(Error::Input(format!(
            "nodes.match = {:?}: no node with triangles has such a name; there are {}",
            object.nodes[rule].r#match,
            names.join(", ")
        )));
    }
    if let Some(rule) = parts.iter().position(|mesh| mesh.triangles.is_empty()) {
        return Err(Error::Input(format!(
            "nodes.match = {:?}: every node that it names already follows a rule above it; the first that matches \
             counts, so put it first",
            object.nodes[rule].r#match
        )));
    }
    if !rest.triangles.is_empty() {
        objects.push(solid(object, object.name.clone(), object.role, object.optical, rest));
    }
    for (NodeRule { r#match, role, optical, ignore }, mesh) in object.nodes.iter().zip(parts) {
        if !ignore {
            let name = format!("{}/{match}", object.name);
            objects.push(solid(
                object,
                name,
                role.unwrap_or(object.role),
                optical.unwrap_or(object.optical),
                mesh,
            ));
        }
    }
    Ok(())
}

fn solid(spec: &ObjectSpec, name: String, role: Role, optical: Optical, mesh: Mesh) -> Object {
    placed(spec, name, role, optical, Surface::Mesh(mesh.transformed(spec.rotation, spec.position_m)))
}

fn placed(spec: &ObjectSpec, name: String, role: Role, optical: Optical, surface: Surface) -> Object {
    Object { name, role, interior: spec.interior, optical, tag_only: spec.tag_only, surface }
}

/// A y-up mesh turned to z up: (x, y, z) → (x, −z, y), exactly.
fn z_up(mut mesh: Mesh) -> Mesh {
    mesh.vertices.iter_mut().for_each(|v| *v = DVec3::new(v.x, -v.z, v.y));
    mesh
}
