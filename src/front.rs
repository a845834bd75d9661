//! The library's front: what a study scores, and what a camera scores in a cell that is made without any
//! file. Everything else in the crate serves this and the command line.

use std::path::Path;

use perirobot_march::backend::adapter::AdapterChoice;
use perirobot_march::backend::factory::{BackendChoice, BackendKind};
use perirobot_march::backend::{Backend, Fusion, Reading, Shot, Slot, VoxelScene};
use perirobot_march::metrics::{BodyPart, Confusion};
use perirobot_march::voxel::grid::MAX_VOXELS_PER_AXIS;
use perirobot_march::voxel::{BitGrid, BodyVoxel, Grid, People};
use perirobot_march::{Error, Result};
use perirobot_scene::objects::Role;
use perirobot_scene::pose::Pose;
use perirobot_study::input::{self, Overrides};
use perirobot_study::sensor::MAX_RAYS;
use perirobot_study::sensor::kinds::rgbd::{KeypointShape, Rgbd};
use perirobot_study::sensor::range::{Along, Range, ReflectanceRanges};
use perirobot_study::sensor::{Camera, Kind, MEASURES, RayScale, noise::Deviation, placement};
use perirobot_study::world::World;
use perirobot_sweep::results::columns;
use perirobot_sweep::scoring;

/// What computes. All give the same integers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Device {
    /// All processors that the process may use.
    #[default]
    Cpu,
    /// The first hardware adapter of Vulkan.
    Gpu,
    /// A Vulkan adapter that runs on the processor, such as Mesa's lavapipe.
    SoftwareGpu,
    /// The plain reference, one thread, by which all others are checked.
    Oracle,
}

impl Device {
    fn open(self) -> Result<Box<dyn Backend + Send>> {
        let (kind, adapter) = match self {
            Device::Cpu => (BackendKind::Cpu, None),
            Device::Gpu => (BackendKind::Gpu, None),
            Device::SoftwareGpu => (BackendKind::Gpu, Some(AdapterChoice::Software)),
            Device::Oracle => (BackendKind::Oracle, None),
        };
        Ok(BackendChoice { kind, adapter, ..BackendChoice::default() }.open()?.0)
    }
}

/// What one choice of poses scores in one region: a row of `results.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct Scored {
    /// Name of the scene.
    pub scene: String,
    /// Which moment of the scene, counted from 0.
    pub snapshot: usize,
    /// Which repeat, counted from 0.
    pub repeat: usize,
    /// Names of the poses: `camera:wall/3/1;pads:floor/0`.
    pub poses: String,
    /// How the sensors' data were read: `points;volume`.
    pub representation: String,
    /// Name of the region.
    pub region: String,
    /// What was right and wrong; scores are its methods ([`Confusion::f1`] and so on).
    pub counts: Confusion,
}

/// A checked study: what to sweep over what.
#[derive(Clone, Debug)]
pub struct Study(input::Study);

impl Study {
    /// Reads and checks a study and its scene files (not their meshes), which must lie in its folder or
    /// below. Overrides change the edge of a voxel, in metres, or switch noise off.
    ///
    /// # Errors
    /// Everything that is wrong with the files, by file and key.
    pub fn load(path: &Path, overrides: &Overrides) -> Result<Study> {
        input::Study::load(path, overrides).map(Study)
    }

    /// Voxelizes the study's scenes and scores every choice of poses of every combination: the rows of
    /// `results.csv`, in order and all in memory. `perirobot sweep` does the same resumably, with a journal.
    ///
    /// # Errors
    /// What is wrong with scenes and meshes, by file and key, or with the device.
    pub fn score(&self, device: Device) -> Result<Vec<Scored>> {
        let Study(study) = self;
        let worlds = World::prepare_all(study)?;
        let rows = scoring::run(study, &worlds, device.open()?.as_mut())?;
        let representations: Vec<Vec<String>> =
            study.combinations.iter().map(|c| columns::representation_names(study, c)).collect();
        let scored = rows.iter().map(|row| Scored {
            scene: study.scenes[row.scene].name.clone(),
            snapshot: row.snapshot,
            repeat: row.repeat,
            poses: columns::pose_names(study, &study.combinations[row.combination], row.choice),
            representation: representations[row.combination][row.representation].clone(),
            region: study.regions[row.region].0.clone(),
            counts: row.counts,
        });
        Ok(scored.collect())
    }
}

/// A depth camera without noise: one ray through the centre of each pixel of an ideal pinhole image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthCamera {
    /// Full angles of view in degrees, across and down; each from 0.001 and below 180.
    pub fov_deg: [f64; 2],
    /// Pixels across and down.
    pub resolution_px: [u32; 2],
    /// Nearest and farthest distance that it measures along each ray, in metres. Without a return a ray says nothing.
    pub range_m: [f64; 2],
}

impl DepthCamera {
    fn rgbd(&self) -> Result<Rgbd> {
        let wrong = |key: &str, value: String, wanted: &str| {
            Err(Error::input(format!("camera.{key}"), format!("is {value}, must be {wanted}")))
        };
        let DepthCamera { fov_deg, resolution_px, range_m } = *self;
        if !fov_deg.iter().all(|&angle| (0.001..180.0).contains(&angle)) {
            return wrong("fov_deg", format!("{fov_deg:?}"), "two angles from 0.001 and below 180 degrees");
        }
        let pixels: u64 = resolution_px.iter().map(|&n| u64::from(n)).product();
        if pixels == 0 || pixels > MAX_RAYS as u64 {
            return wrong(
                "resolution_px",
                format!("{resolution_px:?}"),
                &format!("at least 1 each and {MAX_RAYS} together"),
            );
        }
        if !(range_m[0] >= 0.0 && range_m[0] < range_m[1] && range_m[1].is_finite()) {
            return wrong(
                "range_m",
                format!("{range_m:?}"),
                "a nearest distance and a farther one, in metres",
            );
        }
        Ok(Rgbd {
            camera: Camera { fov_rad: fov_deg.map(f64::to_radians), resolution_px },
            range: Range {
                range_m,
                along: Along::Ray,
                near_ignore_m: 0.0,
                no_return_is_free: false,
                noise: Deviation::NONE,
                dropout: 0.0,
                calibration: None,
                reflectance: ReflectanceRanges::NONE,
            },
            shapes: vec![KeypointShape::Points],
            keypoint_tolerance_m: 0.0,
        })
    }
}

/// A cell in voxels, made without any file. Voxel [0, 0, 0] has its lowest corner at the world's origin, and z
/// is up.
#[derive(Clone, Debug)]
pub struct Cell {
    grid: Grid,
    /// Voxels of the environment, the robot and people.
    roles: [BitGrid; 3],
    regions: Vec<BitGrid>,
}

impl Cell {
    /// A cell of so many voxels along x, y and z, whose edges are `voxel_size_m` metres long. `role` says what
    /// stands in a voxel, `None` for nothing.
    ///
    /// # Errors
    /// Where an axis has no voxel or more than 1023, or the voxel size is no length above 0.
    pub fn from_fn(
        size: [u32; 3],
        voxel_size_m: f64,
        mut role: impl FnMut([u32; 3]) -> Option<Role>,
    ) -> Result<Cell> {
        if let Some(axis) = (0..3).find(|&r| size[r] == 0 || size[r] > MAX_VOXELS_PER_AXIS) {
            let what = format!(
                "is {size:?}, must be 1 to {MAX_VOXELS_PER_AXIS} voxels along {}",
                ["x", "y", "z"][axis]
            );
            return Err(Error::input("size", what));
        }
        if !(voxel_size_m > 0.0 && voxel_size_m.is_finite()) {
            let what = format!("is {voxel_size_m}, must be a length above 0, in metres");
            return Err(Error::input("voxel_size_m", what));
        }
        let grid = Grid { voxel_size_m, origin: [0; 3], size };
        let mut roles = [(); 3].map(|()| BitGrid::new(grid.window()));
        for voxel in voxels_of(size) {
            if let Some(role) = role(voxel) {
                roles[role as usize].set(voxel.map(|n| n as i32));
            }
        }
        Ok(Cell { grid, roles, regions: Vec::new() })
    }

    /// The same from an array with x fastest: voxel [x, y, z] is `roles[x + size[0] * (y + size[1] * z)]`.
    ///
    /// # Errors
    /// As [`Cell::from_fn`], and where the array is not as long as there are voxels.
    pub fn from_array(size: [u32; 3], voxel_size_m: f64, roles: &[Option<Role>]) -> Result<Cell> {
        let voxels: u64 = size.iter().map(|&n| u64::from(n)).product();
        if voxels != roles.len() as u64 {
            let what = format!("has {} entries, {size:?} voxels are {voxels}", roles.len());
            return Err(Error::input("roles", what));
        }
        let [nx, ny, _] = size.map(|n| n as usize);
        Cell::from_fn(size, voxel_size_m, |[x, y, z]| roles[x as usize + nx * (y as usize + ny * z as usize)])
    }

    /// Adds a region of interest: the voxels that are counted. A cell without any is counted whole.
    pub fn region(mut self, mut inside: impl FnMut([u32; 3]) -> bool) -> Cell {
        let mut region = BitGrid::new(self.grid.window());
        voxels_of(self.grid.size)
            .filter(|&voxel| inside(voxel))
            .for_each(|v| region.set(v.map(|n| n as i32)));
        self.regions.push(region);
        self
    }

    /// Casts a camera from each pose and counts what its points claim: of each pose, the counts of each
    /// region. All voxels of people are one person of one part, detected with 3 hits.
    ///
    /// # Errors
    /// Where no camera can have these values, a pose lies outside the cell, or the device fails.
    pub fn score(&self, camera: &DepthCamera, poses: &[Pose], device: Device) -> Result<Vec<Vec<Confusion>>> {
        let camera = camera.rgbd()?;
        let placements = poses.iter().zip(0..).map(|(pose, number)| {
            let at = Grid::voxel_of(self.grid.position_q16(pose.position_m));
            match pose.position_m.is_finite() && self.grid.window().contains(at) {
                true => Ok(placement(&camera, pose, &self.grid, 0)),
                false => {
                    let [x, y, z] = self.grid.size.map(|n| f64::from(n) * self.grid.voxel_size_m);
                    let what = format!("is at {} m, outside the cell of {x} × {y} × {z} m", pose.position_m);
                    Err(Error::input(format!("poses[{number}]"), what))
                }
            }
        });
        let placements: Vec<_> = placements.collect::<Result<_>>()?;
        if let Some(number) = self.regions.iter().position(BitGrid::is_empty) {
            return Err(Error::input(format!("regions[{number}]"), "has no voxel"));
        }
        let mut backend = device.open()?;
        backend.tables(
            &camera.rays(&RayScale::new(self.grid.voxel_size_m, false)).into_iter().collect::<Vec<_>>(),
        )?;
        backend.load(&self.voxel_scene())?;
        let [hit, miss] = MEASURES;
        let mut counts = Vec::with_capacity(poses.len());
        for batch in placements.chunks(backend.slots()) {
            let slots = 0..batch.len() as Slot;
            let shots: Vec<Shot> =
                slots.clone().zip(batch).map(|(slot, &pose)| Shot::once(slot, pose)).collect();
            backend.sense(0, &shots)?;
            let jobs: Vec<_> =
                slots.map(|slot| vec![Reading { slot, volume: None, hit, miss, presence: false }]).collect();
            counts.extend(backend.score(Fusion::OccupiedWins, &jobs)?);
        }
        Ok(counts)
    }

    /// The cell as backends see it.
    fn voxel_scene(&self) -> VoxelScene {
        let all = self.grid.window();
        let regions = match self.regions.is_empty() {
            true => vec![BitGrid::full(all)],
            false => self.regions.clone(),
        };
        let window = regions.iter().map(BitGrid::bounds).reduce(|a, b| a.union(&b)).unwrap_or(all);
        let [environment, robot, human] = &self.roles;
        let mut blockers = environment.clone();
        blockers.add(robot);
        blockers.add(human);
        let over = |plane: &BitGrid| plane.to_window(window);
        let human = over(human);
        let voxels = human.voxels().map(|voxel| BodyVoxel { voxel, person: 0, part: BodyPart::Body });
        VoxelScene {
            shades: None,
            truth: over(&blockers),
            robot: over(robot),
            regions: regions.iter().map(over).collect(),
            people: People { min_hits: 3, voxels: voxels.collect() },
            human,
            window,
            blockers: blockers.into(),
            over_time: None,
        }
    }
}

/// The voxels of a grid, x fastest.
fn voxels_of([nx, ny, nz]: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}
