//! Reads the text of a URDF into plain structs, with a place in every message. `model` checks what they say.

use std::path::Path;

use glam::{DMat3, DQuat};
use roxmltree::Node;

use crate::objects::xml::{Xml, children};
use crate::pose::{from_rpy, unit_quaternion};
use perirobot_march::error::{Argument, Issue, Words};

/// Deepest nesting of elements: a URDF needs 5.
const MAX_DEPTH: usize = 64;

/// No angle is larger; beyond it there are slips of the pen.
const LARGEST_RAD: f64 = 1e6;

/// A robot as it is written.
pub(super) struct Robot {
    pub(super) links: Vec<LinkElement>,
    pub(super) joints: Vec<JointElement>,
}

/// A link as it is written.
pub(super) struct LinkElement {
    pub(super) name: String,
    pub(super) collision: Vec<LinkBody>,
    pub(super) visual: Vec<LinkBody>,
}

/// A shape, and where it is in its link.
pub(super) struct LinkBody {
    pub(super) origin: OriginElement,
    pub(super) geometry: Geometry,
}

/// Where something is in the frame of something else; metres.
#[derive(Debug)]
pub(super) struct OriginElement {
    pub(super) xyz: [f64; 3],
    pub(super) rotation: DMat3,
}

/// A shape as it is written; metres.
pub(super) enum Geometry {
    Box { size: [f64; 3] },
    Cylinder { radius: f64, length: f64 },
    Capsule { radius: f64, length: f64 },
    Sphere { radius: f64 },
    Mesh { filename: String, scale: [f64; 3] },
}

/// A joint as it is written.
pub(super) struct JointElement {
    pub(super) name: String,
    pub(super) kind: JointKind,
    pub(super) origin: OriginElement,
    pub(super) parent: String,
    pub(super) child: String,
    pub(super) axis: [f64; 3],
    pub(super) limits: [f64; 2],
    pub(super) mimic: Option<Mimic>,
}

/// How a joint moves.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum JointKind {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Floating,
    Planar,
    Spherical,
}

/// The joint that leads another one, and how.
pub(super) struct Mimic {
    pub(super) joint: String,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

/// The versions of the format that changed what is read here.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Version([u32; 2]);

impl Version {
    const QUATERNIONS: Version = Version([1, 1]);
    const NO_LIMIT_IS_NONE: Version = Version([1, 2]);

    /// That of a file; 1.0 where it says nothing that makes sense, as ROS has it.
    fn from_root(root: Node) -> Version {
        let read = |text: &str| {
            let (major, minor) = text.trim().split_once('.')?;
            Some(Version([major.parse().ok()?, minor.parse().ok()?]))
        };
        root.attribute("version").and_then(read).unwrap_or(Version([1, 0]))
    }
}

/// Reads a URDF's text; `path` is for the command that expands it.
pub(super) fn read(path: &Path, text: &str) -> Result<Robot, Issue> {
    let of_xacro = |issue| match text.contains("<xacro:") {
        true => expand(path),
        false => issue,
    };
    let xml = Xml::scan(text).map_err(of_xacro)?;
    let document = xml.document().map_err(of_xacro)?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        return Err(Issue::says(format!("its root is <{:.40}>", root.tag_name().name()))
            .with_advice("a URDF's is <robot>"));
    }
    refuse_depth(root)?;
    // What the scan made of `xmlns:x = "http://www.ros.org/wiki/xacro"`.
    let declared = |uri: &str| uri.ends_with("/xacro");
    let declared = root.attributes().filter(|a| declared(a.value())).filter_map(|a| a.name().split_once('.'));
    let prefixes: Vec<&str> = declared.map(|(_, prefix)| prefix).chain(["xacro"]).collect();
    if root.descendants().any(|node| node.is_element() && is_macro(&node, &prefixes)) {
        return Err(expand(path));
    }
    let version = Version::from_root(root);
    // The rest of a file belongs to simulators and drivers.
    let links = children(root, "link").map(|node| link(node, version));
    let joints = children(root, "joint").map(|node| joint(node, version));
    Ok(Robot { links: links.collect::<Result<_, _>>()?, joints: joints.collect::<Result<_, _>>()? })
}

fn link(node: Node, version: Version) -> Result<LinkElement, Issue> {
    let bodies = |kind| {
        let body = |body: Node| {
            Ok(LinkBody {
                origin: origin(body, version)?,
                geometry: geometry(required_child(body, "geometry")?)?,
            })
        };
        children(node, kind).map(body).collect::<Result<_, Issue>>()
    };
    Ok(LinkElement {
        name: text_of(node, "name")?,
        collision: bodies("collision")?,
        visual: bodies("visual")?,
    })
}

fn geometry(node: Node) -> Result<Geometry, Issue> {
    let Some(shape) = node.children().find(Node::is_element) else {
        return Err(wrong(node, "<geometry>".into(), "must hold a box, cylinder, capsule, sphere or mesh"));
    };
    Ok(match shape.tag_name().name() {
        "box" => Geometry::Box { size: needed_vector(shape, "size")? },
        "cylinder" => Geometry::Cylinder {
            radius: needed_number(shape, "radius")?,
            length: needed_number(shape, "length")?,
        },
        "capsule" => Geometry::Capsule {
            radius: needed_number(shape, "radius")?,
            length: needed_number(shape, "length")?,
        },
        "sphere" => Geometry::Sphere { radius: needed_number(shape, "radius")? },
        "mesh" => Geometry::Mesh {
            filename: text_of(shape, "filename")?,
            scale: numbers(shape, "scale")?.unwrap_or([1.0; 3]),
        },
        other => {
            return Err(wrong(
                shape,
                format!("<{other:.40}>"),
                "must be a box, cylinder, capsule, sphere or mesh",
            ));
        }
    })
}

fn joint(node: Node, version: Version) -> Result<JointElement, Issue> {
    let written = text_of(node, "type")?;
    let kind = match written.as_str() {
        "fixed" => JointKind::Fixed,
        "revolute" => JointKind::Revolute,
        "continuous" => JointKind::Continuous,
        "prismatic" => JointKind::Prismatic,
        "floating" => JointKind::Floating,
        "planar" => JointKind::Planar,
        "spherical" => JointKind::Spherical,
        other => {
            let rule = "must be fixed, revolute, continuous or prismatic";
            return Err(wrong(node, format!("<joint type = {other:.60?}>"), rule));
        }
    };
    let limit = children(node, "limit").next();
    if limit.is_none() && matches!(kind, JointKind::Revolute | JointKind::Prismatic) {
        let cure = if kind == JointKind::Revolute { ", or make it continuous" } else { "" };
        let rule = format!("give it lower, upper, effort and velocity{cure}");
        return Err(wrong(node, format!("is {written} and has no <limit>"), rule));
    }
    let unsaid = if version >= Version::NO_LIMIT_IS_NONE { f64::INFINITY } else { 0.0 };
    let bound = |name, unsaid: f64| match limit {
        Some(limit) => Ok(number(limit, name)?.unwrap_or(unsaid)),
        None => Ok(unsaid),
    };
    let mimic = children(node, "mimic").next().map(|mimic| {
        let [multiplier, offset] = [number(mimic, "multiplier")?, number(mimic, "offset")?];
        let [multiplier, offset] = [multiplier.unwrap_or(1.0), offset.unwrap_or(0.0)];
        Ok(Mimic { joint: text_of(mimic, "joint")?, multiplier, offset })
    });
    let axis = children(node, "axis").next().map(|axis| needed_vector(axis, "xyz"));
    Ok(JointElement {
        name: text_of(node, "name")?,
        kind,
        origin: origin(node, version)?,
        parent: text_of(required_child(node, "parent")?, "link")?,
        child: text_of(required_child(node, "child")?, "link")?,
        axis: axis.transpose()?.unwrap_or([1.0, 0.0, 0.0]),
        limits: [bound("lower", -unsaid)?, bound("upper", unsaid)?],
        mimic: mimic.transpose()?,
    })
}

/// Where an element is, by its `<origin>`.
fn origin(node: Node, version: Version) -> Result<OriginElement, Issue> {
    let Some(origin) = children(node, "origin").next() else {
        return Ok(OriginElement { xyz: [0.0; 3], rotation: DMat3::IDENTITY });
    };
    let xyz = numbers(origin, "xyz")?.unwrap_or([0.0; 3]);
    let rpy = numbers(origin, "rpy")?;
    let quaternion: Option<[f64; 4]> = match version >= Version::QUATERNIONS {
        true => numbers(origin, "quat_xyzw")?,
        false => None,
    };
    if rpy.is_some_and(|rpy| rpy.iter().any(|angle| angle.abs() > LARGEST_RAD)) {
        let rule = format!("must be angles from -{LARGEST_RAD} to {LARGEST_RAD}");
        return Err(wrong(
            origin,
            attribute_text(origin, "rpy", origin.attribute("rpy").unwrap_or_default()),
            rule,
        ));
    }
    let rotation = match (rpy, quaternion.map(DQuat::from_array)) {
        (Some(_), Some(_)) => {
            return Err(wrong(origin, "<origin>".into(), "must have rpy or quat_xyzw, not both"));
        }
        (_, Some(turn)) => unit_quaternion(turn).map(DMat3::from_quat).ok_or_else(|| {
            wrong(origin, "<origin quat_xyzw>".into(), "must be a quaternion of finite length")
        })?,
        (rpy, None) => from_rpy(rpy.unwrap_or([0.0; 3])),
    };
    Ok(OriginElement { xyz, rotation })
}

/// The first child of a name.
fn required_child<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> Result<Node<'a, 'i>, Issue> {
    let missing = || wrong(node, format!("<{}>", node.tag_name().name()), format!("must hold <{name}>"));
    children(node, name).next().ok_or_else(missing)
}

fn text_of(node: Node, name: &str) -> Result<String, Issue> {
    let missing =
        || wrong(node, format!("<{}>", node.tag_name().name()), format!("must have {name} = \"…\""));
    node.attribute(name).map(String::from).ok_or_else(missing)
}

fn needed_number(node: Node, name: &str) -> Result<f64, Issue> {
    text_of(node, name)?;
    Ok(number(node, name)?.unwrap_or_default())
}

fn needed_vector(node: Node, name: &str) -> Result<[f64; 3], Issue> {
    text_of(node, name)?;
    Ok(numbers(node, name)?.unwrap_or_default())
}

/// A number, finite or not: what it may be depends on what it is for.
fn number(node: Node, name: &str) -> Result<Option<f64>, Issue> {
    let Some(value) = node.attribute(name) else { return Ok(None) };
    let odd = || wrong(node, attribute_text(node, name, value), "must be a number");
    value.trim().parse().map(Some).map_err(|_| odd())
}

/// So many finite numbers in a row.
fn numbers<const N: usize>(node: Node, name: &str) -> Result<Option<[f64; N]>, Issue> {
    let Some(value) = node.attribute(name) else { return Ok(None) };
    let all: Option<Vec<f64>> = value.split_whitespace().map(|word| word.parse().ok()).collect();
    let all = all.filter(|all| all.iter().all(|x| x.is_finite()));
    let count = if N == 3 { "three" } else { "four" };
    let odd = || wrong(node, attribute_text(node, name, value), format!("must be {count} finite numbers"));
    all.and_then(|all| all.try_into().ok()).map(Some).ok_or_else(odd)
}

/// An attribute as it is written.
fn attribute_text(node: Node, name: &str, value: &str) -> String {
    format!("<{} {name} = {value:.60?}>", node.tag_name().name())
}

/// What is wrong with an element, at its link or joint, with its line.
fn wrong(node: Node, what: String, wanted: impl Into<Words>) -> Issue {
    let named = node.ancestors().find(|n| n.has_tag_name("link") || n.has_tag_name("joint")).unwrap_or(node);
    let line = node.document().text_pos_at(node.range().start).row;
    let name = named.attribute("name").unwrap_or_default();
    Issue::says(what)
        .with_advice(wanted)
        .with_place(format!("{} {name:?} (line {line})", named.tag_name().name()))
}

/// What to do with a xacro.
pub(super) fn expand(path: &Path) -> Issue {
    let plain = path.with_extension("");
    let plain = match plain.extension() {
        Some(ending) if ending == "urdf" => plain,
        _ => plain.with_extension("urdf"),
    };
    let plain = if plain == path { plain.with_extension("expanded.urdf") } else { plain };
    let (from, to) = (path.display(), plain.display());
    Issue::unsupported("is a xacro, which only its own program expands")
        .with_advice(format!(
            "run `xacro {from} > {to}` (or `ros2 run xacro xacro {from} > {to}`) and name {to}"
        ))
        .cure(
            Words::from("a file that ends in .xacro is expanded by ")
                + Argument("xacro")
                + ", which runs that program (ROS has it, and so has `pip install xacro`)",
        )
}

/// An expanded file may still declare the prefix of xacro; only its elements and substitutions need
/// expanding.
fn is_macro(node: &Node, prefixes: &[&str]) -> bool {
    let unexpanded = |value: &str| value.contains("${") || value.contains("$(");
    node.tag_name().name().split_once('.').is_some_and(|(prefix, _)| prefixes.contains(&prefix))
        || (is_described(node) && node.attributes().any(|a| unexpanded(a.value())))
}

/// Whether the element is a link or joint of the robot, or in one.
fn is_described(node: &Node) -> bool {
    let root = node.document().root_element();
    let top = node.ancestors().find(|n| n.parent_element() == Some(root));
    top.is_some_and(|top| top.has_tag_name("link") || top.has_tag_name("joint"))
}

fn refuse_depth(root: Node) -> Result<(), Issue> {
    let mut open = vec![(root, 1)];
    while let Some((node, depth)) = open.pop() {
        if depth > MAX_DEPTH {
            return Err(Issue::too_large(format!("nests elements more than {MAX_DEPTH} deep"))
                .with_advice("no URDF needs that"));
        }
        open.extend(node.children().filter(Node::is_element).map(|child| (child, depth + 1)));
    }
    Ok(())
}
