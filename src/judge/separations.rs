//! What a controller would measure of sets of sensors at each moment, and `separation.csv`, a row for each moment and
//! each speed of the robot.

use std::path::Path;

use super::cases::Moment;
use super::judged::JudgedSet;
use super::separation::{Decision, Separation, Surroundings};
use crate::backend::Backend;
use crate::error::Issue;
use crate::results::Subject;
use crate::results::files::SEPARATION;
use crate::results::table::{Column, ColumnKind, Datum, TableFile, TableFormat};
use crate::study::{Stopping, Study};
use crate::view::{Choice, Viewer};
use crate::world::World;
use crate::{Error, Result};

/// What is measured of a set of sensors at each moment.
pub type Separations = Vec<(Moment, Separation)>;

/// What is measured of each choice of a study. `stop` is asked before each view, and may give a reason to stop.
///
/// # Errors
/// When the backend fails; `Error::Stopped` with that reason.
pub fn separations(
    study: &Study,
    worlds: &[World],
    choices: &[Choice],
    backend: &mut dyn Backend,
    stop: &dyn Fn() -> Option<String>,
) -> Result<Vec<Separations>> {
    let mut viewer = Viewer::new(study, backend)?;
    let mut all = vec![Separations::new(); choices.len()];
    for world in worlds {
        let surroundings = Surroundings::of(world);
        for repeat in 0..study.repeats as usize {
            let moment = Moment { scene: world.scene, snapshot: world.snapshot, repeat };
            for (choice, own) in choices.iter().zip(&mut all) {
                if let Some(why) = stop() {
                    return Err(Error::Stopped(Issue::says(why)));
                }
                let view = viewer.view(world, Choice { repeat, ..*choice })?;
                own.push((moment, surroundings.separation(&view)));
            }
        }
    }
    Ok(all)
}

/// Writes the table; `sets` are those that were judged with what is measured of each.
pub fn separation_csv(
    folder: &Path,
    subject: &Subject,
    sets: &[(&JudgedSet, &Separations)],
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
    for (set, separations) in sets {
        for (moment, separation) in *separations {
            let Separation { truly, unknown_free, unknown_occupied } = *separation;
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
