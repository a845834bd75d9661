//! The guide: pages to read, no code. They are the Markdown files of `src/guide`, and of other folders where
//! they lie beside the files they are about; `tests/documents/pages.rs` carries out their commands.
//!
//! | page | what it tells |
//! |---|---|
//! | [`first_hour`] | installing, a first study, its results, pictures, other programs |
//! | [`own_cell`] | the tutorial: a cell from CAD, a robot, a person, sensors, to the report |
//! | [`plan`] | the planner: a page in which sensors are placed by hand |
//! | [`choose`] | which set of sensors is the best: what to ask, the front, what is proven and what is not |
//! | [`approach`] | how near a person comes unnoticed: what watches, what to ask, how to read the answer |
//! | [`review`] | requirements that pass or fail: as planned, with a sensor dead, with mounts that are off |
//! | [`sensors`] | which kind a device is, what it claims, real devices, noise, mounts |
//! | [`recorded`] | maps and point clouds that real sensors recorded, scored against the truth |
//! | [`every_key`] | the reference of scene and study files |
//! | [`long_sweeps`] | stopping and going on, failing devices, shards, clusters, large tables |
//! | [`python`] | pandas, numpy, OctoMap, sweeps from a script |
//! | [`same_integers`] | why CPU, GPU and oracle agree in every count |
//! | [`rules`] | what is counted, exactly |
//! | [`why_fast`] | which algorithm saves what, and why it is exact |
//! | [`wide_gpus`] | what to expect of the kernels on hardware, and why; measured on one GPU |
//! | [`measured`] | speeds, as ratios to the oracle |
//! | [`change_it`] | the files to touch for a new sensor, mesh format, representation or kernel |
//! | [`contributing`] | building, testing, shipped pictures and schemas, releases |
//! | [`tests`] | which file of `tests/` proves what |

/// Makes a module of a page. Links between pages are written `[text][page]`; of two definitions the first
/// counts, so here they lead to modules, and on GitHub to the files named at the end of the page.
macro_rules! page {
    ($name:ident, $file:literal) => {
        #[doc = "[first hour]: crate::guide::first_hour"]
        #[doc = "[own cell]: crate::guide::own_cell"]
        #[doc = "[sensors]: crate::guide::sensors"]
        #[doc = "[plan]: crate::guide::plan"]
        #[doc = "[choose]: crate::guide::choose"]
        #[doc = "[approach]: crate::guide::approach"]
        #[doc = "[review]: crate::guide::review"]
        #[doc = "[recorded]: crate::guide::recorded"]
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

page!(first_hour, "first_hour.md");
page!(plan, "plan.md");
page!(choose, "choose.md");
page!(review, "review.md");
page!(sensors, "sensors.md");
page!(approach, "approach.md");
page!(recorded, "recorded.md");
page!(long_sweeps, "long_sweeps.md");
page!(python, "python.md");
page!(same_integers, "same_integers.md");
page!(why_fast, "why_fast.md");
page!(wide_gpus, "wide_gpus.md");
page!(measured, "../../benches/RESULTS.md");
page!(change_it, "change_it.md");
page!(contributing, "contributing.md");
page!(tests, "../../tests/README.md");

#[doc(inline)]
pub use perirobot_march::rules;
#[doc(inline)]
pub use perirobot_shipped::{every_key, own_cell};
