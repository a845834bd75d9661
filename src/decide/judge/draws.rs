//! Shifted mounts: drawn from the study's mounting error, the same on every machine.
//!
//! Each mount is drawn separately, so the draws of a sensor do not depend on the sensors that are judged with it. The hashed
//! words are the seed, a word of its own, sensor, candidate, draw and attempt. An impossible draw (outside the grid, inside
//! a solid body) is drawn again; a mount without a place stays as planned, which is reported.

use std::path::Path;

use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::pose::Pose;
use perirobot_study::input::{MountingError, Study};
use perirobot_study::sensor::{Candidate, Setting, Stance};
use perirobot_study::world::World;
use perirobot_sweep::results::files::DRAWS;
use perirobot_sweep::results::table::{Column, ColumnKind, Datum, TableFile, TableFormat};

/// Attempts per draw; if all fail, the mount stays as planned, which is reported.
const ATTEMPTS: u32 = 100;

/// Sensors at drawn mounts.
#[derive(Debug)]
pub struct Draws {
    /// The study with a candidate for each draw of each mount, mount by mount. A sensor without a pose keeps its own
    /// candidate.
    pub(super) study: Study,
    /// Its worlds, with the same voxels.
    pub(super) worlds: Vec<World>,
    /// Sensor and candidate of each mount, sensor by sensor.
    mounts: Vec<[usize; 2]>,
    /// The mounts that stay as planned because no draw was possible, with the index of the draw; sorted.
    kept: Vec<([usize; 2], u32)>,
    draws: u32,
}

impl Draws {
    /// Draws the mounts of some sensors at their candidates.
    ///
    /// # Errors
    /// If no mount has a possible draw.
    pub(super) fn new(
        study: &Study,
        worlds: &[World],
        error: &MountingError,
        used: impl Iterator<Item = [usize; 2]>,
    ) -> Result<Draws> {
        let has_pose = |&[sensor, candidate]: &[usize; 2]| {
            matches!(study.sensors[sensor].candidates[candidate].setting, Setting::Pose(_))
        };
        let mut mounts: Vec<[usize; 2]> = used.filter(has_pose).collect();
        mounts.sort_unstable();
        mounts.dedup();
        let (mut drawn, mut kept) = (study.clone(), Vec::new());
        for (index, sensor) in drawn.sensors.iter_mut().enumerate() {
            let of_it: Vec<usize> =
                mounts.iter().filter(|mount| mount[0] == index).map(|mount| mount[1]).collect();
            if of_it.is_empty() {
                continue;
            }
            let mut candidates = Vec::new();
            for planned in of_it {
                let Candidate { name, group, setting } = &sensor.candidates[planned];
                for draw in 0..error.draws {
                    let words = [index, planned, draw as usize];
                    let planned_pose = setting.pose();
                    let found = draw_one(study, worlds, error, words, candidates.len(), &planned_pose);
                    if found.is_none() {
                        kept.push(([index, planned], draw));
                    }
                    let pose = found.unwrap_or(planned_pose);
                    let name = format!("{name}~{draw}");
                    candidates.push(Candidate { name, group: group.clone(), setting: Setting::Pose(pose) });
                }
            }
            sensor.candidates = candidates;
        }
        if !mounts.is_empty() && kept.len() == mounts.len() * error.draws as usize {
            return Err(nothing_moves(study, &mounts));
        }
        let worlds = worlds.iter().map(|world| world.with_sensors(&drawn.sensors)).collect();
        Ok(Draws { study: drawn, worlds, mounts, kept, draws: error.draws })
    }

    /// Fails if every draw of every mount of some members is as planned.
    pub(super) fn check_some_move(&self, study: &Study, members: &[[usize; 3]]) -> Result<()> {
        let own = members.iter().map(|&[sensor, candidate, _]| [sensor, candidate]);
        let own: Vec<[usize; 2]> = own.filter(|mount| self.mounts.contains(mount)).collect();
        let is_kept = |mount: &[usize; 2]| (0..self.draws).all(|draw| self.keeps(*mount, draw));
        match !own.is_empty() && own.iter().all(is_kept) {
            true => Err(nothing_moves(study, &own)),
            false => Ok(()),
        }
    }

    /// Whether a mount stays as planned in a draw, since none was possible.
    pub(super) fn keeps(&self, mount: [usize; 2], draw: u32) -> bool {
        self.kept.binary_search(&(mount, draw)).is_ok()
    }

    /// The candidate of a mount in a draw.
    pub(super) fn candidate(&self, [sensor, candidate]: [usize; 2], draw: u32) -> usize {
        let of_it = self.mounts.iter().filter(|mount| mount[0] == sensor);
        let place = of_it.map(|mount| mount[1]).position(|known| known == candidate);
        place.map_or(candidate, |place| place * self.draws as usize + draw as usize)
    }

    /// Writes the poses in the format of a study: `csv = "draws.csv"`.
    ///
    /// # Errors
    /// Those of the disk.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let mut columns = ["sensor", "pose"].map(|name| Column::new(name, ColumnKind::Text)).to_vec();
        columns.push(Column::new("draw", ColumnKind::Count));
        let numbers = ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"];
        columns.extend(numbers.map(|name| Column::new(name, ColumnKind::Score)));
        let mut table = TableFile::create(&folder.join(DRAWS), TableFormat::Csv, &columns)?;
        let mut before = None;
        for &[sensor, _] in &self.mounts {
            if before.replace(sensor) == Some(sensor) {
                continue;
            }
            let spec = &self.study.sensors[sensor];
            for (row, candidate) in spec.candidates.iter().enumerate() {
                let Pose { position_m: p, rotation: q } = candidate.setting.pose();
                let mut fields = [&spec.name, &candidate.name].map(|name| Datum::Text(name)).to_vec();
                fields.push(Datum::Count(row as u64 % u64::from(self.draws)));
                fields.extend([p.x, p.y, p.z, q.w, q.x, q.y, q.z].map(|number| Datum::Score(Some(number))));
                table.row(&fields)?;
            }
        }
        table.finish()
    }
}

/// The error if every draw of every mount is as planned: verdicts under mounting error would equal those of the plan.
fn nothing_moves(study: &Study, mounts: &[[usize; 2]]) -> Error {
    let name = |&[sensor, candidate]: &[usize; 2]| {
        let sensor = &study.sensors[sensor];
        format!("{}:{}", sensor.name, sensor.candidates[candidate].name)
    };
    let names: Vec<String> = mounts.iter().map(name).collect();
    let what = format!(
        "mounting_error: no draw of {} is possible: each leaves the grid, is inside a solid object, or the sensor cannot work there",
        names.join(" or ")
    );
    let wanted = "make the scene's room larger or the error smaller, or judge other poses";
    Issue::says(what).with_advice(wanted.to_string()).with_place(&study.path).into()
}

/// One draw of a mount, if possible. `number` is the index of its candidate in the study of the draws.
fn draw_one(
    study: &Study,
    worlds: &[World],
    error: &MountingError,
    [sensor, candidate, draw]: [usize; 3],
    number: usize,
    planned: &Pose,
) -> Option<Pose> {
    let is_level = study.sensors[sensor].kind.stance() == Stance::Level;
    let attempt =
        |attempt| error.off.mount(planned, error.seed, [sensor, candidate, draw], attempt, is_level);
    let is_possible =
        |pose: &Pose| worlds.iter().all(|world| world.takes(study, [sensor, number], planned, pose));
    (0..ATTEMPTS).map(attempt).find(is_possible)
}
