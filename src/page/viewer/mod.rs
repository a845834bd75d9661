//! The viewer shared by the report and the planner: scripts that draw a cell in three dimensions with WebGL, their
//! elements and vectors, and their style. A page includes the texts in its own script and style, in this order.

pub mod runs;
pub mod sensor;

/// The scripts: elements of a page, vectors, voxels, rays, shaders, pointers and keys, the stage.
pub const SCRIPTS: [&str; 7] = [
    include_str!("elements.js"),
    include_str!("vectors.js"),
    include_str!("voxels.js"),
    include_str!("rays.js"),
    include_str!("shaders.js"),
    include_str!("pointer.js"),
    include_str!("stage.js"),
];

/// The style of a stage.
pub const STYLE: &str = include_str!("stage.css");

/// The light and dark colours as CSS variables.
#[cfg(feature = "report")]
pub fn colour_variables() -> String {
    crate::report::colours::variables()
}
