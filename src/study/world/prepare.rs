//! Prepares the worlds of a scene: its objects are built, sensors mounted, all of it voxelized on one grid, and the sensors
//! and regions of the study checked in each snapshot.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use rayon::prelude::*;

use super::baselines::{baselines, reachable};
use super::described::{Described, KnownHashes, describe};
use super::{Floor, World, extent, shapes, warnings};
use crate::input::Study;
use crate::sensor::{Sensor, Setting};
use perirobot_march::backend::{MEMORY_BYTES, OverTime};
use perirobot_march::error::{Issue, Site};
use perirobot_march::progress::Progress;
use perirobot_march::voxel::{BitGrid, Grid, Window};
use perirobot_march::{Error, Result};
use perirobot_scene::objects::{Scene, build::build_or_all};
use perirobot_scene::pose::Pose;
use perirobot_scene::truth::region::SweptBy;
use perirobot_scene::truth::{Region, RegionShape, Snapshots, people, region, voxelize};

/// Memory for the truths that are kept; others are put together again when they are asked for.
const KEPT_BYTES: u64 = 256 << 20;

/// What a voxel takes while its scene is made, about.
const BYTES_PER_VOXEL: u64 = 6;

/// The worlds of some scenes: scene by scene, in each snapshot by snapshot.
///
/// As many scenes as there are threads are made at the same time, or fewer that are large, so that memory stays bounded.
pub(super) fn all_worlds(
    study: &Study,
    scenes: Range<usize>,
    progress: &dyn Progress,
) -> Result<Vec<World>, Vec<Error>> {
    let mut worlds = Vec::new();
    let (mut scenes, threads) = (scenes.peekable(), rayon::current_num_threads());
    while scenes.peek().is_some() {
        let (mut read, mut bytes) = (Vec::new(), Vec::new());
        while fits_beside(&bytes, threads)
            && let Some(scene) = scenes.next()
        {
            let scene = ReadScene::new(study, scene, progress);
            bytes.push(scene.as_ref().map_or(0, ReadScene::bytes));
            let is_wrong = scene.is_err();
            read.push(scene);
            if is_wrong {
                // An earlier scene may be wrong, too, and is then the one to name.
                break;
            }
        }
        let made: Vec<Result<Vec<World>, Vec<Error>>> =
            read.into_par_iter().map(|scene| scene.and_then(|scene| scene.worlds(progress))).collect();
        for of_scene in made {
            worlds.extend(of_scene?);
        }
    }
    Ok(worlds)
}

/// Whether one more scene is made beside some that take so many bytes each: no more scenes than threads, and together
/// about as much memory as [`MEMORY_BYTES`] for each thread.
fn fits_beside(bytes: &[u64], threads: usize) -> bool {
    let all = bytes.iter().fold(0, |all: u64, &bytes| all.saturating_add(bytes));
    bytes.len() < threads && all < threads as u64 * MEMORY_BYTES
}

/// The worlds of a scene, snapshot by snapshot.
pub(super) fn worlds(study: &Study, scene: usize, progress: &dyn Progress) -> Result<Vec<World>, Vec<Error>> {
    ReadScene::new(study, scene, progress)?.worlds(progress)
}

/// A scene whose files are read: one scene after the other, since each has what its readers remarked.
struct ReadScene<'a> {
    study: &'a Study,
    scene: usize,
    begin: Instant,
    snapshots: Vec<Scene>,
    /// The voxels between all surfaces.
    surfaces: Result<Window>,
    shapes: Result<Vec<RegionShape>, Vec<Error>>,
    remarks: Vec<String>,
}

impl ReadScene<'_> {
    fn new<'a>(study: &'a Study, scene: usize, progress: &dyn Progress) -> Result<ReadScene<'a>, Vec<Error>> {
        progress.check_stop().map_err(|e| vec![e])?;
        let (spec, begin) = (&study.scenes[scene], Instant::now());
        let snapshots = build_or_all(spec, &study.sources, study.voxel_size_m)?;
        let surfaces = voxelize::scene_extent(&snapshots, study.voxel_size_m);
        // What is wrong with a region is told after what is wrong with the scene.
        let shapes = shapes::shapes(study, spec).map_err(|e| study.sources.classify(vec![e]));
        // Those about objects are theirs already.
        let remarks = study.sources.take_remarks();
        Ok(ReadScene { study, scene, begin, snapshots, surfaces, shapes, remarks })
    }

    /// What it takes of memory while it is made, about.
    fn bytes(&self) -> u64 {
        self.surfaces.as_ref().map_or(0, |surfaces| surfaces.volume().saturating_mul(BYTES_PER_VOXEL))
    }

    fn worlds(self, progress: &dyn Progress) -> Result<Vec<World>, Vec<Error>> {
        let ReadScene { study, scene, begin, snapshots, surfaces, shapes, remarks } = self;
        progress.check_stop().map_err(|e| vec![e])?;
        let spec = &study.scenes[scene];
        log::info!("scene {:?}: voxelizing at {} m", spec.name, study.voxel_size_m);
        let in_scene = |e: Error| vec![e.with_place(&spec.path)];
        let surfaces = surfaces.map_err(in_scene)?;
        let mounts = mounts(study, &snapshots)?;
        let grid = grid(study, scene, &snapshots, &mounts, &surfaces)?;
        let kept_bytes = KEPT_BYTES / study.scenes.len() as u64;
        let voxels = Arc::new(Snapshots::new(&snapshots, grid, kept_bytes, progress).map_err(in_scene)?);
        let floor = Floor::new(study, &snapshots[0]);
        let cell = SceneVoxels { study, scene, floor, voxels, shapes: shapes?, surfaces };
        let mut worlds = cell.worlds(mounts, progress)?;
        let told = warnings::warnings(study, &snapshots, &worlds);
        (worlds[0].warnings, worlds[0].is_filled) = (told.lines, told.is_filled);
        let remarks = remarks.into_iter().map(|remark| format!("a region is read from {remark}"));
        worlds[0].warnings.extend(remarks);
        let ([x, y, z], occupied) = (grid.size, worlds[0].truth().occupied.count());
        let (count, seconds) = (worlds.len(), begin.elapsed().as_secs_f64());
        log::info!(
            "scene {:?}: {x} × {y} × {z} voxels, {occupied} occupied (snapshot 0 of \
                {count}), ready in {seconds:.3} s",
            spec.name
        );
        Ok(worlds)
    }
}

/// The mounted sensors of a snapshot: for each the settings of its candidates, and where its carrier is.
struct Mounts {
    settings: Vec<Arc<Vec<Setting>>>,
    carriers: Vec<Option<Pose>>,
}

/// The mounts of each snapshot; settings that are the same in snapshots on end are held once.
fn mounts(study: &Study, snapshots: &[Scene]) -> Result<Vec<Mounts>, Vec<Error>> {
    let mut all: Vec<Mounts> = Vec::new();
    for snapshot in snapshots {
        let carriers = all_or_wrong(study.sensors.iter().map(|sensor| carrier(sensor, snapshot)));
        let carriers = carriers.map_err(|all| blame_study(study, all))?;
        let before = all.last().map_or(&[][..], |mounts| &mounts.settings);
        let shared = study.sensors.iter().zip(&carriers).enumerate().map(|(number, (sensor, carrier))| {
            let new = sensor.settings(carrier.as_ref());
            match before.get(number) {
                Some(same) if **same == new => same.clone(),
                _ => Arc::new(new),
            }
        });
        all.push(Mounts { settings: shared.collect(), carriers });
    }
    Ok(all)
}

/// The grid of the scene. A wrong unit is the likely cause of one that is too large.
fn grid(
    study: &Study,
    scene: usize,
    snapshots: &[Scene],
    mounts: &[Mounts],
    surfaces: &Window,
) -> Result<Grid, Vec<Error>> {
    let settings: Vec<_> = mounts.iter().map(|mounts| mounts.settings.clone()).collect();
    extent::grid(study, snapshots, &settings, surfaces).map_err(|e| {
        let spec = &study.scenes[scene];
        let slips = study.warnings.iter().map(|slip| (&study.path, slip));
        let slips = slips.chain(spec.warnings.iter().map(|slip| (&spec.path, slip)));
        let told = slips.map(|(path, slip)| format!("{}: {slip}", path.display()));
        blame_study(study, vec![told.fold(e, Error::cure)])
    })
}

/// Errors that the study causes.
fn blame_study(study: &Study, all: Vec<Error>) -> Vec<Error> {
    all.into_iter().map(|e| e.with_place(&study.path)).collect()
}

/// A scene in voxels, of which worlds are made.
struct SceneVoxels<'a> {
    study: &'a Study,
    scene: usize,
    floor: Floor,
    voxels: Arc<Snapshots>,
    shapes: Vec<RegionShape>,
    surfaces: Window,
}

impl SceneVoxels<'_> {
    /// A world for each snapshot; what is the same in several is held once.
    fn worlds(&self, mounts: Vec<Mounts>, progress: &dyn Progress) -> Result<Vec<World>, Vec<Error>> {
        let spec = &self.study.scenes[self.scene];
        let (over_time, known) = (Mutex::new(None), KnownHashes::default());
        let made = mounts.into_par_iter().enumerate().map(|(snapshot, mounts)| {
            progress.check_stop().map_err(|e| vec![e])?;
            let moment = if spec.snapshots > 1 { format!(", snapshot {snapshot}") } else { String::new() };
            let place = format!("scene {:?}{moment}", spec.name);
            let world = self.world(snapshot, mounts, &known).map_err(|all| {
                blame_study(self.study, all.into_iter().map(|e| e.with_place(place.as_str())).collect())
            })?;
            if spec.snapshots > 1 {
                add_blockers(&over_time, &world.truth().blockers);
            }
            Ok(world)
        });
        // The first snapshot that is wrong is the one to name.
        let made: Vec<Result<World, Vec<Error>>> = made.collect();
        let mut worlds: Vec<World> = made.into_iter().collect::<Result<_, _>>()?;
        if let Some([always, ever]) = over_time.into_inner().unwrap_or_else(PoisonError::into_inner) {
            let all = Arc::new(OverTime { always: always.into(), ever: ever.into() });
            worlds.iter_mut().for_each(|world| world.over_time = Some(all.clone()));
        }
        Ok(worlds)
    }

    /// The world of a snapshot, in which all regions and candidates are right.
    fn world(
        &self,
        snapshot: usize,
        Mounts { settings, carriers }: Mounts,
        known: &KnownHashes,
    ) -> Result<World, Vec<Error>> {
        let (study, scene) = (self.study, self.scene);
        let truth = self.voxels.truth(snapshot);
        let named = study.regions.iter().zip(&self.shapes);
        let swept_by: SweptBy = &|role| self.voxels.swept(role);
        let regions: Vec<Region> =
            all_or_wrong(named.map(|((name, _), shape)| region::region(name, shape, &truth, swept_by)))?;
        let reachable =
            reachable(study, [scene, snapshot], &truth, &settings).map_err(|(sensor, candidate, e)| {
                let (sensor, candidate) =
                    (&study.sensors[sensor], &study.sensors[sensor].candidates[candidate]);
                let pose = Site::Subject(candidate.name.clone());
                vec![e.with_place(pose).with_place(format!("sensor {:?}", sensor.name)).into()]
            })?;
        let people = people(&truth, study.min_hits);
        let baselines = regions.iter().map(|region| baselines(&truth, region, &people, &reachable)).collect();
        let mut world = World {
            scene,
            name: study.scenes[scene].name.clone(),
            snapshot,
            grid: truth.grid,
            floor: self.floor,
            snapshots: self.voxels.clone(),
            over_time: None,
            regions,
            settings,
            carriers,
            surfaces: self.surfaces,
            baselines,
            people,
            warnings: Vec::new(),
            is_filled: false,
            described: Described::default(),
        };
        world.described = describe(study, &mut world, known);
        Ok(world)
    }
}

/// Adds a snapshot's blockers to those of every snapshot and of any, in whatever order the snapshots come.
fn add_blockers(over_time: &Mutex<Option<[BitGrid; 2]>>, blockers: &BitGrid) {
    let mut over_time = over_time.lock().unwrap_or_else(PoisonError::into_inner);
    let [always, ever] = over_time.get_or_insert_with(|| [blockers.clone(), blockers.clone()]);
    always.keep(blockers);
    ever.add(blockers);
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
pub(super) fn carrier(sensor: &Sensor, scene: &Scene) -> Result<Option<Pose>> {
    let Some(on) = &sensor.on else { return Ok(None) };
    let placed = |issue: Issue| issue.with_place("on").with_place(format!("sensor {:?}", sensor.name));
    Ok(Some(scene.link(on).map_err(placed)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_scenes_are_made_beside_fewer_others() {
        let beside = |bytes: u64, threads: usize| {
            (0..).find(|&count| !fits_beside(&vec![bytes; count], threads)).unwrap()
        };
        assert_eq!([1, 4, 16].map(|threads| beside(MEMORY_BYTES / 2, threads)), [1, 4, 16]);
        assert_eq!([1, 4, 16].map(|threads| beside(4 * MEMORY_BYTES, threads)), [1, 1, 4]);
        assert_eq!([1, 4, 16].map(|threads| beside(u64::MAX, threads)), [1, 1, 1]);
    }
}
