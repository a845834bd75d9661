//! Reads the skeleton of a BVH file.

use std::collections::HashSet;

use glam::DVec3;

use perirobot_march::error::Issue;

/// Most bones of a skeleton, fingers and faces included.
const MOST_BONES: usize = 10_000;
/// No number of a file is larger; beyond it there are slips of the pen.
pub(super) const LARGEST: f64 = 1e7;

/// A bone: the joint at which it begins, named after what it carries.
#[derive(Debug, PartialEq)]
pub(super) struct Bone {
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    /// Where it begins in its parent's frame.
    pub(super) offset: DVec3,
    /// What a frame says about it, in the order of its numbers.
    pub(super) channels: Vec<Channel>,
}

/// What a number of a frame moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Channel {
    Position(BoneAxis),
    Rotation(BoneAxis),
}

/// An axis of a bone's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BoneAxis {
    X,
    Y,
    Z,
}

/// What the lines between braces are about.
#[derive(Clone, Copy)]
enum Within {
    Bone(usize),
    /// Where a bone without children ends, which no joint of a person needs.
    End,
}

/// The bones, parents before children, and the byte at which the motion begins.
pub(super) fn read(text: &str) -> Result<(Vec<Bone>, usize), Issue> {
    let (mut bones, mut names): (Vec<Bone>, _) = (Vec::new(), HashSet::new());
    let (mut open, mut next): (Vec<Within>, Option<Within>) = (Vec::new(), None);
    let (mut byte, mut begun) = (0, false);
    for (number, line) in text.split_inclusive('\n').enumerate() {
        byte += line.len();
        let at = |issue: Issue| issue.with_place(format!("line {}", number + 1));
        let damaged = |what: &str| at(Issue::damaged(what.to_string()));
        let line = line.trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let (rest, opens) = match rest.trim().strip_suffix('{') {
            Some(rest) => (rest.trim(), true),
            None => (rest.trim(), word == "{"),
        };
        if !begun && !word.is_empty() && word != "HIERARCHY" {
            return Err(at(Issue::says("must begin with HIERARCHY").with_advice("is it a BVH file?")));
        }
        match word {
            "" | "{" => {}
            "HIERARCHY" => begun = true,
            "MOTION" if open.is_empty() && next.is_none() && !bones.is_empty() => return Ok((bones, byte)),
            "ROOT" | "JOINT" => {
                let parent = match (word, open.last()) {
                    ("ROOT", None) if bones.is_empty() => None,
                    ("JOINT", Some(Within::Bone(parent))) => Some(*parent),
                    ("ROOT", None) => {
                        return Err(at(Issue::unsupported("a second ROOT")
                            .with_advice("one person a file: write each into a file of its own")));
                    }
                    _ => return Err(damaged("a JOINT must be inside of a ROOT, and a ROOT in nothing")),
                };
                if rest.is_empty() || !names.insert(rest.to_string()) {
                    return Err(at(
                        Issue::says(format!("{word} {rest:?}")).with_advice("must have a name of its own")
                    ));
                }
                if bones.len() == MOST_BONES {
                    return Err(at(Issue::too_large(format!("more than {MOST_BONES} bones"))));
                }
                next = Some(Within::Bone(bones.len()));
                bones.push(Bone { name: rest.into(), parent, offset: DVec3::ZERO, channels: Vec::new() });
            }
            "End" => next = Some(Within::End),
            "OFFSET" => {
                let offset = numbers(rest).filter(|numbers| numbers.len() == 3);
                let offset = offset.ok_or_else(|| {
                    at(Issue::value("OFFSET", format!("{rest:.60}"), "must be three numbers"))
                })?;
                match open.last() {
                    Some(Within::Bone(bone)) => bones[*bone].offset = DVec3::from_slice(&offset),
                    Some(Within::End) => {}
                    None => return Err(damaged("an OFFSET outside of all bones")),
                }
            }
            "CHANNELS" => {
                let Some(Within::Bone(bone)) = open.last() else {
                    return Err(damaged("CHANNELS outside of all bones"));
                };
                bones[*bone].channels = channels(rest).map_err(at)?;
            }
            "}" => {
                open.pop().ok_or_else(|| damaged("a } too many"))?;
            }
            word => {
                let known = "HIERARCHY, ROOT, JOINT, End Site, OFFSET, CHANNELS, MOTION";
                return Err(at(Issue::damaged(format!("{word:.40} where one of {known} is due"))));
            }
        }
        if opens {
            open.push(next.take().ok_or_else(|| damaged("a { that belongs to no bone"))?);
        }
    }
    Err(Issue::damaged("ends before MOTION").with_advice("it is cut off, or its braces do not match"))
}

/// `6 Xposition Yposition Zposition Zrotation Xrotation Yrotation`.
fn channels(text: &str) -> Result<Vec<Channel>, Issue> {
    let mut words = text.split_whitespace();
    let count = words.next().and_then(|count| count.parse::<usize>().ok());
    let channel = |word: &str| {
        let axis = match word.chars().next()?.to_ascii_uppercase() {
            'X' => BoneAxis::X,
            'Y' => BoneAxis::Y,
            'Z' => BoneAxis::Z,
            _ => return None,
        };
        match word[1..].to_ascii_lowercase().as_str() {
            "position" => Some(Channel::Position(axis)),
            "rotation" => Some(Channel::Rotation(axis)),
            _ => None,
        }
    };
    let channels: Option<Vec<Channel>> = words.map(channel).collect();
    channels.filter(|channels| Some(channels.len()) == count).ok_or_else(|| {
        let rule =
            "must be a count and as many of Xposition, Yposition, Zposition, Xrotation, Yrotation, Zrotation";
        Issue::value("CHANNELS", format!("{text:.120}"), rule)
    })
}

/// The numbers of a line; none if a word is none.
pub(super) fn numbers(text: &str) -> Option<Vec<f64>> {
    let number = |word: &str| word.parse::<f64>().ok().filter(|number| number.abs() <= LARGEST);
    text.split_whitespace().map(number).collect()
}
