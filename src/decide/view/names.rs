//! Finds the choice of poses for a user's name.

use perirobot_march::error::{Argument, Issue, Site};
use perirobot_march::{Error, Result};
use perirobot_study::input::{Choices, slug};
use perirobot_sweep::results::columns::BETWEEN_MEMBERS;

/// Least similarity of a suggested name.
const NEAR: f64 = 0.7;

/// The choices of poses of a combination, by name.
#[derive(Clone, Debug)]
pub struct ChoiceNames<'a> {
    /// The combination's name.
    pub combination: &'a str,
    /// Its sensors in the order of precedence, each with the names of its poses in the choice, in their order.
    pub members: Vec<(&'a str, Vec<&'a str>)>,
}

/// The combinations, and the index of their choice, for a name: as in the column `poses` of results.csv, or with
/// another spelling (`South wall/2/0` for `south-wall/2/0`); for a sensor scored alone, the pose's name alone suffices.
/// Several combinations may have such a choice. For an unknown name the [`Error::Input`] suggests the nearest.
pub fn find_choices(
    all: &[ChoiceNames],
    poses: &str,
    combination: Option<&str>,
) -> Result<Vec<(usize, usize)>> {
    let candidates: Vec<(usize, &ChoiceNames)> = all
        .iter()
        .enumerate()
        .filter(|(_, names)| combination.is_none_or(|c| c == names.combination))
        .collect();
    if candidates.is_empty() {
        let names: Vec<_> = all.iter().map(|names| names.combination).collect();
        return Err(unknown(Argument("combination"), combination, &names));
    }
    let meant = |(number, names): &(usize, &ChoiceNames)| {
        Some((*number, names.find_exact(poses).or_else(|| names.find_spelling(poses))?))
    };
    let found: Vec<(usize, usize)> = candidates.iter().filter_map(meant).collect();
    if !found.is_empty() {
        return Ok(found);
    }
    let near = |(_, names): &(usize, &ChoiceNames)| Some(names.name(names.nearest(poses)?));
    let mut near: Vec<String> = candidates.iter().filter_map(near).collect();
    near.dedup();
    let meant = match near.is_empty() {
        true => String::new(),
        false => format!(" (did you mean {}?)", near.join(", ")),
    };
    let (_, first) = candidates[0];
    let rule = format!(
        "must be sensor:pose as `perirobot check` lists poses, or as in the column `poses` of results.csv, as in {}",
        first.name(0)
    );
    let place = Site::Argument(Argument("pose"), poses.into());
    Err(Error::input(place, format!("no such choice of poses{meant}")).with_advice(rule))
}

/// The error for an unknown name.
pub fn unknown(argument: Argument, name: Option<&str>, known: &[impl AsRef<str>]) -> Error {
    Issue::unknown(known).with_place(Site::Argument(argument, name.unwrap_or_default().into())).into()
}

impl ChoiceNames<'_> {
    /// The choice with exactly this name; poses of equal sensors may be in any order.
    fn find_exact(&self, poses: &str) -> Option<usize> {
        self.find_each(poses, |known, own| known.iter().position(|name| *name == own))
    }

    /// The choice whose name differs only in spelling.
    fn find_spelling(&self, poses: &str) -> Option<usize> {
        self.find_each(poses, |known, own| {
            let own = plain(own);
            let mut matches = (0..known.len()).filter(|&i| plain(known[i]) == own);
            // If two names differ only in spelling, the name is ambiguous.
            matches.next().filter(|_| matches.next().is_none())
        })
    }

    /// The choice with the nearest name, if each of its poses is near.
    fn nearest(&self, poses: &str) -> Option<usize> {
        self.find_each(poses, |known, own| {
            let own = plain(own);
            let near = |i: &usize| strsim::normalized_damerau_levenshtein(&plain(known[*i]), &own);
            // The first of equally near ones.
            let best = (0..known.len()).rev().max_by(|a, b| near(a).total_cmp(&near(b)))?;
            (near(&best) >= NEAR).then_some(best)
        })
    }

    /// The choice whose poses `find` selects, sensor by sensor, from the names of the poses; a sensor's name may be
    /// left out.
    fn find_each(&self, poses: &str, find: impl Fn(&[&str], &str) -> Option<usize>) -> Option<usize> {
        let parts: Vec<&str> = poses.split(BETWEEN_MEMBERS).collect();
        if parts.len() != self.members.len() {
            return None;
        }
        let members = parts.into_iter().zip(&self.members);
        let found = members.map(|(part, (sensor, known))| {
            let own = part.strip_prefix(sensor).and_then(|rest| rest.strip_prefix(':')).unwrap_or(part);
            find(known, own)
        });
        self.choices().number(&found.collect::<Option<Vec<_>>>()?)
    }

    fn choices(&self) -> Choices {
        Choices::from_sensors(self.members.iter().map(|(sensor, known)| (sensor, known.as_slice())))
    }

    /// The number of choices.
    pub(super) fn count(&self) -> usize {
        self.choices().count()
    }

    /// The name of a choice, as in the column `poses`.
    pub(super) fn name(&self, choice: usize) -> String {
        let names = self.members.iter().zip(self.choices().nth(choice));
        let names = names.map(|((sensor, known), place)| format!("{sensor}:{}", known[place]));
        names.collect::<Vec<_>>().join(BETWEEN_MEMBERS)
    }
}

/// A name with each of its parts in the spelling of group names.
pub(super) fn plain(name: &str) -> String {
    name.split('/').map(slug).collect::<Vec<_>>().join("/")
}
