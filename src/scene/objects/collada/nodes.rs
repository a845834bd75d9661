//! Visits the nodes of a COLLADA file's scene: which geometry stands where.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, DVec4};
use roxmltree::Node;

use super::{Library, child, children};

use perirobot_march::error::Issue;

/// Deepest nesting of nodes, instances followed.
const MAX_DEPTH: usize = 256;
/// Most nodes of a scene: instances of instances double with each level.
const MOST_NODES: usize = 100_000;

/// Calls `placed` with every geometry of the file's scene and `scene_from_geometry`, in the file's units.
pub(super) fn place<'a, 'i>(
    library: &Library<'a, 'i>,
    root: Node<'a, 'i>,
    mut placed: impl FnMut(Node<'a, 'i>, DAffine3) -> Result<(), Issue>,
) -> Result<(), Issue> {
    let scene = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    let scene = scene.ok_or_else(|| {
        Issue::says("has no <scene> that shows a <visual_scene>")
            .with_advice("export the surfaces as a scene")
    })?;
    let scene = library.follow(scene, "url", "visual_scene")?;
    let mut open: Vec<_> = children(scene, "node").map(|node| (node, DAffine3::IDENTITY, 1)).collect();
    let mut seen = 0;
    while let Some((node, scene_from_parent, depth)) = open.pop() {
        seen += 1;
        if depth > MAX_DEPTH || seen > MOST_NODES {
            let what = format!("more than {MAX_DEPTH} levels or {MOST_NODES} nodes");
            return Err(library.with_line(node, Issue::too_large(what).with_advice("flatten the scene")));
        }
        let scene_from_node = scene_from_parent * parent_from_node(library, node)?;
        for entry in node.children().filter(Node::is_element) {
            match entry.tag_name().name() {
                "node" => open.push((entry, scene_from_node, depth + 1)),
                "instance_node" => {
                    open.push((library.follow(entry, "url", "node")?, scene_from_node, depth + 1));
                }
                "instance_geometry" => {
                    placed(library.follow(entry, "url", "geometry")?, scene_from_node)?;
                }
                "instance_controller" => {
                    let what = Issue::unsupported("a skeleton poses the mesh");
                    return Err(library.with_line(entry, what.with_advice("export it with the pose applied")));
                }
                _ => {}
            }
        }
    }
    Ok(())
}

/// A node's own transform: its elements multiply in the order they are written.
fn parent_from_node(library: &Library, node: Node) -> Result<DAffine3, Issue> {
    let mut parent_from_node = DAffine3::IDENTITY;
    for entry in node.children().filter(Node::is_element) {
        let tag = entry.tag_name().name();
        let count = match tag {
            "matrix" => 16,
            "translate" | "scale" => 3,
            "rotate" => 4,
            "lookat" | "skew" => {
                return Err(library.with_line(
                    entry,
                    Issue::unsupported("not supported")
                        .with_advice("export transforms as one <matrix> a node"),
                ));
            }
            _ => continue,
        };
        let numbers = library.numbers(entry)?;
        if numbers.len() != count {
            return Err(library.with_line(
                entry,
                Issue::says(format!("has {} numbers", numbers.len())).with_advice(format!("must be {count}")),
            ));
        }
        let vector = || DVec3::from_slice(&numbers);
        parent_from_node *= match tag {
            "matrix" => matrix(&numbers)
                .ok_or_else(|| library.with_line(entry, Issue::says("its last row must be 0 0 0 1")))?,
            "translate" => DAffine3::from_translation(vector()),
            "scale" => DAffine3::from_scale(vector()),
            _ => rotation(vector(), numbers[3])
                .ok_or_else(|| library.with_line(entry, Issue::says("turns about an axis that is zero")))?,
        };
    }
    Ok(parent_from_node)
}

/// Sixteen numbers, row by row.
fn matrix(numbers: &[f64]) -> Option<DAffine3> {
    let matrix = DMat4::from_cols_slice(numbers).transpose();
    (matrix.row(3) == DVec4::W).then(|| DAffine3::from_mat4(matrix))
}

/// A turn about an axis. One by nothing needs none: modellers write it for what is not turned.
fn rotation(axis: DVec3, angle_deg: f64) -> Option<DAffine3> {
    if angle_deg == 0.0 {
        return Some(DAffine3::IDENTITY);
    }
    let axis = axis.try_normalize()?;
    let (sin, cos) = libm::sincos(angle_deg.to_radians() / 2.0);
    let v = axis * sin;
    Some(DAffine3::from_mat3(DMat3::from_quat(DQuat::from_xyzw(v.x, v.y, v.z, cos))))
}
