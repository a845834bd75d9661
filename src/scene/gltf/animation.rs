//! Samples a glTF animation: where its channels put and turn the nodes at a time. Channels that blend morph
//! targets are counted, not followed.

use std::collections::{HashMap, HashSet};

use ::gltf::json::accessor::Type;
use ::gltf::json::animation::{Animation, Channel, Interpolation, Property, Sampler};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Accessor, Index};
use glam::{DQuat, DVec3, DVec4};

use super::MemoryLimit;
use super::accessor::Elements;
use super::container::Container;

use crate::error::{Issue, Site};

/// An animation of a glTF file, checked.
#[derive(Clone, Debug)]
pub struct Clip {
    index: usize,
    tracks: Vec<Track>,
    /// Channels that blend morph targets, which are not followed.
    pub morph_channels: usize,
}

/// Where an animation puts a node; properties without a channel stay as in the file.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moved {
    pub(super) translation: Option<DVec3>,
    pub(super) rotation: Option<DQuat>,
    pub(super) scale: Option<DVec3>,
}

/// One property of one node over time.
#[derive(Clone, Debug)]
struct Track {
    channel: usize,
    node: usize,
    property: Property,
    interpolation: Interpolation,
    /// Strictly increasing, at least one.
    times_s: Vec<f64>,
    /// One a time; of a cubic spline three: the tangent coming in, the value, the tangent going out. Vectors
    /// of three numbers leave w at zero; rotations are x, y, z, w.
    values: Vec<DVec4>,
}

impl Clip {
    pub(super) fn read(
        container: &Container,
        name: Option<&str>,
        budget: &mut MemoryLimit,
    ) -> Result<Clip, Issue> {
        let index = find(&container.root.animations, name)?;
        let json = &container.root.animations[index];
        let mut clip = Clip { index, tracks: Vec::new(), morph_channels: 0 };
        let mut targets = HashSet::new();
        for (number, channel) in json.channels.iter().enumerate() {
            let at = |issue: Issue| issue.at(format!("animations[{index}].channels[{number}]"));
            let (node, nodes) = (channel.target.node.value(), container.root.nodes.len());
            let property = match channel.target.path {
                Checked::Valid(Property::MorphTargetWeights) => {
                    clip.morph_channels += 1;
                    continue;
                }
                Checked::Valid(property) => property,
                Checked::Invalid => {
                    return Err(at(
                        Issue::says("must be translation, rotation, scale or weights").at("target.path")
                    ));
                }
            };
            if node >= nodes {
                return Err(at(Issue::value("target.node", node, format!("there are {nodes}"))));
            }
            if !targets.insert((node, property as u8)) {
                return Err(at(Issue::says(format!(
                    "nodes[{node}] has this property moved by another channel, too"
                ))));
            }
            let (times_s, interpolation, values) =
                curve(container, json, channel, property, budget).map_err(at)?;
            let track = Track { channel: number, node, property, interpolation, times_s, values };
            clip.tracks.push(track);
        }
        if clip.tracks.is_empty() {
            return Err(Issue::says(format!("animations[{index}] moves no node")));
        }
        Ok(clip)
    }

    /// The first and the last time of any channel, in seconds. Before and after them, nodes keep the pose of
    /// that time.
    pub fn span_s(&self) -> [f64; 2] {
        self.tracks.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[first, last], track| {
            [first.min(track.times_s[0]), last.max(track.times_s[track.times_s.len() - 1])]
        })
    }

    /// The nodes that the clip moves, at a time.
    pub(super) fn moved(&self, time_s: f64) -> Result<HashMap<usize, Moved>, Issue> {
        let mut nodes: HashMap<usize, Moved> = HashMap::new();
        for track in &self.tracks {
            let value = track.at(time_s);
            let node = nodes.entry(track.node).or_default();
            match track.property {
                Property::Translation => node.translation = Some(value.truncate()),
                Property::Scale => node.scale = Some(value.truncate()),
                _ => {
                    // Keys of opposite sign can cancel out between them.
                    let unit = value.try_normalize().ok_or_else(|| {
                        let (index, channel) = (self.index, track.channel);
                        Issue::says(format!("no rotation is left at {time_s} s"))
                            .at(format!("animations[{index}].channels[{channel}]"))
                    })?;
                    node.rotation = Some(DQuat::from_vec4(unit));
                }
            }
        }
        Ok(nodes)
    }
}

fn find(animations: &[Animation], name: Option<&str>) -> Result<usize, Issue> {
    let named =
        |name: &Option<String>| name.as_deref().map_or("(no name)".into(), |name| format!("{name:?}"));
    let mut names: Vec<String> = animations.iter().take(12).map(|animation| named(&animation.name)).collect();
    if animations.len() > names.len() {
        names.push("…".into());
    }
    let there_are = names.join(", ");
    let fits = |animation: &Animation| name.is_none_or(|name| animation.name.as_deref() == Some(name));
    let mut found = (0..animations.len()).filter(|&i| fits(&animations[i]));
    match (found.next(), found.next(), name) {
        (Some(index), None, _) => Ok(index),
        (Some(_), Some(_), None) => {
            Err(Issue::says("has several animations").wanted(format!("set clip to one of {there_are}")))
        }
        (Some(_), Some(_), Some(name)) => {
            Err(Issue::says(format!("two animations are named {name:?}")).wanted("rename one"))
        }
        (None, _, _) if animations.is_empty() => {
            Err(Issue::says("has no animation").wanted("export one with it"))
        }
        (None, _, name) => Err(Issue::says(format!("no animation is named {:?}", name.unwrap_or_default()))
            .wanted(format!("there are {there_are}"))),
    }
}

type CurveParts = (Vec<f64>, Interpolation, Vec<DVec4>);

fn curve(
    container: &Container,
    animation: &Animation,
    channel: &Channel,
    property: Property,
    budget: &mut MemoryLimit,
) -> Result<CurveParts, Issue> {
    let number = channel.sampler.value();
    let samplers = &animation.samplers;
    let sampler: &Sampler = samplers
        .get(number)
        .ok_or_else(|| Issue::value("sampler", number, format!("there are {}", samplers.len())))?;
    let at = |issue: Issue| issue.at(Site::Table(format!("samplers[{number}]")));
    let interpolation = match sampler.interpolation {
        Checked::Valid(interpolation) => interpolation,
        Checked::Invalid => {
            return Err(at(Issue::says("must be LINEAR, STEP or CUBICSPLINE").at("interpolation")));
        }
    };
    let times_s = times(container, sampler.input, budget).map_err(at)?;
    let is_rotation = property == Property::Rotation;
    let elements = match is_rotation {
        true => Elements::rotations(container, sampler.output),
        false => Elements::floats(container, sampler.output, Type::Vec3, "must be VEC3 of float"),
    }
    .map_err(|issue| at(issue.at("output")))?;
    let per_time = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    if elements.count != per_time * times_s.len() {
        let (found, needed) = (elements.count, per_time * times_s.len());
        return Err(at(Issue::says(format!("output has {found} values"))
            .wanted(format!("its {} times need {needed}", times_s.len()))));
    }
    budget.spend((elements.count * size_of::<DVec4>()) as u64)?;
    let mut values = Vec::with_capacity(elements.count);
    for i in 0..elements.count {
        let component = |c: usize| if c < 3 || is_rotation { elements.number(i, c) } else { 0.0 };
        let value = DVec4::from_array(std::array::from_fn(component));
        let is_tangent = per_time == 3 && i % 3 != 1;
        if !value.is_finite() || (is_rotation && !is_tangent && value.length() == 0.0) {
            let rule = if is_rotation { "must be finite and not zero" } else { "must be finite" };
            return Err(at(Issue::says(format!("output value {i} is {value}")).wanted(rule)));
        }
        // A key's length in f32 is not quite one, which would bend the path between keys.
        values.push(if is_rotation && per_time == 1 { value.normalize() } else { value });
    }
    Ok((times_s, interpolation, values))
}

fn times(container: &Container, input: Index<Accessor>, budget: &mut MemoryLimit) -> Result<Vec<f64>, Issue> {
    let at = |issue: Issue| issue.at("input");
    let elements = Elements::floats(container, input, Type::Scalar, "must be SCALAR of float").map_err(at)?;
    if elements.count == 0 {
        return Err(at(Issue::says("has no time")));
    }
    budget.spend((elements.count * size_of::<f64>()) as u64)?;
    let times_s: Vec<f64> = (0..elements.count).map(|i| elements.number(i, 0)).collect();
    if let Some(i) = times_s.iter().position(|time| !time.is_finite()) {
        return Err(at(Issue::says(format!("time {i} is {}", times_s[i])).wanted("must be finite")));
    }
    if let Some(i) = times_s.windows(2).position(|pair| pair[0] >= pair[1]) {
        let (before, after) = (times_s[i], times_s[i + 1]);
        return Err(at(
            Issue::says(format!("time {} is {after} after {before}", i + 1)).wanted("times must increase")
        ));
    }
    Ok(times_s)
}

impl Track {
    /// The value at a time, by the rules of glTF 2.0 (appendix C); a rotation may lack unit length.
    fn at(&self, time_s: f64) -> DVec4 {
        let last = self.times_s.len() - 1;
        // How many keys lie at or before the time.
        let after = self.times_s.partition_point(|&key| key <= time_s);
        if after == 0 {
            return self.value(0);
        }
        let key = after - 1;
        if key == last {
            return self.value(last);
        }
        let step_s = self.times_s[key + 1] - self.times_s[key];
        let t = (time_s - self.times_s[key]) / step_s;
        match self.interpolation {
            Interpolation::Step => self.value(key),
            Interpolation::Linear if self.property == Property::Rotation => {
                slerp(self.value(key), self.value(key + 1), t)
            }
            Interpolation::Linear => self.value(key).lerp(self.value(key + 1), t),
            Interpolation::CubicSpline => {
                let (t2, t3) = (t * t, t * t * t);
                let (out, into) = (self.values[3 * key + 2], self.values[3 * (key + 1)]);
                (2.0 * t3 - 3.0 * t2 + 1.0) * self.value(key)
                    + step_s * (t3 - 2.0 * t2 + t) * out
                    + (3.0 * t2 - 2.0 * t3) * self.value(key + 1)
                    + step_s * (t3 - t2) * into
            }
        }
    }

    /// The value at a key.
    fn value(&self, key: usize) -> DVec4 {
        match self.interpolation {
            Interpolation::CubicSpline => self.values[3 * key + 1],
            _ => self.values[key],
        }
    }
}

/// From one unit quaternion to another, the shorter way round, at constant speed. Its sines are `libm`'s, so
/// that two machines agree.
fn slerp(from: DVec4, to: DVec4, t: f64) -> DVec4 {
    let dot = from.dot(to);
    // A quaternion and its negative are one rotation; the nearer is the shorter way.
    let (to, dot) = if dot < 0.0 { (-to, -dot) } else { (to, dot) };
    let angle = libm::acos(dot.min(1.0));
    let sine = libm::sin(angle);
    // Between almost equal rotations the straight line is as good, and has no sine to divide by.
    if sine < 1e-9 {
        return from.lerp(to, t);
    }
    (libm::sin((1.0 - t) * angle) * from + libm::sin(t * angle) * to) / sine
}
