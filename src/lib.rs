//! Which sensors to buy for a robot cell, where to mount them, what they cost, whether that is enough, and what they
//! still do not see.
//!
//! perirobot voxelizes a cell, casts every ray of every candidate sensor pose through it, labels voxels as the sensor
//! would (occupied, free, unknown), compares the labels with the truth inside regions of interest, and scores the pose
//! with F1 and Cohen's κ. It implements and extends the perirobot space representation of Rozlivek, Svarny and
//! Hoffmann (IROS 2023). The counts behind the scores are the same integers on every CPU and GPU.
//!
//! Most people use the program: `perirobot choose study.toml`; the [`guide`] is for them. A Rust program needs ten
//! names: `Study`, `Cell`, `Role`, `DepthCamera`, `Pose`, `Device`, `Scored`, `Confusion`, `Error` and
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
//! The voxels of a cell can also come from a function or an array. Each pose returns the counts of each region:
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
//! The data flow:
//!
//! ```text
//! scene.toml, meshes ─► scene ─► truth ─► world ──┐
//! study.toml ─► study (sensors, poses, regions) ──┴─► sweep, choose ─► results ─► report, view
//!                                                      │       ▲                  view ─► render, export
//!                                    poses, ray tables ▼       │ counts
//!                                                      backend ┘  oracle, cpu or gpu: cast, carve, fuse, count
//! ```
//!
//! Each floor is a crate in a folder of `src/`, which may use the crates above it in this table. Its README lists input,
//! output and where to begin.
//!
//! | crate | modules |
//! |---|---|
//! | `perirobot-march` in `src/march` | `march`: the integer arithmetic of a ray (the rules are in [`guide::rules`]); `voxel`: grids, bit planes, solids; `backend`: cast, carve, fuse and count as oracle, CPU and GPU, with the kernels in the top folder `shaders/`; `metrics`: counts and scores; `progress`: how a long job reports and stops; [`error`] |
//! | `perirobot-scene` in `src/scene` | `source`: all access to files; `pose`; `ros`: messages and bags; `objects`: with roles, a file for each format; `truth`: the cell in voxels; `recording`: recorded maps and clouds; `spelling`, `shell` |
//! | `perirobot-study` in `src/study` | `input`: the keys of study and scene files, checked, with defaults, among them `[stopping]` of ISO 13855; `diagnostics`: how a wrong value is reported; `sensor`: rays and claims, a file for each kind; `world`: scenes in voxels with regions and placed sensors |
//! | `perirobot-sweep` in `src/sweep` | `scoring`: the order of casting and scoring, failing devices; `results`: journal, manifest, tables |
//! | `perirobot-cover` in `src/cover` | the best sets of candidates by exact branch and bound, with bounds by cuts; independent of sensors, uses only the marcher |
//! | `perirobot-decide` in `src/decide` | `choose`: the best sets of sensors, with a proof; `judge`: requirements; `approach`: how close a body gets before any sensor detects it; `view`: one choice of poses, voxel by voxel |
//! | `perirobot-page` in `src/page` | `render`: pictures; `export`: files for other programs, a file for each format; `report`: tables, the page, figures |
//! | `perirobot-plan` in `src/plan` | the planner: edits of the study's text, warm counts, a local server and its page |
//! | `perirobot` in `src` | `front`: [`Cell`], [`DepthCamera`], [`Device`], [`Scored`], [`Study`]; [`cli`]: the command line, a file for each command; `cluster`: scripts, a file for each engine; [`guide`] |
//!
//! The Python package (`src/python`) uses these crates; `perirobot` only for the command in its wheel. Files that ship inside the program are the crate
//! `perirobot-shipped` in `scenes/`. What a change touches, file by file, is in [`guide::change_it`]; which file of
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
//! | evidence | what one candidate reports: three bit planes, occupied, free and hits | |
//! | hit | a voxel in which a ray truly ended; with noise its return may be read in another voxel, which is then called occupied | |
//! | slot | the number under which a backend keeps the evidence of one candidate | |
//! | fuse | to give each voxel one label from several sensors' evidence | integrate (OctoMap) |
//! | label | the claim about a voxel: occupied, free or unknown | the same (OctoMap) |
//! | counts | labels against truth: true and false positives and negatives, unknown though occupied (UO), unknown though free (UF) | confusion matrix (paper) |
//! | journal | the finished rows of a sweep on disk, or the poses cast by `choose`, from which a run resumes | checkpoint |
//! | cut | an upper bound for what sets cover, as a sum over their candidates; `shown_by` in `choose.json` | Benders cut |
//!
//! These words have no equivalent elsewhere:
//!
//! | word | meaning | why it stays |
//! |---|---|---|
//! | step | all sets of at most N sensors within a cost limit: a row of `front.csv` | a point of a front is one set; a bound belongs to all |
//! | bound | a score that no set of a step exceeds; *proven* if the best set has it | an optimality gap is a difference of scores |
//! | worth | the number by which sets are compared: an exact fraction, or a mean of scores | a printed score is rounded |
//! | gain | the improvement over the best smaller set, or over the set before refining | |
//! | moment | one snapshot, in one repeat if sensors have noise | counts exist for each repeat |
//! | case | a set as a condition of `judge` changes it: dead sensor, shifted mount, posture | a condition has several |
//! | unnoticed | of a body in `approach`: too few of its voxels are watched | detection is scored for people in the scene only |
//! | company | whether a scene's people are present while a body approaches | they block its way and hide it |
//! | claim | what a sensor reports in one representation | evidence is the same in all of them |

pub mod cli;
mod cluster;
mod front;
pub mod guide;

pub use front::{Cell, DepthCamera, Device, Scored, Study};
#[doc(inline)]
pub use perirobot_march::error;
#[doc(inline)]
pub use perirobot_march::metrics::Confusion;
pub use perirobot_march::{Error, Result};
#[doc(inline)]
pub use perirobot_scene::objects::Role;
#[doc(inline)]
pub use perirobot_scene::pose::Pose;
#[doc(inline)]
pub use perirobot_study::input::Overrides;
