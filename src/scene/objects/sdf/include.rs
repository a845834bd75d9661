//! Reads the elements of SDF files into a tree of models, the included ones with them.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use roxmltree::Node;

use super::element::{child, text};
use super::geometry::{SdfShape, shape};
use super::model::{Model, OWN, SdfLink};
use super::pose::SdfPose;
use super::{File, SdfFile, state};
use crate::objects::urdf::GeometryUse;
use crate::objects::xml::{Xml, children};
use crate::source::{Sources, resolve_backslashes};
use crate::spelling::plural;
use perirobot_march::error::{Issue, Site};
use perirobot_march::{Error, Result};

/// Deepest nesting of models and includes.
const MAX_DEPTH: usize = 32;
/// Most models of a world: a file may include itself.
const MOST_MODELS: usize = 20_000;
/// Most links, frames and bodies of a world.
const MOST_PARTS: usize = 250_000;
/// Elements that make or carry something, and are not read.
const NOT_READ: [&str; 11] = [
    "light",
    "plugin",
    "sensor",
    "actor",
    "population",
    "road",
    "projector",
    "particle_emitter",
    "audio_source",
    "gripper",
    "battery",
];

/// The files of a world.
pub(super) struct WorldReader<'a> {
    file: &'a SdfFile,
    sources: &'a Sources,
    /// Models so far, and their links, frames and bodies.
    size: WorldSize,
    /// Files that are included, by what names them.
    included: HashMap<PathBuf, Rc<Included>>,
    /// What was left out, and how often.
    pub(super) left_out: BTreeMap<String, usize>,
}

/// How much a world has.
#[derive(Clone, Copy, Debug, Default)]
struct WorldSize {
    models: usize,
    parts: usize,
}

/// What a file has that is included.
struct Included {
    path: File,
    /// None if it only has what is left out.
    model: Option<Model>,
    size: WorldSize,
    left_out: BTreeMap<String, usize>,
}

impl WorldReader<'_> {
    pub(super) fn new<'a>(file: &'a SdfFile, sources: &'a Sources) -> WorldReader<'a> {
        let (size, included, left_out) = Default::default();
        WorldReader { file, sources, size, included, left_out }
    }

    /// The whole file: its only world, or the models that it has without one.
    pub(super) fn world(&mut self) -> Result<Model> {
        let path: File = self.file.path.as_path().into();
        let text = self.sources.text(&path)?;
        let at = |issue: Issue| issue.with_place(&*path);
        let xml = Xml::scan(&text).map_err(at)?;
        let document = xml.document().map_err(at)?;
        let root = sdf(document.root_element()).map_err(at)?;
        let mut worlds = children(root, "world");
        let world = match (worlds.next(), worlds.next()) {
            (Some(_), Some(_)) => {
                return Err(at(Issue::says("has several worlds").with_advice("leave one")).into());
            }
            (Some(world), None) => world,
            (None, _) => root,
        };
        self.model(world, None, &path, 0)
    }

    /// A model, or a world, which has no name.
    fn model(&mut self, node: Node, name: Option<String>, file: &File, depth: usize) -> Result<Model> {
        let place = name.as_ref().map_or("world".into(), |name| format!("model {name:?}"));
        let at = |issue: Issue| Error::from(issue.with_place(place.clone()).with_place(&**file));
        self.spend(depth, WorldSize { models: 1, parts: 0 }).map_err(at)?;
        let is_world = name.is_none();
        let mut model = Model {
            name,
            file: file.clone(),
            pose: if is_world { SdfPose::default() } else { SdfPose::from_element(node).map_err(at)? },
            placement_frame: node.attribute("placement_frame").filter(|_| !is_world).map(String::from),
            is_merged: false,
            links: Vec::new(),
            frames: Vec::new(),
            models: Vec::new(),
            names: Default::default(),
        };
        let mut states = Vec::new();
        for part in node.children().filter(Node::is_element) {
            let named = || {
                let name = part.attribute("name").filter(|name| !name.is_empty());
                name.map(String::from).ok_or_else(|| {
                    at(Issue::says(format!("one of its <{}>", part.tag_name().name()))
                        .with_advice("must have a name"))
                })
            };
            match part.tag_name().name() {
                "state" if is_world => states.push(part),
                "link" => {
                    self.spend(depth, WorldSize { models: 0, parts: 1 }).map_err(at)?;
                    let name = named()?;
                    let link = self.link(part, name.clone(), file);
                    model.links.push(link.map_err(|issue| at(issue.with_place(format!("link {name:?}"))))?);
                }
                "model" => {
                    let inner = self.model(part, Some(named()?), file, depth + 1)?;
                    model.models.push(inner);
                }
                "include" => model.models.extend(self.include(part, file, &place, depth)?),
                kind @ ("joint" | "frame") => {
                    self.spend(depth, WorldSize { models: 0, parts: 1 }).map_err(at)?;
                    let name = named()?;
                    let pose = SdfPose::from_element(part)
                        .map_err(|issue| at(issue.with_place(format!("{kind} {name:?}"))))?;
                    let default = match kind {
                        "joint" => text(part, "child"),
                        _ => part.attribute("attached_to").filter(|name| !name.is_empty()),
                    };
                    model.frames.push((name, pose, default.unwrap_or(OWN).into()));
                }
                other => self.leave_out(other),
            }
        }
        for node in states {
            if let count @ 1.. = state::apply(node, &mut model).map_err(at)? {
                let models = plural(count, "model");
                self.sources
                    .remark(file, format!("with {models} placed by its <state>, as in Gazebo classic"));
            }
            state::unread_parts(node).for_each(|what| *self.left_out.entry(what.into()).or_default() += 1);
        }
        Ok(model)
    }

    /// Counts what a world has, down to a depth.
    fn spend(&mut self, depth: usize, size: WorldSize) -> Result<(), Issue> {
        self.size.models += size.models;
        self.size.parts += size.parts;
        if depth > MAX_DEPTH || self.size.models > MOST_MODELS {
            let what = format!("has models more than {MAX_DEPTH} deep, or more than {MOST_MODELS}");
            return Err(Issue::too_large(what).with_advice("does a file include itself?"));
        }
        if self.size.parts > MOST_PARTS {
            let what = format!("has more than {MOST_PARTS} links, frames and bodies");
            return Err(Issue::too_large(what).with_advice("include fewer models"));
        }
        Ok(())
    }

    fn link(&mut self, node: Node, name: String, file: &File) -> Result<SdfLink, Issue> {
        let kind = match self.file.geometry {
            GeometryUse::Collision => "collision",
            GeometryUse::Visual => "visual",
        };
        let mut bodies = Vec::new();
        for part in node.children().filter(Node::is_element) {
            let tag = part.tag_name().name();
            if tag != kind {
                self.leave_out(tag);
                continue;
            }
            let at = |issue: Issue| {
                issue.with_place(format!("{kind} {:?}", part.attribute("name").unwrap_or_default()))
            };
            let pose = SdfPose::from_element(part).map_err(at)?;
            if let Some(other) = pose.relative_to.as_ref().filter(|other| **other != name) {
                return Err(at(Issue::unsupported(format!("its pose is relative to {other:?}"))
                    .with_advice("write it relative to its link, or give that frame a link")));
            }
            let geometry = child(part, "geometry").ok_or_else(|| at(Issue::missing("geometry")))?;
            match shape(geometry, |uri| self.resolve(uri, file)).map_err(at)? {
                Ok(shape) => {
                    self.spend(0, WorldSize { models: 0, parts: 1 }).map_err(at)?;
                    bodies.push(SdfShape { pose, shape });
                }
                Err(Some(left)) => *self.left_out.entry(left).or_default() += 1,
                Err(None) => {}
            }
        }
        Ok(SdfLink { name, pose: SdfPose::from_element(node)?, bodies })
    }

    /// The model that an `<include>` means, if it is on this machine.
    fn include(&mut self, node: Node, file: &File, place: &str, depth: usize) -> Result<Option<Model>> {
        let at =
            |issue: Issue| Error::from(issue.with_place("include").with_place(place).with_place(&**file));
        let uri = text(node, "uri").ok_or_else(|| at(Issue::missing("uri")))?;
        node.children().filter(Node::is_element).for_each(|part| self.leave_out(part.tag_name().name()));
        if uri.starts_with("http://") || uri.starts_with("https://") {
            self.left_out.insert(format!("include {uri:.200} (not on this machine)"), 1);
            return Ok(None);
        }
        // Every world of Gazebo has one: a light.
        if uri == "model://sun" {
            *self.left_out.entry("light".into()).or_default() += 1;
            return Ok(None);
        }
        let place = self.resolve(uri, file).map_err(at)?;
        let included = match self.included.get(&place) {
            Some(included) => included.clone(),
            None => {
                let of_uri =
                    |e: Error| e.with_place(Site::Key(uri.into())).with_place("include").with_place(&**file);
                let path: File = self.model_file(place.clone())?.into();
                let text = self.sources.text(&path).map_err(of_uri)?;
                let included = Rc::new(self.read_included(&path, &text, depth)?);
                self.included.insert(place, included.clone());
                included
            }
        };
        for (what, count) in &included.left_out {
            *self.left_out.entry(what.clone()).or_default() += count;
        }
        let Some(mut model) = included.model.clone() else { return Ok(None) };
        self.spend(depth + model.height(), included.size)
            .map_err(|issue| issue.with_place(&*included.path))?;
        if let Some(name) = text(node, "name") {
            model.name = Some(name.into());
        }
        if child(node, "pose").is_some() {
            model.pose = SdfPose::from_element(node).map_err(at)?;
        }
        model.placement_frame = text(node, "placement_frame").map(String::from).or(model.placement_frame);
        model.is_merged = matches!(node.attribute("merge"), Some("true" | "1"));
        Ok(Some(model))
    }

    /// What a file has for those who include it. Its size is not counted yet.
    fn read_included(&mut self, path: &File, text: &str, depth: usize) -> Result<Included> {
        let inside = |issue: Issue| Error::from(issue.with_place(&**path));
        let xml = Xml::scan(text).map_err(inside)?;
        let document = xml.document().map_err(inside)?;
        let root = sdf(document.root_element()).map_err(inside)?;
        let (outer_size, outer_left_out) = (self.size, std::mem::take(&mut self.left_out));
        let model = match child(root, "model") {
            Some(model) => {
                let name = model.attribute("name").unwrap_or_default().to_string();
                Some(self.model(model, Some(name), path, depth + 1)?)
            }
            None if ["light", "actor"].iter().all(|kind| child(root, kind).is_none()) => {
                return Err(inside(Issue::says("has no model to include")));
            }
            None => {
                root.children()
                    .filter(Node::is_element)
                    .for_each(|part| self.leave_out(part.tag_name().name()));
                None
            }
        };
        let inner = std::mem::replace(&mut self.size, outer_size);
        let size =
            WorldSize { models: inner.models - outer_size.models, parts: inner.parts - outer_size.parts };
        let left_out = std::mem::replace(&mut self.left_out, outer_left_out);
        Ok(Included { path: path.clone(), model, size, left_out })
    }

    /// Where a uri leads, seen from a file.
    fn resolve(&self, uri: &str, from: &Path) -> Result<PathBuf, Issue> {
        let folder = from.parent().unwrap_or(Path::new(""));
        if let Some(rest) = uri.strip_prefix("model://") {
            let all = self.file.models.iter().map(|models| models.join(rest));
            let found = all.map(|path| resolve_backslashes(&path).into_owned()).find(|path| path.exists());
            return found.ok_or_else(|| {
                Issue::says(format!("{uri:.200} is in none of the folders of models"))
                    .with_advice("name the folder that has it, as in models = [\"models\"]")
            });
        }
        match uri.split_once("://") {
            Some(("file", path)) => Ok(folder.join(path)),
            Some((scheme, _)) => Err(Issue::unsupported(format!("{scheme:.20}:// is not supported"))
                .with_advice("write model://name/… or a path from the file's folder")),
            None => Ok(folder.join(uri)),
        }
    }

    /// The SDF of a model that is named by its folder: the one of the newest version in `model.config`, else `model.sdf`.
    fn model_file(&self, path: PathBuf) -> Result<PathBuf> {
        if !path.is_dir() {
            return Ok(path);
        }
        let config = path.join("model.config");
        if !config.exists() {
            return Ok(path.join("model.sdf"));
        }
        let text = self.sources.text(&config)?;
        let xml = Xml::scan(&text).map_err(|issue| issue.with_place(&config))?;
        let document = xml.document().map_err(|issue| issue.with_place(&config))?;
        let version = |node: &Node| {
            let version = node.attribute("version").unwrap_or_default();
            version.split('.').map(|part| part.parse().unwrap_or(0)).collect::<Vec<u32>>()
        };
        let newest = children(document.root_element(), "sdf").max_by_key(version);
        let name = newest.and_then(|node| node.text()).map_or("model.sdf", str::trim);
        Ok(path.join(name))
    }

    fn leave_out(&mut self, element: &str) {
        if NOT_READ.contains(&element) {
            *self.left_out.entry(element.into()).or_default() += 1;
        }
    }
}

/// The root of an SDF file.
fn sdf<'a, 'i>(root: Node<'a, 'i>) -> Result<Node<'a, 'i>, Issue> {
    match root.tag_name().name() {
        "sdf" | "gazebo" => Ok(root),
        other => Err(Issue::says(format!("its root is <{other:.40}>")).with_advice("an SDF's is <sdf>")),
    }
}
