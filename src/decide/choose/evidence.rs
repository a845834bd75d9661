//! The evidence of every sensor at every candidate, cast once: rows of bits for the solver, over the voxels of each
//! requested region in all scenes, snapshots and repeats. The file on disk serves any region.

mod casting;
mod deciding;
mod file;
mod region;
mod rows;

pub use casting::{CastEvidence, Casting};
pub use file::EVIDENCE;
use perirobot_cover::CandidateEvidence;
use perirobot_cover::layout::WantedCounts;
use perirobot_march::Result;
use perirobot_march::backend::Backend;
use perirobot_march::progress::Progress;
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// Default limit of evidence in memory, in bytes.
pub const MEMORY_BYTES: u64 = 2 << 30;

/// Casts every candidate of a study in all of its worlds, and holds its evidence of a region in memory.
/// `representations` is the representation of each sensor.
///
/// # Errors
/// If it does not fit into the memory limit, before any cast; if the backend fails; `Error::Stopped`.
pub fn cast_evidence(
    study: &Study,
    worlds: &[World],
    (region, representations): (usize, &[usize]),
    memory_bytes: u64,
    backend: &mut dyn Backend,
    progress: &dyn Progress,
) -> Result<CandidateEvidence> {
    let regions = [(region, WantedCounts::ALL)];
    let mut casting = Casting::begin(study, &regions, representations, worlds, memory_bytes, None)?;
    casting.run(backend, progress)?;
    Ok(casting.evidence().pop().expect("one region was asked for"))
}
