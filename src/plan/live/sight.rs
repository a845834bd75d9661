//! Which sensors of a plan see a place, and what keeps the others from it.

use glam::DVec3;
use perirobot_decide::view::why::Sighting;
use perirobot_decide::view::{Choice, Viewer};
use perirobot_march::error::Issue;
use perirobot_march::lengths::describe_place;
use perirobot_march::voxel::Grid;
use perirobot_march::{Error, Result};
use perirobot_page::report::describe_cause;
use perirobot_study::input::Planned;

use super::Live;
use super::score::without_doubles;

/// What a sensor knows of a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SensorSight {
    /// Its place in the plan.
    pub index: usize,
    /// Whether it labels the voxel there.
    pub sees: bool,
    /// What it says, or why it says nothing.
    pub words: String,
}

/// What the sensors of a plan know of a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WhyAnswer {
    /// The voxel, from the corner of the grid.
    pub voxel: [i32; 3],
    /// What is truly there: the name of the first object whose surface is, if one is.
    pub object: Option<String>,
    /// Each sensor of the plan.
    pub sensors: Vec<SensorSight>,
}

impl Live {
    /// Tells which sensors of a plan see a place at a moment.
    ///
    /// # Errors
    /// A place outside of the grid; a plan or a moment that the study does not have; when the backend fails.
    pub fn why(&mut self, plan: &[Planned], moment: usize, at_m: DVec3) -> Result<WhyAnswer> {
        let (kept, problems) = without_doubles(self.study()?, plan);
        let planned: Vec<Planned> = kept.iter().map(|&index| plan[index]).collect();
        self.fine()?.world(moment)?;
        let (mut study, worlds, candidates) = self.plan(&planned)?;
        let world = &worlds[moment];
        let voxel = Grid::voxel_of(world.grid.position_q16(at_m));
        if !world.grid.window().contains(voxel) {
            let what = format!("the place at {} is outside of the grid", describe_place(at_m));
            return Err(Error::from(Issue::says(what)));
        }
        let mut sensors: Vec<SensorSight> = problems
            .into_iter()
            .map(|problem| SensorSight { index: problem.index, sees: false, words: problem.words })
            .collect();
        let mut members = Vec::new();
        for ((&index, planned), candidate) in kept.iter().zip(&planned).zip(candidates) {
            let member = [planned.sensor, candidate];
            match world.impossible_placement(&study, member) {
                Some(words) => {
                    study.combinations[0].members.retain(|own| [own.sensor, own.candidates[0]] != member);
                    sensors.push(SensorSight { index, sees: false, words });
                }
                None => members.push((index, member)),
            }
        }
        let truth = world.truth();
        let object = truth.objects.iter().find(|object| object.voxels.get(voxel));
        let object = object.map(|object| object.name.clone());
        if !members.is_empty() {
            let choice = Choice { combination: 0, choice: 0, representation: 0, repeat: 0 };
            let told = self.use_backend(|backend| {
                let view = Viewer::new(&study, backend)?.view_voxel(world, voxel, choice)?;
                let words = |sighting: Sighting| match sighting {
                    Sighting::Occupied => (true, "sees that something is there".to_string()),
                    Sighting::Free => (true, "sees that nothing is there".to_string()),
                    Sighting::Unknown(cause) => (false, describe_cause(&view, &cause)),
                };
                let of_members = view.members.iter().map(|member| [member.sensor, member.candidate]);
                Ok(of_members.zip(view.sightings(voxel).into_iter().map(words)).collect::<Vec<_>>())
            })?;
            for (member, (sees, words)) in told {
                let index = members.iter().find(|(_, own)| *own == member).map(|(index, _)| *index);
                sensors.extend(index.map(|index| SensorSight { index, sees, words }));
            }
        }
        sensors.sort_by_key(|sensor| sensor.index);
        Ok(WhyAnswer { voxel, object, sensors })
    }
}
