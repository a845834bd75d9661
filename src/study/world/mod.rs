//! A study made ready to cast: every scene voxelized, every region a mask, every pose inside its grid.
//! Whatever can be wrong with the input is found here, before any ray.

mod baselines;
mod bodies;
mod cut;
mod dead;
mod described;
mod extent;
mod floor;
mod mounts;
mod people;
pub mod place;
mod rays;
mod robots;
pub mod shapes;
mod sizes;
mod stuck;
mod thin;
mod warnings;

use std::sync::Arc;
use std::time::Instant;

use crate::sensor::{self, Sensor, Setting, Station};
use crate::study::Study;
pub use baselines::Baselines;
use baselines::{baselines, reachable};
pub use cut::cut_warnings;
pub use described::{Described, DescribedRegion};
use extent::grid;
pub use floor::{Floor, FloorSource};
use perirobot_march::backend::{GridPose, OverTime, VoxelScene};
use perirobot_march::error::{Issue, Site};
use perirobot_march::progress::Progress;
use perirobot_march::voxel::{BitGrid, Grid, People, Window};
use perirobot_march::{Error, Result};
use perirobot_scene::pose::Pose;
use perirobot_scene::scene::{Role, Scene, build::build_or_all};
use perirobot_scene::truth::region::SweptBy;
use perirobot_scene::truth::{Region, RegionShape, Snapshots, Truth, people, region, voxelize};
pub use rays::ray_tables_of;
pub use rays::{ray_table, ray_tables};

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

/// Memory for the truths that are kept; others are put together again when they are asked for.
const KEPT_BYTES: u64 = 256 << 20;

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
        let make = |scene| World::make(study, scene, progress).map_err(Error::first);
        let scenes: Vec<_> = (0..study.scenes.len()).map(make).collect::<Result<_>>()?;
        Ok(scenes.into_iter().flatten().collect())
    }

    /// The voxels of all regions.
    pub fn in_regions(&self) -> BitGrid {
        let mut all = BitGrid::new(region::window_of(&self.regions));
        self.regions.iter().for_each(|region| all.add(&region.voxels));
        all
    }

    /// Voxelizes one scene of a study, all its snapshots on one grid, and checks the study's sensors and
    /// regions against each.
    pub fn prepare(study: &Study, scene: usize) -> Result<Vec<World>> {
        World::examine(study, scene).map_err(Error::first)
    }

    /// The same, but tells all that is wrong with whatever can be judged independently: objects, carriers of
    /// sensors, regions.
    pub fn examine(study: &Study, scene: usize) -> Result<Vec<World>, Vec<Error>> {
        World::make(study, scene, &|| None)
    }

    fn make(study: &Study, scene: usize, progress: &dyn Progress) -> Result<Vec<World>, Vec<Error>> {
        progress.check_stop().map_err(|e| vec![e])?;
        let spec = &study.scenes[scene];
        let in_scene = |e: Error| vec![e.at(&spec.path)];
        let in_study = |e: Error| vec![e.at(&study.path)];
        let begin = Instant::now();
        log::info!("scene {:?}: voxelizing at {} m", spec.name, study.voxel_size_m);
        let snapshots = build_or_all(spec, &study.sources, study.voxel_size_m)?;
        let extent = voxelize::scene_extent(&snapshots, study.voxel_size_m).map_err(in_scene)?;
        let mut carriers: Vec<Vec<Option<Pose>>> = Vec::new();
        let mut settings: Vec<Vec<Arc<Vec<Setting>>>> = Vec::new();
        for snapshot in &snapshots {
            let each = all_or_wrong(study.sensors.iter().map(|sensor| carrier(sensor, snapshot)));
            let each = each.map_err(|all| all.into_iter().flat_map(in_study).collect::<Vec<_>>())?;
            let before = settings.last().map_or(&[][..], Vec::as_slice);
            let shared = study.sensors.iter().zip(&each).enumerate().map(|(number, (sensor, carrier))| {
                let new = sensor.settings(carrier.as_ref());
                match before.get(number) {
                    Some(same) if **same == new => same.clone(),
                    _ => Arc::new(new),
                }
            });
            let shared = shared.collect();
            settings.push(shared);
            carriers.push(each);
        }
        // A wrong unit is the likely cause of a grid that is too large.
        let slips = || {
            let all = study.warnings.iter().map(|slip| (&study.path, slip));
            let all = all.chain(spec.warnings.iter().map(|slip| (&spec.path, slip)));
            all.map(|(path, slip)| format!("{}: {slip}", path.display())).collect::<Vec<_>>()
        };
        let grid = grid(study, &snapshots, &settings, &extent)
            .map_err(|e| in_study(slips().into_iter().fold(e, Error::cure)))?;
        let kept_bytes = KEPT_BYTES / study.scenes.len() as u64;
        let in_voxels = Arc::new(Snapshots::new(&snapshots, grid, kept_bytes, progress).map_err(in_scene)?);
        let floor = Floor::new(study, &snapshots[0]);
        let shapes = shapes::shapes(study).map_err(|e| study.sources.judged(vec![e]))?;
        let mut worlds: Vec<World> = Vec::new();
        let mut over_time: Option<OverTime> = None;
        for (snapshot, mounted) in settings.into_iter().zip(carriers).enumerate() {
            progress.check_stop().map_err(|e| vec![e])?;
            let moment = if spec.snapshots > 1 { format!(", snapshot {snapshot}") } else { String::new() };
            let place = format!("scene {:?}{moment}", spec.name);
            let world = World::of_snapshot(study, [scene, snapshot], (&in_voxels, floor), mounted, &shapes);
            let mut world = world.map_err(|all| {
                all.into_iter().flat_map(|e| in_study(e.at(place.as_str()))).collect::<Vec<_>>()
            })?;
            worlds.last().iter().for_each(|before| world.share_regions(before));
            let blockers = &world.truth().blockers;
            let all = || OverTime { always: BitGrid::clone(blockers), ever: BitGrid::clone(blockers) };
            let all = over_time.get_or_insert_with(all);
            all.always.keep(blockers);
            all.ever.add(blockers);
            worlds.push(world);
        }
        let told = warnings::warnings(study, &snapshots, &worlds);
        (worlds[0].warnings, worlds[0].is_filled) = (told.lines, told.is_filled);
        // Those about objects are theirs already.
        let remarks = study.sources.take_remarks().into_iter();
        worlds[0].warnings.extend(remarks.map(|remark| format!("a region is read from {remark}")));
        if let (Some(all), [_, _, ..]) = (over_time, &worlds[..]) {
            let all = Arc::new(all);
            worlds.iter_mut().for_each(|world| world.over_time = Some(all.clone()));
        }
        let ([x, y, z], occupied) = (grid.size, worlds[0].truth().occupied.count());
        let (count, seconds) = (worlds.len(), begin.elapsed().as_secs_f64());
        log::info!(
            "scene {:?}: {x} × {y} × {z} voxels, {occupied} occupied (snapshot 0 of \
                    {count}), ready in {seconds:.3} s",
            spec.name
        );
        Ok(worlds)
    }

    fn of_snapshot(
        study: &Study,
        [scene, snapshot]: [usize; 2],
        (snapshots, floor): (&Arc<Snapshots>, Floor),
        (settings, carriers): (Vec<Arc<Vec<Setting>>>, Vec<Option<Pose>>),
        shapes: &[RegionShape],
    ) -> Result<World, Vec<Error>> {
        let truth = snapshots.truth(snapshot);
        let named = study.regions.iter().zip(shapes);
        let swept_by: SweptBy = &|role| snapshots.swept(role);
        let regions: Vec<Region> =
            all_or_wrong(named.map(|((name, _), shape)| region::region(name, shape, &truth, swept_by)))?;
        let reachable =
            reachable(study, [scene, snapshot], &truth, &settings).map_err(|(sensor, candidate, e)| {
                let (sensor, candidate) =
                    (&study.sensors[sensor], &study.sensors[sensor].candidates[candidate]);
                let pose = Site::Subject(candidate.name.clone());
                vec![e.at(pose).at(format!("sensor {:?}", sensor.name)).into()]
            })?;
        let people = people(&truth, study.min_hits);
        let baselines = regions.iter().map(|region| baselines(&truth, region, &people, &reachable)).collect();
        let name = study.scenes[scene].name.clone();
        let mut world = World {
            scene,
            name,
            snapshot,
            grid: truth.grid,
            floor,
            snapshots: snapshots.clone(),
            over_time: None,
            regions,
            settings,
            carriers,
            baselines,
            people,
            warnings: Vec::new(),
            is_filled: false,
            described: Described::default(),
        };
        world.described = described::described(study, &world);
        Ok(world)
    }

    /// Keeps regions that are the same in an earlier snapshot once only.
    fn share_regions(&mut self, earlier: &World) {
        for (region, before) in self.regions.iter_mut().zip(&earlier.regions) {
            if before.voxels == region.voxels {
                region.voxels = before.voxels.clone();
            }
        }
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
            blockers: truth.blockers.clone(),
            over_time: self.over_time.clone(),
            window,
            truth: truth.occupied.over(window),
            human: truth.human.over(window),
            robot: truth.robot.over(window),
            regions: self.regions.iter().map(|region| region.voxels.over(window)).collect(),
            people: self.people.within(window),
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

/// The values of checks that all passed, or all that is wrong.
fn all_or_wrong<T>(checks: impl Iterator<Item = Result<T>>) -> Result<Vec<T>, Vec<Error>> {
    let (mut good, mut wrong) = (Vec::new(), Vec::new());
    checks.for_each(|check| match check {
        Ok(value) => good.push(value),
        Err(e) => wrong.push(e),
    });
    if wrong.is_empty() { Ok(good) } else { Err(wrong) }
}

/// Where the link is that carries a sensor in a scene, if one does.
fn carrier(sensor: &Sensor, scene: &Scene) -> Result<Option<Pose>> {
    let Some(on) = &sensor.on else { return Ok(None) };
    let wrong = |issue: Issue| issue.at("on").at(format!("sensor {:?}", sensor.name));
    let carrier = scene.objects.iter().find(|object| object.name == on.object);
    let linkage = carrier.and_then(|object| object.linkage.as_deref()).ok_or_else(|| {
        let robots: Vec<_> =
            scene.objects.iter().filter(|o| o.linkage.is_some()).map(|o| o.name.as_str()).collect();
        let rule = "must be a robot with links, an object with urdf = ...";
        let known = format!("scene {:?} has {robots:?}", scene.name);
        wrong(Issue::value("object", format!("{:?}", on.object), rule).cure(known))
    })?;
    let link = linkage.link(&on.link).map_err(|e| wrong(e.at(format!("link = {:?}", on.link))))?;
    Ok(Some(*link))
}

#[cfg(test)]
mod tests;
