//! Splits a STEP file by its layers. A converter to triangles drops layers, and makes one mesh of all solids of a part,
//! which may be on different layers; so each group of solids becomes a file of its own, in which all else is the same.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::ops::Range;

use wildmatch::WildMatch;

use super::part21::{Placed, Token, arguments, decode, for_each_entity, records, references};
use crate::spelling::plural;

/// The solids, shells and surfaces of a file that are alike to some patterns of layers, as a STEP file.
#[derive(Debug, PartialEq)]
pub(super) struct Group {
    /// Which patterns match one of the layers of each.
    pub(super) matched: Vec<bool>,
    /// All layers of these shapes, sorted.
    pub(super) layers: Vec<String>,
    pub(super) step: Vec<u8>,
}

/// A list of shapes: the items of a part's representation.
struct Shapes {
    number: u64,
    /// Where its items are, without their brackets.
    place: Range<usize>,
    items: Vec<u64>,
}

/// Entities that stand for what they paint.
const STYLES: [&str; 2] = ["STYLED_ITEM", "OVER_RIDING_STYLED_ITEM"];
/// Items of a representation that are no shapes of it: frames, and copies of other representations.
const FRAMES: [&str; 4] = ["AXIS1_PLACEMENT", "AXIS2_PLACEMENT_2D", "AXIS2_PLACEMENT_3D", "MAPPED_ITEM"];

/// What a file says of layers.
#[derive(Default)]
struct File {
    names: Vec<String>,
    /// The layers of each entity that has some.
    layers: HashMap<u64, Vec<usize>>,
    representations: Vec<Shapes>,
    /// The other representations of the same shape.
    same: HashMap<u64, Vec<u64>>,
    /// Items that are [`FRAMES`].
    frames: HashSet<u64>,
    /// The entities that a shape names: its shells and faces.
    within: HashMap<u64, Vec<u64>>,
}

/// The groups of a file, of which each shape is in one, and remarks about items of layers that are not whole shapes.
pub(super) fn split(step: &[u8], patterns: &[WildMatch]) -> (Vec<Group>, Vec<String>) {
    let file = File::read(step);
    let matches = |layer: &usize| patterns.iter().map(|p| p.matches(&file.names[*layer])).collect::<Vec<_>>();
    let by_layer: Vec<Vec<bool>> = (0..file.names.len()).map(|layer| matches(&layer)).collect();
    let matched = |layers: &[usize]| {
        let mut all = vec![false; patterns.len()];
        layers
            .iter()
            .for_each(|layer| all.iter_mut().zip(&by_layer[*layer]).for_each(|(all, one)| *all |= one));
        all
    };
    let mut groups: BTreeMap<Vec<bool>, BTreeSet<usize>> = BTreeMap::new();
    // What each item of each representation belongs to; nothing for frames, which all groups need.
    let mut belongs = Vec::new();
    let mut used = HashSet::new();
    // Surface models whose shells match different patterns.
    let mut mixed = BTreeSet::new();
    for shapes in &file.representations {
        let (own, from) = file.layers_of_list(shapes.number);
        let all = matched(&own);
        let of_item = |item: &u64| {
            (!file.frames.contains(item)).then(|| {
                let (layers, from) = file.layers_of_shape(*item);
                used.extend(from);
                let shells = file.within.get(item).into_iter().flatten();
                let of_shell =
                    |shell: &u64| matched(file.layers.get(shell).map_or(&[][..], |layers| layers.as_slice()));
                if shells.map(of_shell).collect::<BTreeSet<_>>().len() > 1 {
                    mixed.insert(*item);
                }
                let mut both = matched(&layers);
                both.iter_mut().zip(&all).for_each(|(both, all)| *both |= all);
                groups.entry(both.clone()).or_default().extend(layers);
                both
            })
        };
        let items: Vec<Option<Vec<bool>>> = shapes.items.iter().map(of_item).collect();
        let distinct: BTreeSet<_> = items.iter().flatten().collect();
        if !distinct.is_empty() {
            used.extend(from);
        }
        for group in distinct {
            groups.entry(group.clone()).or_default().extend(&own);
        }
        belongs.push(items);
    }
    let mut remarks = file.remarks(&used, &by_layer);
    if !mixed.is_empty() {
        let models = plural(mixed.len(), "surface model");
        remarks.push(format!(
            "with {models} whose shells are on different layers: each follows the rules as a whole"
        ));
    }
    let count = groups.len();
    let groups = groups.into_iter().map(|(matched, layers)| {
        let step = if count == 1 { step.to_vec() } else { file.keep(step, &belongs, &matched) };
        let mut layers: Vec<String> = layers.into_iter().map(|layer| file.names[layer].clone()).collect();
        layers.sort();
        Group { matched, layers, step }
    });
    (groups.collect(), remarks)
}

impl File {
    fn read(step: &[u8]) -> File {
        let mut file = File::default();
        let mut indices = HashMap::new();
        for_each_entity(step, |number, body| file.read_lists(number, body, &mut indices));
        if file.names.is_empty() {
            return file;
        }
        let items: HashSet<u64> =
            file.representations.iter().flat_map(|shapes| shapes.items.iter().copied()).collect();
        let mut styled = Vec::new();
        for_each_entity(step, |number, body| {
            let is_item = items.contains(&number);
            if !is_item && !file.layers.contains_key(&number) {
                return;
            }
            let records = records(body);
            let is_one_of = |known: &[&str]| {
                records.iter().any(|(keyword, _)| known.iter().any(|known| known.as_bytes() == *keyword))
            };
            if is_one_of(&STYLES) {
                // The first argument that is an entity is what it paints.
                let mut arguments = records.iter().flat_map(|(_, record)| arguments(record));
                styled.extend(arguments.find_map(one_reference).map(|painted| (number, painted)));
            } else if is_item && is_one_of(&FRAMES) {
                file.frames.insert(number);
            } else if is_item {
                file.within.insert(number, references(body).collect());
            }
        });
        for (style, painted) in styled {
            let layers = file.layers.remove(&style).unwrap_or_default();
            file.layers.entry(painted).or_default().extend(layers);
        }
        file
    }

    /// Reads an entity that is a layer, a representation of a shape, or says that two of these are the same.
    fn read_lists(&mut self, number: u64, body: &[Placed], indices: &mut HashMap<String, usize>) {
        let records = records(body);
        let is_shape = records.iter().any(|(keyword, _)| keyword.ends_with(b"SHAPE_REPRESENTATION"));
        for (keyword, record) in &records {
            let is_list =
                keyword.ends_with(b"SHAPE_REPRESENTATION") || is_shape && *keyword == b"REPRESENTATION";
            match (*keyword, &arguments(record)[..]) {
                (b"PRESENTATION_LAYER_ASSIGNMENT", [[(Token::Text(name), _)], _, items]) => {
                    let name = decode(name);
                    let index = *indices.entry(name.clone()).or_insert(self.names.len());
                    if index == self.names.len() {
                        self.names.push(name);
                    }
                    references(items).for_each(|item| self.layers.entry(item).or_default().push(index));
                }
                (b"SHAPE_REPRESENTATION_RELATIONSHIP", [_, _, one, other]) => {
                    if let (Some(one), Some(other)) = (one_reference(one), one_reference(other)) {
                        self.same.entry(one).or_default().push(other);
                        self.same.entry(other).or_default().push(one);
                    }
                }
                (_, [_, [(Token::Sign(b'('), open), items @ .., (Token::Sign(b')'), close)], _])
                    if is_list =>
                {
                    let items = references(items).collect();
                    self.representations.push(Shapes { number, place: open.end..close.start, items });
                }
                _ => {}
            }
        }
    }

    /// The layers of all items of a representation, and the entities that have them.
    fn layers_of_list(&self, number: u64) -> (Vec<usize>, Vec<u64>) {
        let same = self.same.get(&number).into_iter().flatten().copied();
        self.layers_of(std::iter::once(number).chain(same))
    }

    /// The layers of a shape, its own and those of what it is made of.
    fn layers_of_shape(&self, number: u64) -> (Vec<usize>, Vec<u64>) {
        let within = self.within.get(&number).into_iter().flatten().copied();
        self.layers_of(std::iter::once(number).chain(within))
    }

    fn layers_of(&self, numbers: impl Iterator<Item = u64>) -> (Vec<usize>, Vec<u64>) {
        let from: Vec<u64> = numbers.filter(|number| self.layers.contains_key(number)).collect();
        (from.iter().flat_map(|number| &self.layers[number]).copied().collect(), from)
    }

    /// Remarks about layers that a pattern matches and that have items without effect.
    fn remarks(&self, used: &HashSet<u64>, by_layer: &[Vec<bool>]) -> Vec<String> {
        let mut counts = BTreeMap::new();
        let others = self.layers.iter().filter(|(number, _)| !used.contains(number));
        for layer in others.flat_map(|(_, layers)| layers).filter(|layer| by_layer[**layer].contains(&true)) {
            *counts.entry(*layer).or_insert(0_usize) += 1;
        }
        let remark = |(layer, count): (usize, usize)| {
            let items = plural(count, "item");
            let kinds = "assemblies, copies, faces or curves";
            format!(
                "without {items} of layer {:?} that are no whole solids or surfaces: {kinds}",
                self.names[layer]
            )
        };
        counts.into_iter().map(remark).collect()
    }

    /// The file with the shapes of one group only.
    fn keep(&self, step: &[u8], belongs: &[Vec<Option<Vec<bool>>>], group: &[bool]) -> Vec<u8> {
        let mut kept = Vec::with_capacity(step.len());
        let mut at = 0;
        for (shapes, belongs) in self.representations.iter().zip(belongs) {
            let stays = |belongs: &Option<Vec<bool>>| belongs.as_ref().is_none_or(|matched| matched == group);
            let items = shapes.items.iter().zip(belongs).filter(|(_, belongs)| stays(belongs));
            let items: Vec<String> = items.map(|(item, _)| format!("#{item}")).collect();
            kept.extend_from_slice(&step[at..shapes.place.start]);
            kept.extend_from_slice(items.join(",").as_bytes());
            at = shapes.place.end;
        }
        kept.extend_from_slice(&step[at..]);
        kept
    }
}

/// The entity that an argument is.
fn one_reference(argument: &[Placed]) -> Option<u64> {
    match argument {
        [(Token::Reference(number), _)] => Some(*number),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
