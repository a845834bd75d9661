//! Parses the text of a URDF into the parser crate's structs, with a place in every message.
//!
//! The parser itself names no place and ignores words that should be numbers, so the text is checked first.

use std::path::Path;

use roxmltree::{Document, Node};
use urdf_rs::Robot;

use crate::error::{Argument, Issue, Words};
use crate::scene::xml;

/// Deepest nesting of elements: a URDF needs 5, and the parser recurses.
const MAX_DEPTH: usize = 64;
/// Elements of links and joints that are not read.
const NEEDLESS: [&str; 5] = ["material", "inertial", "dynamics", "calibration", "safety_controller"];

/// Reads a URDF's text; `path` is for the command that expands it.
pub(super) fn read(path: &Path, text: &str) -> Result<Robot, Issue> {
    let document = xml::parse(text).map_err(|issue| match text.contains("<xacro:") {
        true => expand(path),
        false => issue,
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        return Err(Issue::says(format!("its root is <{:.40}>", root.tag_name().name()))
            .wanted("a URDF's is <robot>"));
    }
    refuse_depth(root)?;
    for node in root.descendants().filter(Node::is_element) {
        if is_macro(&node) {
            return Err(expand(path));
        }
        // The rest of a file belongs to simulators and drivers.
        if is_described(&node) {
            check_vectors(&node).map_err(|issue| issue.at(place(&document, &node)))?;
        }
    }
    for joint in children(root, "joint") {
        check_limit(&joint).map_err(|issue| issue.at(place(&document, &joint)))?;
    }
    let needed = needed(root, text);
    urdf_rs::read_from_string(&needed)
        .map_err(|e| wrong_element(&document, text).unwrap_or(Issue::damaged(e.to_string())))
}

/// The text of a document without elements that neither shape nor motion needs: files that every ROS tool
/// reads have empty textures and odd inertias, at which the parser would stop.
fn needed(element: Node, text: &str) -> String {
    let root = element.document().root_element();
    let is_needless = |node: &Node| {
        let tag = node.tag_name().name();
        let is_top = node.parent_element() == Some(root);
        node.is_element() && (NEEDLESS.contains(&tag) || (is_top && !["link", "joint"].contains(&tag)))
    };
    let mut needed = String::with_capacity(element.range().len());
    let mut from = element.range().start;
    for needless in element.descendants().filter(is_needless) {
        let range = needless.range();
        // One inside another is gone already.
        if range.start >= from {
            needed += &text[from..range.start];
            from = range.end;
        }
    }
    needed + &text[from..element.range().end]
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
        .wanted(format!("run `xacro {from} > {to}` (or `ros2 run xacro xacro {from} > {to}`) and name {to}"))
        .cure(
            Words::from("a file that ends in .xacro is expanded by ")
                + Argument::Xacro
                + ", which runs that program (ROS has it, and so has `pip install xacro`)",
        )
}

/// An expanded file may still declare the xacro namespace; only its elements and substitutions need
/// expanding.
fn is_macro(node: &Node) -> bool {
    let unexpanded = |value: &str| value.contains("${") || value.contains("$(");
    node.tag_name().namespace().is_some_and(|uri| uri.ends_with("/xacro"))
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
                .wanted("no URDF needs that"));
        }
        open.extend(node.children().filter(Node::is_element).map(|child| (child, depth + 1)));
    }
    Ok(())
}

fn children<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

/// The parser skips words that are no numbers, so `0 o.1 0 0` would pass.
fn check_vectors(node: &Node) -> Result<(), Issue> {
    for name in ["xyz", "rpy", "size", "scale"] {
        let Some(value) = node.attribute(name) else { continue };
        let numbers: Option<Vec<f64>> = value.split_whitespace().map(|word| word.parse().ok()).collect();
        if numbers.is_none_or(|numbers| numbers.len() != 3 || numbers.iter().any(|x| !x.is_finite())) {
            let tag = node.tag_name().name();
            return Err(
                Issue::says(format!("<{tag} {name} = {value:.60?}>")).wanted("must be three finite numbers")
            );
        }
    }
    Ok(())
}

fn check_limit(joint: &Node) -> Result<(), Issue> {
    let Some(kind @ ("revolute" | "prismatic")) = joint.attribute("type") else { return Ok(()) };
    if children(*joint, "limit").next().is_some() {
        return Ok(());
    }
    let cure = if kind == "revolute" { ", or make it continuous" } else { "" };
    Err(Issue::says(format!("is {kind} and has no <limit>"))
        .wanted(format!("give it lower, upper, effort and velocity{cure}")))
}

/// The link or joint that an element is in, with the element's line.
fn place(document: &Document, node: &Node) -> String {
    let named = node.ancestors().find(|n| n.has_tag_name("link") || n.has_tag_name("joint")).unwrap_or(*node);
    let line = document.text_pos_at(node.range().start).row;
    let name = named.attribute("name").unwrap_or_default();
    format!("{} {name:?} (line {line})", named.tag_name().name())
}

/// The first link or joint that cannot be read by itself, and why.
fn wrong_element(document: &Document, text: &str) -> Option<Issue> {
    let root = document.root_element();
    children(root, "link").chain(children(root, "joint")).find_map(|node| {
        let alone = format!("<robot name=\"alone\">{}</robot>", needed(node, text));
        let error = urdf_rs::read_from_string(&alone).err()?;
        Some(Issue::damaged(error.to_string()).at(place(document, &node)))
    })
}
