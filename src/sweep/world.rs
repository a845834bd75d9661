//! A study made ready to cast: every scene voxelized, every region a mask, every pose inside its grid. Whatever can be
//! wrong with the input is found here, before any ray.

use glam::DVec3;

use crate::backend::Cell;
use crate::march::MAX_RANGE_VOXELS;
use crate::metrics::Confusion;
use crate::scene::{Role, Scene, build::build};
use crate::sensor::Sensor;
use crate::study::{SceneSpec, Study};
use crate::voxel::{BitGrid, Grid, Region, Truth, Window, region, voxelize};
use crate::{Error, Result};

use super::shapes;

/// A scene of a study, in voxels.
#[derive(Debug)]
pub struct World {
    /// The scene's name.
    pub name: String,
    /// Which voxels are what.
    pub truth: Truth,
    /// The study's regions in this scene, in study order.
    pub regions: Vec<Region>,
    /// For each region, what the simplest answers would score.
    pub baselines: Vec<Baselines>,
    /// What was assumed that the user may not expect.
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
    /// Voxelizes one scene of a study and checks the study's sensors and regions against it.
    pub fn prepare(study: &Study, spec: &SceneSpec) -> Result<World> {
        let in_scene = |e| Error::input(spec.path.display(), e);
        let in_study = |e| Error::input(study.path.display(), e);
        let scene = build(spec, study.voxel_size_m)?;
        let extent = voxelize::scene_extent(&scene, study.voxel_size_m).map_err(in_scene)?;
        let grid = grid(study, &scene, &extent).map_err(in_study)?;
        let truth = voxelize::voxelize(&scene, grid).map_err(in_scene)?;
        let shapes = shapes::shapes(study)?;
        let regions: Vec<Region> = study
            .regions
            .iter()
            .zip(&shapes)
            .map(|((name, _), shape)| region::region(name, shape, &truth))
            .collect::<Result<_>>()
            .map_err(|e| in_study(Error::input(format!("scene {:?}", spec.name), e)))?;
        let begins = study.sensors.iter().flat_map(|sensor| {
            let housing =
                (sensor.near_ignore_m / study.voxel_size_m).ceil().min(f64::from(MAX_RANGE_VOXELS)) as u32;
            sensor.candidates.iter().map(move |c| (grid.position_q16(c.pose.position_m), housing))
        });
        let reachable = voxelize::reachable(&truth, begins);
        let baselines = regions.iter().map(|region| baselines(&truth, region, &reachable)).collect();
        let warnings = warnings(study, &truth, &regions);
        Ok(World { name: spec.name.clone(), truth, regions, baselines, warnings })
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

/// The grid of a scene: the user's bounds, or all surfaces and sensor positions.
fn grid(study: &Study, scene: &Scene, surfaces: &Window) -> Result<Grid> {
    let size_m = study.voxel_size_m;
    let at_world = Grid { voxel_size_m: size_m, origin: [0; 3], size: [1; 3] };
    let key = |p: DVec3| Grid::cell_of(at_world.position_q16(p));
    let one = |p: DVec3| Window::between(key(p), key(p));
    let Some([min, max]) = study.bounds_m else {
        voxelize::grid_over(surfaces, size_m)
            .map_err(|e| Error::Input(format!("{e}{}", voxelize::largest_object(scene))))?;
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

fn warnings(study: &Study, truth: &Truth, regions: &[Region]) -> Vec<String> {
    let mut warnings = Vec::new();
    for object in &truth.objects {
        warnings.extend(object.warnings.iter().map(|w| format!("object {:?} {w}", object.name)));
        if object.cells.is_empty() {
            warnings.push(format!("object {:?} lies outside the grid and is left out", object.name));
        }
    }
    if !truth.objects.iter().any(|o| o.role == Role::Human) {
        warnings.push("no object has role = \"human\": human_seen has no value".into());
    }
    for region in regions.iter().filter(|region| region.cut_share > 0.0) {
        let percent = 100.0 * region.cut_share;
        warnings.push(format!(
            "region {:?}: {percent:.1} % of it lies outside the grid and is not counted",
            region.name
        ));
    }
    let ignored = truth.ignored.count() as f64 / truth.grid.window().volume() as f64;
    if ignored > 0.5 {
        let percent = 100.0 * ignored;
        warnings.push(format!(
            "{percent:.0} % of the grid is inside bodies whose interior is ignored: a hull that is the room itself \
             needs interior = \"free\""
        ));
    }
    for sensor in &study.sensors {
        warnings.extend(inside_warning(
            sensor,
            &truth.blockers,
            &truth.grid,
            "stand in an occupied voxel: their rays start behind its surface",
        ));
        warnings.extend(inside_warning(
            sensor,
            &truth.ignored,
            &truth.grid,
            "stand inside a body whose interior is ignored",
        ));
    }
    warnings
}

fn inside_warning(sensor: &Sensor, plane: &BitGrid, grid: &Grid, what: &str) -> Option<String> {
    let cell = |position| Grid::cell_of(grid.position_q16(position));
    let mut inside = sensor.candidates.iter().filter(|c| plane.get(cell(c.pose.position_m)));
    let first = inside.next()?;
    let count = 1 + inside.count();
    Some(format!("sensor {:?}: {count} poses (first {}) {what}", sensor.name, first.name))
}

#[cfg(test)]
mod tests;
