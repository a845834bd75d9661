//! The distance measured by a controller that stops the robot if people are too close, from the labels.
//!
//! # Theory
//! It has the environment and the pose of the robot. Every other voxel that is labelled occupied may be a person: the
//! measured distance is the least from such a voxel to the robot, and the robot stops if it is less than the needed one.
//! Unknown voxels are taken as free, which may miss a person, or as occupied, which may cause a needless stop.
//!
//! # Practice
//! Distances are squared, in whole voxels, between centres, from the robot with the inside of its bodies, in the
//! whole grid. Voxels of the environment or of the robot are left out, even if a person touches them.

use perirobot_march::backend::Planes;
use perirobot_march::voxel::{BitGrid, Distances, squared_voxels};
use perirobot_study::world::World;

/// The sensor-independent part of a measurement at a moment.
#[derive(Debug)]
pub struct MeasuredSurroundings {
    /// The distances from the robot; `None` without a robot.
    from_robot: Option<Distances>,
    /// The voxels known to the controller: the environment, the robot, and their insides.
    known: BitGrid,
    /// The true distance of the nearest person.
    truly: Option<u32>,
}

/// The least distances at a moment, squared in voxels; `None` if there is nothing to measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Separation {
    /// Whether there is a robot.
    pub has_robot: bool,
    /// The true distance of people.
    pub truly: Option<u32>,
    /// The distance of unexpected voxels labelled occupied.
    pub unknown_free: Option<u32>,
    /// The distance of these and of voxels without a label.
    pub unknown_occupied: Option<u32>,
}

/// The controller's decision at a moment, and whether it is correct.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// It runs, and no person is too close.
    Runs,
    /// It is stopped, and a person is too close.
    Stops,
    /// It runs, although a person is too close.
    MissedStop,
    /// It is stopped, although no person is too close.
    NeedlessStop,
}

impl MeasuredSurroundings {
    /// The surroundings at a moment.
    pub fn new(world: &World) -> MeasuredSurroundings {
        let (truth, nobody) = (world.truth(), world.truth_without_people());
        let mut known = BitGrid::clone(&nobody.occupied);
        known.add(&nobody.ignored);
        known.add(&truth.robot_volume);
        let robot = truth.robot_volume.to_window(world.grid.window());
        let from_robot = (!robot.is_empty()).then(|| Distances::from_set(&robot));
        let truly = from_robot.as_ref().and_then(|distances| distances.least(&truth.human));
        MeasuredSurroundings { from_robot, known, truly }
    }

    /// The measurement of a view of this moment, or without sensors.
    pub fn separation(&self, labels: Option<&Planes>) -> Separation {
        let nothing = BitGrid::new(self.known.window());
        let (occupied, free) = labels.map_or((&nothing, &nothing), |labels| (&labels.occupied, &labels.free));
        let least = |mut voxels: BitGrid| {
            voxels.remove(&self.known);
            self.from_robot.as_ref().and_then(|distances| distances.least(&voxels))
        };
        let mut unknown = BitGrid::full(self.known.window());
        unknown.remove(free);
        Separation {
            has_robot: self.from_robot.is_some(),
            truly: self.truly,
            unknown_free: least(occupied.clone()),
            unknown_occupied: least(unknown),
        }
    }
}

impl Decision {
    /// All decisions.
    pub const ALL: [Decision; 4] =
        [Decision::Runs, Decision::Stops, Decision::MissedStop, Decision::NeedlessStop];

    /// The decision for a measured and a true least distance, and the needed one.
    pub fn new(measured: Option<u32>, truly: Option<u32>, needed_m: f64, voxel_size_m: f64) -> Decision {
        let needed = squared_voxels(needed_m, voxel_size_m);
        let is_near = |distance: Option<u32>| distance.is_some_and(|squared| squared < needed);
        match (is_near(measured), is_near(truly)) {
            (false, false) => Decision::Runs,
            (true, true) => Decision::Stops,
            (false, true) => Decision::MissedStop,
            (true, false) => Decision::NeedlessStop,
        }
    }

    /// The name in tables.
    pub fn name(self) -> &'static str {
        ["runs", "stops", "missed_stop", "needless_stop"][self as usize]
    }
}

impl Separation {
    /// A squared distance in metres.
    pub fn metres(squared: u32, voxel_size_m: f64) -> f64 {
        f64::from(squared).sqrt() * voxel_size_m
    }

    /// Excess of the measured distance of the nearest person over the true one, with unknown voxels taken as free, in
    /// metres; 0 if it is measured at its distance or nearer. `None` without a person or a measurement.
    pub fn missed_m(&self, voxel_size_m: f64) -> Option<f64> {
        let metres = |squared| Separation::metres(squared, voxel_size_m);
        Some((metres(self.unknown_free?) - metres(self.truly?)).max(0.0))
    }
}
