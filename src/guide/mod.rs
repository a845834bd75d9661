//! The guide: pages to read, no code. `cargo doc --open` builds it, works offline and has a search (press `s`) that
//! finds pages by their subjects, such as *cost*, *dead sensor* or *pandas*.
//!
//! **Begin with your page**: [`integrator`], [`safety_engineer`] or [`researcher`].
//!
//! # First hour
//!
//! | page | contents |
//! |---|---|
//! | [`first_hour`] | install, a first study, its results, pictures, files for other programs |
//! | [`plan`] | the planner: sensors placed by hand, counted at once |
//!
//! # Plan a cell
//!
//! | page | contents |
//! |---|---|
//! | [`plan_a_cell`] | from CAD to a signed report, with a palletising cell |
//! | [`own_cell`] | the tutorial: a cell from CAD, a robot, a person and sensors, step by step |
//! | [`sensors`] | which kind a device is, real devices, noise, mounts |
//!
//! # Decide and review
//!
//! | page | contents |
//! |---|---|
//! | [`choose`] | the cheapest set that passes, the best set for a budget, and the proof |
//! | [`review`] | requirements that pass or fail: as planned, with a dead sensor, with shifted mounts |
//! | [`approach`] | how close a person gets before any sensor detects it, and needed distances |
//! | [`recorded`] | maps and point clouds of real sensors, scored against the truth |
//!
//! # Reference
//!
//! | page | contents |
//! |---|---|
//! | [`commands`] | all commands, shared options, exit codes |
//! | [`results`] | files and columns of a sweep, and how to compare scores |
//! | [`every_key`] | every key of scene and study files |
//! | [`python`] | pandas, numpy, OctoMap, sweeps from a script |
//! | [`long_sweeps`] | resuming, failing devices, shards, clusters, large tables |
//! | [`rules`] | the definition of every count, with drawings |
//! | [`same_integers`] | why CPU, GPU and oracle agree in every count |
//! | [`why_fast`] | the algorithms, and why each is exact |
//! | [`wide_gpus`] | what to expect of the kernels on hardware |
//! | [`measured`] | measurements: speed, size, memory |
//! | [`change_it`] | files to touch for a new sensor, mesh format, representation or kernel |
//! | [`contributing`] | build, test, generated files, release |
//! | [`tests`] | which file of `tests/` proves what |
//!
//! The pages are the Markdown files of `src/guide`, and of other folders beside the files that they describe.
//! `tests/documents/pages.rs` runs their commands.

/// Makes a module of a page, which rustdoc's search also finds by the given subjects. Links between pages are
/// written `[text][page]`; of two definitions the first counts, so here they lead to modules, and on a forge to the
/// files named at the end of the page.
macro_rules! page {
    ($name:ident, $file:literal, [$($subject:literal),*]) => {
        $(#[doc(alias = $subject)])*
        #[doc = "[first hour]: crate::guide::first_hour"]
        #[doc = "[plan a cell]: crate::guide::plan_a_cell"]
        #[doc = "[own cell]: crate::guide::own_cell"]
        #[doc = "[sensors]: crate::guide::sensors"]
        #[doc = "[plan]: crate::guide::plan"]
        #[doc = "[choose]: crate::guide::choose"]
        #[doc = "[approach]: crate::guide::approach"]
        #[doc = "[review]: crate::guide::review"]
        #[doc = "[recorded]: crate::guide::recorded"]
        #[doc = "[results]: crate::guide::results"]
        #[doc = "[every key]: crate::guide::every_key"]
        #[doc = "[long sweeps]: crate::guide::long_sweeps"]
        #[doc = "[python]: crate::guide::python"]
        #[doc = "[same integers]: crate::guide::same_integers"]
        #[doc = "[rules]: crate::guide::rules"]
        #[doc = "[why fast]: crate::guide::why_fast"]
        #[doc = "[wide gpus]: crate::guide::wide_gpus"]
        #[doc = "[measured]: crate::guide::measured"]
        #[doc = "[change it]: crate::guide::change_it"]
        #[doc = "[tests]: crate::guide::tests"]
        #[doc = "[contributing]: crate::guide::contributing"]
        #[doc = ""]
        #[doc = include_str!($file)]
        pub mod $name {}
    };
}

page!(integrator, "integrator.md", ["shopping list", "mounting"]);
page!(safety_engineer, "safety_engineer.md", ["safety", "risk assessment"]);
page!(researcher, "researcher.md", ["paper", "reproduce", "citation"]);
page!(first_hour, "first_hour.md", ["install", "init", "render", "report", "figures", "export"]);
page!(plan, "plan.md", ["planner", "drag", "browser"]);
page!(plan_a_cell, "plan_a_cell.md", ["palletiser", "CAD", "sign"]);
page!(sensors, "sensors.md", ["camera", "lidar", "catalogue", "noise", "calibration"]);
page!(choose, "choose.md", ["cost", "budget", "front", "proof", "cheapest"]);
page!(review, "review.md", ["judge", "requirement", "dead sensor", "mounting error", "postures"]);
page!(approach, "approach.md", ["undetected", "ISO 13855", "stopping", "needed distance"]);
page!(recorded, "recorded.md", ["score", "point cloud", "OctoMap", "rosbag"]);
page!(commands, "commands.md", ["exit code", "options", "help"]);
page!(results, "results.md", ["results.csv", "scores.csv", "columns", "kappa", "F1"]);
page!(python, "python.md", ["pandas", "numpy", "xarray", "notebook"]);
page!(long_sweeps, "long_sweeps.md", ["resume", "shard", "cluster", "Slurm", "Parquet"]);
page!(same_integers, "same_integers.md", ["oracle", "exact", "verify-backends"]);
page!(why_fast, "why_fast.md", ["algorithms", "SIMD"]);
page!(wide_gpus, "wide_gpus.md", ["H100", "occupancy", "llvmpipe"]);
page!(measured, "../../benches/RESULTS.md", ["speed", "memory use", "benchmarks"]);
page!(change_it, "change_it.md", ["extend", "new sensor", "new format"]);
page!(contributing, "contributing.md", ["build", "release process"]);
page!(tests, "../../tests/README.md", ["test files"]);

#[doc(inline)]
pub use perirobot_march::rules;
#[doc(inline)]
pub use perirobot_shipped::{every_key, own_cell};
