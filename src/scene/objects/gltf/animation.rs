//! Samples a glTF animation: where its channels put and turn the nodes at a time, and with which weights they blend
//! morph targets.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use ::gltf::json::accessor::Type;
use ::gltf::json::animation::{Animation, Channel, Interpolation, Property, Sampler};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Accessor, Index};
use glam::{DQuat, DVec3, DVec4};

use super::accessor::Elements;
use super::container::Container;
use super::{MemoryLimit, morph};

use perirobot_march::error::{Issue, Site};

/// An animation of a glTF file, checked.
#[derive(Clone, Debug)]
pub struct Clip {
    index: usize,
    tracks: Vec<Track>,
}

/// Which animation of a file is meant.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub enum WhichClip {
    /// The only one.
    #[default]
    Only,
    /// The one of this name.
    Named(String),
    /// By its number in the file, counted from 0.
    Number(usize),
}

/// Where an animation puts a node; properties without a channel stay as in the file.
#[derive(Clone, Debug, Default)]
pub(super) struct Moved {
    pub(super) translation: Option<DVec3>,
    pub(super) rotation: Option<DQuat>,
    pub(super) scale: Option<DVec3>,
    /// A weight for each morph target of its mesh.
    pub(super) weights: Option<Vec<f64>>,
}

impl Moved {
    /// Whether the node itself is elsewhere than in the file, not only its mesh blended.
    pub(super) fn is_placed(&self) -> bool {
        self.translation.is_some() || self.rotation.is_some() || self.scale.is_some()
    }
}

/// One property of one node over time; of weights, that of one morph target.
#[derive(Clone, Debug)]
struct Track {
    channel: usize,
    node: usize,
    property: Property,
    interpolation: Interpolation,
    /// Strictly increasing, at least one.
    times_s: Rc<[f64]>,
    /// One a time; of a cubic spline three: the tangent coming in, the value, the tangent going out. Vectors
    /// of three numbers leave w at zero; rotations are x, y, z, w; a weight is x.
    values: Vec<DVec4>,
}

impl Clip {
    pub(super) fn read(
        container: &Container,
        which: &WhichClip,
        budget: &mut MemoryLimit,
    ) -> Result<Clip, Issue> {
        let index = find(&container.root.animations, which)?;
        let json = &container.root.animations[index];
        let mut clip = Clip { index, tracks: Vec::new() };
        let mut targets = HashSet::new();
        for (number, channel) in json.channels.iter().enumerate() {
            let at = |issue: Issue| issue.with_place(format!("animations[{index}].channels[{number}]"));
            let (node, nodes) = (channel.target.node.value(), container.root.nodes.len());
            let property = match channel.target.path {
                Checked::Valid(property) => property,
                Checked::Invalid => {
                    return Err(at(Issue::says("must be translation, rotation, scale or weights")
                        .with_place("target.path")));
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
            let targets = match property {
                Property::MorphTargetWeights => morph::targets_of_node(&container.root, node).map_err(at)?,
                _ => 1,
            };
            // Exporters leave channels behind whose targets they took away.
            if targets == 0 {
                continue;
            }
            let SamplerCurve { times_s, interpolation, values } =
                curve(container, json, channel, (property, targets), budget).map_err(at)?;
            clip.tracks.extend(values.into_iter().map(|values| Track {
                channel: number,
                node,
                property,
                interpolation,
                times_s: times_s.clone(),
                values,
            }));
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
    pub(super) fn move_nodes(&self, time_s: f64) -> Result<HashMap<usize, Moved>, Issue> {
        let mut nodes: HashMap<usize, Moved> = HashMap::new();
        for track in &self.tracks {
            let value = track.sample(time_s);
            let node = nodes.entry(track.node).or_default();
            match track.property {
                Property::Translation => node.translation = Some(value.truncate()),
                Property::Scale => node.scale = Some(value.truncate()),
                // The tracks of a channel are in the order of its targets.
                Property::MorphTargetWeights => node.weights.get_or_insert_default().push(value.x),
                Property::Rotation => {
                    // Keys of opposite sign can cancel out between them.
                    let unit = value.try_normalize().ok_or_else(|| {
                        let (index, channel) = (self.index, track.channel);
                        Issue::says(format!("no rotation is left at {time_s} s"))
                            .with_place(format!("animations[{index}].channels[{channel}]"))
                    })?;
                    node.rotation = Some(DQuat::from_vec4(unit));
                }
            }
        }
        Ok(nodes)
    }
}

fn find(animations: &[Animation], which: &WhichClip) -> Result<usize, Issue> {
    let named = |(number, animation): (usize, &Animation)| match &animation.name {
        Some(name) => format!("{name:?}"),
        None => format!("{number} (it has no name)"),
    };
    let mut names: Vec<String> = animations.iter().enumerate().take(12).map(named).collect();
    if animations.len() > names.len() {
        names.push("…".into());
    }
    let there_are = names.join(", ");
    let fits = |&i: &usize| match which {
        WhichClip::Only => true,
        WhichClip::Named(name) => animations[i].name.as_ref() == Some(name),
        WhichClip::Number(number) => i == *number,
    };
    let mut found = (0..animations.len()).filter(fits);
    match (found.next(), found.next(), which) {
        (Some(index), None, _) => Ok(index),
        (Some(_), Some(_), WhichClip::Named(name)) => {
            Err(Issue::says(format!("two animations are named {name:?}"))
                .with_advice("set clip to the number of one, counted from 0"))
        }
        (Some(_), Some(_), _) => {
            Err(Issue::says("has several animations").with_advice(format!("set clip to one of {there_are}")))
        }
        (None, ..) if animations.is_empty() => {
            Err(Issue::says("has no animation").with_advice("export one with it"))
        }
        (None, _, WhichClip::Number(number)) => Err(Issue::says(format!("there is no animation {number}"))
            .with_advice(format!("there are {}, counted from 0: {there_are}", animations.len()))),
        (None, _, WhichClip::Named(name)) => Err(Issue::says(format!("no animation is named {name:?}"))
            .with_advice(format!("there are {there_are}"))),
        (None, _, WhichClip::Only) => unreachable!("any animation is the only one or one of several"),
    }
}

/// What a channel's sampler holds.
struct SamplerCurve {
    times_s: Rc<[f64]>,
    interpolation: Interpolation,
    /// Those of the property or, of weights, of each morph target.
    values: Vec<Vec<DVec4>>,
}

fn curve(
    container: &Container,
    animation: &Animation,
    channel: &Channel,
    (property, targets): (Property, usize),
    budget: &mut MemoryLimit,
) -> Result<SamplerCurve, Issue> {
    let number = channel.sampler.value();
    let samplers = &animation.samplers;
    let sampler: &Sampler = samplers
        .get(number)
        .ok_or_else(|| Issue::value("sampler", number, format!("there are {}", samplers.len())))?;
    let at = |issue: Issue| issue.with_place(Site::Table(format!("samplers[{number}]")));
    let interpolation = match sampler.interpolation {
        Checked::Valid(interpolation) => interpolation,
        Checked::Invalid => {
            return Err(at(Issue::says("must be LINEAR, STEP or CUBICSPLINE").with_place("interpolation")));
        }
    };
    let times_s = times(container, sampler.input, budget).map_err(at)?;
    let is_rotation = property == Property::Rotation;
    let (elements, width) = match property {
        Property::Rotation => (Elements::rotations(container, sampler.output), 4),
        Property::MorphTargetWeights => (Elements::blending(container, sampler.output), 1),
        _ => (Elements::floats(container, sampler.output, Type::Vec3, "must be VEC3 of float"), 3),
    };
    let elements = elements.map_err(|issue| at(issue.with_place("output")))?;
    let per_time = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let needed = (per_time * targets).saturating_mul(times_s.len());
    if elements.count != needed {
        let each = if targets == 1 { String::new() } else { format!(" of {targets} morph targets") };
        return Err(at(Issue::says(format!("output has {} values", elements.count))
            .with_advice(format!("its {} times{each} need {needed}", times_s.len()))));
    }
    budget.spend((elements.count * size_of::<DVec4>() + targets * size_of::<Track>()) as u64)?;
    let mut values = vec![Vec::with_capacity(elements.count / targets); targets];
    for i in 0..elements.count {
        let component = |c: usize| if c < width { elements.number(i, c) } else { 0.0 };
        let value = DVec4::from_array(std::array::from_fn(component));
        // A spline has the tangents coming in of all targets, then their values, then the tangents going out.
        let is_tangent = per_time == 3 && i / targets % 3 != 1;
        if !value.is_finite() || (is_rotation && !is_tangent && value.length() == 0.0) {
            let rule = if is_rotation { "must be finite and not zero" } else { "must be finite" };
            return Err(at(Issue::says(format!("output value {i} is {value}")).with_advice(rule)));
        }
        // A key's length in f32 is not quite one, which would bend the path between keys.
        let value = if is_rotation && per_time == 1 { value.normalize() } else { value };
        values[i % targets].push(value);
    }
    Ok(SamplerCurve { times_s, interpolation, values })
}

fn times(
    container: &Container,
    input: Index<Accessor>,
    budget: &mut MemoryLimit,
) -> Result<Rc<[f64]>, Issue> {
    let at = |issue: Issue| issue.with_place("input");
    let elements = Elements::floats(container, input, Type::Scalar, "must be SCALAR of float").map_err(at)?;
    if elements.count == 0 {
        return Err(at(Issue::says("has no time")));
    }
    budget.spend((elements.count * size_of::<f64>()) as u64)?;
    let times_s: Vec<f64> = (0..elements.count).map(|i| elements.number(i, 0)).collect();
    if let Some(i) = times_s.iter().position(|time| !time.is_finite()) {
        return Err(at(Issue::says(format!("time {i} is {}", times_s[i])).with_advice("must be finite")));
    }
    if let Some(i) = times_s.windows(2).position(|pair| pair[0] >= pair[1]) {
        let (before, after) = (times_s[i], times_s[i + 1]);
        return Err(at(Issue::says(format!("time {} is {after} after {before}", i + 1))
            .with_advice("times must increase")));
    }
    Ok(times_s.into())
}

impl Track {
    /// The value at a time, by the rules of glTF 2.0 (appendix C); a rotation may lack unit length.
    fn sample(&self, time_s: f64) -> DVec4 {
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
