//! Sensors at other poses in the same voxels.

use std::sync::Arc;

use super::{World, true_poses};
use crate::pose::Pose;
use crate::sensor::{Sensor, Setting, Stance, Station};
use crate::study::Study;
use crate::voxel::Grid;

impl World {
    /// The same voxels with other candidates of the study's sensors, which [`World::takes`].
    pub(crate) fn with_sensors(&self, sensors: &[Sensor]) -> World {
        let each = sensors.iter().zip(&self.carriers);
        let settings = each.map(|(sensor, carrier)| Arc::new(sensor.settings(carrier.as_ref())));
        World { settings: settings.collect(), ..self.clone() }
    }

    /// Whether a sensor of the study, mounted as a planned pose is, may stand at another as its candidate of this
    /// number: in the grid, in no solid thing unless the planned one is, and where its kind can work. Poses are in
    /// the world, or on the link that carries the sensor.
    pub(crate) fn takes(
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
            looks_out && truth.blockers.get(voxel(&setting.pose()))
        };
        let truly = true_poses(study, other, [sensor, candidate]);
        let mut places = [other.pose()].into_iter().chain(truly);
        let station = Station { truth: &truth, window, setting: other, rays: None, truly: None, draws: 0 };
        places.all(|pose| window.contains(voxel(&pose)))
            && (is_solid(&planned) || !is_solid(&other))
            && spec.kind.check(&station).is_ok()
    }
}
