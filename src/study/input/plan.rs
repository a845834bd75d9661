//! A study that scores one plan: sensors that somebody placed, at listed poses or anywhere else.

use super::{Combination, Member, Study};
use crate::sensor::{Candidate, Setting};
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_march::march::fold;
use perirobot_scene::pose::Pose;

/// The name of a study's combination that is a plan, and the group of the poses that only a plan has.
pub const PLANNED: &str = "planned";

/// A sensor of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planned {
    /// Index of the sensor.
    pub sensor: usize,
    /// Where it is.
    pub at: PlannedAt,
}

/// Where a sensor of a plan is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlannedAt {
    /// At a candidate, by its index.
    Listed(usize),
    /// At a pose in the world, or on the link that carries the sensor. One that is listed is that candidate, so far as that
    /// makes a difference.
    Pose(Pose),
}

impl Study {
    /// The study with a plan as its only combination, and the candidates of the plan's sensors, in the plan's order. Listed
    /// candidates keep their numbers; poses that are not listed come after them, and draw by themselves
    /// ([`Study::elsewhere`]). Sensors speak in the order of the combination [`PLANNED`] of the study, others after them in
    /// study order, equal ones in that of their candidates; it also says how they are fused.
    ///
    /// # Errors
    /// A sensor or a candidate that the study does not have, a pose of a sensor that takes none, two equal sensors at the same
    /// candidate.
    pub fn with_plan(&self, plan: &[Planned]) -> Result<(Study, Vec<usize>)> {
        let mut study = self.clone();
        let mut placed: Vec<[usize; 2]> = Vec::new();
        for &Planned { sensor, at } in plan {
            let Some(spec) = self.sensors.get(sensor) else {
                let what = format!("there is no sensor {sensor}: the study has {}", self.sensors.len());
                return Err(Issue::says(what).into());
            };
            let wrong = |what: String| Issue::says(what).with_place(format!("sensor {:?}", spec.name));
            let candidate = match at {
                PlannedAt::Listed(candidate) if candidate < spec.candidates.len() => candidate,
                PlannedAt::Listed(candidate) => {
                    let what = format!("has no pose {candidate}: it has {}", spec.candidates.len());
                    return Err(wrong(what).into());
                }
                PlannedAt::Pose(_) if !spec.kind.takes_poses() => {
                    return Err(
                        wrong(format!("is of kind {:?}, which takes no poses", spec.kind.name())).into()
                    );
                }
                PlannedAt::Pose(pose) => {
                    let listed = self.listed_candidate(sensor, &pose);
                    let listed = listed.filter(|&candidate| !placed.contains(&[sensor, candidate]));
                    listed.unwrap_or_else(|| study.add_candidate(sensor, pose))
                }
            };
            if placed.contains(&[sensor, candidate]) {
                let name = &spec.candidates[candidate].name;
                return Err(wrong(format!("is twice at pose {name}: move one of the two")).into());
            }
            placed.push([sensor, candidate]);
        }
        let known = self.combinations.iter().find(|combination| combination.name == PLANNED);
        let place = |sensor: usize| {
            let members = known.iter().flat_map(|known| known.members.iter());
            members.enumerate().find(|(_, member)| member.sensor == sensor).map_or(usize::MAX, |(n, _)| n)
        };
        let mut members = placed.clone();
        members.sort_by_key(|&[sensor, candidate]| {
            (self.sensors[sensor].kind.speaks_last(), place(sensor), sensor, candidate)
        });
        let member = |&[sensor, candidate]: &[usize; 2]| Member { sensor, candidates: vec![candidate] };
        study.combinations = vec![Combination {
            name: PLANNED.into(),
            fusion: known.map_or(self.fusion, |known| known.fusion),
            members: members.iter().map(member).collect(),
        }];
        Ok((study, placed.into_iter().map(|[_, candidate]| candidate).collect()))
    }

    /// The candidate of a sensor that is this pose, where its draws depend on that.
    fn listed_candidate(&self, sensor: usize, pose: &Pose) -> Option<usize> {
        let spec = &self.sensors[sensor];
        let matters = spec.kind.is_noisy() || spec.kind.calibration().is_some();
        let wanted = matters.then(|| self.quantise(pose))?;
        spec.candidates.iter().position(|candidate| self.quantise(&candidate.setting.pose()) == wanted)
    }

    /// Adds a pose to a sensor's candidates: its index.
    fn add_candidate(&mut self, sensor: usize, pose: Pose) -> usize {
        let word = 1 << 31 | fold(self.quantise(&pose)) >> 1;
        let spec = &mut self.sensors[sensor];
        let count = spec.candidates.len();
        if spec.draw_words.is_empty() {
            spec.draw_words = (0..count as u32).collect();
        }
        spec.draw_words.push(word);
        let names = (0..).map(|number| format!("{PLANNED}/{number}"));
        let is_free = |name: &String| spec.candidates.iter().all(|known| known.name != *name);
        let name = { names }.find(is_free).expect("a sensor has fewer candidates than there are names");
        spec.candidates.push(Candidate { name, group: PLANNED.into(), setting: Setting::Pose(pose) });
        count
    }
}
