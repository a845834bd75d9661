//! `separation.csv`: measured distances at each moment, and the decision at each speed of the robot.

use std::path::Path;

use super::separation::{Decision, Separation};
use perirobot_march::Result;
use perirobot_study::input::Stopping;
use perirobot_sweep::results::files::SEPARATION;
use perirobot_sweep::results::table::{Column, ColumnKind, Datum, TableFile, TableFormat};

/// The measurement of a set of sensors at a moment.
pub(crate) struct MeasuredMoment<'m> {
    /// Combination, poses and representation of the set, as in results.csv.
    pub set: [&'m str; 3],
    /// The scene, by its name.
    pub scene: &'m str,
    /// Snapshot and repeat.
    pub snapshot_and_repeat: [usize; 2],
    /// The measured distances.
    pub separation: Separation,
}

/// Writes a row for each moment and each speed of the robot.
pub(crate) fn separation_csv<'m>(
    folder: &Path,
    moments: impl Iterator<Item = MeasuredMoment<'m>>,
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
    for MeasuredMoment { set, scene, snapshot_and_repeat, separation } in moments {
        let Separation { truly, unknown_free, unknown_occupied, .. } = separation;
        for at in &stopping.speeds {
            let mut row: Vec<Datum> = set.map(Datum::Text).to_vec();
            row.push(Datum::Text(scene));
            row.extend(snapshot_and_repeat.map(|n| Datum::Count(n as u64)));
            for squared in [truly, unknown_free, unknown_occupied] {
                let metres = squared.map(|squared| Separation::metres(squared, voxel_size_m));
                row.extend([metres, squared.map(f64::from)].map(Datum::Score));
            }
            let numbers = [separation.missed_m(voxel_size_m), Some(at.speed_m_s), Some(at.needed_m)];
            row.extend(numbers.map(Datum::Score));
            let decision = |measured| Decision::new(measured, truly, at.needed_m, voxel_size_m).name();
            row.extend([unknown_free, unknown_occupied].map(|measured| Datum::Text(decision(measured))));
            table.row(&row)?;
        }
    }
    table.finish()
}
