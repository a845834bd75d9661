//! Puts the models of a world where its `<state>` has them. Gazebo classic writes one into every world that it saves, and
//! shows the world so. All poses in it are in the world.

use std::collections::HashMap;

use glam::DAffine3;
use roxmltree::Node;

use super::element::{child, text};
use super::model::Model;
use super::pose::SdfPose;
use crate::objects::xml::children;
use perirobot_march::error::Issue;

/// How far a model is moved at least, in metres and in parts of a turn's matrix, to be told as moved.
const MOVED: f64 = 1e-6;

/// Moves the models of a world, and returns how many stand elsewhere than their own poses say.
pub(super) fn apply(state: Node, world: &mut Model) -> Result<usize, Issue> {
    place_models(state, DAffine3::IDENTITY, &mut world.models)
}

/// What of a state is not read, by its name.
pub(super) fn unread_parts(state: Node) -> impl Iterator<Item = &'static str> {
    let inserted = children(state, "insertions").flat_map(|list| children(list, "model"));
    let deleted = children(state, "deletions").flat_map(|list| children(list, "name"));
    let scaled =
        children(state, "model").filter(|model| text(*model, "scale").is_some_and(|scale| scale != "1 1 1"));
    (inserted.map(|_| "model inserted by state"))
        .chain(deleted.map(|_| "deletion by state"))
        .chain(scaled.map(|_| "scale of a model in state"))
}

fn place_models(state: Node, world_from_parent: DAffine3, models: &mut [Model]) -> Result<usize, Issue> {
    let states = index_by_name(state, "model");
    let mut moved = 0;
    for model in models {
        let state = model.name.as_deref().and_then(|name| states.get(name));
        let Some((state, world_from_model)) = state.map(|state| state_pose(*state)).transpose()?.flatten()
        else {
            continue;
        };
        let pose = world_from_parent.inverse() * world_from_model;
        let stood = model.pose.relative_to.is_none() && model.pose.parent_from_own.abs_diff_eq(pose, MOVED);
        moved += usize::from(!stood);
        model.pose = SdfPose { parent_from_own: pose, relative_to: None };
        model.placement_frame = None;
        let links = index_by_name(state, "link");
        for link in &mut model.links {
            let state = links.get(link.name.as_str());
            if let Some((_, world_from_link)) = state.map(|state| state_pose(*state)).transpose()?.flatten() {
                let parent_from_own = world_from_model.inverse() * world_from_link;
                link.pose = SdfPose { parent_from_own, relative_to: None };
            }
        }
        moved += place_models(state, world_from_model, &mut model.models)?;
    }
    Ok(moved)
}

/// A state of a model or a link, and its pose in the world; none if it has none.
fn state_pose<'a, 'i>(state: Node<'a, 'i>) -> Result<Option<(Node<'a, 'i>, DAffine3)>, Issue> {
    match child(state, "pose") {
        Some(_) => Ok(Some((
            state,
            SdfPose::from_element(state).map_err(|issue| issue.with_place("state"))?.parent_from_own,
        ))),
        None => Ok(None),
    }
}

fn index_by_name<'a, 'i>(state: Node<'a, 'i>, kind: &'static str) -> HashMap<&'a str, Node<'a, 'i>> {
    children(state, kind).filter_map(|node| Some((node.attribute("name")?, node))).collect()
}
