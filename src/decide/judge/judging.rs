//! The judgement of choices of a sweep. The questions are checked before anything is counted or removed; then
//! everything is counted, and the files are written.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::alone::add_cases;
use super::cases::Conditions;
use super::caveats::caveats;
use super::counting::count_plan;
use super::draws::Draws;
use super::judge_json::Verdicts;
use super::judged::JudgedSet;
use super::near::SharedGround;
use super::postures::check_postures;
use super::scope::counted_conditions;
use super::speed::{AtEachSpeed, Speeds, at_each_speed, speeds_csv};
use super::table::{conditions_csv, requirements_csv};
use super::what_if::WhatIf;
use crate::approach::fusion_warning;
use crate::controller::{MeasuredMoment, separation_csv};
use crate::view::Choice;
use perirobot_march::backend::factory::{BackendFactory, ChosenBackends};
use perirobot_march::error::Issue;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Condition, Requirement, Study};
use perirobot_study::world::{World, cut_warnings};
use perirobot_sweep::results::Results;
use perirobot_sweep::results::files::{
    CONDITIONS, DRAWS, JUDGE_JSON, REQUIREMENTS, SEPARATION, SPEEDS, remove_files,
};

/// Choices of a sweep, ready to be judged.
pub struct Judging<'a> {
    study: &'a Study,
    worlds: &'a [World],
    results: &'a Results,
    choices: &'a [Choice],
    what_ifs: Vec<WhatIf<'a>>,
    grounds: Vec<SharedGround<'a>>,
    at_speeds: Vec<AtEachSpeed>,
    /// What speaks against the verdicts of each choice.
    caveats: Vec<Vec<String>>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
    /// Warnings of scenes, by their names: parts of regions and people that the grid cuts off.
    pub cut_off: Vec<(&'a str, Vec<String>)>,
}

/// The result of a judgement.
pub struct JudgeResult<'a> {
    /// Each choice with its verdicts.
    pub sets: Vec<JudgedSet<'a>>,
    /// The drawn mounts of all choices, if any.
    draws: Option<Draws>,
    /// Warnings about the places of people of `[postures]`.
    pub warnings: Vec<String>,
}

impl JudgeResult<'_> {
    /// What speaks against the verdicts of the sets, each once.
    pub fn caveats(&self) -> BTreeSet<&str> {
        self.sets.iter().flat_map(|set| &set.caveats).map(String::as_str).collect()
    }
}

/// Fails if a study has no requirements.
pub fn requires_something(study: &Study) -> Result<()> {
    if !study.requirements.is_empty() {
        return Ok(());
    }
    let region = study.regions.first().map_or("robot", |(name, _)| name.as_str());
    let example = format!(
        "[[require]] name = \"parts seen\", score = \"parts_detected\", region = {region:?}, at_least = 0.9"
    );
    Err(Error::from(Issue::missing("require").with_place(&study.path)).with_advice(format!(
        "add a requirement, as in {example}; `require` of [choose] only limits a search"
    )))
}

/// Removes the files of an earlier judgement from a folder, and one more file, so that they are never mistaken for the
/// new ones, even after an interruption.
pub fn forget(folder: &Path, more: Option<&Path>) -> Result<()> {
    let files = [JUDGE_JSON, REQUIREMENTS, CONDITIONS, DRAWS, SEPARATION, SPEEDS];
    remove_files(files.map(|name| folder.join(name)).into_iter().chain(more.map(PathBuf::from)))
}

impl<'a> Judging<'a> {
    /// Checks the requirements of a study for some choices.
    ///
    /// # Errors
    /// If something cannot be computed, for example for a person who cannot be read.
    pub fn new(
        study: &'a Study,
        worlds: &'a [World],
        results: &'a Results,
        choices: &'a [Choice],
    ) -> Result<Judging<'a>> {
        let what_ifs: Vec<WhatIf> = choices.iter().map(|choice| WhatIf::new(study, worlds, choice)).collect();
        let grounds = SharedGround::of_choices(&what_ifs)?;
        let near = choices.iter().filter(|_| !grounds.is_empty());
        let fused: BTreeSet<String> = near.filter_map(|choice| fusion_warning(study, choice)).collect();
        let caveats_of = |(number, choice): (usize, &Choice)| {
            let own = grounds.iter().find_map(|ground| ground.of_choice(number)).unwrap_or_default();
            caveats(&what_ifs[number], choice, own)
        };
        let caveats = choices.iter().enumerate().map(caveats_of).collect::<Result<_>>()?;
        let at_speeds = at_each_speed(study);
        let mut cut_off = cut_off(study, worlds, &at_speeds);
        cut_off.extend(check_postures(study, worlds)?);
        let warnings = fused.into_iter().collect();
        Ok(Judging {
            study,
            worlds,
            results,
            choices,
            what_ifs,
            grounds,
            at_speeds,
            caveats,
            warnings,
            cut_off,
        })
    }

    /// The number of cases to count, in each snapshot and repeat.
    pub fn total(&self) -> u64 {
        let conditions = counted_conditions(self.study);
        let near: u64 = self.grounds.iter().map(|ground| ground.total(&self.what_ifs)).sum();
        let cases = |what_if: &WhatIf| what_if.total(&conditions) + what_if.total_measured();
        near + self.what_ifs.iter().map(cases).sum::<u64>()
    }

    /// Counts all cases, and decides. Backends are opened when needed.
    ///
    /// # Errors
    /// If a backend fails, or counts the plan differently than the sweep; if no mount can move from its planned place;
    /// `Error::Stopped`.
    pub fn judge(
        &self,
        open: &dyn Fn() -> Result<ChosenBackends>,
        progress: &dyn Progress,
    ) -> Result<JudgeResult<'_>> {
        let requested = counted_conditions(self.study);
        let is_swept = |choice: &Choice| choice.combination < self.results.combinations.len();
        let counts = !requested.is_empty() || !self.choices.iter().all(is_swept);
        let mut backends = counts.then(open).transpose()?;
        let mut conditions: Vec<Conditions> = Vec::new();
        for (choice, what_if) in self.choices.iter().zip(&self.what_ifs) {
            conditions.push(match &mut backends {
                Some(backends) if !is_swept(choice) => count_plan(what_if, self.results, backends, progress)?,
                _ => Conditions::from_results(self.study, self.results, choice)?,
            });
        }
        let work = (&requested[..], &self.grounds[..]);
        let draws = add_cases(
            &self.what_ifs,
            &mut conditions,
            work,
            (backends.as_mut().map(|backends| backends as &mut dyn BackendFactory), open),
            progress,
        )?;
        let each = self.choices.iter().zip(conditions).zip(&self.caveats);
        let judged = each.map(|((choice, conditions), caveats)| {
            let set = match is_swept(choice) {
                true => JudgedSet::new(&self.study.requirements, self.results, choice, conditions),
                false => JudgedSet::not_swept((self.study, self.worlds), choice, conditions),
            };
            JudgedSet { caveats: caveats.clone(), ..set }
        });
        let sets: Vec<JudgedSet> = judged.collect();
        // All choices have the same postures.
        let posture_cases = sets.first().map_or(&[][..], |set| set.conditions.cases(Condition::Postures));
        let warnings = posture_cases.iter().flat_map(|case| case.warnings.clone()).collect();
        Ok(JudgeResult { sets, draws, warnings })
    }

    /// The sets with requirements at each robot speed, and the verdicts there.
    pub fn speeds<'s>(&'s self, sets: &'s [JudgedSet<'s>]) -> Vec<(&'s JudgedSet<'s>, Speeds<'s>)> {
        if self.study.stopping.is_none() {
            return Vec::new();
        }
        sets.iter().filter_map(|set| Some((set, Speeds::new(&self.at_speeds, self.results, set)?))).collect()
    }

    /// Writes the files into the folder of the sweep; returns the verdicts of `judge.json`.
    ///
    /// # Errors
    /// If one cannot be written.
    pub fn write(&self, folder: &Path, judged: &JudgeResult<'_>) -> Result<Verdicts> {
        let JudgeResult { sets, draws, .. } = judged;
        // A file of poses belongs to one choice.
        if let (Some(draws), [_]) = (draws, self.choices) {
            draws.write(folder)?;
        }
        let speeds = self.speeds(sets);
        let verdicts = Verdicts::new(self.study, self.results, sets, &speeds);
        verdicts.write(folder)?;
        requirements_csv(folder, &verdicts.sets)?;
        conditions_csv(folder, &verdicts.sets)?;
        let Some(stopping) = &self.study.stopping else { return Ok(verdicts) };
        if !speeds.is_empty() {
            speeds_csv(folder, self.results, &speeds, stopping)?;
        }
        let moments = sets.iter().flat_map(|set| self.measured_moments(set));
        separation_csv(folder, moments, stopping, self.study.voxel_size_m)?;
        Ok(verdicts)
    }

    /// The measurements of the plan of a set.
    fn measured_moments<'s>(&'s self, set: &'s JudgedSet) -> impl Iterator<Item = MeasuredMoment<'s>> {
        set.conditions.measurements().map(|(moment, separation)| MeasuredMoment {
            set: [&set.combination, &set.poses, &set.representation].map(String::as_str),
            scene: &self.results.scenes[moment.scene].name,
            snapshot_and_repeat: [moment.snapshot, moment.repeat],
            separation: *separation,
        })
    }
}

/// The parts of the regions with requirements that the grid of each scene cuts off.
fn cut_off<'a>(study: &Study, worlds: &'a [World], at_speeds: &[AtEachSpeed]) -> Vec<(&'a str, Vec<String>)> {
    let required = study.requirements.iter().chain(at_speeds.iter().map(|at| &at.requirement));
    let regions: BTreeSet<usize> = required.filter_map(Requirement::region).collect();
    let regions = Vec::from_iter(regions);
    let of_scenes = worlds.chunk_by(|one, next| one.scene == next.scene);
    let of_scenes = of_scenes.map(|scene| (scene[0].name.as_str(), cut_warnings(study, scene, &regions)));
    of_scenes.collect()
}
