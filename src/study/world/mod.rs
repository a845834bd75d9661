//! A study made ready to cast: every scene voxelized, every region a mask, every pose inside its grid.
//! Whatever can be wrong with the input is found here, before any ray.

mod baselines;
mod bodies;
mod carried;
mod cases;
mod contour;
mod cut;
mod dead;
mod described;
mod extent;
mod floor;
mod mounts;
pub mod near;
mod people;
pub mod place;
mod placed;
mod prepare;
mod rays;
mod robots;
mod same;
pub mod shapes;
mod sizes;
mod specular;
mod stuck;
mod thin;
mod warnings;

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;

use crate::input::Study;
use crate::sensor::{self, Setting, Station};
pub use baselines::Baselines;
pub use cases::case_warnings;
pub use contour::{Contour, ContourRay, ContourRule};
pub use cut::cut_warnings;
pub use described::{Described, DescribedRegion};
pub use floor::{Floor, FloorSource};
use perirobot_march::backend::{GridPose, OverTime, VoxelScene};
use perirobot_march::progress::Progress;
use perirobot_march::voxel::{BitGrid, Grid, People, Window};
use perirobot_march::{Error, Result};
use perirobot_scene::objects::Role;
use perirobot_scene::pose::Pose;
use perirobot_scene::truth::{Region, Snapshots, Truth, region};
pub use placed::PlacementProblem;
pub use rays::KeptRays;
pub use rays::ray_tables_of;
pub use rays::{ray_table, ray_tables};
pub use same::{share_kinds, with_sensors_of, worlds_key};
pub use stuck::tripping_object;

/// A scene of a study at one moment, in voxels.
#[derive(Clone, Debug)]
pub struct World {
    /// Index of the scene in the study.
    pub scene: usize,
    /// The scene's name.
    pub name: String,
    /// Which moment of the scene it is, counted from 0.
    pub snapshot: usize,
    /// Where its voxels are.
    pub grid: Grid,
    /// The floor from which heights in words are measured.
    pub floor: Floor,
    /// All snapshots of the scene, in voxels.
    snapshots: Arc<Snapshots>,
    /// Blockers over all snapshots of the scene; `None` where there is one snapshot.
    pub over_time: Option<Arc<OverTime>>,
    /// The study's regions in this scene, in study order.
    pub regions: Vec<Region>,
    /// For each sensor, its candidates' settings with poses in the world, whatever carries the sensor; one
    /// allocation in snapshots on end where they are the same.
    pub settings: Vec<Arc<Vec<Setting>>>,
    /// For each sensor, where the link is that carries it, if one does.
    carriers: Vec<Option<Pose>>,
    /// The voxels of all surfaces of all snapshots of the scene, from the world's origin.
    surfaces: Window,
    /// For each region, what the simplest answers would score.
    pub baselines: Vec<Baselines>,
    /// The people, and the voxels of each.
    pub people: People,
    /// What was assumed about the scene that the user may not expect, told with its first snapshot only.
    pub warnings: Vec<String>,
    /// Whether a hull fills most of its grid by its interior, which explains whatever else is odd.
    pub is_filled: bool,
    /// Its entry in the manifest.
    pub described: Described,
}

impl World {
    /// The worlds of all scenes of a study: scene by scene, in each snapshot by snapshot.
    pub fn prepare_all(study: &Study) -> Result<Vec<World>> {
        World::prepare_all_unless(study, &|| None)
    }

    /// The same, which may be stopped before each object and each snapshot.
    ///
    /// # Errors
    /// `Error::Stopped`.
    pub fn prepare_all_unless(study: &Study, progress: &dyn Progress) -> Result<Vec<World>> {
        World::prepare_scenes(study, 0..study.scenes.len(), progress)
    }

    /// The same of some scenes of the study, which are named by their numbers.
    pub fn prepare_scenes(
        study: &Study,
        scenes: Range<usize>,
        progress: &dyn Progress,
    ) -> Result<Vec<World>> {
        let is_whole = scenes == (0..study.scenes.len());
        let mut worlds = prepare::all_worlds(study, scenes, progress).map_err(Error::first)?;
        if is_whole && !worlds.is_empty() {
            let warnings = case_warnings(study, &worlds);
            worlds[0].warnings.extend(warnings);
        }
        Ok(worlds)
    }

    /// The diagonal of its grid, in metres.
    pub fn across_m(&self) -> f64 {
        DVec3::from_array(self.grid.size.map(f64::from)).length() * self.grid.voxel_size_m
    }

    /// How far a sensor is from the farthest corner around all regions at any of its poses, in metres; 0 if it has none.
    pub fn farthest_m(&self, sensor: usize) -> f64 {
        let window = region::window_of(&self.regions);
        let [low, high] = [window.min, window.end()].map(|corner| self.grid.corner_m(corner));
        let distance = |setting: &Setting| match setting {
            Setting::Pose(Pose { position_m: at, .. }) => (*at - low).abs().max((*at - high).abs()).length(),
            _ => 0.0,
        };
        self.settings[sensor].iter().map(distance).fold(0.0, f64::max)
    }

    /// The voxels of all regions.
    pub fn region_voxels(&self) -> BitGrid {
        let mut all = BitGrid::new(region::window_of(&self.regions));
        self.regions.iter().for_each(|region| all.add(&region.voxels));
        all
    }

    /// Voxelizes one scene of a study, all its snapshots on one grid, and checks the study's sensors and
    /// regions against each.
    pub fn prepare(study: &Study, scene: usize) -> Result<Vec<World>> {
        World::examine(study, scene).map_err(Error::first)
    }

    /// Where the link is that carries a sensor, if one does.
    pub fn carrier(&self, sensor: usize) -> Option<Pose> {
        self.carriers.get(sensor).copied().flatten()
    }

    /// The same, but tells all that is wrong with whatever can be judged independently: objects, carriers of
    /// sensors, regions.
    pub fn examine(study: &Study, scene: usize) -> Result<Vec<World>, Vec<Error>> {
        prepare::worlds(study, scene, &|| None)
    }

    /// The truth, put together when it is asked for, unless it was asked for lately. Callers that need it
    /// often keep it.
    pub fn truth(&self) -> Arc<Truth> {
        self.snapshots.truth(self.snapshot)
    }

    /// The same moment with other candidates of its sensors. Its grid stays as it is.
    pub fn with_settings(&self, settings: Vec<Vec<Setting>>) -> World {
        World { settings: settings.into_iter().map(Arc::new).collect(), ..self.clone() }
    }

    /// The truth if nobody were there.
    pub fn truth_without_people(&self) -> Truth {
        self.snapshots.truth_without(self.snapshot, Role::Human)
    }

    /// The scene's name, with the snapshot's number where there are several.
    pub fn title(&self, study: &Study) -> String {
        match study.scenes[self.scene].snapshots {
            1 => self.name.clone(),
            _ => format!("{}[{}]", self.name, self.snapshot),
        }
    }

    /// A sensor at a candidate, quantised; at the origin if it has no pose.
    pub fn placement(&self, study: &Study, sensor: usize, candidate: usize, repeat: usize) -> GridPose {
        let truth = self.truth();
        self.station(study, &truth, [sensor, candidate, repeat]).placement(&*study.sensors[sensor].kind)
    }

    /// A sensor at a candidate in one repeat, looked at over the whole grid, without its table of rays.
    /// `truth` is this world's.
    pub fn station<'a>(
        &self,
        study: &Study,
        truth: &'a Truth,
        [sensor, candidate, repeat]: [usize; 3],
    ) -> Station<'a> {
        let setting = self.settings[sensor][candidate];
        Station {
            moment: [self.scene, self.snapshot],
            truth,
            window: self.grid.window(),
            setting,
            rays: None,
            truly: true_pose(study, setting, [sensor, candidate, repeat]),
            draws: sensor::draws(
                study.seed,
                [self.scene, self.snapshot, sensor, study.sensors[sensor].draw_word(candidate), repeat],
            ),
        }
    }

    /// The scene as backends see it, with evidence kept over a window.
    pub fn scene(&self, window: Window) -> VoxelScene {
        let truth = self.truth();
        VoxelScene {
            shades: truth.shades.clone(),
            blockers: truth.blockers.clone(),
            over_time: self.over_time.clone(),
            window,
            truth: truth.occupied.to_window(window),
            human: truth.human.to_window(window),
            robot: truth.robot.to_window(window),
            regions: self.regions.iter().map(|region| region.voxels.to_window(window)).collect(),
            people: self.people.crop(window),
        }
    }
}

/// Where a sensor truly is in a repeat, if it has a pose and its mount may be off.
fn true_pose(study: &Study, setting: Setting, [sensor, candidate, repeat]: [usize; 3]) -> Option<Pose> {
    let spec = &study.sensors[sensor];
    let calibration = spec.kind.calibration()?;
    let words = [sensor, spec.draw_word(candidate), repeat];
    match setting {
        Setting::Pose(pose) => Some(calibration.true_pose(&pose, study.seed, words)),
        _ => None,
    }
}

/// The same in each repeat.
fn true_poses(
    study: &Study,
    setting: Setting,
    [sensor, candidate]: [usize; 2],
) -> impl Iterator<Item = Pose> + use<'_> {
    let repeats = 0..study.repeats as usize;
    repeats.map_while(move |repeat| true_pose(study, setting, [sensor, candidate, repeat]))
}

#[cfg(test)]
mod tests;
