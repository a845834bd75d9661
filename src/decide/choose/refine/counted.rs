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

/// Tells what was found; with it comes the study that has its poses, and its worlds, if anything was gained. With
/// noise, which is drawn for each pose of a study, a sweep may see less gained than there was, or nothing.
pub(super) fn count_refined(
    (study, choose, worlds): (&Study, &Choose, &[World]),
    told: &FrontReport,
    all: &[Refined],
    backend: &mut dyn Backend,
) -> Result<Refinement> {
    let around = Around::new(study, worlds);
    let untold: Vec<RefinedReport> = all.iter().map(|refined| refined.untold(study, told, &around)).collect();
    let mut gaining: Vec<usize> = (0..all.len()).filter(|&number| all[number].worth.is_some()).collect();
    while !gaining.is_empty() {
        let mut with_poses = study.clone();
        let listed: Vec<_> =
            gaining.iter().map(|&number| all[number].list(study, &around, &mut with_poses)).collect();
        let worlds = World::prepare_all(&with_poses)?;
        let places = Places::new(&with_poses, &worlds[0]);
        let telling = Telling { study: &with_poses, choose, worlds: &worlds, places };
        let mut told = untold.clone();
        for (&number, (set, poses)) in gaining.iter().zip(listed) {
            telling.tell(&mut told[number], all[number].worth, &set, poses, backend)?;
        }
        let before = gaining.len();
        gaining.retain(|&number| told[number].best.is_some());
        if gaining.len() == before {
            return Ok(Refinement { told, with_poses: Some((with_poses, worlds)), complete: true });
        }
    }
    Ok(Refinement { told: untold, with_poses: None, complete: true })
}

impl Refined {
    /// What is told where nothing was gained.
    fn untold(&self, study: &Study, told: &FrontReport, around: &Around) -> RefinedReport {
        let step = told.steps.iter().find(|step| step.at_most == self.limits.at_most);
        let step = step.expect("a set that was found is told");
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

    /// Lists the poses of the set in a study, and says which of its candidates the set then has.
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

struct Telling<'a> {
    /// The study with the poses that were found.
    study: &'a Study,
    choose: &'a Choose,
    worlds: &'a [World],
    places: Places<'a>,
}

impl Telling<'_> {
    /// Tells a set, if it is better than the one it began with and meets what is required.
    fn tell(
        &self,
        told: &mut RefinedReport,
        found: Option<Worth>,
        set: &[[usize; 2]],
        poses: Vec<FinePose>,
        backend: &mut dyn Backend,
    ) -> Result<()> {
        let Choose { objective, over, .. } = *self.choose;
        let mut set = set.to_vec();
        // As in a combination, who speaks last stands last.
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
                "the refined set of at most {} was searched with {} {:?}, and counted again it has {:?}: report this",
                told.at_most,
                objective.name(),
                found.map(Worth::value),
                all_worth.map(Worth::value)
            );
            return Err(Error::Disagreement(Issue::says(what)));
        }
        let Some(all_worth) = all_worth.filter(|worth| reaches && worth.value() > told.score_before) else {
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
        told.best = Some(SetReport::new(sensors.collect(), all_worth));
        told.gain = Some(all_worth.value() - told.score_before);
        told.poses = poses;
        Ok(())
    }

    /// The counts of no sensor at all.
    fn nothing_seen(&self) -> Vec<Confusion> {
        let moment = |world: &World| world.baselines[self.choose.region].nothing_seen;
        (0..self.study.repeats).flat_map(|_| self.worlds.iter().map(moment)).collect()
    }
}
