//! A plan counted at one moment.

use std::sync::Arc;
use std::time::{Duration, Instant};

use perirobot_march::Result;
use perirobot_march::backend::{Backend, Planes, fuse};
use perirobot_march::metrics::Confusion;
use perirobot_march::voxel::Grid;
use perirobot_scene::truth::region::window_of;
use perirobot_study::input::{Planned, PlannedAt, Study};
use perirobot_study::world::World;

use super::cell::ReadyMoment;
use super::evidence::{HeldEvidence, Said};
use super::floor::FloorMap;
use super::frustum::Frustum;
use super::{Live, Resolution};

/// What is to be counted.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoreRequest {
    /// The sensors.
    pub plan: Vec<Planned>,
    /// At which moment, as [`Live::worlds`] numbers them.
    pub moment: usize,
    /// In which repeat, for sensors with noise; 0 is the first.
    pub repeat: usize,
    /// In which voxels.
    pub resolution: Resolution,
    /// Which of the sensors is dead, by its place in the plan.
    pub dead: Option<usize>,
}

/// What is wrong with a sensor where it is placed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlacedProblem {
    /// Its place in the plan.
    pub index: usize,
    /// In words, with what to do.
    pub words: String,
    /// Whether it is left out, since it cannot be counted there.
    pub is_left_out: bool,
}

/// What was counted.
#[derive(Clone, Debug)]
pub struct ScoreAnswer {
    /// The grid.
    pub grid: Grid,
    /// The counts of each region, as a sweep has them.
    pub counts: Vec<Confusion>,
    /// The labels over the window of all regions: occupied, free, and which voxels are truly hit. What is neither is unknown.
    pub labels: Planes,
    /// How many sensors watch each spot of the floor.
    pub floor: FloorMap,
    /// For each sensor of the plan where its rays end; `None` of one without rays, or that is dead or left out.
    pub frustums: Vec<Option<Arc<Frustum>>>,
    /// What is wrong with sensors where they are.
    pub problems: Vec<PlacedProblem>,
    /// How long it took.
    pub took: Duration,
}

impl Live {
    /// Counts a plan at a moment. A sensor that cannot be counted where it is is left out.
    ///
    /// # Errors
    /// A plan, a moment or a repeat that the study does not have; when the backend fails.
    pub fn score(&mut self, request: &ScoreRequest) -> Result<ScoreAnswer> {
        let begin = Instant::now();
        let &ScoreRequest { ref plan, moment, repeat, resolution, dead } = request;
        let cell = self.cell(resolution)?;
        let (kept, mut problems) = without_doubles(&cell.study, plan);
        let planned: Vec<Planned> = kept.iter().map(|&index| plan[index]).collect();
        let (study, candidates) = cell.study.with_plan(&planned)?;
        let (ready, world) = (cell.ready(moment)?, cell.world(moment)?.with_sensors(&study.sensors));
        let mut placed: Vec<(usize, [usize; 2])> = Vec::new();
        for ((&index, planned), candidate) in kept.iter().zip(&planned).zip(candidates) {
            let member = [planned.sensor, candidate];
            match world.impossible_placement(&study, member) {
                Some(words) => problems.push(PlacedProblem { index, words, is_left_out: true }),
                None if dead == Some(index) => {}
                None => placed.push((index, member)),
            }
        }
        let members: Vec<[usize; 2]> = placed.iter().map(|(_, member)| *member).collect();
        let of = (resolution, moment, repeat);
        let held = self.held.take().filter(|held| held.is_of(of));
        let mut held = Some(held);
        let counted = self.use_backend(|backend| {
            // After a device has failed, nothing is held.
            let known = held.take().flatten().map_or_else(|| HeldEvidence::new(of, &world, backend), Ok)?;
            count(&study, &world, &members, &ready, known, backend)
        });
        let (said, counts, held) = counted?;
        self.held = Some(held);
        let voices = speaking(&study, &members);
        let voices: Vec<(Planes, [i32; 2])> = voices
            .map(|place| {
                let kind = &study.sensors[members[place][0]].kind;
                (Planes::clone(&said[place].planes), kind.log_odds(0))
            })
            .collect();
        let labels = fuse(window_of(&world.regions), study.combinations[0].fusion, &voices);
        let mut frustums = vec![None; plan.len()];
        for ((index, _), said) in placed.iter().zip(&said) {
            frustums[*index] = said.frustum.clone();
            let problem = said.problem.iter();
            problems.extend(problem.map(|problem| PlacedProblem {
                index: *index,
                words: problem.words.clone(),
                is_left_out: false,
            }));
        }
        problems.sort_by_key(|problem| problem.index);
        Ok(ScoreAnswer {
            grid: world.grid,
            counts,
            labels,
            floor: ready.floor.map(said.iter().map(|said| &*said.planes)),
            frustums,
            problems,
            took: begin.elapsed(),
        })
    }
}

/// The places of a plan's sensors but for one that is at the listed pose of an equal one, and what to say of that.
pub(super) fn without_doubles(study: &Study, plan: &[Planned]) -> (Vec<usize>, Vec<PlacedProblem>) {
    let (mut kept, mut problems): (Vec<usize>, Vec<PlacedProblem>) = (Vec::new(), Vec::new());
    for (index, planned) in plan.iter().enumerate() {
        let is_listed = matches!(planned.at, PlannedAt::Listed(_));
        if is_listed && kept.iter().any(|&other| plan[other] == *planned) {
            let name = study.sensors.get(planned.sensor).map_or("", |sensor| sensor.name.as_str());
            let words = format!("another {name:?} is at this very pose: move one of the two");
            problems.push(PlacedProblem { index, words, is_left_out: true });
        } else {
            kept.push(index);
        }
    }
    (kept, problems)
}

/// The places of members in the order they speak.
fn speaking(study: &Study, members: &[[usize; 2]]) -> impl Iterator<Item = usize> {
    let order = study.combinations[0].members.iter().map(|member| [member.sensor, member.candidates[0]]);
    order.filter_map(|own| members.iter().position(|member| *member == own))
}

/// What members say, what is counted of them in each region, and what the backend then holds.
fn count(
    study: &Study,
    world: &World,
    members: &[[usize; 2]],
    ready: &ReadyMoment,
    mut held: HeldEvidence,
    backend: &mut dyn Backend,
) -> Result<(Vec<Said>, Vec<Confusion>, HeldEvidence)> {
    let frustum = |_: usize, rays: &_, from: &_| Frustum::new(rays, from, &world.grid, &ready.search);
    let said = held.say((study, world), members, &frustum, backend)?;
    if members.is_empty() {
        let nothing = world.baselines.iter().map(|region| region.nothing_seen).collect();
        return Ok((said, nothing, held));
    }
    let job = speaking(study, members).filter_map(|place| said[place].reading).collect();
    let counts = backend.score(study.combinations[0].fusion, &[job])?.swap_remove(0);
    Ok((said, counts, held))
}
