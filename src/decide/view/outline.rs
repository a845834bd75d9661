//! Small figures of a sensor's direction: a pyramid for a camera, a cone for rays in one direction, and the ground
//! watched by pads and gates. Pictures and exports draw sensors with them.

use glam::DVec3;

use super::{SensorView, View};
use perirobot_study::sensor::Setting;
use perirobot_study::world::ray_table;

/// Directions along the rim of a cone.
const RIM: usize = 24;
/// A wider cone shows no direction: half angle in radians (80°).
const WIDEST_RAD: f64 = 1.4;

/// The position and directions of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// The origin of its rays, in world metres.
    pub apex_m: DVec3,
    /// Unit directions in the world, around its whole field of view, anticlockwise as seen from the sensor; empty for
    /// all-round sensors and those without rays.
    pub rim: Vec<DVec3>,
}

impl View<'_> {
    /// The figure of a sensor; `None` if it has no pose, or is drawn as [`View::grounds`].
    pub fn outline(&self, member: &SensorView) -> Option<Outline> {
        let kind = &self.study.sensors[member.sensor].kind;
        if !kind.prisms().is_empty() {
            return None;
        }
        let Setting::Pose(pose) = self.world.settings[member.sensor][member.candidate] else { return None };
        let world_from_sensor = kind.frame(&pose);
        let mut rim = Vec::new();
        if let Some(rays) = ray_table(self.study, member.sensor) {
            let dir = |ray: usize| DVec3::from_array(rays.dirs_q15[ray].map(f64::from)).normalize();
            rim = match rays.image {
                Some(image) => {
                    let [width, height] = image.size_px.map(|n| n as usize);
                    [0, width * (height - 1), width * height - 1, width - 1].map(dir).to_vec()
                }
                None => cone(&(0..rays.dirs_q15.len()).map(dir).collect::<Vec<_>>()),
            };
        }
        let rim = rim.into_iter().map(|dir| world_from_sensor * dir).collect();
        Some(Outline { apex_m: pose.position_m, rim })
    }

    /// The ground below the volume of a pad or a gate, each as its corners in world metres; empty for other sensors.
    pub fn grounds(&self, member: &SensorView) -> Vec<Vec<DVec3>> {
        let pose = self.world.settings[member.sensor][member.candidate].pose();
        let prisms = self.study.sensors[member.sensor].kind.prisms();
        prisms.into_iter().map(|prism| prism.footprint_m(&pose)).collect()
    }
}

/// The rim of the narrowest cone about the mean of some directions that contains them all.
fn cone(dirs: &[DVec3]) -> Vec<DVec3> {
    let axis = dirs.iter().sum::<DVec3>().normalize_or_zero();
    let narrowest = dirs.iter().map(|dir| dir.dot(axis)).fold(1.0, f64::min);
    let half_rad = libm::acos(narrowest.clamp(-1.0, 1.0));
    if axis == DVec3::ZERO || half_rad > WIDEST_RAD {
        return Vec::new();
    }
    let (u, v) = axis.any_orthonormal_pair();
    let (sin, cos) = libm::sincos(half_rad);
    let at = |i: usize| {
        let (y, x) = libm::sincos(i as f64 * std::f64::consts::TAU / RIM as f64);
        axis * cos - (u * x - v * y) * sin
    };
    (0..RIM).map(at).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::view::{ChoiceSelector, find};
    use perirobot_march::backend::cpu::Cpu;
    use perirobot_study::input::{Overrides, Study};
    use perirobot_study::world::World;

    #[test]
    fn cones_hold_what_goes_one_way_and_nothing_else() {
        let (sin, cos) = libm::sincos(0.5);
        let ring = |z: f64| {
            let at = move |i| libm::sincos(f64::from(i) * std::f64::consts::TAU / 7.0);
            (0..7).map(move |i| DVec3::new(at(i).1 * sin, at(i).0 * sin, z))
        };
        let found = cone(&ring(cos).chain([DVec3::Z]).collect::<Vec<_>>());
        assert_eq!(found.len(), RIM);
        assert!(found.iter().all(|dir| (dir.z - cos).abs() < 1e-12 && dir.is_normalized()), "{found:?}");
        assert_eq!(cone(&ring(cos).chain(ring(-cos)).collect::<Vec<_>>()), [], "all around");
    }

    #[test]
    fn a_pad_is_drawn_as_its_rectangle() {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/paper/exp2.toml");
        let coarse = Overrides { voxel_size_m: Some(0.2), ..Overrides::default() };
        let study = Study::load(&path, &coarse).unwrap();
        let world = &World::prepare(&study, 0).unwrap()[0];
        // The pads, at (0, −1.25), are in front of the robot, which has no position and neither figure nor ground.
        let wanted =
            ChoiceSelector { poses: "pads:floor/13/0;robot:known".into(), ..ChoiceSelector::default() };
        let (_, choice) = find(&study, std::slice::from_ref(world), &wanted).unwrap();
        let view = View::new(&study, world, choice, &mut Cpu::new(Some(1)).unwrap()).unwrap();
        let drawn = view.members.iter().map(|member| (view.outline(member), view.grounds(member)));
        let corners = [[0.0, -1.25], [1.0, -1.25], [1.0, -0.5], [0.0, -0.5]];
        let rectangle = corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        assert_eq!(drawn.collect::<Vec<_>>(), [(None, vec![rectangle]), (None, vec![])]);
    }

    #[test]
    fn rims_go_round_as_the_sensor_sees_them() {
        // Seen along +z, anticlockwise means from x to −y: y points down in a picture.
        let found = cone(&[DVec3::new(0.1, 0.0, 1.0).normalize(), DVec3::new(-0.1, 0.0, 1.0).normalize()]);
        let turn: f64 = (0..RIM).map(|i| found[i].cross(found[(i + 1) % RIM]).z).sum();
        assert!(turn < 0.0, "{turn}");
    }
}
