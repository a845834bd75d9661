//! Refined sets, counted again with their poses among those of the study, like a sweep.

use super::around::{Around, RefineSpot};
use super::{Refined, Refinement};
use crate::choose::report::{FinePose, FrontReport, RefinedReport, SensorReport, SetReport};
use crate::choose::verify::recount;
use perirobot_cover::{Ratio, Worth};
use perirobot_march::backend::Backend;
use perirobot_march::error::Issue;
use perirobot_march::metrics::Confusion;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Choose, Study};
use perirobot_study::sensor::turned::Turned;
use perirobot_study::sensor::{Candidate, Cost, Setting};
use perirobot_study::world::World;
use perirobot_study::world::place::Places;

/// Recounts refined sets; returns also the study with their poses, and its worlds, if anything was gained. Noise is
/// drawn for each pose of a study, so the gain may be smaller than in the search, or vanish.
pub(super) fn count_refined(
    (study, choose, worlds): (&Study, &Choose, &[World]),
    front: &FrontReport,
    all: &[Refined],
    backend: &mut dyn Backend,
) -> Result<Refinement> {
    let around = Around::new(study, worlds);
    let without_gain: Vec<RefinedReport> =
        all.iter().map(|refined| refined.report_without_gain(study, front, &around)).collect();
    let mut gaining: Vec<usize> = (0..all.len()).filter(|&number| all[number].worth.is_some()).collect();
    while !gaining.is_empty() {
        let mut with_poses = study.clone();
        let listed: Vec<_> =
            gaining.iter().map(|&number| all[number].list(study, &around, &mut with_poses)).collect();
        let worlds = World::prepare_all(&with_poses)?;
        let places = Places::new(&with_poses, &worlds[0]);
        let recounter = Recounter { study: &with_poses, choose, worlds: &worlds, places };
        let mut reports = without_gain.clone();
        for (&number, (set, poses)) in gaining.iter().zip(listed) {
            recounter.complete(&mut reports[number], all[number].worth, &set, poses, backend)?;
        }
        let before = gaining.len();
        gaining.retain(|&number| reports[number].best.is_some());
        if gaining.len() == before {
            return Ok(Refinement { told: reports, with_poses: Some((with_poses, worlds)), complete: true });
        }
    }
    Ok(Refinement { told: without_gain, with_poses: None, complete: true })
}

impl Refined {
    /// The report of a set without gain.
    fn report_without_gain(&self, study: &Study, front: &FrontReport, around: &Around) -> RefinedReport {
        let step = front.steps.iter().find(|step| step.at_most == self.limits.at_most);
        let step = step.expect("the front contains every refined set");
        let name = |spot: &&RefineSpot| {
            let sensor = &study.sensors[spot.sensor];
            format!("{}:{}", sensor.name, sensor.candidates[spot.candidate].name)
        };
        let stays = |spot: &&RefineSpot| around.stays(spot);
        RefinedReport {
            at_most: self.limits.at_most,
            budget: self.limits.budget.map(Cost::from_thousandths),
            around: step.best.poses.clone(),
            stays: self.listed.iter().filter(stays).map(|spot| name(&spot)).collect(),
            score_before: step.best.score,
            rounds: self.rounds,
            cast: self.cast,
            poses: Vec::new(),
            best: None,
            gain: None,
        }
    }

    /// Adds the poses of the set to a study, and returns the set's candidates there.
    fn list(&self, listed: &Study, around: &Around, study: &mut Study) -> (Vec<[usize; 2]>, Vec<FinePose>) {
        let group = FrontReport::group_of_refined(listed);
        let (mut set, mut poses) = (Vec::new(), Vec::new());
        for (number, spot) in self.spots.iter().enumerate() {
            let Some(pose) = around.pose(spot).filter(|_| spot.is_moved()) else {
                set.push([spot.sensor, spot.candidate]);
                continue;
            };
            let sensor = &mut study.sensors[spot.sensor];
            let near = &sensor.candidates[spot.candidate];
            let Turned { pan_deg, tilt_deg, roll_deg } = Turned::new(&pose);
            let q = pose.rotation;
            poses.push(FinePose {
                sensor: sensor.name.clone(),
                pose: format!("{group}/{}/{}", self.limits.at_most, number + 1),
                near: near.name.clone(),
                position_m: pose.position_m.to_array(),
                quaternion_wxyz: [q.w, q.x, q.y, q.z],
                pan_deg,
                tilt_deg,
                roll_deg,
            });
            set.push([spot.sensor, sensor.candidates.len()]);
            let (name, group) = (poses[poses.len() - 1].pose.clone(), near.group.clone());
            sensor.candidates.push(Candidate { name, group, setting: Setting::Pose(pose) });
        }
        (set, poses)
    }
}

struct Recounter<'a> {
    /// The study with the found poses.
    study: &'a Study,
    choose: &'a Choose,
    worlds: &'a [World],
    places: Places<'a>,
}

impl Recounter<'_> {
    /// Completes the report of a set, if it beats its origin and meets the requirements.
    fn complete(
        &self,
        report: &mut RefinedReport,
        found: Option<Worth>,
        set: &[[usize; 2]],
        poses: Vec<FinePose>,
        backend: &mut dyn Backend,
    ) -> Result<()> {
        let Choose { objective, over, .. } = *self.choose;
        let mut set = set.to_vec();
        // In a combination, the sensor that takes precedence is last.
        set.sort_by_key(|&[sensor, _]| self.study.sensors[sensor].kind.speaks_last());
        let without = |out: usize| (0..set.len()).filter(|i| *i != out).map(|i| set[i]).collect::<Vec<_>>();
        let mut sets: Vec<Vec<[usize; 2]>> = vec![set.clone()];
        sets.extend((0..set.len()).map(without).filter(|rest| !rest.is_empty()));
        let mut counts = recount(self.study, self.choose, self.worlds, &sets, backend, &|| None)?;
        if set.len() == 1 {
            counts.push(self.nothing_seen());
        }
        let worth = |counts: &Vec<Confusion>| Worth::from_counts(objective, over, counts);
        let reaches = self.choose.require.iter().all(|require| {
            let worth = Worth::from_counts(require.score, require.over, &counts[0]);
            worth.is_some_and(|worth| worth.reaches(Ratio::from_f64(require.at_least)))
        });
        let all_worth = worth(&counts[0]);
        let is_noisy = self.study.sensors.iter().any(|sensor| sensor.kind.is_noisy());
        if !is_noisy && (all_worth != found || !reaches) {
            let what = format!(
                "the refined set of at most {} was searched with {} {:?}, but counted again it has {:?}: please report this",
                report.at_most,
                objective.name(),
                found.map(Worth::value),
                all_worth.map(Worth::value)
            );
            return Err(Error::Disagreement(Issue::says(what)));
        }
        let Some(all_worth) = all_worth.filter(|worth| reaches && worth.value() > report.score_before) else {
            return Ok(());
        };
        let sensors = set.iter().enumerate().map(|(number, &[sensor, candidate])| {
            let spec = &self.study.sensors[sensor];
            SensorReport {
                sensor: spec.name.clone(),
                pose: spec.candidates[candidate].name.clone(),
                place: self.places.words(sensor, candidate),
                cost: spec.terms.cost,
                score_without: worth(&counts[number + 1]).map(Worth::value),
            }
        });
        report.best = Some(SetReport::new(sensors.collect(), all_worth));
        report.gain = Some(all_worth.value() - report.score_before);
        report.poses = poses;
        Ok(())
    }

    /// The counts without any sensor.
    fn nothing_seen(&self) -> Vec<Confusion> {
        let moment = |world: &World| world.baselines[self.choose.region].nothing_seen;
        (0..self.study.repeats).flat_map(|_| self.worlds.iter().map(moment)).collect()
    }
}
