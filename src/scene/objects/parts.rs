//! The parts of an object: reads the meshes and tessellates the bodies.

use std::collections::BTreeSet;
use std::sync::Arc;

use wildmatch::WildMatch;

use super::gltf::NodeMesh;
use super::keypoints::Keypoints;
use super::loaded::{SceneFiles, with_key};
use super::mesh_file::{MeshFormat, undo_z_up};
use super::spec::{NodeRule, ObjectSpec, SurfaceSpec, UrdfSpec};
use super::{
    Mesh, Object, Optical, Role, Surface, keypoints as joints, mannequin, octomap, primitive, sdf, urdf,
};
use crate::pose::Pose;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};

/// The parts of an object at one moment, in its own frame. What was odd about its files is a warning of the first.
pub(super) fn parts(object: &ObjectSpec, files: &mut SceneFiles, sag_m: f64) -> Result<Vec<Object>> {
    let mut parts = read(object, files, sag_m)?;
    if let Some(first) = parts.first_mut() {
        let remarks = files.sources.take_remarks().into_iter();
        first.warnings.extend(remarks.map(|remark| format!("is read from {remark}")));
    }
    Ok(parts)
}

fn read(object: &ObjectSpec, files: &mut SceneFiles, sag_m: f64) -> Result<Vec<Object>> {
    let sources = files.sources;
    let keypoints = object.keypoints.as_ref().map(|file| file.read(sources));
    let mut keypoints = keypoints.transpose().map_err(with_key("keypoints"))?;
    let mesh = match &object.surface {
        SurfaceSpec::Box { size_m } => primitive::cuboid(*size_m),
        SurfaceSpec::Room { size_m } => primitive::room(*size_m),
        SurfaceSpec::Plane { size_m } => primitive::plane(*size_m),
        SurfaceSpec::Sphere { radius_m } => primitive::sphere(*radius_m, sag_m),
        SurfaceSpec::Cylinder { radius_m, height_m } => primitive::cylinder(*radius_m, *height_m, sag_m),
        SurfaceSpec::Capsule { radius_m, length_m } => primitive::capsule(*radius_m, *length_m, sag_m),
        SurfaceSpec::Mannequin(person) => {
            let person = files.person(person).map_err(with_key("mannequin"))?;
            keypoints = (object.role == Role::Human).then_some(person);
            mannequin::body(&person, sag_m)
        }
        SurfaceSpec::Shipped(person) => {
            let person = joints::load_shipped(person)?;
            keypoints = Some(person);
            mannequin::body(&person, sag_m)
        }
        SurfaceSpec::Mesh(file) if matches!(file.format, MeshFormat::Gltf | MeshFormat::Step) => {
            let layers: Vec<WildMatch> =
                object.nodes.iter().filter_map(|rule| pattern(&rule.layer)).collect();
            // A STEP file has no animation, which the first of these reports.
            let mut nodes = match layers.is_empty() || object.animated.is_some() {
                true => files.gltf_nodes(&file.path, object.animated.as_ref())?,
                false => files.step_layers(&file.path, &layers)?,
            };
            let is_z_up = file.is_glb_z_up(sources);
            for NodeMesh { mesh, .. } in &mut nodes {
                *mesh = std::mem::take(mesh).scale(file.scale);
                if is_z_up {
                    mesh.vertices.iter_mut().for_each(|vertex| *vertex = undo_z_up(*vertex));
                }
            }
            return parts_by_rules(object, nodes, keypoints);
        }
        SurfaceSpec::Mesh(file) => file.load(sources).map_err(with_key("mesh"))?,
        SurfaceSpec::Octomap(path) => {
            let map = octomap::read(path, sources).map_err(with_key("octomap"))?;
            let surface = Surface::Voxels { resolution_m: map.resolution_m, keys: map.occupied };
            let part = part(object, object.name.clone(), object.role, object.optical, surface);
            return Ok(vec![Object { keypoints, ..part }]);
        }
        SurfaceSpec::Sdf(file) => {
            let world = sdf::load(file, sources, sag_m).map_err(with_key("sdf"))?;
            let warning = world.warning();
            let mut objects = parts_by_rules(object, world.links, keypoints)?;
            if let Some(first) = objects.first_mut() {
                first.warnings.extend(warning);
            }
            return Ok(objects);
        }
        SurfaceSpec::Urdf(robot) => return Ok(vec![urdf_robot(object, robot, files, sag_m)?]),
    };
    let surface = Surface::Mesh(mesh);
    let part = part(object, object.name.clone(), object.role, object.optical, surface);
    Ok(vec![Object { keypoints, ..part }])
}

/// The objects that a file of named nodes becomes.
fn parts_by_rules(
    object: &ObjectSpec,
    nodes: Vec<NodeMesh>,
    keypoints: Option<Keypoints>,
) -> Result<Vec<Object>> {
    let mut objects = Vec::new();
    split_by_rules(object, nodes, &mut objects)?;
    // Parts may have other roles; the joints go with the person.
    let mut people = objects.iter_mut().filter(|part| part.role == Role::Human);
    if let (Some(person), Some(_)) = (people.next(), &keypoints) {
        if let Some(other) = people.next() {
            let what =
                "are both human, and keypoints belong to one body: let one rule match all of the person";
            return Err(Error::input("nodes", format!("{:?} and {:?} {what}", person.name, other.name)));
        }
        person.keypoints = keypoints;
    }
    Ok(objects)
}

/// A compiled pattern of a key, if the key is there.
fn pattern(key: &Option<String>) -> Option<WildMatch> {
    key.as_deref().map(WildMatch::new)
}

/// The patterns of a rule.
struct Patterns {
    name: Option<WildMatch>,
    layer: Option<WildMatch>,
}

impl Patterns {
    fn new(rule: &NodeRule) -> Patterns {
        Patterns { name: pattern(&rule.r#match), layer: pattern(&rule.layer) }
    }

    fn has_name(&self, node: &NodeMesh) -> bool {
        self.name.as_ref().is_none_or(|name| node.names.iter().any(|other| name.matches(other)))
    }

    fn has_layer(&self, node: &NodeMesh) -> bool {
        self.layer.as_ref().is_none_or(|layer| node.layers.iter().any(|other| layer.matches(other)))
    }

    fn covers(&self, node: &NodeMesh) -> bool {
        self.has_name(node) && self.has_layer(node)
    }

    /// Why they match no node.
    fn miss(&self, rule: &NodeRule, nodes: &[NodeMesh]) -> Issue {
        let wrong = |key: &str, pattern: &Option<String>, what: String| {
            Issue::value(key, format!("{:?}", pattern.as_deref().unwrap_or_default()), what)
        };
        if !nodes.iter().any(|node| self.has_layer(node)) {
            let layers: BTreeSet<&str> =
                nodes.iter().flat_map(|node| &node.layers).map(String::as_str).collect();
            let what = match layers.is_empty() {
                true => {
                    "no whole solid or surface of the file is on a layer (assemblies, faces and curves do not count): \
                     select parts by match"
                        .into()
                }
                false => format!(
                    "no whole solid or surface is on such a layer (assemblies, faces and curves do not count); there are {}",
                    first_names(layers)
                ),
            };
            return wrong("nodes.layer", &rule.layer, what);
        }
        let what = match &rule.layer {
            Some(layer) if nodes.iter().any(|node| self.has_name(node)) => {
                format!("no part of such a name is on a layer {layer:?}")
            }
            _ => {
                let names: BTreeSet<&str> =
                    nodes.iter().filter_map(|node| node.names.last()).map(String::as_str).collect();
                format!("no node with triangles has such a name; there are {}", first_names(names))
            }
        };
        wrong("nodes.match", &rule.r#match, what)
    }
}

/// A list for a message.
fn first_names<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    names.into_iter().take(12).collect::<Vec<_>>().join(", ")
}

/// Nodes become one object for the nodes that no rule names, under the object's own name, and one for
/// each rule, named `object/pattern`. A node follows the first rule that matches it or a node above it.
fn split_by_rules(object: &ObjectSpec, nodes: Vec<NodeMesh>, objects: &mut Vec<Object>) -> Result<()> {
    let rules: Vec<Patterns> = object.nodes.iter().map(Patterns::new).collect();
    let mut rest = Mesh::default();
    let mut parts = vec![Mesh::default(); rules.len()];
    for node in &nodes {
        match rules.iter().position(|rule| rule.covers(node)) {
            Some(rule) => parts[rule].append(&node.mesh),
            None => rest.append(&node.mesh),
        }
    }
    let is_missed = |rule: &Patterns| !nodes.iter().any(|node| rule.covers(node));
    if let Some(rule) = rules.iter().position(is_missed) {
        return Err(rules[rule].miss(&object.nodes[rule], &nodes).into());
    }
    if let Some(rule) = parts.iter().position(|mesh| mesh.triangles.is_empty()) {
        return Err(Issue::value(
            "nodes",
            format!("{:?}", object.nodes[rule].name()),
            "every node that it names already follows a rule above it; the first that \
                matches counts, so put it first",
        )
        .into());
    }
    if !rest.triangles.is_empty() {
        let rest = Surface::Mesh(rest);
        objects.push(part(object, object.name.clone(), object.role, object.optical, rest));
    }
    for (rule, mesh) in object.nodes.iter().zip(parts) {
        if !rule.ignore {
            let name = format!("{}/{}", object.name, rule.name());
            let (role, optical) = (rule.role.unwrap_or(object.role), rule.optical.unwrap_or(object.optical));
            let part = part(object, name, role, optical, Surface::Mesh(mesh));
            objects.push(Object { radar: rule.radar.unwrap_or(part.radar), ..part });
        }
    }
    Ok(())
}

fn part(spec: &ObjectSpec, name: String, role: Role, optical: Optical, surface: Surface) -> Object {
    Object {
        name,
        role,
        interior: spec.interior,
        optical,
        radar: spec.radar,
        shade: if role == Role::Human { spec.person_shade } else { spec.shade },
        tag_only: spec.tag_only,
        takes_unit: spec.surface.takes_unit(),
        surface,
        frame: crate::pose::Pose::ORIGIN,
        keypoints: None,
        linkage: None,
        warnings: Vec::new(),
    }
}

/// All links of a robot as one object, which keeps where they are.
fn urdf_robot(object: &ObjectSpec, robot: &UrdfSpec, files: &mut SceneFiles, sag_m: f64) -> Result<Object> {
    let sources = files.sources;
    let model =
        urdf::load(&robot.path, &robot.xacro_args, &robot.packages, sources).map_err(with_key("urdf"))?;
    let mut joints = robot.joints.clone();
    if let Some((file, time_s)) = &robot.recorded {
        let at = with_key("snapshots.animation.joints");
        let table = files.joint_table(&file.path).map_err(&at)?;
        let now = model
            .sort_recorded(table.values_at(*time_s, |joint| model.turn(joint, file.angles)), file.angles);
        joints.extend(now.map_err(|issue| at(issue.with_place(&file.path).into()))?);
    }
    let root_from_link = model.pose(&joints)?;
    let meshes = model.meshes(robot.geometry, &robot.packages, sources, sag_m).map_err(with_key("urdf"))?;
    let surface = Surface::Mesh(urdf::merge(&meshes, &root_from_link));
    let linkage = Some(Arc::new(model.linkage(&root_from_link, &Pose::ORIGIN)));
    Ok(Object { linkage, ..part(object, object.name.clone(), object.role, object.optical, surface) })
}
