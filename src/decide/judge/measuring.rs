//! Distances that a controller measures with a choice of sensors, as planned and in the cases with a requirement on it.

use super::alteration::Alteration;
use super::cases::{Case, Conditions};
use super::draws::Draws;
use super::postures::{Stood, find_posture};
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
    /// How many cases [`measure_cases`] looks at, at each moment for itself.
    pub fn total_measured(&self) -> u64 {
        let asked = controller_conditions(self.study);
        self.cases_under(&asked) * self.worlds.len() as u64 * u64::from(self.study.repeats)
    }
}

/// A case of a choice, with the members that speak in it.
type SpeakingCase<'c, 'w> = (&'c WhatIf<'w>, Vec<[usize; 3]>, &'c mut Case);

/// Adds to the cases of each condition that asks for it what a controller would measure, choice by choice.
///
/// # Errors
/// When the backend fails; `Error::Stopped`.
pub fn measure_cases(
    what_ifs: &[WhatIf],
    conditions: &mut [Conditions],
    draws: Option<&Draws>,
    backend: &mut dyn Backend,
    progress: &dyn Progress,
) -> Result<()> {
    let Some(WhatIf { study, worlds, .. }) = what_ifs.first() else { return Ok(()) };
    let asked = controller_conditions(study);
    let (mut planned, mut drawn) = (Vec::new(), Vec::new());
    let mut stood: Vec<(String, Vec<SpeakingCase>)> = Vec::new();
    for (what_if, conditions) in what_ifs.iter().zip(conditions) {
        let of_asked = conditions.cases.iter_mut().filter(|(condition, _)| asked.contains(condition));
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
                    match stood.iter_mut().find(|(known, _)| *known == name) {
                        Some((_, cases)) => cases.push(own),
                        None => stood.push((name, vec![own])),
                    }
                }
            }
        }
    }
    measure_in(study, worlds, planned, backend, progress)?;
    if let Some(draws) = draws {
        measure_in(&draws.study, &draws.worlds, drawn, backend, progress)?;
    }
    for (name, cases) in stood {
        let Stood { study, worlds, .. } = Stood::new(study, worlds, find_posture(study, &name)?)?;
        measure_in(&study, &worlds, cases, backend, progress)?;
    }
    Ok(())
}

/// Measures cases in the same voxels, each with the sensors that speak in it.
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
