//! What a controller would measure of a choice of sensors, as planned and in the cases in which something is required of
//! it.

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
    /// How many cases [`WhatIf::measure`] looks at, at each moment for itself.
    pub fn total_measured(&self) -> u64 {
        let asked = controller_conditions(self.study);
        self.cases_under(&asked) * self.worlds.len() as u64 * u64::from(self.study.repeats)
    }

    /// Adds to the cases of each condition that asks for it what a controller would measure.
    ///
    /// # Errors
    /// When the backend fails; `Error::Stopped`.
    pub fn measure(
        &self,
        conditions: &mut Conditions,
        draws: Option<&Draws>,
        backend: &mut dyn Backend,
        progress: &dyn Progress,
    ) -> Result<()> {
        let asked = controller_conditions(self.study);
        let of_asked = conditions.cases.iter_mut().filter(|(condition, _)| asked.contains(condition));
        for (_, cases) in of_asked {
            let (mut planned, mut drawn) = (Vec::new(), Vec::new());
            for case in cases {
                match (&case.alteration, draws) {
                    (Alteration::None, _) => planned.push((self.members.clone(), case)),
                    (Alteration::Dead(dead), _) => {
                        planned.push((self.remaining_members(&self.dead(dead)?), case))
                    }
                    (Alteration::Draw(draw), Some(draws)) => drawn.push((self.draw(draws, *draw), case)),
                    (Alteration::Draw(_), None) => {}
                    (Alteration::Posture(name), _) => {
                        let Stood { study, worlds, .. } =
                            Stood::new(self.study, self.worlds, find_posture(self.study, name)?)?;
                        let own = vec![(self.members.clone(), case)];
                        self.measure_in(&study, &worlds, own, backend, progress)?;
                    }
                }
            }
            self.measure_in(self.study, self.worlds, planned, backend, progress)?;
            if let Some(draws) = draws {
                self.measure_in(&draws.study, &draws.worlds, drawn, backend, progress)?;
            }
        }
        Ok(())
    }

    /// Measures cases in the same voxels, each with the sensors that speak in it.
    fn measure_in(
        &self,
        study: &Study,
        worlds: &[World],
        cases: Vec<(Vec<[usize; 3]>, &mut Case)>,
        backend: &mut dyn Backend,
        progress: &dyn Progress,
    ) -> Result<()> {
        let mut combinations = Vec::new();
        let mut set = |members: &[[usize; 3]]| {
            (!members.is_empty()).then(|| {
                let (combination, representation) = self.as_combination(study, members, String::new());
                combinations.push(combination);
                Choice { combination: combinations.len() - 1, choice: 0, representation, repeat: 0 }
            })
        };
        let sets: Vec<Option<Choice>> = cases.iter().map(|(members, _)| set(members)).collect();
        let study = Study { combinations, ..study.clone() };
        let measured = measure(&study, worlds, &sets, backend, progress)?;
        cases.into_iter().zip(measured).for_each(|((_, case), measured)| case.measured = measured);
        Ok(())
    }
}
