//! Combinations of a study, checked: which sensors are fused, in which poses, by which rule.

use wildmatch::WildMatch;

use super::choices::Choices;
use super::file::CombinationFile;
use super::slug;
use crate::diagnostics::{Place, Problems};
use crate::sensor::Sensor;
use perirobot_march::backend::Fusion;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};

/// Most rows of results of a study: a journal of 64 GB.
pub const MAX_ROWS: usize = 1_000_000_000;

/// Most bytes that the names of all representations of all combinations may take; they are kept in memory.
pub const MAX_NAMES_BYTES: usize = 64 << 20;

/// Most equal sensors of a combination.
const MOST_EQUAL: usize = 64;

/// Sensors that are scored together: every pose of each with every pose of the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Unique in the study.
    pub name: String,
    /// How their evidence becomes one label.
    pub fusion: Fusion,
    /// The sensors in the order they speak; a known robot is the last. Equal ones follow each other.
    pub members: Vec<Member>,
}

/// One sensor of a combination. Two that are equal are two of one sensor, in different poses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// Index of the sensor in the study.
    pub sensor: usize,
    /// Which of its candidates take part, in their order.
    pub candidates: Vec<usize>,
}

impl Combination {
    /// How many choices of poses it has.
    pub fn choices(&self) -> usize {
        self.all_choices().count()
    }

    /// The candidate of each member in a choice. Those of the last member vary fastest; of equal members each
    /// has a later one than the member before it.
    pub fn choice(&self, number: usize) -> Vec<usize> {
        let chosen = self.all_choices().nth(number).into_iter();
        chosen.zip(&self.members).map(|(i, member)| member.candidates[i]).collect()
    }

    fn all_choices(&self) -> Choices {
        Choices::from_sensors(self.members.iter().map(|member| (member.sensor, member.candidates.as_slice())))
    }

    /// How many choices of a representation for each member there are.
    pub fn representation_count(&self, sensors: &[Sensor]) -> usize {
        let counts = self.members.iter().map(|member| sensors[member.sensor].kind.representations().len());
        counts.fold(1, usize::saturating_mul)
    }

    /// Every choice of a representation for each member; those of the last member vary fastest.
    pub fn representations(&self, sensors: &[Sensor]) -> Vec<Vec<usize>> {
        self.members.iter().fold(vec![Vec::new()], |all, member| {
            let count = sensors[member.sensor].kind.representations().len();
            all.iter()
                .flat_map(|one| (0..count).map(move |next| [one.as_slice(), &[next]].concat()))
                .collect()
        })
    }
}

/// The combinations of a study, or each sensor alone where it names none.
pub(super) fn check(
    at: &Place,
    entries: Vec<CombinationFile>,
    fusion: Fusion,
    sensors: &[Sensor],
) -> Result<Vec<Combination>, Vec<Error>> {
    if entries.is_empty() {
        let alone = |(sensor, spec): (usize, &Sensor)| Combination {
            name: spec.name.clone(),
            fusion,
            members: vec![Member { sensor, candidates: (0..spec.candidates.len()).collect() }],
        };
        return Ok(sensors.iter().enumerate().map(alone).collect());
    }
    let mut problems = Problems::default();
    let checked = entries.into_iter().map(|entry| one(at, entry, fusion, sensors));
    let combinations: Vec<Combination> = checked.filter_map(|one| problems.keep(one)).collect();
    problems.keep(at.unique("combination", combinations.iter().map(|c| c.name.as_str())));
    problems.none()?;
    Ok(combinations)
}

/// Refuses a study whose results would not fit a disk. `per_choice` is how many regions, snapshots and
/// repeats there are for each choice.
pub(super) fn check_rows(
    at: &Place,
    combinations: &[Combination],
    sensors: &[Sensor],
    per_choice: usize,
) -> Result<()> {
    let (mut rows, mut bytes) = (0usize, 0usize);
    for combination in combinations {
        let (choices, representations) = (combination.choices(), combination.representation_count(sensors));
        rows = rows.saturating_add(choices.saturating_mul(representations).saturating_mul(per_choice));
        if rows > MAX_ROWS {
            let what = format!(
                "{choices} choices of poses in {representations} representations, each {per_choice} times (regions, snapshots, \
                 repeats), make more than {MAX_ROWS} rows of results"
            );
            let issue = Issue::too_large(what).with_advice("name a part of the poses, or fewer of the rest");
            return Err(at.wrap(issue.with_place(format!("combination {:?}", combination.name))));
        }
        let names = combination.members.iter().map(|member| sensors[member.sensor].kind.representations());
        bytes = bytes.saturating_add(bytes_of_names(names));
        if bytes > MAX_NAMES_BYTES {
            let what = format!("{representations} choices of a representation for each sensor are too many");
            let issue =
                Issue::too_large(what).with_advice("fuse fewer sensors, or give them fewer representations");
            return Err(at.wrap(issue.with_place(format!("combination {:?}", combination.name))));
        }
    }
    Ok(())
}

/// An upper bound of the memory, in bytes, for the names of a combination's representations, which are joined
/// from those of its sensors.
pub fn bytes_of_names<S: AsRef<str>>(sensors: impl Iterator<Item = impl AsRef<[S]>>) -> usize {
    /// Bytes of a name besides its text: its place in a list.
    const OF_EACH: usize = 64;
    let (mut representations, mut length) = (1usize, OF_EACH);
    for names in sensors {
        let names = names.as_ref();
        representations = representations.saturating_mul(names.len());
        length += 1 + names.iter().map(|name| name.as_ref().len()).max().unwrap_or(0);
    }
    representations.saturating_mul(length)
}

fn one(at: &Place, entry: CombinationFile, fusion: Fusion, sensors: &[Sensor]) -> Result<Combination> {
    let name = entry.name.clone().unwrap_or_else(|| default_name(&entry));
    let at = at.key(&format!("combination {name:?}"));
    at.some("sensors", &entry.sensors, "sensors = [\"camera\", \"pads\"]")?;
    if let Some(i) = (0..entry.sensors.len()).find(|&i| entry.sensors[..i].contains(&entry.sensors[i])) {
        return Err(at.wrong(
            "sensors",
            format!("{:?}", entry.sensors[i]),
            "stands twice: name each sensor once, and say in `count` how many of it there are",
        ));
    }
    let known = || sensors.iter().map(|sensor| sensor.name.as_str()).collect::<Vec<_>>();
    let stranger = |sensor: &&String| !entry.sensors.contains(sensor);
    let not_among = |key: &str, stranger: &String| {
        let rule = format!("is not among its sensors {:?}: name one of those", entry.sensors);
        Err(at.wrong(key, format!("{stranger:?}"), &rule))
    };
    if let Some(sensor) = entry.poses.keys().find(stranger) {
        return not_among("poses", sensor);
    }
    if let Some(sensor) = entry.count.keys().find(stranger) {
        return not_among("count", sensor);
    }
    let mut members = Vec::new();
    for name in &entry.sensors {
        let Some(sensor) = sensors.iter().position(|sensor| sensor.name == *name) else {
            return Err(at.wrong(
                "sensors",
                format!("{name:?}"),
                &format!("must be sensors of the study: {:?}", known()),
            ));
        };
        let candidates = subset(&at, &sensors[sensor], entry.poses.get(name))?;
        let count = entry.count.get(name).copied().unwrap_or(1);
        let most = candidates.len().min(MOST_EQUAL);
        if !(1..=most).contains(&count) {
            let rule = format!(
                "must be from 1 to {most}: no two are in one of its {} poses, and at most {MOST_EQUAL} are equal",
                candidates.len()
            );
            return Err(at.key("count").wrong(name, count, &rule));
        }
        members.extend(std::iter::repeat_n(Member { sensor, candidates }, count));
    }
    // The sort is stable: the others speak in the order they are listed.
    members.sort_by_key(|member| sensors[member.sensor].kind.speaks_last());
    Ok(Combination { name, fusion: entry.fusion.unwrap_or(fusion), members })
}

/// Its sensors: `lidar + 3 camera`.
fn default_name(entry: &CombinationFile) -> String {
    let counted = |sensor: &String| match entry.count.get(sensor) {
        None | Some(1) => sensor.clone(),
        Some(count) => format!("{count} {sensor}"),
    };
    entry.sensors.iter().map(counted).collect::<Vec<_>>().join(" + ")
}

/// A pattern whose group is spelled as the study does, `south wall/*`, in the spelling of names.
fn with_slug(pattern: &str) -> String {
    match pattern.split_once('/') {
        Some((group, rest)) if !group.contains(['*', '?']) => format!("{}/{rest}", slug(group)),
        _ => pattern.into(),
    }
}

/// The candidates that some pattern names, or all without patterns.
fn subset(at: &Place, sensor: &Sensor, patterns: Option<&Vec<String>>) -> Result<Vec<usize>> {
    let all = 0..sensor.candidates.len();
    let Some(patterns) = patterns else { return Ok(all.collect()) };
    let at = at.key("poses");
    let names = |candidate: usize| sensor.candidates[candidate].name.as_str();
    let matching = |pattern: &String| {
        let as_is = WildMatch::new(pattern);
        match all.clone().any(|candidate| as_is.matches(names(candidate))) {
            true => as_is,
            false => WildMatch::new(&with_slug(pattern)),
        }
    };
    let matches: Vec<WildMatch> = patterns.iter().map(matching).collect();
    for (pattern, matcher) in patterns.iter().zip(&matches) {
        if !all.clone().any(|candidate| matcher.matches(names(candidate))) {
            let rule = format!("names no pose; those of {:?} are like {:?}", sensor.name, names(0));
            return Err(at.wrong(&sensor.name, format!("{pattern:?}"), &rule));
        }
    }
    let chosen: Vec<usize> =
        all.filter(|&candidate| matches.iter().any(|matcher| matcher.matches(names(candidate)))).collect();
    at.some(&sensor.name, &chosen, "camera = [\"ceiling/*\"]")?;
    Ok(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::{Overrides, Study};
    use std::path::Path;

    #[test]
    fn groups_of_poses_may_be_spelled_as_in_the_study() {
        let quick = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/quick.toml");
        let study = Study::load(&quick, &Overrides::default()).unwrap();
        let at = Place::new(&quick);
        let chosen = |pattern: &str| subset(&at, &study.sensors[0], Some(&vec![pattern.into()]));
        // Ten positions with two orientations each come before the ceiling.
        assert_eq!(chosen("right wall/*").unwrap(), (0..20).collect::<Vec<_>>());
        assert_eq!(chosen("Right wall/?/1").unwrap(), chosen("right-wall/?/1").unwrap());
        assert_eq!(chosen("*wall/4/0").unwrap(), [8]);
        for wrong in ["right wall", "left wall/*", "Right*/0/0"] {
            let error = chosen(wrong).unwrap_err().to_string();
            assert!(error.contains(&format!("camera = {wrong:?}: names no pose")), "{error}");
        }
    }
}
