//! All that is asked of the bodies that approach one choice of sensors: checked in all scenes before anything is cast,
//! answered scene by scene, and written into a folder.

use std::fs;
use std::path::Path;

use super::approach_json::{APPROACH, APPROACH_JSON, Approaches};
use super::ground::Ground;
use super::moments::{ApproachAnswer, BodyPlan, answers, moments_of};
use super::picture::{PATHS, floor_plan, is_named_as_plan, paths_ply, plan_names};
use super::table::describe;
use crate::judge::Alteration;
use crate::view::Choice;
use crate::view::watched::Watchers;
use perirobot_march::Result;
use perirobot_march::progress::Progress;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::results::files::{OutputFolder, remove_files};

/// A choice of a study, in its worlds.
pub type ChoiceIn<'a> = (&'a Study, &'a [World], Choice);

/// The questions to all scenes.
pub struct Approaching<'a> {
    planned: ChoiceIn<'a>,
    worlds: &'a [World],
    watchers: Watchers<'a>,
    case: String,
    grounds: Vec<Ground<'a>>,
}

/// The answers of all scenes.
pub struct Approached<'a> {
    asked: Vec<(Ground<'a>, Vec<ApproachAnswer>)>,
    plans: Vec<Vec<BodyPlan>>,
    /// The answers: the rows of `approach.csv`.
    pub approaches: Approaches,
}

impl<'a> Approaching<'a> {
    /// Checks what a study asks of bodies that approach a choice; `altered` is the same choice after [`crate::judge::alter`].
    ///
    /// # Errors
    /// When something cannot be asked of a scene.
    pub fn new(
        planned: ChoiceIn<'a>,
        altered: ChoiceIn<'a>,
        alteration: &Alteration,
    ) -> Result<Approaching<'a>> {
        let watchers = Watchers::new(altered.0, altered.2);
        let (study, worlds, choice) = alteration.where_bodies_come_in(planned, altered);
        let grounds = Ground::from_scenes(study, worlds, Watchers::new(study, choice).each())?;
        Ok(Approaching { planned, worlds: altered.1, watchers, case: alteration.words(), grounds })
    }

    /// How many moments there are to answer.
    pub fn total(&self) -> u64 {
        self.grounds.iter().map(moments_of).sum()
    }

    /// Answers everything. `tell` gets the answers of each scene in words.
    ///
    /// # Errors
    /// When a scene has no hazard, those of `tell`, and `Error::Stopped`.
    pub fn answer(
        self,
        progress: &dyn Progress,
        tell: &mut dyn FnMut(&str) -> Result<()>,
    ) -> Result<Approached<'a>> {
        let (mut asked, mut plans) = (Vec::new(), Vec::new());
        let scenes = self.worlds.chunk_by(|one, next| one.scene == next.scene);
        for (ground, worlds) in self.grounds.into_iter().zip(scenes) {
            let (answers, of_scene) = answers(&ground, worlds, &self.watchers, progress)?;
            tell(&describe(&ground, &answers))?;
            asked.push((ground, answers));
            plans.push(of_scene);
        }
        let (study, _, choice) = self.planned;
        let approaches = Approaches::new(study, &choice, self.case, &asked);
        Ok(Approached { asked, plans, approaches })
    }
}

impl Approached<'_> {
    /// Writes the answers, the ways and the floor plans. Returns the floor plans of earlier runs that are left there.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, folder: &OutputFolder) -> Result<Vec<String>> {
        // If a run ends early, its files are not taken for those of an earlier one.
        remove_files([APPROACH_JSON, APPROACH, PATHS].map(|name| folder.path().join(name)))?;
        folder.write(PATHS, &paths_ply(&self.asked))?;
        let of_scenes = self.asked.iter().zip(&self.plans);
        let plans: Vec<_> =
            of_scenes.flat_map(|(asked, plans)| plans.iter().map(move |plan| (asked, plan))).collect();
        let names = plan_names(plans.iter().map(|((ground, _), plan)| plan.names(ground)));
        for (name, ((ground, answers), plan)) in names.iter().zip(&plans) {
            folder.write(name, &floor_plan(ground, answers, plan))?;
        }
        self.approaches.write(folder.path())?;
        folder.write(APPROACH, &self.approaches.csv())?;
        let is_left = |name: &String| is_named_as_plan(name) && !names.contains(name);
        Ok(names_in(folder.path()).filter(is_left).collect())
    }
}

/// The names in a folder that are text.
fn names_in(folder: &Path) -> impl Iterator<Item = String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.file_name().into_string().ok())
}
