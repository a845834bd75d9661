//! The poses around those of a set.

use std::sync::Arc;

use perirobot_march::voxel::Grid;
use perirobot_scene::pose::Pose;
use perirobot_scene::truth::Truth;
use perirobot_study::input::Study;
use perirobot_study::sensor::spread::{TURNS, WAYS};
use perirobot_study::sensor::{Candidate, Setting, Stance, Station};
use perirobot_study::world::World;

/// The number of halvings of a step.
pub(super) const LEVELS: u32 = 10;
/// Angles are no finer than this.
const LEAST_DEG: f64 = 1.0;
/// Positions are no finer than this share of a voxel.
const LEAST_VOXELS: f64 = 0.5;

/// A sensor at a listed pose, or moved from one by parts of its group's steps, in units of 2⁻ᴸᴱⱽᴱᴸˢ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RefineSpot {
    pub(super) sensor: usize,
    /// The listed pose.
    pub(super) candidate: usize,
    parts: [i32; WAYS],
}

impl RefineSpot {
    /// A listed pose.
    pub(super) fn from_candidate([sensor, candidate]: [usize; 2]) -> RefineSpot {
        RefineSpot { sensor, candidate, parts: [0; WAYS] }
    }

    /// Whether it is not a listed pose.
    pub(super) fn is_moved(&self) -> bool {
        self.parts != [0; WAYS]
    }

    /// Whether it is one of some listed poses.
    pub(super) fn is_listed(&self, among: &[[usize; 2]]) -> bool {
        !self.is_moved() && among.contains(&[self.sensor, self.candidate])
    }
}

/// Generates the poses around those of a set.
pub(super) struct Around<'a> {
    study: &'a Study,
    worlds: &'a [World],
    /// The study without candidates.
    bare: Study,
}

impl<'a> Around<'a> {
    pub(super) fn new(study: &'a Study, worlds: &'a [World]) -> Around<'a> {
        let mut bare = Study { combinations: Vec::new(), sensors: Vec::new(), ..study.clone() };
        let without = |sensor: &perirobot_study::sensor::Sensor| perirobot_study::sensor::Sensor {
            candidates: Vec::new(),
            spreads: Vec::new(),
            ..sensor.clone()
        };
        bare.sensors = study.sensors.iter().map(without).collect();
        Around { study, worlds, bare }
    }

    /// The spots of a set and, around those that may move, all spots one halved step away; sensor by sensor, each once.
    pub(super) fn all(
        &self,
        set: &[RefineSpot],
        may_move: impl Fn(&RefineSpot) -> bool,
        level: u32,
    ) -> Vec<RefineSpot> {
        let mut all = set.to_vec();
        for spot in set.iter().filter(|spot| may_move(spot)) {
            for other in self.neighbours(spot, level) {
                if !all.contains(&other) {
                    all.push(other);
                }
            }
        }
        all.sort_by_key(|spot| spot.sensor);
        self.keep_free(set, &mut all);
        all
    }

    /// The spots one step away in each direction.
    fn neighbours(&self, spot: &RefineSpot, level: u32) -> Vec<RefineSpot> {
        let steps = self.steps(spot);
        let ways = (0..WAYS).filter(|&way| {
            let least = if TURNS.contains(&way) { LEAST_DEG } else { LEAST_VOXELS * self.study.voxel_size_m };
            steps[way] / f64::from(1 << level) >= least
        });
        let parts = 1 << (LEVELS - level);
        let both = ways.flat_map(|way| {
            [-parts, parts].map(|by| {
                let mut other = *spot;
                other.parts[way] += by;
                other
            })
        });
        both.filter(|other| self.pose(other).is_some()).collect()
    }

    /// Whether a spot has no neighbours.
    pub(super) fn stays(&self, spot: &RefineSpot) -> bool {
        self.steps(spot) == [0.0; WAYS]
    }

    /// The spacing of the listed poses of a spot's group in each direction. Sensors on a robot stay at their listed
    /// poses.
    fn steps(&self, spot: &RefineSpot) -> [f64; WAYS] {
        let sensor = &self.study.sensors[spot.sensor];
        let spread = sensor.spreads.iter().find(|spread| spread.candidates.contains(&spot.candidate));
        spread.filter(|_| sensor.on.is_none()).map_or([0.0; WAYS], |spread| spread.steps())
    }

    /// The pose of a moved spot; `None` outside its group.
    pub(super) fn pose(&self, spot: &RefineSpot) -> Option<Pose> {
        let sensor = &self.study.sensors[spot.sensor];
        let spread = sensor.spreads.iter().find(|spread| spread.candidates.contains(&spot.candidate))?;
        let Setting::Pose(listed) = sensor.candidates[spot.candidate].setting else { return None };
        let steps = spread.steps();
        let offset =
            std::array::from_fn(|way| f64::from(spot.parts[way]) * steps[way] / f64::from(1 << LEVELS));
        spread.move_pose(spot.candidate, &listed, offset)
    }

    /// Removes spots inside an object, or where the sensor cannot work, at any moment.
    fn keep_free(&self, set: &[RefineSpot], all: &mut Vec<RefineSpot>) {
        for world in self.worlds {
            let truth = world.truth();
            all.retain(|spot| set.contains(spot) || self.is_free(spot, world, &truth));
        }
    }

    fn is_free(&self, spot: &RefineSpot, world: &World, truth: &Arc<Truth>) -> bool {
        let Some(pose) = self.pose(spot) else { return false };
        let kind = &self.study.sensors[spot.sensor].kind;
        let (window, setting) = (world.grid.window(), Setting::Pose(pose));
        let voxel = Grid::voxel_of(world.grid.position_q16(pose.position_m));
        let looks = kind.stance() != Stance::Level;
        let stands_free = window.contains(voxel) && !truth.blockers.get(voxel);
        let moment = [world.scene, world.snapshot];
        let station = Station { moment, truth, window, setting, rays: None, truly: None, draws: 0 };
        (stands_free || !looks) && kind.check(&station).is_ok()
    }

    /// The study with only these spots, which are sorted by sensor.
    pub(super) fn study_of(&self, spots: &[RefineSpot]) -> Study {
        let mut study = self.bare.clone();
        for (spot, number) in spots.iter().zip(numbers(spots)) {
            let setting = match self.pose(spot).filter(|_| spot.is_moved()) {
                Some(pose) => Setting::Pose(pose),
                None => self.study.sensors[spot.sensor].candidates[spot.candidate].setting,
            };
            let candidate = Candidate { name: number.to_string(), group: String::new(), setting };
            study.sensors[spot.sensor].candidates.push(candidate);
        }
        study
    }

    /// The worlds with only these spots.
    pub(super) fn worlds_of(&self, spots: &[RefineSpot]) -> Vec<World> {
        let in_world = |world: &World| {
            let mut settings = vec![Vec::new(); self.study.sensors.len()];
            for spot in spots {
                let setting = match self.pose(spot).filter(|_| spot.is_moved()) {
                    Some(pose) => Setting::Pose(pose),
                    None => world.settings[spot.sensor][spot.candidate],
                };
                settings[spot.sensor].push(setting);
            }
            world.with_settings(settings)
        };
        self.worlds.iter().map(in_world).collect()
    }
}

/// The index of each spot among those of its sensor.
pub(super) fn numbers(spots: &[RefineSpot]) -> Vec<usize> {
    let before = |(number, spot): (usize, &RefineSpot)| {
        spots[..number].iter().filter(|other| other.sensor == spot.sensor).count()
    };
    spots.iter().enumerate().map(before).collect()
}
