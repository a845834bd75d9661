//! Scores where to put the sensors of a robot cell.
//!
//! perirobot voxelizes a cell, casts every ray of every candidate sensor pose through it, writes what the
//! sensor would claim (occupied, free, unknown), compares that with the truth inside regions of interest, and
//! scores the pose with F1 and Cohen's κ. It implements the perirobot space representation of Rozlivek,
//! Svarny and Hoffmann (IROS 2023), and gives the same integers on the CPU and on any GPU.
//!
//! Most people use the program: `perirobot sweep study.toml`. The [`guide`] begins with a first hour. A Rust
//! program scores poses with the ten names below.
//!
//! # From files
//!
//! A study names scenes, regions, sensors and their candidate poses:
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
//! A cell is also a function from voxels to roles, or an array:
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
//!     Pose::facing([x, 0.25, 2.2].into(), [0.0, 1.0, 0.0].into(), 0.0, -0.5)
//! });
//! for (pose, counts) in poses.iter().zip(cell.score(&camera, &poses, Device::Cpu)?) {
//!     println!("{}: F1 {:.3?}, κ {:.3?}", pose.position_m, counts[0].f1(), counts[0].kappa());
//! #   assert!(counts[0].f1() > Some(0.05) && counts[0].total() == 20 * 20 * 25);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # How it is built
//!
//! ```text
//! study.toml ─► study ─────────────────┐
//! scene.toml ─► scene ─► voxel ─► world ─► sweep ─► results ─► report
//! sensors ────► sensor ────────────────┘    │ ▲         └─► view ─► render, export
//!                                           ▼ │ counts
//!                     march ─► backend: cast, carve, fuse, count (oracle, CPU, GPU)
//! ```
//!
//! Each room is a folder of `src/` (or a file of that name). No room uses one that stands below it in this
//! table; `tests/rooms.rs` holds the code to that.
//!
//! | room | what it has |
//! |---|---|
//! | `error`, `spelling`, `shell` | what is wrong, what may be meant, words for a shell |
//! | `source` | the one door by which files come in |
//! | `march` | the arithmetic that every backend shares, and the rules of every count (`SEMANTICS.md`) |
//! | `metrics` | from counts to scores: F1, κ, who is detected |
//! | `pose` | where something is and how it is turned |
//! | `scene` | surfaces with roles: mesh formats, robots, people, motion |
//! | `voxel` | grid, bit planes, voxelizer, regions: the truth |
//! | `backend` | cast, carve, fuse, count: the same integers from `oracle`, `cpu` and `gpu` (kernels: `shaders/`) |
//! | `sensor` | rays and volumes, a file a sensor |
//! | `study` | what the user wrote, checked once |
//! | `world` | a study's scene at one snapshot, ready to be cast in |
//! | `results` | what a sweep leaves: journal, manifest, tables, and all of it read back |
//! | `sweep` | what is run, in which order, on which device; the comparison of backends |
//! | `choose` | the best set of sensors for each size and cost, with proof |
//! | `front` | the ten names above |
//! | `view`, `render`, `export` | a chosen set, voxel by voxel: why, as a picture, as files |
//! | `report` | results presented to people: text and page |
//! | `cluster` | a sweep for Slurm, HyperQueue and Kubernetes |
//!
//! The command line (`src/cli`, a file a command) is the program's, above them all. Where a change goes is
//! listed, file by file, in [`guide::change_it`].
//!
//! # Words
//!
//! | word | meaning | elsewhere |
//! |---|---|---|
//! | cell | the workplace that a robot and people share | workspace (paper) |
//! | voxel | a cube of the grid; never called a cell | voxel (paper), leaf (OctoMap) |
//! | scene, snapshot | the objects of a cell; one moment of a scene that moves | scene (paper) |
//! | world | a scene of a study at one snapshot, in voxels | |
//! | role | environment, robot or human: what an object is | |
//! | region | the voxels that are counted | region of interest (paper) |
//! | candidate | one way to set a sensor up, usually a pose | placement (paper) |
//! | combination | sensors whose evidence is fused | sensor set |
//! | choice of poses | a candidate of each sensor of a combination | |
//! | representation | how a sensor's data are read as voxels (`points`, `cylinders`, `zone`) | PC, PC+Cyl, Zone (paper) |
//! | crossing | a ray's step over a voxel boundary | one step of Amanatides and Woo's traversal |
//! | end, return | how a ray ended; an end at a surface that is measured | endpoint (OctoMap) |
//! | first hit | the first blocker on a ray, before any range or noise | |
//! | hit | a voxel that a return truly comes from | |
//! | carve | to mark as free what returning rays passed | free cells of `computeUpdate` (OctoMap) |
//! | packet, tile | 64 rays that are cast together; those of 8 × 8 pixels | ray packet |
//! | evidence | three bit planes of one candidate: occupied, free, hits | |
//! | slot | where a backend keeps evidence | |
//! | fuse | to make one label a voxel of several sensors' evidence | integrate (OctoMap) |
//! | label | occupied, free or unknown, as claimed | the same (OctoMap) |
//! | counts | TP, FP, FN, TN, UO, UF: labels against the truth | confusion matrix with unknown (paper) |
//! | journal | the finished rows of a sweep on disk | checkpoint, write-ahead log |
//! | placement | in the guide and messages: a choice of poses | setup (paper) |

#[doc(hidden)]
pub mod backend;
#[doc(hidden)]
pub mod choose;
#[doc(hidden)]
pub mod cluster;
mod error;
#[doc(hidden)]
pub mod export;
mod front;
pub mod guide;
#[doc(hidden)]
pub mod march;
#[doc(hidden)]
pub mod metrics;
#[doc(hidden)]
pub mod pose;
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
pub mod view;
#[doc(hidden)]
pub mod voxel;
#[doc(hidden)]
pub mod world;

mod spelling;

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
pub const SEMANTICS_VERSION: u32 = 3;
