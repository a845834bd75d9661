//! From names, as a user reads them in results.csv, to what they stand for in a study.

use super::{Choice, names};
use crate::study::Study;
use crate::sweep::World;
use crate::sweep::compare::{self, select_choices};
use crate::sweep::table::{pose_names, representation_names};
use crate::{Error, Result};

/// Which choice, in which scene; what is not said is the first there is.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// As in the column `poses` of results.csv; of a sensor that is scored alone, the pose's own name will do.
    pub poses: String,
    /// The combination's name, where several have such a choice.
    pub combination: Option<String>,
    /// As in the column `representation`.
    pub representation: Option<String>,
    /// The scene's name.
    pub scene: Option<String>,
    /// Which moment of it, counted from 0.
    pub snapshot: usize,
    /// Which repeat, counted from 0.
    pub repeat: usize,
}

/// Finds the world (of those of the study, or at least of the scene) and the choice; names what there is where something is not.
pub fn find<'w>(study: &Study, worlds: &'w [World], wanted: &Wanted) -> Result<(&'w World, Choice)> {
    let named = compare::Selection::Named(wanted.poses.clone());
    let asked = |name: &str| wanted.combination.as_ref().is_none_or(|wanted| wanted == name);
    if !study.combinations.iter().any(|combination| asked(&combination.name)) {
        let names: Vec<_> = study.combinations.iter().map(|combination| combination.name.as_str()).collect();
        return Err(unknown("--combination", wanted.combination.as_deref(), &names));
    }
    let combinations: Vec<_> =
        study.combinations.iter().enumerate().filter(|(_, c)| asked(&c.name)).collect();
    let mut found = combinations.iter().filter_map(|(number, combination)| {
        let as_written = || {
            let spelled = names::spelled(study, combination, &wanted.poses)?;
            select_choices(&compare::Selection::Named(spelled), study, combination).first().copied()
        };
        Some((*number, select_choices(&named, study, combination).first().copied().or_else(as_written)?))
    });
    let (combination, choice) = found.next().ok_or_else(|| {
        let all = combinations.iter().map(|(_, combination)| *combination);
        let example = all.clone().next().map_or(String::new(), |c| pose_names(study, c, 0));
        let mut near: Vec<String> = all.filter_map(|c| names::nearest(study, c, &wanted.poses)).collect();
        near.dedup();
        let meant = match near.is_empty() {
            true => String::new(),
            false => format!(" (did you mean {}?)", near.join(", ")),
        };
        let what = format!(
            "no such choice of poses{meant}: must be sensor:pose as `perirobot check` lists poses, or as in the column \
             `poses` of results.csv, as in {example}"
        );
        Error::input(format!("--pose {}", wanted.poses), what)
    })?;
    if let Some((other, _)) = found.next() {
        let [a, b] = [combination, other].map(|number| &study.combinations[number].name);
        let what = format!("is a choice of {a:?} and of {b:?}: say which with --combination");
        return Err(Error::input(format!("--pose {}", wanted.poses), what));
    }
    let names = representation_names(study, &study.combinations[combination]);
    let representation = match &wanted.representation {
        None => 0,
        Some(name) => names
            .iter()
            .position(|known| known == name)
            .ok_or_else(|| unknown("--representation", Some(name), &names))?,
    };
    below("--repeat", wanted.repeat, study.repeats as usize)?;
    let scene = find_scene(study, wanted)?;
    let here = |world: &&World| (world.scene, world.snapshot) == (scene, wanted.snapshot);
    let world = worlds.iter().find(here).expect("worlds are those of the study's scenes");
    Ok((world, Choice { combination, choice, representation, repeat: wanted.repeat }))
}

/// Finds the scene alone, which has such a snapshot.
pub fn find_scene(study: &Study, wanted: &Wanted) -> Result<usize> {
    let scenes: Vec<_> = study.scenes.iter().map(|scene| scene.name.as_str()).collect();
    let scene = match &wanted.scene {
        None => 0,
        Some(name) => scenes
            .iter()
            .position(|known| known == name)
            .ok_or_else(|| unknown("--scene", Some(name), &scenes))?,
    };
    below("--snapshot", wanted.snapshot, study.scenes[scene].snapshots)?;
    Ok(scene)
}

fn below(option: &str, number: usize, of: usize) -> Result<()> {
    match number < of {
        true => Ok(()),
        false => Err(Error::input(format!("{option} {number}"), format!("must be from 0 to {}", of - 1))),
    }
}

fn unknown(option: &str, name: Option<&str>, known: &[impl AsRef<str>]) -> Error {
    let known: Vec<_> = known.iter().map(AsRef::as_ref).collect();
    let what = format!("there is no such one, there are {}", known.join(", "));
    Error::input(format!("{option} {}", name.unwrap_or_default()), what)
}
