//! A judged choice of sensors, and its members in each altered case, which `counting` counts.

use super::draws::Draws;
use crate::view::Choice;
use perirobot_march::backend::Fusion;
use perirobot_march::error::{Argument, Issue, Site};
use perirobot_march::{Error, Result};
use perirobot_study::input::{Combination, Condition, Member, MountingError, Study};
use perirobot_study::world::World;

/// A choice of sensors to be counted in altered cases.
pub struct WhatIf<'a> {
    pub(super) study: &'a Study,
    pub(super) worlds: &'a [World],
    pub(super) fusion: Fusion,
    /// Sensor, candidate and representation of each member.
    pub(super) members: Vec<[usize; 3]>,
}

impl<'a> WhatIf<'a> {
    /// A choice of a study.
    pub fn new(study: &'a Study, worlds: &'a [World], choice: &Choice) -> WhatIf<'a> {
        let combination = &study.combinations[choice.combination];
        let ways = combination.representations(&study.sensors).swap_remove(choice.representation);
        let members = combination.members.iter().zip(combination.choice(choice.choice)).zip(ways);
        let members = members.map(|((member, candidate), way)| [member.sensor, candidate, way]);
        WhatIf { study, worlds, fusion: combination.fusion, members: members.collect() }
    }

    /// The number of cases to count, with the plan, in each snapshot and repeat; 0 without conditions besides the plan.
    pub fn total(&self, asked: &[Condition]) -> u64 {
        let all = [&[Condition::AsPlanned], asked].concat();
        let silent =
            self.left_out(&all).iter().filter(|(_, dead)| dead.len() == self.members.len()).count() as u64;
        let moments = self.worlds.len() as u64 * u64::from(self.study.repeats);
        if asked.is_empty() { 0 } else { (self.cases_under(&all) - silent) * moments }
    }

    pub(super) fn error(&self, asked: &[Condition]) -> Option<&MountingError> {
        self.study.mounting_error.as_ref().filter(|_| asked.contains(&Condition::MountingError))
    }

    pub(super) fn draws(&self, error: &MountingError) -> Result<Draws> {
        Draws::new(self.study, self.worlds, error, self.members.iter().map(|&[s, c, _]| [s, c]))
    }

    /// The members in one draw of their mounts.
    pub(super) fn draw(&self, draws: &Draws, draw: u32) -> Vec<[usize; 3]> {
        self.members.iter().map(|&[s, c, way]| [s, draws.candidate([s, c], draw), way]).collect()
    }

    /// The names of the members that stay as planned in a draw.
    pub(super) fn planned_members(&self, draws: &Draws, draw: u32) -> Vec<String> {
        let kept = self.members.iter().filter(|&&[s, c, _]| draws.keeps([s, c], draw));
        kept.map(|&member| self.name(member)).collect()
    }

    /// The dead sensors of each case, with the plan first, if sensors are left out.
    pub(super) fn left_out(&self, asked: &[Condition]) -> Vec<(Condition, Vec<usize>)> {
        let mut dead = vec![(Condition::AsPlanned, Vec::new())];
        for (condition, count) in [(Condition::OneSensorDead, 1), (Condition::TwoSensorsDead, 2)] {
            if asked.contains(&condition) {
                let cases = dead_members(self.members.len(), count).into_iter();
                dead.extend(cases.map(|dead| (condition, dead)));
            }
        }
        dead
    }

    /// The indices of the members with these names.
    ///
    /// # Errors
    /// If a name is unknown.
    pub(super) fn dead(&self, sensors: &[String]) -> Result<Vec<usize>> {
        let known = self.names();
        let number = |sensor: &String| {
            known.iter().position(|name| name == sensor).ok_or_else(|| {
                let place = Site::Argument(Argument("dead"), sensor.clone());
                Error::from(Issue::unknown(&known).with_place(place))
            })
        };
        sensors.iter().map(number).collect()
    }

    /// The members without those at these indices.
    pub(super) fn remaining_members(&self, dead: &[usize]) -> Vec<[usize; 3]> {
        let left = self.members.iter().enumerate().filter(|(number, _)| !dead.contains(number));
        left.map(|(_, member)| *member).collect()
    }

    /// The names of all members.
    pub(super) fn names(&self) -> Vec<String> {
        self.members.iter().map(|&member| self.name(member)).collect()
    }

    pub(super) fn name(&self, [sensor, candidate, _]: [usize; 3]) -> String {
        let sensor = &self.study.sensors[sensor];
        format!("{}:{}", sensor.name, sensor.candidates[candidate].name)
    }

    /// Members as a combination with one choice of poses, and the index of their representation there.
    pub(super) fn as_combination(
        &self,
        study: &Study,
        members: &[[usize; 3]],
        name: String,
    ) -> (Combination, usize) {
        let combination = WhatIf::combination(members, name, self.fusion);
        let wanted = members.iter().map(|member| member[2]);
        let ways = combination.representations(&study.sensors);
        let way = ways.iter().position(|way| way.iter().copied().eq(wanted.clone())).unwrap_or_default();
        (combination, way)
    }

    /// The number of cases of these conditions.
    pub(super) fn cases_under(&self, asked: &[Condition]) -> u64 {
        let draws = self.error(asked).map_or(0, |error| u64::from(error.draws));
        let postures = if asked.contains(&Condition::Postures) { self.study.postures.len() } else { 0 };
        let left_out = self.left_out(asked);
        let left_out = left_out.iter().filter(|(condition, _)| asked.contains(condition)).count();
        (left_out + postures) as u64 + draws
    }

    /// Members as a combination with one choice of poses.
    pub(super) fn combination(members: &[[usize; 3]], name: String, fusion: Fusion) -> Combination {
        let member = |&[sensor, candidate, _]: &[usize; 3]| Member { sensor, candidates: vec![candidate] };
        Combination { name, fusion, members: members.iter().map(member).collect() }
    }
}

/// The indices of the dead members in each case of a condition with 0, 1 or 2 dead sensors. A single sensor cannot fail
/// twice: the worst case is that it is dead.
pub(crate) fn dead_members(members: usize, dead: usize) -> Vec<Vec<usize>> {
    let all = 0..members;
    match dead {
        0 => vec![Vec::new()],
        2 if members > 1 => all.clone().flat_map(|a| (a + 1..all.end).map(move |b| vec![a, b])).collect(),
        _ => all.map(|one| vec![one]).collect(),
    }
}
