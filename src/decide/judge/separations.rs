//! What a controller would measure of sets of sensors at each moment, as planned and in the cases in which something is
//! required of it, and `separation.csv`, a row for each moment and each speed of the robot.

use std::path::Path;

use super::alteration::Alteration;
use super::cases::{Case, Conditions};
use super::draws::Draws;
use super::judged::JudgedSet;
use super::postures::{Stood, named};
use super::scope::controller_conditions;
use super::separation::{Decision, Separation, Surroundings};
use super::what_if::WhatIf;
use crate::view::{Choice, Viewer};
use perirobot_march::backend::Backend;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_study::study::{Stopping, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::Subject;
use perirobot_sweep::results::files::SEPARATION;
use perirobot_sweep::results::table::{Column, ColumnKind, Datum, TableFile, TableFormat};
use perirobot_sweep::sweep::Watch;

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
        watch: &mut dyn Watch,
    ) -> Result<()> {
        let asked = controller_conditions(self.study);
        let of_asked = conditions.cases.iter_mut().filter(|(condition, _)| asked.contains(condition));
        for (_, cases) in of_asked {
            let (mut planned, mut drawn) = (Vec::new(), Vec::new());
            for case in cases {
                match (&case.alteration, draws) {
                    (Alteration::None, _) => planned.push((self.members.clone(), case)),
                    (Alteration::Dead(dead), _) => planned.push((self.without(&self.dead(dead)?), case)),
                    (Alteration::Draw(draw), Some(draws)) => drawn.push((self.drawn(draws, *draw), case)),
                    (Alteration::Draw(_), None) => {}
                    (Alteration::Posture(name), _) => {
                        let Stood { study, worlds, .. } =
                            Stood::new(self.study, self.worlds, named(self.study, name)?)?;
                        let own = vec![(self.members.clone(), case)];
                        self.measure_in(&study, &worlds, own, backend, watch)?;
                    }
                }
            }
            self.measure_in(self.study, self.worlds, planned, backend, watch)?;
            if let Some(draws) = draws {
                self.measure_in(&draws.study, &draws.worlds, drawn, backend, watch)?;
            }
        }
        Ok(())
    }

    /// Measures cases in the same voxels, each with the sensors that speak in it, so that distances from the robot are
    /// computed once for each moment of the scenes.
    fn measure_in(
        &self,
        study: &Study,
        worlds: &[World],
        mut cases: Vec<(Vec<[usize; 3]>, &mut Case)>,
        backend: &mut dyn Backend,
        watch: &mut dyn Watch,
    ) -> Result<()> {
        let (mut combinations, mut choices) = (Vec::new(), Vec::new());
        for (members, case) in &mut cases {
            case.measured = vec![Separation::default(); worlds.len() * study.repeats as usize];
            choices.push((!members.is_empty()).then(|| {
                let (combination, representation) = self.in_ways(study, members, String::new());
                combinations.push(combination);
                Choice { combination: combinations.len() - 1, choice: 0, representation, repeat: 0 }
            }));
        }
        let study = Study { combinations, ..study.clone() };
        let mut viewer = Viewer::new(&study, backend)?;
        for (number, world) in worlds.iter().enumerate() {
            let surroundings = Surroundings::new(world);
            for ((_, case), choice) in cases.iter_mut().zip(&choices) {
                // Moments are listed repeat by repeat.
                let moments = case.measured.iter_mut().skip(number).step_by(worlds.len());
                for (repeat, separation) in moments.enumerate() {
                    if let Some(why) = watch.stop() {
                        return Err(Error::Stopped(Issue::says(why)));
                    }
                    let view =
                        choice.map(|choice| viewer.view(world, Choice { repeat, ..choice })).transpose()?;
                    *separation = surroundings.separation(view.as_ref().map(|view| &view.labels));
                    watch.finished(1);
                }
            }
        }
        Ok(())
    }
}

/// Writes the table of what is measured of the plan of each set.
pub(super) fn separation_csv(
    folder: &Path,
    subject: &Subject,
    sets: &[JudgedSet],
    stopping: &Stopping,
    voxel_size_m: f64,
) -> Result<()> {
    use ColumnKind::{Count, Score, Text};
    let columns = [
        ("combination", Text),
        ("poses", Text),
        ("representation", Text),
        ("scene", Text),
        ("snapshot", Count),
        ("repeat", Count),
        ("true_m", Score),
        ("true_squared", Score),
        ("unknown_free_m", Score),
        ("unknown_free_squared", Score),
        ("unknown_occupied_m", Score),
        ("unknown_occupied_squared", Score),
        ("missed_m", Score),
        ("speed_m_s", Score),
        ("needed_m", Score),
        ("unknown_free", Text),
        ("unknown_occupied", Text),
    ];
    let columns = columns.map(|(name, kind)| Column::new(name, kind));
    let mut table = TableFile::create(&folder.join(SEPARATION), TableFormat::Csv, &columns)?;
    for set in sets {
        for (moment, separation) in set.conditions.measured() {
            let Separation { truly, unknown_free, unknown_occupied, .. } = *separation;
            for at in &stopping.speeds {
                let names = [&set.combination, &set.poses, &set.representation];
                let mut row: Vec<Datum> = names.map(|name| Datum::Text(name)).to_vec();
                row.push(Datum::Text(&subject.scenes[moment.scene].name));
                row.extend([moment.snapshot, moment.repeat].map(|n| Datum::Count(n as u64)));
                for squared in [truly, unknown_free, unknown_occupied] {
                    let metres = squared.map(|squared| Separation::metres(squared, voxel_size_m));
                    row.extend([metres, squared.map(f64::from)].map(Datum::Score));
                }
                let numbers = [separation.missed_m(voxel_size_m), Some(at.speed_m_s), Some(at.needed_m)];
                row.extend(numbers.map(Datum::Score));
                let decision = |measured| Decision::at(measured, truly, at.needed_m, voxel_size_m).name();
                row.extend([unknown_free, unknown_occupied].map(|measured| Datum::Text(decision(measured))));
                table.row(&row)?;
            }
        }
    }
    table.finish()
}
