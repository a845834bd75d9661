//! Reads the elements of SDF files into a tree of models, the included ones with them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use roxmltree::Node;

use super::geometry::{Body, shape};
use super::model::{Link, Model, OWN, child, children, text};
use super::pose::Pose;
use super::{File, SdfFile};
use crate::error::{Issue, Site};
use crate::scene::urdf::Geometry;
use crate::scene::xml;
use crate::source::Sources;
use crate::{Error, Result};

/// Deepest nesting of models and includes.
const MAX_DEPTH: usize = 32;
/// Most models of a world: a file may include itself.
const MOST_MODELS: usize = 20_000;
/// Elements that make or carry something, and are not read.
const NOT_READ: [&str; 12] = [
    "light",
    "plugin",
    "sensor",
    "actor",
    "population",
    "road",
    "state",
    "projector",
    "particle_emitter",
    "audio_source",
    "gripper",
    "battery",
];

/// The files of a world.
pub(super) struct Reader<'a> {
    file: &'a SdfFile,
    sources: &'a Sources,
    models: usize,
    /// What was left out, and how often.
    pub(super) left_out: BTreeMap<String, usize>,
}

impl Reader<'_> {
    pub(super) fn new<'a>(file: &'a SdfFile, sources: &'a Sources) -> Reader<'a> {
        Reader { file, sources, models: 0, left_out: BTreeMap::new() }
    }

    /// The whole file: its only world, or the models that it has without one.
    pub(super) fn world(&mut self) -> Result<Model> {
        let path: File = self.file.path.as_path().into();
        let text = self.sources.text(&path)?;
        let at = |issue: Issue| issue.at(&*path);
        let document = xml::parse(&text).map_err(at)?;
        let root = sdf(document.root_element()).map_err(at)?;
        let mut worlds = children(root, "world");
        let world = match (worlds.next(), worlds.next()) {
            (Some(_), Some(_)) => {
                return Err(at(Issue::says("has several worlds").wanted("leave one")).into());
            }
            (Some(world), None) => world,
            (None, _) => root,
        };
        self.model(world, None, &path, 0)
    }

    /// A model, or a world, which has no name.
    fn model(&mut self, node: Node, name: Option<String>, file: &File, depth: usize) -> Result<Model> {
        let place = name.as_ref().map_or("world".into(), |name| format!("model {name:?}"));
        let at = |issue: Issue| Error::from(issue.at(place.clone()).at(&**file));
        self.models += 1;
        if depth > MAX_DEPTH || self.models > MOST_MODELS {
            let what = format!("has models more than {MAX_DEPTH} deep, or more than {MOST_MODELS}");
            return Err(at(Issue::too_large(what).wanted("does a file include itself?")));
        }
        let is_world = name.is_none();
        let mut model = Model {
            name,
            file: file.clone(),
            pose: if is_world { Pose::default() } else { Pose::of(node).map_err(at)? },
            placement_frame: node.attribute("placement_frame").filter(|_| !is_world).map(String::from),
            is_merged: false,
            links: Vec::new(),
            frames: Vec::new(),
            models: Vec::new(),
        };
        for part in node.children().filter(Node::is_element) {
            let named = || {
                let name = part.attribute("name").filter(|name| !name.is_empty());
                name.map(String::from).ok_or_else(|| {
                    at(Issue::says(format!("one of its <{}>", part.tag_name().name()))
                        .wanted("must have a name"))
                })
            };
            match part.tag_name().name() {
                "link" => {
                    let name = named()?;
                    let link = self.link(part, name.clone(), file);
                    model.links.push(link.map_err(|issue| at(issue.at(format!("link {name:?}"))))?);
                }
                "model" => {
                    let inner = self.model(part, Some(named()?), file, depth + 1)?;
                    model.models.push(inner);
                }
                "include" => model.models.extend(self.include(part, file, &place, depth)?),
                kind @ ("joint" | "frame") => {
                    let name = named()?;
                    let pose = Pose::of(part).map_err(|issue| at(issue.at(format!("{kind} {name:?}"))))?;
                    let default = match kind {
                        "joint" => text(part, "child"),
                        _ => part.attribute("attached_to").filter(|name| !name.is_empty()),
                    };
                    model.frames.push((name, pose, default.unwrap_or(OWN).into()));
                }
                other => self.leave_out(other),
            }
        }
        Ok(model)
    }

    fn link(&mut self, node: Node, name: String, file: &File) -> Result<Link, Issue> {
        let kind = match self.file.geometry {
            Geometry::Collision => "collision",
            Geometry::Visual => "visual",
        };
        let mut bodies = Vec::new();
        for part in node.children().filter(Node::is_element) {
            let tag = part.tag_name().name();
            if tag != kind {
                self.leave_out(tag);
                continue;
            }
            let at =
                |issue: Issue| issue.at(format!("{kind} {:?}", part.attribute("name").unwrap_or_default()));
            let pose = Pose::of(part).map_err(at)?;
            if let Some(other) = pose.relative_to.as_ref().filter(|other| **other != name) {
                return Err(at(Issue::unsupported(format!("its pose is relative to {other:?}"))
                    .wanted("write it relative to its link, or give that frame a link")));
            }
            let geometry = child(part, "geometry").ok_or_else(|| at(Issue::missing("geometry")))?;
            match shape(geometry, |uri| self.resolve(uri, file)).map_err(at)? {
                Ok(shape) => bodies.push(Body { pose, shape }),
                Err(Some(left)) => *self.left_out.entry(left).or_default() += 1,
                Err(None) => {}
            }
        }
        Ok(Link { name, pose: Pose::of(node)?, bodies })
    }

    /// The model that an `<include>` means, if it is on this machine.
    fn include(&mut self, node: Node, file: &File, place: &str, depth: usize) -> Result<Option<Model>> {
        let at = |issue: Issue| Error::from(issue.at("include").at(place).at(&**file));
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
        let path: File = self.model_file(self.resolve(uri, file).map_err(at)?)?.into();
        let text_of_file =
            self.sources.text(&path).map_err(|e| e.at(Site::Key(uri.into())).at("include").at(&**file))?;
        let inside = |issue: Issue| Error::from(issue.at(&*path));
        let document = xml::parse(&text_of_file).map_err(inside)?;
        let root = sdf(document.root_element()).map_err(inside)?;
        let Some(model) = child(root, "model") else {
            if ["light", "actor"].iter().all(|kind| child(root, kind).is_none()) {
                return Err(inside(Issue::says("has no model to include")));
            }
            root.children().filter(Node::is_element).for_each(|part| self.leave_out(part.tag_name().name()));
            return Ok(None);
        };
        let name = text(node, "name").or(model.attribute("name")).unwrap_or_default().to_string();
        let mut model = self.model(model, Some(name), &path, depth + 1)?;
        if child(node, "pose").is_some() {
            model.pose = Pose::of(node).map_err(at)?;
        }
        model.placement_frame = text(node, "placement_frame").map(String::from).or(model.placement_frame);
        model.is_merged = matches!(node.attribute("merge"), Some("true" | "1"));
        Ok(Some(model))
    }

    /// Where a uri leads, seen from a file.
    fn resolve(&self, uri: &str, from: &Path) -> Result<PathBuf, Issue> {
        let folder = from.parent().unwrap_or(Path::new(""));
        if let Some(rest) = uri.strip_prefix("model://") {
            let found = self.file.models.iter().map(|models| models.join(rest)).find(|path| path.exists());
            return found.ok_or_else(|| {
                Issue::says(format!("{uri:.200} is in none of the folders of models"))
                    .wanted("name the folder that has it, as in models = [\"models\"]")
            });
        }
        match uri.split_once("://") {
            Some(("file", path)) => Ok(folder.join(path)),
            Some((scheme, _)) => Err(Issue::unsupported(format!("{scheme:.20}:// is not supported"))
                .wanted("write model://name/… or a path from the file's folder")),
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
        let document = xml::parse(&text).map_err(|issue| issue.at(&config))?;
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
        other => Err(Issue::says(format!("its root is <{other:.40}>")).wanted("an SDF's is <sdf>")),
    }
}
