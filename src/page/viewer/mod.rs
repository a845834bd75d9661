//! What the viewer of the cell draws from; the report and the planner show it.

pub mod runs;
pub mod sensor;
