//! A controller's measured distances with a choice of sensors, as planned and in the required cases.

use super::alteration::Alteration;
use super::cases::{Case, Conditions};
use super::draws::Draws;
use super::postures::{PostureStudy, find_posture};
use super::scope::controller_conditions;
use super::what_if::WhatIf;
use crate::controller::measure;
use crate::view::Choice;
use perirobot_march::Result;
use perirobot_march::backend::Backend;
use perirobot_march::progress::Progress;
use perirobot_study::input::Study;
use perirobot_study::world::World;

impl WhatIf<'_> {
    /// The number of cases in [`measure_cases`], each moment counted.
    pub fn total_measured(&self) -> u64 {
        let controlled = controller_conditions(self.study);
        self.cases_under(&controlled) * self.worlds.len() as u64 * u64::from(self.study.repeats)
    }
}

/// A case of a choice, with its active members.
type SpeakingCase<'c, 'w> = (&'c WhatIf<'w>, Vec<[usize; 3]>, &'c mut Case);

/// Adds a controller's measurements to the cases of each condition with such a requirement, choice by choice.
///
/// # Errors
/// If the backend fails; `Error::Stopped`.
pub fn measure_cases(
    what_ifs: &[WhatIf],
    conditions: &mut [Conditions],
    draws: Option<&Draws>,
    backend: &mut dyn Backend,
    progress: &dyn Progress,
) -> Result<()> {
    let Some(WhatIf { study, worlds, .. }) = what_ifs.first() else { return Ok(()) };
    let controlled = controller_conditions(study);
    let (mut planned, mut drawn) = (Vec::new(), Vec::new());
    let mut by_posture: Vec<(String, Vec<SpeakingCase>)> = Vec::new();
    for (what_if, conditions) in what_ifs.iter().zip(conditions) {
        let of_asked = conditions.cases.iter_mut().filter(|(condition, _)| controlled.contains(condition));
        for case in of_asked.flat_map(|(_, cases)| cases) {
            match (&case.alteration, draws) {
                (Alteration::None, _) => planned.push((what_if, what_if.members.clone(), case)),
                (Alteration::Dead(dead), _) => {
                    let members = what_if.remaining_members(&what_if.dead(dead)?);
                    planned.push((what_if, members, case));
                }
                (Alteration::Draw(draw), Some(draws)) => {
                    drawn.push((what_if, what_if.draw(draws, *draw), case));
                }
                (Alteration::Draw(_), None) => {}
                (Alteration::Posture(name), _) => {
                    let name = name.clone();
                    let own = (what_if, what_if.members.clone(), case);
                    match by_posture.iter_mut().find(|(known, _)| *known == name) {
                        Some((_, cases)) => cases.push(own),
                        None => by_posture.push((name, vec![own])),
                    }
                }
            }
        }
    }
    measure_in(study, worlds, planned, backend, progress)?;
    if let Some(draws) = draws {
        measure_in(&draws.study, &draws.worlds, drawn, backend, progress)?;
    }
    for (name, cases) in by_posture {
        let PostureStudy { study, worlds, .. } =
            PostureStudy::new(study, worlds, find_posture(study, &name)?)?;
        measure_in(&study, &worlds, cases, backend, progress)?;
    }
    Ok(())
}

/// Measures cases with the same voxels, each with its active sensors.
fn measure_in(
    study: &Study,
    worlds: &[World],
    cases: Vec<SpeakingCase>,
    backend: &mut dyn Backend,
    progress: &dyn Progress,
) -> Result<()> {
    let mut combinations = Vec::new();
    let mut set = |what_if: &WhatIf, members: &[[usize; 3]]| {
        (!members.is_empty()).then(|| {
            let (combination, representation) = what_if.as_combination(study, members, String::new());
            combinations.push(combination);
            Choice { combination: combinations.len() - 1, choice: 0, representation, repeat: 0 }
        })
    };
    let sets: Vec<Option<Choice>> = cases.iter().map(|(what_if, members, _)| set(what_if, members)).collect();
    let study = Study { combinations, ..study.clone() };
    let measured = measure(&study, worlds, &sets, backend, progress)?;
    cases.into_iter().zip(measured).for_each(|((.., case), measured)| case.measured = measured);
    Ok(())
}
