//! Sensors at other poses in the same voxels.

use std::sync::Arc;

use glam::DVec3;

use super::{World, true_poses};
use crate::input::Study;
use crate::sensor::{Sensor, Setting, Stance, Station};
use perirobot_march::Result;
use perirobot_march::error::{Issue, Site};
use perirobot_march::lengths::describe_place;
use perirobot_march::voxel::Grid;
use perirobot_scene::pose::Pose;
use perirobot_scene::truth::Truth;

impl World {
    /// The same voxels with other candidates of the study's sensors, which [`World::takes`] or [`World::examine_sensors`].
    pub fn with_sensors(&self, sensors: &[Sensor]) -> World {
        let each = sensors.iter().zip(&self.carriers);
        let settings = each.map(|(sensor, carrier)| Arc::new(sensor.settings(carrier.as_ref())));
        World { settings: settings.collect(), ..self.clone() }
    }

    /// Finds out whether the study's sensors can work at all their candidates in this world: in the grid, where their kind
    /// can stand. The study may be one with other candidates.
    ///
    /// # Errors
    /// The first candidate that is wrong, by its name.
    pub fn examine_sensors(&self, study: &Study) -> Result<()> {
        let truth = self.truth();
        let settings = self.with_sensors(&study.sensors).settings;
        for (number, (sensor, settings)) in study.sensors.iter().zip(&settings).enumerate() {
            for (index, (candidate, &setting)) in sensor.candidates.iter().zip(settings.iter()).enumerate() {
                let (mount, checked) = self.examine_setting(study, &truth, [number, index], setting);
                let name = Site::Subject(format!("pose {}{mount}", candidate.name));
                checked.map_err(|e| e.with_place(name).with_place(format!("sensor {:?}", sensor.name)))?;
            }
        }
        Ok(())
    }

    /// Whether a sensor can work at a setting: in the grid, where its kind can stand. With it, words where its mount is to
    /// blame.
    pub(super) fn examine_setting(
        &self,
        study: &Study,
        truth: &Truth,
        [sensor, candidate]: [usize; 2],
        setting: Setting,
    ) -> (&'static str, Result<(), Issue>) {
        let (moment, window) = ([self.scene, self.snapshot], self.grid.window());
        let station = Station { moment, truth, window, setting, rays: None, truly: None, draws: 0 };
        let voxel = |pose: &Pose| Grid::voxel_of(self.grid.position_q16(pose.position_m));
        let is_outside = |pose: &Pose| !window.contains(voxel(pose));
        let believed = matches!(setting, Setting::Pose(_)).then(|| setting.pose());
        let off = true_poses(study, setting, [sensor, candidate]).find(is_outside);
        match (believed.filter(is_outside), off) {
            (Some(pose), _) => ("", Err(self.misplaced_issue(pose.position_m))),
            (None, Some(pose)) => (" with its mount off", Err(self.misplaced_issue(pose.position_m))),
            (None, None) => ("", study.sensors[sensor].kind.check(&station)),
        }
    }

    /// What is wrong with a place outside of the grid.
    fn misplaced_issue(&self, at: DVec3) -> Issue {
        let [low, high] = [[0; 3], self.grid.size.map(|n| n as i32)].map(|voxel| self.grid.corner_m(voxel));
        let [at, low, high] = [at, low, high].map(describe_place);
        Issue::says(format!("is at {at}, outside of the voxels of scene {:?}", self.name))
            .with_advice(format!("they go from {low} to {high}"))
    }

    /// Whether a sensor of the study, mounted as a planned pose is, may stand at another as its candidate of this
    /// number: in the grid, in no solid thing unless the planned one is, and where its kind can work. Poses are in
    /// the world, or on the link that carries the sensor.
    pub fn takes(
        &self,
        study: &Study,
        [sensor, candidate]: [usize; 2],
        planned: &Pose,
        other: &Pose,
    ) -> bool {
        let (spec, truth) = (&study.sensors[sensor], self.truth());
        let carrier = self.carriers[sensor].as_ref();
        let [planned, other] = [planned, other].map(|pose| Setting::Pose(*pose).carried_by(carrier));
        let voxel = |pose: &Pose| Grid::voxel_of(self.grid.position_q16(pose.position_m));
        let window = self.grid.window();
        let is_solid = |setting: &Setting| {
            let looks_out = spec.kind.stance() != Stance::Level && carrier.is_none();
            looks_out && spec.kind.blockers(&truth).get(voxel(&setting.pose()))
        };
        let truly = true_poses(study, other, [sensor, candidate]);
        let mut places = [other.pose()].into_iter().chain(truly);
        let moment = [self.scene, self.snapshot];
        let station =
            Station { moment, truth: &truth, window, setting: other, rays: None, truly: None, draws: 0 };
        places.all(|pose| window.contains(voxel(&pose)))
            && (is_solid(&planned) || !is_solid(&other))
            && spec.kind.check(&station).is_ok()
    }
}
