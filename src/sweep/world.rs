//! A study made ready to cast: every scene voxelized, every region a mask, every pose inside its grid. Whatever can be
//! wrong with the input is found here, before any ray.

mod dead;
mod described;
mod people;
mod thin;
mod warnings;

use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use serde_json::Value;

use super::shapes;
use crate::backend::{Cell, Placement};
use crate::march::MAX_RANGE_VOXELS;
use crate::metrics::Confusion;
use crate::scene::{Scene, build::build_or_all};
use crate::sensor::{self, Pose, Reach, Sensor, Setting, Stance, Station};
use crate::study::Study;
use crate::voxel::{BitGrid, GoOn, Grid, People, Region, Shape, Snapshots, Truth, Window, region, voxelize};
use crate::{Error, Result};

/// A scene of a study at one moment, in voxels.
#[derive(Debug)]
pub struct World {
    /// Index of the scene in the study.
    pub scene: usize,
    /// The scene's name.
    pub name: String,
    /// Which moment of the scene it is, counted from 0.
    pub snapshot: usize,
    /// Where its voxels are.
    pub grid: Grid,
    /// All snapshots of the scene, in voxels.
    snapshots: Arc<Snapshots>,
    /// Of its blockers, what every snapshot of the scene has; `None` where there is one snapshot.
    pub still: Option<Arc<BitGrid>>,
    /// The study's regions in this scene, in study order.
    pub regions: Vec<Region>,
    /// For each sensor, its candidates' settings with poses in the world, whatever carries the sensor; one allocation in
    /// snapshots on end where they are the same.
    pub settings: Vec<Arc<Vec<Setting>>>,
    /// For each region, what the simplest answers would score.
    pub baselines: Vec<Baselines>,
    /// Whose voxels people's are.
    pub people: People,
    /// What was assumed about the scene that the user may not expect, told with its first snapshot only.
    pub warnings: Vec<String>,
    /// Its entry in the manifest.
    pub(crate) described: Value,
}

/// What the truths of all scenes that are kept to be asked again may take; what does not fit is put together again.
const KEPT_BYTES: u64 = 256 << 20;

/// Scores to hold a pose against: a sensor that is stuck beats many poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Baselines {
    /// Everything labelled occupied.
    pub all_occupied: Confusion,
    /// Everything labelled free.
    pub all_free: Confusion,
    /// Everything unknown.
    pub nothing_seen: Confusion,
    /// Everything right that a ray from any of the study's positions could reach; the rest unknown.
    pub ceiling: Confusion,
}

impl World {
    /// The worlds of all scenes of a study: scene by scene, in each snapshot by snapshot.
    pub fn prepare_all(study: &Study) -> Result<Vec<World>> {
        World::prepare_all_unless(study, &|| None)
    }

    /// The same, unless somebody says why to stop, who is asked before each object and each snapshot.
    ///
    /// # Errors
    /// `Error::Stopped` with what was said.
    pub fn prepare_all_unless(
        study: &Study,
        stop: &(dyn Fn() -> Option<String> + Sync),
    ) -> Result<Vec<World>> {
        let go_on = || stop().map_or(Ok(()), |why| Err(Error::Stopped(why)));
        let make = |scene| World::make(study, scene, &go_on).map_err(Error::first);
        let scenes: Vec<_> = (0..study.scenes.len()).map(make).collect::<Result<_>>()?;
        Ok(scenes.into_iter().flatten().collect())
    }

    /// The voxels of all regions.
    pub fn in_regions(&self) -> BitGrid {
        let mut all = BitGrid::new(self.grid.window());
        self.regions.iter().for_each(|region| all.add(&region.cells));
        all
    }

    /// Voxelizes one scene of a study, all its snapshots on one grid, and checks the study's sensors and regions
    /// against each.
    pub fn prepare(study: &Study, scene: usize) -> Result<Vec<World>> {
        World::examine(study, scene).map_err(Error::first)
    }

    /// The same, but of what can be judged for itself (objects, carriers of sensors, regions) all that is wrong is told.
    pub fn examine(study: &Study, scene: usize) -> Result<Vec<World>, Vec<Error>> {
        World::make(study, scene, &|| Ok(()))
    }

    fn make(study: &Study, scene: usize, go_on: GoOn) -> Result<Vec<World>, Vec<Error>> {
        go_on().map_err(|e| vec![e])?;
        let spec = &study.scenes[scene];
        let in_scene = |e: Error| vec![e.at(spec.path.display())];
        let in_study = |e: Error| vec![e.at(study.path.display())];
        let begin = Instant::now();
        tracing::info!("scene {:?}: voxelizing at {} m", spec.name, study.voxel_size_m);
        let snapshots = build_or_all(spec, &study.sources, study.voxel_size_m)?;
        let extent = voxelize::scene_extent(&snapshots, study.voxel_size_m).map_err(in_scene)?;
        let mut settings: Vec<Vec<Arc<Vec<Setting>>>> = Vec::new();
        for snapshot in &snapshots {
            let each = study.sensors.iter().map(|sensor| self::settings(sensor, snapshot));
            let each =
                all_or_wrong(each).map_err(|all| all.into_iter().flat_map(in_study).collect::<Vec<_>>())?;
            let before = settings.last().map_or(&[][..], Vec::as_slice);
            let shared = each.into_iter().enumerate().map(|(sensor, new)| match before.get(sensor) {
                Some(same) if **same == new => same.clone(),
                _ => Arc::new(new),
            });
            let shared = shared.collect();
            settings.push(shared);
        }
        // A slip of a unit is the likely cause of a grid that cannot be.
        let slips = || {
            let all = study.warnings.iter().map(|slip| (&study.path, slip));
            let all = all.chain(spec.warnings.iter().map(|slip| (&spec.path, slip)));
            all.map(|(path, slip)| format!("; {}: {slip}", path.display())).collect::<String>()
        };
        let grid = grid(study, &snapshots, &settings, &extent)
            .map_err(|e| in_study(Error::Input(format!("{e}{}", slips()))))?;
        let kept_bytes = KEPT_BYTES / study.scenes.len() as u64;
        let in_voxels = Arc::new(Snapshots::of(&snapshots, grid, kept_bytes, go_on).map_err(in_scene)?);
        let shapes = shapes::shapes(study).map_err(|e| study.sources.judged(vec![e]))?;
        let mut worlds: Vec<World> = Vec::new();
        let mut still: Option<BitGrid> = None;
        for (snapshot, settings) in settings.into_iter().enumerate() {
            go_on().map_err(|e| vec![e])?;
            let moment = if spec.snapshots > 1 { format!(", snapshot {snapshot}") } else { String::new() };
            let place = format!("scene {:?}{moment}", spec.name);
            let world = World::of_snapshot(study, [scene, snapshot], &in_voxels, settings, &shapes);
            let mut world = world
                .map_err(|all| all.into_iter().flat_map(|e| in_study(e.at(&place))).collect::<Vec<_>>())?;
            worlds.last().iter().for_each(|before| world.share_regions(before));
            let blockers = &world.truth().blockers;
            still.get_or_insert_with(|| BitGrid::clone(blockers)).keep(blockers);
            worlds.push(world);
        }
        worlds[0].warnings = warnings::warnings(study, &snapshots, &worlds);
        if let (Some(still), [_, _, ..]) = (still, &worlds[..]) {
            let still = Arc::new(still);
            worlds.iter_mut().for_each(|world| world.still = Some(still.clone()));
        }
        let ([x, y, z], occupied) = (grid.size, worlds[0].truth().occupied.count());
        let (count, seconds) = (worlds.len(), begin.elapsed().as_secs_f64());
        tracing::info!(
            "scene {:?}: {x} × {y} × {z} voxels, {occupied} occupied (snapshot 0 of {count}), ready in {seconds:.3} s",
            spec.name
        );
        Ok(worlds)
    }

    fn of_snapshot(
        study: &Study,
        [scene, snapshot]: [usize; 2],
        snapshots: &Arc<Snapshots>,
        settings: Vec<Arc<Vec<Setting>>>,
        shapes: &[Shape],
    ) -> Result<World, Vec<Error>> {
        let truth = snapshots.truth(snapshot);
        let named = study.regions.iter().zip(shapes);
        let regions: Vec<Region> =
            all_or_wrong(named.map(|((name, _), shape)| region::region(name, shape, &truth)))?;
        let reachable = reachable(study, &truth, &settings).map_err(|(sensor, candidate, e)| {
            let (sensor, candidate) = (&study.sensors[sensor], &study.sensors[sensor].candidates[candidate]);
            vec![Error::Input(format!("sensor {:?}: {} {e}", sensor.name, candidate.name))]
        })?;
        let people = People::of(&truth, study.min_hits);
        let baselines = regions.iter().map(|region| baselines(&truth, region, &people, &reachable)).collect();
        let name = study.scenes[scene].name.clone();
        let mut world = World {
            scene,
            name,
            snapshot,
            grid: truth.grid,
            snapshots: snapshots.clone(),
            still: None,
            regions,
            settings,
            baselines,
            people,
            warnings: Vec::new(),
            described: Value::Null,
        };
        world.described = described::described(study, &world);
        Ok(world)
    }

    /// Keeps regions that are the same in an earlier snapshot once only.
    fn share_regions(&mut self, earlier: &World) {
        for (region, before) in self.regions.iter_mut().zip(&earlier.regions) {
            if before.cells == region.cells {
                region.cells = before.cells.clone();
            }
        }
    }

    /// Which voxels are what: put together when it is asked for, unless it was of late. Whoever asks often keeps it.
    pub fn truth(&self) -> Arc<Truth> {
        self.snapshots.truth(self.snapshot)
    }

    /// The scene's name, with the snapshot's number where there are several.
    pub fn title(&self, study: &Study) -> String {
        match study.scenes[self.scene].snapshots {
            1 => self.name.clone(),
            _ => format!("{}[{}]", self.name, self.snapshot),
        }
    }

    /// A sensor at a candidate, quantised; at the origin if it has no pose.
    pub fn placement(&self, study: &Study, sensor: usize, candidate: usize, repeat: usize) -> Placement {
        let truth = self.truth();
        self.station(study, &truth, [sensor, candidate, repeat]).placement(&*study.sensors[sensor].kind)
    }

    /// A sensor at a candidate in one repeat, looked at over the whole grid, without its table of rays. `truth` is this
    /// world's.
    pub fn station<'a>(
        &self,
        study: &Study,
        truth: &'a Truth,
        [sensor, candidate, repeat]: [usize; 3],
    ) -> Station<'a> {
        let setting = self.settings[sensor][candidate];
        Station {
            truth,
            window: self.grid.window(),
            setting,
            rays: None,
            truly: true_pose(study, setting, [sensor, candidate, repeat]),
            draws: sensor::draws(study.seed, [self.scene, self.snapshot, sensor, candidate, repeat]),
        }
    }

    /// The scene as backends see it, with evidence kept over a window.
    pub fn cell(&self, window: Window) -> Cell {
        let truth = self.truth();
        Cell {
            blockers: truth.blockers.clone(),
            still: self.still.clone(),
            window,
            truth: truth.occupied.over(window),
            human: truth.human.over(window),
            robot: truth.robot.over(window),
            regions: self.regions.iter().map(|region| region.cells.over(window)).collect(),
            people: self.people.within(window),
        }
    }
}

/// Where a sensor truly is in a repeat, if it has a pose and its mount may be off.
fn true_pose(study: &Study, setting: Setting, [sensor, candidate, repeat]: [usize; 3]) -> Option<Pose> {
    let calibration = study.sensors[sensor].kind.calibration()?;
    match setting {
        Setting::Pose(pose) => Some(calibration.true_pose(&pose, study.seed, [sensor, candidate, repeat])),
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

/// The settings of a sensor's candidates in a scene, with poses in the world.
fn settings(sensor: &Sensor, scene: &Scene) -> Result<Vec<Setting>> {
    let own = sensor.candidates.iter().map(|candidate| candidate.setting);
    let Some(on) = &sensor.on else { return Ok(own.collect()) };
    let wrong = |what: String| Error::input(format!("sensor {:?}: on", sensor.name), what);
    let carrier = scene.objects.iter().find(|object| object.name == on.object);
    let linkage = carrier.and_then(|object| object.linkage.as_deref()).ok_or_else(|| {
        let robots: Vec<_> =
            scene.objects.iter().filter(|o| o.linkage.is_some()).map(|o| o.name.as_str()).collect();
        wrong(format!(
            "object = {:?}: must be a robot with links, an object with urdf = ...; scene {:?} has {robots:?}",
            on.object, scene.name
        ))
    })?;
    let link = linkage.link(&on.link).map_err(|e| wrong(format!("link = {:?}: {e}", on.link)))?;
    let carried = |setting| match setting {
        Setting::Pose(pose) => Setting::Pose(pose.carried_by(link)),
        Setting::Fixed => Setting::Pose(*link),
        Setting::Inflation(_) => setting,
    };
    Ok(own.map(carried).collect())
}

/// What is wrong with a candidate: index of the sensor, of the candidate, and why.
type Wrong = (usize, usize, String);

/// What any sensor of a study could do from any of its candidates.
struct Reachable {
    /// The voxels that it could speak of.
    spoken_of: BitGrid,
    /// The voxels that it could hit or feel.
    hit: BitGrid,
}

/// What any sensor of the study could do from any of its candidates, every candidate checked.
fn reachable(study: &Study, truth: &Truth, settings: &[Arc<Vec<Setting>>]) -> Result<Reachable, Wrong> {
    let blank = BitGrid::new(truth.grid.window());
    let (mut begins, mut spoken_of) = (Vec::new(), blank.clone());
    let (mut hits_begin, mut hit) = (Vec::new(), blank);
    for (s, sensor) in study.sensors.iter().enumerate() {
        if let Some(cells) = sensor.kind.wherever_it_stands(truth) {
            spoken_of.add(&cells);
        }
        let housing = (sensor.kind.housing_m() / study.voxel_size_m).ceil();
        let housing = housing.min(f64::from(MAX_RANGE_VOXELS)) as u32;
        for (c, &setting) in settings[s].iter().enumerate() {
            let station =
                Station { truth, window: truth.grid.window(), setting, rays: None, truly: None, draws: 0 };
            sensor.kind.check(&station).map_err(|e| (s, c, e))?;
            let truly = true_poses(study, setting, [s, c]).map(|pose| pose.position_m);
            let from = [station.pose().position_m].into_iter().chain(truly);
            let here: Vec<_> = from.map(|at| (truth.grid.position_q16(at), housing)).collect();
            match sensor.kind.feels(&station) {
                Reach::Only(cells) => hit.add(&cells),
                Reach::Rays | Reach::RaysAnd(_) => hits_begin.extend_from_slice(&here),
            }
            match sensor.kind.reach(&station) {
                Reach::Rays => begins.extend(here),
                Reach::Only(cells) => spoken_of.add(&cells),
                Reach::RaysAnd(cells) => {
                    spoken_of.add(&cells);
                    begins.extend(here);
                }
            }
        }
    }
    let same = begins == hits_begin;
    let by_rays = |begins: Vec<_>| (!begins.is_empty()).then(|| voxelize::reachable(truth, begins));
    let reached = by_rays(begins);
    let may_hit = if same { reached.clone() } else { by_rays(hits_begin) };
    reached.iter().for_each(|cells| spoken_of.add(cells));
    may_hit.iter().for_each(|cells| hit.add(cells));
    Ok(Reachable { spoken_of, hit })
}

/// The grid of a scene: the user's bounds, or all surfaces of all snapshots and sensor positions.
fn grid(
    study: &Study,
    snapshots: &[Scene],
    settings: &[Vec<Arc<Vec<Setting>>>],
    surfaces: &Window,
) -> Result<Grid> {
    let size_m = study.voxel_size_m;
    let at_world = Grid { voxel_size_m: size_m, origin: [0; 3], size: [1; 3] };
    let key = |p: DVec3| Grid::cell_of(at_world.position_q16(p));
    let one = |p: DVec3| Window::between(key(p), key(p));
    let Some([min, max]) = study.bounds_m else {
        voxelize::grid_over_all(surfaces, size_m, snapshots)?;
        let each = settings.iter().flat_map(|snapshot| snapshot.iter().enumerate());
        let all = each.flat_map(|(sensor, all)| {
            let candidates = all.iter().enumerate();
            candidates.flat_map(move |(candidate, setting)| positions(study, [sensor, candidate], setting))
        });
        let all = all.fold(*surfaces, |all, p| all.union(&one(p)));
        return voxelize::grid_over(&all, size_m).map_err(|e| {
            let mut extent = *surfaces;
            let stretches = |p: DVec3| {
                extent = extent.union(&one(p));
                voxelize::grid_over(&extent, size_m).is_err()
            };
            first_pose(study, settings, stretches).map_or_else(
                || Error::Input(e.to_string()),
                |pose| Error::input(format!("{pose} stretches the grid"), &e),
            )
        });
    };
    let bounds = Window::between(key(min), key(max));
    match first_pose(study, settings, |p| !bounds.contains(key(p))) {
        None => voxelize::grid_over(&bounds, size_m),
        Some(pose) => Err(Error::Input(format!(
            "{pose} is outside grid.bounds_m {min} to {max}: move it, or widen the bounds"
        ))),
    }
}

/// Where a setting puts a sensor that looks out from there: where it is believed to be, and where it truly is in each repeat
/// if its mount may be off. Pads and gates are checked against the grid, and do not stretch it.
fn positions<'a>(
    study: &'a Study,
    [sensor, candidate]: [usize; 2],
    setting: &Setting,
) -> impl Iterator<Item = DVec3> + use<'a> {
    let kind = &study.sensors[sensor].kind;
    let believed = match setting {
        Setting::Pose(pose) if kind.stance() != Stance::Level => Some(*pose),
        _ => None,
    };
    let truly = believed
        .into_iter()
        .flat_map(move |pose| true_poses(study, Setting::Pose(pose), [sensor, candidate]));
    believed.into_iter().chain(truly).map(|pose| pose.position_m)
}

/// The first pose of the study, in any snapshot, whose position is so, in words.
fn first_pose(
    study: &Study,
    settings: &[Vec<Arc<Vec<Setting>>>],
    mut is_so: impl FnMut(DVec3) -> bool,
) -> Option<String> {
    let each = settings.iter().flat_map(|snapshot| snapshot.iter().enumerate());
    let mut poses = each.flat_map(|(s, all)| {
        let candidates = all.iter().enumerate();
        candidates.flat_map(move |(c, setting)| {
            positions(study, [s, c], setting).map(move |at| (s, c, setting, at))
        })
    });
    let (s, c, setting, at) = poses.find(|(.., at)| is_so(*at))?;
    let (sensor, believed) = (&study.sensors[s], setting.pose().position_m);
    let off = if at == believed {
        String::new()
    } else {
        format!(" (where its calibration puts it, which is believed at {believed})")
    };
    Some(format!("sensor {:?}: pose {} at {at}{off}", sensor.name, sensor.candidates[c].name))
}

fn baselines(truth: &Truth, region: &Region, people: &People, reachable: &Reachable) -> Baselines {
    let Reachable { spoken_of: reachable, hit } = reachable;
    let count = |planes: &[&BitGrid]| {
        let mut cells = BitGrid::clone(&region.cells);
        planes.iter().for_each(|plane| cells.keep(plane));
        cells.count()
    };
    let (s, t) = (region.cells.count(), count(&[&truth.occupied]));
    let (h, r) = (count(&[&truth.occupied, &truth.human]), count(&[&truth.occupied, &truth.robot]));
    let (reached, t_reached) = (count(&[reachable]), count(&[reachable, &truth.occupied]));
    let h_reached = count(&[reachable, &truth.occupied, &truth.human]);
    let r_reached = count(&[reachable, &truth.occupied, &truth.robot]);
    let f = s - t;
    // Whoever reaches a voxel of a person may be a presence sensor.
    let may_hit = people.detection(&region.cells, |voxel| hit.get(voxel), |voxel| hit.get(voxel));
    let no_hit = people.detection(&region.cells, |_| false, |_| false);
    let from = |counts| Confusion::from_counts(counts).with(no_hit);
    Baselines {
        all_occupied: from([t, f, 0, 0, 0, 0, h, 0, 0, r, 0, 0]),
        all_free: from([0, 0, t, f, 0, 0, 0, h, 0, 0, r, 0]),
        nothing_seen: from([0, 0, 0, 0, t, f, 0, 0, h, 0, 0, r]),
        ceiling: from([
            t_reached,
            0,
            0,
            reached - t_reached,
            t - t_reached,
            f - (reached - t_reached),
            h_reached,
            0,
            h - h_reached,
            r_reached,
            0,
            r - r_reached,
        ])
        .with(may_hit),
    }
}

#[cfg(test)]
mod tests;
