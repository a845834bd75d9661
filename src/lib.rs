//! Scores where to put the sensors of a robot cell.
//!
//! perirobot voxelizes a cell, casts every ray of every candidate sensor pose through it, writes what the
//! sensor would claim (occupied, free, unknown), compares that with the truth inside regions of interest, and
//! scores the pose with F1 and Cohen's κ. It implements and extends "perirobot space
//! representation" by Rozlivek, Svarny and Hoffmann (IROS 2023). The counts behind the scores are integers,
//! and the same on every CPU and GPU.
//!
//! Most people use the program: `perirobot sweep study.toml`; the [`guide`] is for them. A Rust program needs
//! ten names: `Study`, `Cell`, `Role`, `DepthCamera`, `Pose`, `Device`, `Scored`, `Confusion`, `Error` and
//! `Result`.
//!
//! # From files
//!
//! A study is a TOML file that names scene files, regions, sensors and their candidate poses:
//!
//! ```
//! # fn main() -> perirobot::Result<()> {
//! use perirobot::{Device, Study};
//!
//! let study = Study::load("scenes/tiny.toml".as_ref(), &Default::default())?;
//! let mut rows = study.score(Device::Cpu)?;
//! rows.retain(|row| row.region == "robot");
//! rows.sort_by(|a, b| b.counts.f1().partial_cmp(&a.counts.f1()).expect("no score is NaN"));
//! for row in rows.iter().take(3) {
//!     println!("{} ({}): F1 {:.3?}", row.poses, row.representation, row.counts.f1());
//! }
//! # assert!(rows[0].counts.f1() > Some(0.1));
//! # Ok(())
//! # }
//! ```
//!
//! # Without any file
//!
//! The voxels of a cell can also come from a function or an array. Of each pose come the counts of each region:
//!
//! ```
//! # fn main() -> perirobot::Result<()> {
//! use perirobot::{Cell, DepthCamera, Device, Pose, Role};
//!
//! // 4 m × 3 m × 2.5 m in voxels of 10 cm: a floor, a table, and a person behind it.
//! let cell = Cell::from_fn([40, 30, 25], 0.1, |voxel| match voxel {
//!     [_, _, 0] | [15..25, 10..20, 7] => Some(Role::Environment),
//!     [18..22, 22..25, 1..18] => Some(Role::Human),
//!     _ => None,
//! })?
//! .region(|[x, y, _]| (10..30).contains(&x) && y >= 10);
//! let camera = DepthCamera { fov_deg: [87.0, 58.0], resolution_px: [320, 200], range_m: [0.3, 6.0] };
//! let poses = [0.5, 2.0, 3.5].map(|x| {
//!     let (pan_rad, tilt_rad) = (0.0, -0.5);
//!     Pose::facing([x, 0.25, 2.2].into(), [0.0, 1.0, 0.0].into(), pan_rad, tilt_rad)
//! });
//! for (pose, regions) in poses.iter().zip(cell.score(&camera, &poses, Device::Cpu)?) {
//!     println!("{}: F1 {:.3?}, κ {:.3?}", pose.position_m, regions[0].f1(), regions[0].kappa());
//! #   assert!(regions[0].f1() > Some(0.05) && regions[0].total() == 20 * 20 * 25);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # How it is built
//!
//! The way of the data (an arrow is "becomes" or "goes into"):
//!
//! ```text
//! scene.toml, meshes ─► scene ─► truth ─► world ──┐
//! study.toml ─► study (sensors, poses, regions) ──┴─► sweep, choose ─► results ─► report, view
//!                                                      │       ▲                  view ─► render, export
//!                                    poses, ray tables ▼       │ counts
//!                                                      backend ┘  oracle, cpu or gpu: cast, carve, fuse, count
//! ```
//!
//! A room is a folder of `src/` or `src/march/` or, where it is small, one file. Rooms further down
//! in this table may use those further up, never the other way round; `tests/documents/rooms.rs` holds the code to that.
//! The first five are a crate of their own, `perirobot-march` in `src/march/`: the marcher, which opens no file
//! and gets scenes as voxels. It takes most of the time, and is compiled as one unit.
//!
//! | room | what it has | where to begin |
//! |---|---|---|
//! | `error` | typed errors | `march/error.rs` |
//! | `march` | the integer arithmetic of a ray that marches through voxels | `src/march/SEMANTICS.md`: the rules of every count |
//! | `metrics` | counts, and the scores made of them: F1, κ, who is detected | `march/metrics.rs`, `march/metrics/score.rs` |
//! | `voxel` | grid, bit planes, solids, distances, floods, the voxels of people | `march/voxel/bits.rs` |
//! | `backend` | cast, carve, fuse and count, in three implementations: `oracle.rs` (plain, slow, defines the counts), `cpu/` (a file for each algorithm) and `gpu/` with the WGSL kernels in the top folder `shaders/` (`cast.wgsl`, and for cameras `carve_boxes.wgsl` and `carve_voxels.wgsl`) | `march/backend/mod.rs` |
//! | `spelling`, `shell` | "did you mean", and numbers as other programs print them; quoting for a shell | one file each |
//! | `source` | opens and reads every file that a user names; keeps paths inside the study's folder; bounds memory, names encodings and converters | `source.rs` |
//! | `pose` | position and rotation | `pose.rs` |
//! | `ros` | messages of ROS in MCAP files, read and written | `messages.rs`, `bag.rs` |
//! | `scene` | objects with roles: a file a mesh format (`stl.rs`, `gltf.rs`), robots (`urdf/`), people, motion | `mesh_file.rs`, `build.rs` |
//! | `truth` | what is where in a scene, in voxels: the voxelizer, people, regions | `voxelize.rs`, `region.rs` |
//! | `recording` | maps and point clouds that real sensors recorded, laid into the grid: a file a format (`pcd.rs`) | `mod.rs`, `voxels.rs` |
//! | `sensor` | what each kind casts and claims: a file a kind | `mod.rs` |
//! | `study` | the keys of study and scene files, checked, with defaults | `file.rs`, `scene_file.rs` |
//! | `world` | scenes in voxels with regions and placed sensors; warnings about them | `mod.rs` |
//! | `results` | the files of a sweep, written and read: journal, manifest, `results.csv`, `scores.csv`, `poses.csv` | `rows.rs`, `columns.rs` |
//! | `sweep` | what is cast and scored in which order; failing devices; backends compared with the oracle | `order.rs`, `session.rs` |
//! | `choose` | the best set of sensors for each size and cost, and a proof that no other set is better | `mod.rs` |
//! | `front` | `Cell`, `DepthCamera`, `Device`, `Scored`: what a Rust program uses | `front.rs` |
//! | `view` | one choice of poses, voxel by voxel, and why a voxel stays unknown; how a sensor is drawn (`outline.rs`) | `mod.rs`, `why.rs` |
//! | `approach` | how near a body can come to the robot without being noticed | `mod.rs`, `answer.rs` |
//! | `judge` | whether requirements are met: as planned, with a dead sensor, with mounts that are off, with other people | `mod.rs` |
//! | `render` | pictures | `mod.rs` |
//! | `export` | files for other programs: a file a format (`glb.rs`, `npz.rs`, `octomap.rs`) | `mod.rs` |
//! | `report` | tables of `summary`, the HTML page (`html/`), and figures for print (`figures/`) | `mod.rs` |
//! | `cluster` | scripts for clusters: a file an engine (`slurm.rs`) | `mod.rs` |
//!
//! The command line (`src/cli`, a file a command) may use all rooms; it parses arguments, prints, and turns
//! errors into exit codes. The Python package (`src/python`) is a crate of its own, which may use them, too; its
//! program `perirobot` is the same command line. What a change touches, file by file, is in [`guide::change_it`]; which file of
//! `tests/` proves what is in [`guide::tests`]; every key of a study is in [`guide::every_key`].
//!
//! # Words
//!
//! | word | meaning | elsewhere |
//! |---|---|---|
//! | cell | the workplace that a robot and people share | workspace (paper) |
//! | voxel | a cube of the grid; never called a cell | leaf (OctoMap) |
//! | scene | the objects of a cell | the same (paper) |
//! | snapshot | one moment of a scene that moves | |
//! | role | what an object is: environment, robot or human | the same (paper) |
//! | region | the voxels that are counted | region of interest (paper) |
//! | candidate | one way to set a sensor up: a pose, or how far a proximity cover senses | placement of a sensor (paper) |
//! | combination | sensors whose evidence is fused | sensor set |
//! | choice of poses | one candidate for each sensor of a combination | placement |
//! | set | sensors, each at a candidate, among which `choose` searches | sensor placement |
//! | front | the best set of each size, and of each step of cost | Pareto front |
//! | representation | how a sensor's data become voxels: `points`, `cylinders`, `zone` … | PC, PC+Cyl, Zone (paper) |
//! | crossing | the step of a ray over a boundary between voxels | step of a grid traversal (Amanatides and Woo) |
//! | first hit | the first blocker on a ray, before range and noise are applied | |
//! | end | how a ray ended: a return, too near, left the grid, nothing | |
//! | return | an end at a surface within range | endpoint (OctoMap) |
//! | carve | to mark as free what returning rays passed | free cells of `computeUpdate` (OctoMap) |
//! | packet | 64 rays that are cast together; a tile is a packet of 8 × 8 pixels | ray packet |
//! | evidence | what one candidate tells: three bit planes, occupied, free and hits | |
//! | hit | a voxel in which a ray truly ended; with noise its return may be read in another voxel, which is then called occupied | |
//! | slot | the number under which a backend keeps the evidence of one candidate | |
//! | fuse | to give each voxel one label from several sensors' evidence | integrate (OctoMap) |
//! | label | what is claimed of a voxel: occupied, free or unknown | the same (OctoMap) |
//! | counts | labels against truth: true and false positives and negatives, unknown though occupied (UO), unknown though free (UF) | confusion matrix (paper) |
//! | journal | the finished rows of a sweep on disk, or what `choose` has cast, from which it goes on | checkpoint |

// The rooms' pages are read by developers, who build them with private items.
#![allow(rustdoc::private_intra_doc_links)]

#[doc(hidden)]
pub mod approach;
#[doc(hidden)]
pub mod choose;
#[doc(hidden)]
pub mod cli;
#[doc(hidden)]
pub mod cluster;
#[doc(hidden)]
pub mod export;
mod front;
pub mod guide;
#[doc(hidden)]
pub mod judge;
#[doc(hidden)]
pub mod pose;
#[doc(hidden)]
pub mod recording;
#[doc(hidden)]
pub mod render;
#[doc(hidden)]
pub mod report;
#[doc(hidden)]
pub mod results;
#[doc(hidden)]
pub mod scene;
#[doc(hidden)]
pub mod sensor;
#[doc(hidden)]
pub mod shell;
#[doc(hidden)]
pub mod source;
#[doc(hidden)]
pub mod study;
#[doc(hidden)]
pub mod sweep;
#[doc(hidden)]
pub mod truth;
#[doc(hidden)]
pub mod view;
#[doc(hidden)]
pub mod world;

mod ros;
mod spelling;
#[cfg(test)]
mod thorough;

// The command line names the library as other programs do.
extern crate self as perirobot;

#[doc(inline)]
pub use perirobot_march::error;
#[doc(hidden)]
pub use perirobot_march::{backend, march, metrics, voxel};

pub use error::{Error, Result};
pub use front::{Cell, DepthCamera, Device, Scored};
#[doc(inline)]
pub use metrics::Confusion;
#[doc(inline)]
pub use pose::Pose;
#[doc(inline)]
pub use scene::Role;
#[doc(inline)]
pub use study::Study;

/// The version of the rules that decide the counts (`src/march/SEMANTICS.md`), recorded in every manifest.
/// It changes whenever the same study could give other integers.
pub const SEMANTICS_VERSION: u32 = 4;
