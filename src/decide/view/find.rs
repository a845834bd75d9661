//! Finds a choice of poses, a representation or a scene of a study by its name in results.csv.

use super::Choice;
use super::names::{ChoiceNames, find_choices, unknown};
use perirobot_march::error::{Argument, Issue, Site, Words};
use perirobot_march::{Error, Result};
use perirobot_study::input::{Combination, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::columns::representation_names;

/// Names a choice and a scene; the default is the first of each.
#[derive(Clone, Debug, Default)]
pub struct ChoiceSelector {
    /// The poses as in the column `poses` of results.csv; for a sensor scored alone, the pose's name alone suffices.
    pub poses: String,
    /// The combination's name, if several have such a choice.
    pub combination: Option<String>,
    /// The representation as in the column `representation`.
    pub representation: Option<String>,
    /// The scene's name.
    pub scene: Option<String>,
    /// The moment, counted from 0.
    pub snapshot: usize,
    /// The repeat, counted from 0.
    pub repeat: usize,
}

/// Finds the world (among those of the study, or at least of the scene) and the choice. The error for an unknown name
/// lists the known ones.
pub fn find<'w>(study: &Study, worlds: &'w [World], wanted: &ChoiceSelector) -> Result<(&'w World, Choice)> {
    let all: Vec<ChoiceNames> = study.combinations.iter().map(|c| choice_names(study, c)).collect();
    let found = find_choices(&all, &wanted.poses, wanted.combination.as_deref())?;
    let (combination, choice) = found[0];
    if let Some((other, _)) = found.get(1) {
        let [a, b] = [combination, *other].map(|number| &study.combinations[number].name);
        let cure = Words::from("choose one with ") + Argument("combination");
        let place = Site::Argument(Argument("pose"), wanted.poses.clone());
        return Err(Error::input(place, format!("is a choice of {a:?} and of {b:?}")).with_advice(cure));
    }
    let names = representation_names(study, &study.combinations[combination]);
    let representation = match &wanted.representation {
        None => 0,
        Some(name) => names
            .iter()
            .position(|known| known == name)
            .ok_or_else(|| unknown(Argument("representation"), Some(name), &names))?,
    };
    check_below(Argument("repeat"), wanted.repeat, study.repeats as usize)?;
    let scene = find_scene(study, wanted)?;
    let here = |world: &&World| (world.scene, world.snapshot) == (scene, wanted.snapshot);
    let world = worlds.iter().find(here).expect("worlds are those of the study's scenes");
    Ok((world, Choice { combination, choice, representation, repeat: wanted.repeat }))
}

/// Most choices of poses that an error lists.
const LISTED: usize = 6;

/// The poses of the only choice of a study, or of one of its combinations.
///
/// # Errors
/// If there are several: the first of them by name. An unknown combination.
pub fn only_choice(study: &Study, combination: Option<&str>) -> Result<String> {
    let all: Vec<ChoiceNames> = study.combinations.iter().map(|c| choice_names(study, c)).collect();
    let named: Vec<&ChoiceNames> =
        all.iter().filter(|names| combination.is_none_or(|name| name == names.combination)).collect();
    if named.is_empty() {
        let known: Vec<_> = all.iter().map(|names| names.combination).collect();
        return Err(unknown(Argument("combination"), combination, &known));
    }
    let count = named.iter().map(|names| names.count()).fold(0, usize::saturating_add);
    let mut first: Vec<String> = named
        .iter()
        .flat_map(|names| (0..names.count()).map(move |choice| names.name(choice)))
        .take(LISTED)
        .collect();
    if count == 1 {
        return Ok(first.swap_remove(0));
    }
    let more = count - first.len();
    let rest = if more > 0 { format!(", and {more} more") } else { String::new() };
    let what = Words::from("")
        + Argument("pose")
        + format!(" is missing: the study has {count} choices of poses").as_str();
    Err(Error::from(Issue::says(what)).with_advice(format!("write one of {}{rest}", first.join(", "))))
}

/// Finds only the scene, and checks that it has this snapshot.
pub fn find_scene(study: &Study, wanted: &ChoiceSelector) -> Result<usize> {
    let scenes: Vec<_> = study.scenes.iter().map(|scene| scene.name.as_str()).collect();
    let scene = match &wanted.scene {
        None => 0,
        Some(name) => scenes
            .iter()
            .position(|known| known == name)
            .ok_or_else(|| unknown(Argument("scene"), Some(name), &scenes))?,
    };
    check_below(Argument("snapshot"), wanted.snapshot, study.scenes[scene].snapshots)?;
    Ok(scene)
}

fn check_below(argument: Argument, number: usize, of: usize) -> Result<()> {
    let place = Site::Argument(argument, number.to_string());
    match number < of {
        true => Ok(()),
        false => Err(Error::input(place, format!("must be from 0 to {}", of - 1))),
    }
}

/// The names of a combination's choices.
pub(super) fn choice_names<'a>(study: &'a Study, combination: &'a Combination) -> ChoiceNames<'a> {
    let members = combination.members.iter().map(|member| {
        let sensor = &study.sensors[member.sensor];
        let poses = member.candidates.iter().map(|&candidate| sensor.candidates[candidate].name.as_str());
        (sensor.name.as_str(), poses.collect())
    });
    ChoiceNames { combination: &combination.name, members: members.collect() }
}
