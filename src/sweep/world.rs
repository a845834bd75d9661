//! A study made ready to cast: every scene voxelized, every region a mask, every pose inside its grid. Whatever can be
//! wrong with the input is found here, before any ray.

mod warnings;

use glam::DVec3;

use crate::backend::Cell;
use crate::march::MAX_RANGE_VOXELS;
use crate::metrics::Confusion;
use crate::scene::{Scene, build::build};
use crate::study::{SceneSpec, Study};
use crate::voxel::{BitGrid, Grid, Region, Truth, Window, region, voxelize};
use crate::{Error, Result};

/// A scene of a study at one moment, in voxels.
#[derive(Debug)]
pub struct World {
    /// The scene's name.
    pub name: String,
    /// Which moment of the scene it is, counted from 0.
    pub snapshot: usize,
    /// Which voxels are what.
    pub truth: Truth,
    /// The study's regions in this scene, in study order.
    pub regions: Vec<Region>,
    /// For each region, what the simplest answers would score.
    pub baselines: Vec<Baselines>,
    /// What was assumed about the scene that the user may not expect, told with its first snapshot only.
    pub warnings: Vec<String>,
}

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
        let scenes: Vec<_> =
            study.scenes.iter().map(|scene| World::prepare(study, scene)).collect::<Result<_>>()?;
        Ok(scenes.into_iter().flatten().collect())
    }

    /// Voxelizes one scene of a study, all its snapshots on one grid, and checks the study's sensors and regions
    /// against each.
    pub fn prepare(study: &Study, spec: &SceneSpec) -> Result<Vec<World>> {
        let in_scene = |e| Error::input(spec.path.display(), e);
        let in_study = |e| Error::input(study.path.display(), e);
        let snapshots = build(spec, study.voxel_size_m)?;
        let extent = voxelize::scene_extent(&snapshots, study.voxel_size_m).map_err(in_scene)?;
        let grid = grid(study, &snapshots, &extent).map_err(in_study)?;
        let truths = voxelize::voxelize_all(&snapshots, grid).map_err(in_scene)?;
        let mut worlds: Vec<World> = (truths.into_iter().zip(&snapshots))
            .map(|(truth, scene)| {
                let moment =
                    if spec.snapshots > 1 { format!(", snapshot {}", scene.snapshot) } else { String::new() };
                let place = format!("scene {:?}{moment}", spec.name);
                World::of_snapshot(study, scene, truth).map_err(|e| in_study(Error::input(place, e)))
            })
            .collect::<Result<_>>()?;
        worlds[0].warnings = warnings::warnings(study, &worlds);
        Ok(worlds)
    }

    fn of_snapshot(study: &Study, scene: &Scene, truth: Truth) -> Result<World> {
        let shapes = study.regions.iter();
        let regions: Vec<Region> =
            shapes.map(|(name, shape)| region::region(name, shape, &truth)).collect::<Result<_>>()?;
        let begins = study.sensors.iter().flat_map(|sensor| {
            let housing =
                (sensor.near_ignore_m / study.voxel_size_m).ceil().min(f64::from(MAX_RANGE_VOXELS)) as u32;
            let grid = truth.grid;
            sensor.candidates.iter().map(move |c| (grid.position_q16(c.pose.position_m), housing))
        });
        let reachable = voxelize::reachable(&truth, begins);
        let baselines = regions.iter().map(|region| baselines(&truth, region, &reachable)).collect();
        let (name, snapshot) = (scene.name.clone(), scene.snapshot);
        Ok(World { name, snapshot, truth, regions, baselines, warnings: Vec::new() })
    }

    /// The scene as backends see it, with evidence kept over a window.
    pub fn cell(&self, window: Window) -> Cell {
        Cell {
            blockers: self.truth.blockers.clone(),
            window,
            truth: self.truth.occupied.over(window),
            human: self.truth.human.over(window),
            robot: self.truth.robot.over(window),
            regions: self.regions.iter().map(|region| region.cells.over(window)).collect(),
        }
    }
}

fn positions(study: &Study) -> impl Iterator<Item = DVec3> + '_ {
    study.sensors.iter().flat_map(|sensor| sensor.candidates.iter().map(|c| c.pose.position_m))
}

/// The grid of a scene: the user's bounds, or all surfaces of all snapshots and sensor positions.
fn grid(study: &Study, snapshots: &[Scene], surfaces: &Window) -> Result<Grid> {
    let size_m = study.voxel_size_m;
    let at_world = Grid { voxel_size_m: size_m, origin: [0; 3], size: [1; 3] };
    let key = |p: DVec3| Grid::cell_of(at_world.position_q16(p));
    let one = |p: DVec3| Window::between(key(p), key(p));
    let Some([min, max]) = study.bounds_m else {
        voxelize::grid_over(surfaces, size_m)
            .map_err(|e| Error::Input(format!("{e}{}", voxelize::largest_object(snapshots))))?;
        let all = positions(study).fold(*surfaces, |all, p| all.union(&one(p)));
        return voxelize::grid_over(&all, size_m).map_err(|e| {
            let mut extent = *surfaces;
            let stretches = |p: DVec3| {
                extent = extent.union(&one(p));
                voxelize::grid_over(&extent, size_m).is_err()
            };
            first_pose(study, stretches).map_or_else(
                || Error::Input(e.to_string()),
                |pose| Error::input(format!("{pose} stretches the grid"), &e),
            )
        });
    };
    let bounds = Window::between(key(min), key(max));
    match first_pose(study, |p| !bounds.contains(key(p))) {
        None => voxelize::grid_over(&bounds, size_m),
        Some(pose) => Err(Error::Input(format!(
            "{pose} is outside grid.bounds_m {min} to {max}: move it, or widen the bounds"
        ))),
    }
}

/// The first pose of the study whose position is so, in words.
fn first_pose(study: &Study, mut is_so: impl FnMut(DVec3) -> bool) -> Option<String> {
    study.sensors.iter().find_map(|sensor| {
        let found = sensor.candidates.iter().find(|c| is_so(c.pose.position_m))?;
        Some(format!("sensor {:?}: pose {} at {}", sensor.name, found.name, found.pose.position_m))
    })
}

fn baselines(truth: &Truth, region: &Region, reachable: &BitGrid) -> Baselines {
    let count = |planes: &[&BitGrid]| {
        let mut cells = region.cells.clone();
        planes.iter().for_each(|plane| cells.keep(plane));
        cells.count()
    };
    let (s, t) = (region.cells.count(), count(&[&truth.occupied]));
    let (h, r) = (count(&[&truth.occupied, &truth.human]), count(&[&truth.occupied, &truth.robot]));
    let (reached, t_reached) = (count(&[reachable]), count(&[reachable, &truth.occupied]));
    let h_reached = count(&[reachable, &truth.occupied, &truth.human]);
    let r_reached = count(&[reachable, &truth.occupied, &truth.robot]);
    let f = s - t;
    let from = Confusion::from_counts;
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
        ]),
    }
}

#[cfg(test)]
mod tests;
