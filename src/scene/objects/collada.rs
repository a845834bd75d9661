//! Reads COLLADA files (`.dae`) as one mesh in metres: the geometries of the file's scene, where its nodes
//! put them, times its `<unit>`. Materials, lights, cameras, animations and physics are passed over.
//!
//! `<up_axis>` is reported to the caller and not applied: in a URDF the file's axes are the link's axes, as
//! in RViz and MoveIt, and files are made to look right there. A mesh that a skeleton poses is refused, since
//! it would stand in its bind pose.

mod geometry;
mod nodes;

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;
use roxmltree::{Document, Node};

use super::mesh::Welder;
use super::xml::Xml;
use super::{Mesh, Up};
use crate::source::{MemoryLimit, Sources};
use perirobot_march::Result;
use perirobot_march::error::Issue;

/// Most triangles of a scene: a geometry may be placed many times.
const MOST_TRIANGLES: usize = 20_000_000;

/// Reads the triangles of a file's scene, in the file's own axes, and says which axis is up.
///
/// # Errors
/// When the file cannot be read, is no COLLADA, refers to what is not there, has a number that is none, or
/// has no triangle with an area. The message names the element and its line.
pub fn load(path: &Path, sources: &Sources) -> Result<(Mesh, Up)> {
    parse(&sources.table(path)?).map_err(|issue| issue.with_place(path).into())
}

fn parse(text: &str) -> Result<(Mesh, Up), Issue> {
    let xml = Xml::scan(text)?;
    let document = xml.document()?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(Issue::says(format!("its root is <{:.40}>", root.tag_name().name()))
            .with_advice("a COLLADA file's is <COLLADA>"));
    }
    let library = Library::new(&document, MemoryLimit::new(text.len() as u64));
    let (unit_m, up) = (unit_m(root)?, up_axis(root)?);
    let mut welder = Welder::default();
    let mut triangles = 0;
    nodes::place(&library, root, |geometry, scene_from_geometry| {
        geometry::read(&library, geometry, |corners| {
            let mut corners = corners.map(|corner| scene_from_geometry.transform_point3(corner) * unit_m);
            // A mirror turns triangles inside out.
            if scene_from_geometry.matrix3.determinant() < 0.0 {
                corners.swap(1, 2);
            }
            if !corners.iter().all(|corner| corner.is_finite()) {
                return Err(Issue::says("its transforms move a corner to infinity"));
            }
            triangles += 1;
            if triangles > MOST_TRIANGLES {
                return Err(Issue::too_large(format!("unfolds to more than {MOST_TRIANGLES} triangles"))
                    .with_advice("place fewer copies"));
            }
            welder.triangle(corners);
            Ok(())
        })
    })?;
    let mesh = welder.finish();
    if mesh.triangles.is_empty() {
        return Err(Issue::says("has no triangle in its scene").with_advice("export the surfaces as meshes"));
    }
    Ok((mesh, up))
}

/// The axis that is up; y by default, as the format says.
fn up_axis(root: Node) -> Result<Up, Issue> {
    let axis = child(root, "asset").and_then(|asset| child(asset, "up_axis"));
    match axis.map_or("Y_UP", |axis| axis.text().unwrap_or_default().trim()) {
        "X_UP" => Ok(Up::X),
        "Y_UP" => Ok(Up::Y),
        "Z_UP" => Ok(Up::Z),
        other => Err(Issue::value("<up_axis>", format!("{other:.40?}"), "must be X_UP, Y_UP or Z_UP")),
    }
}

/// Metres in one of the file's units.
fn unit_m(root: Node) -> Result<f64, Issue> {
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit"));
    let Some(meter) = unit.and_then(|unit| unit.attribute("meter")) else { return Ok(1.0) };
    match meter.trim().parse() {
        Ok(unit_m) if unit_m > 0.0 && f64::is_finite(unit_m) => Ok(unit_m),
        _ => Err(Issue::says(format!("<unit meter = {meter:.40?}>"))
            .with_advice("must be a finite number above zero")),
    }
}

/// Elements by their ids, to follow references.
struct Library<'a, 'i> {
    document: &'a Document<'i>,
    /// By the name of the element and the id, which elements of several kinds may share; of several the first.
    by_id: HashMap<(&'a str, &'a str), Node<'a, 'i>>,
    /// For the numbers that are read: those of a geometry again wherever it is placed, and its positions for each of its
    /// primitives.
    limit: RefCell<MemoryLimit>,
}

impl<'a, 'i> Library<'a, 'i> {
    fn new(document: &'a Document<'i>, limit: MemoryLimit) -> Self {
        let mut by_id = HashMap::new();
        for node in document.descendants() {
            if let Some(id) = node.attribute("id") {
                by_id.entry((node.tag_name().name(), id)).or_insert(node);
            }
        }
        Library { document, by_id, limit: RefCell::new(limit) }
    }

    /// The element of a name that an attribute refers to.
    fn follow(&self, node: Node<'a, 'i>, attribute: &str, tag: &str) -> Result<Node<'a, 'i>, Issue> {
        let url = node
            .attribute(attribute)
            .ok_or_else(|| self.with_line(node, Issue::says(format!("{attribute} is missing"))))?;
        let wrong = |rule: String| self.with_line(node, Issue::value(attribute, format!("{url:.60?}"), rule));
        let id = url
            .strip_prefix('#')
            .ok_or_else(|| wrong("must be # and the id of an element of the same file".into()))?;
        let found = self.by_id.get(&(tag, id)).copied();
        found.ok_or_else(|| wrong(format!("the file has no <{tag}> of that id")))
    }

    /// A problem in an element, with its line.
    fn with_line(&self, node: Node, issue: Issue) -> Issue {
        let line = self.document.text_pos_at(node.range().start).row;
        issue.with_place(format!("<{}> in line {line}", node.tag_name().name()))
    }

    fn numbers(&self, node: Node) -> Result<Vec<f64>, Issue> {
        let finite = |word: &str| word.parse().ok().filter(|x: &f64| x.is_finite());
        self.words(node, "finite number", finite)
    }

    fn whole_numbers(&self, node: Node) -> Result<Vec<usize>, Issue> {
        self.words(node, "index", |word| word.parse().ok())
    }

    fn words<T>(&self, node: Node, what: &str, read: impl Fn(&str) -> Option<T>) -> Result<Vec<T>, Issue> {
        let words = node.text().unwrap_or_default().split_whitespace();
        let number = |word: &str| {
            self.limit.borrow_mut().spend_on::<f64>(1).map_err(|issue| self.with_line(node, issue))?;
            read(word).ok_or_else(|| self.with_line(node, Issue::says(format!("{word:.40?} is no {what}"))))
        };
        words.map(number).collect()
    }

    fn attribute(&self, node: Node, name: &str) -> Result<Option<usize>, Issue> {
        let read = |value: &str| {
            let wrong = |_| {
                self.with_line(node, Issue::value(name, format!("{value:.40?}"), "must be a whole number"))
            };
            value.trim().parse().map_err(wrong)
        };
        node.attribute(name).map(read).transpose()
    }
}

fn children<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name(tag))
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> Option<Node<'a, 'i>> {
    children(node, tag).next()
}

/// Three corners of a triangle.
type Corners = [DVec3; 3];

#[cfg(test)]
mod tests;
