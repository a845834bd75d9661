//! Messages of ROS 2 in MCAP files, as `ros2 bag` records and plays them and Foxglove shows them: what
//! recordings are read from, and views written to.
//!
//! A message is serialised as ROS 2 does by default: OMG's Common Data Representation, plain, behind four bytes that say
//! which order its bytes have. Those of ROS 1, field after field without padding, are read, too.

mod bag;
mod chunk;
mod frames;
pub mod messages;
mod ros1;

use bag::STATIC_FRAMES;
pub(crate) use bag::read_clouds;
pub use bag::{BagWriter, STAMP};
use frames::Frames;
