//! Tiles of a camera whose rays all return from behind everything that matters: what each of them hits is not asked.
//!
//! # Theory
//! A ray that returns frees all voxels that it enters before its return is read. If it comes to no blocker up to where
//! it has left the last voxel that matters, and noise cannot bring its return back to there, all that matters of
//! it is that it does return: the voxels that it frees, marks and hits behind do not count.
//!
//! It returns if it must enter a blocker within its range: a layer of them across its cone (`across`).
//!
//! # Practice
//! Walls and floors around a region: half of the rays, or more. Floats decide only whether this is proved.

use super::across::Across;
use super::cone::ConeAtPose;
use super::first_hit::Search;
use super::sense::SECTION;

/// The most sections of a cone without blockers that are looked at.
const EMPTY: usize = 16;

/// How the rays of a cone go.
pub(super) enum Way {
    /// All enter a blocker where it is asked, and none before.
    Returns,
    /// None has entered one up to so far, in voxels.
    Clear(f32),
}

/// How far the rays of a cone have surely entered no blocker of any layer, that have entered none up to `from`.
pub(super) fn clear<'a>(cone: &ConeAtPose, searches: impl Iterator<Item = &'a Search<'a>>, from: f32) -> f32 {
    searches.map(|search| cone.clear(search, from)).fold(f32::MAX, f32::min)
}

/// Whether all rays of a cone, none of which has entered a blocker up to `clear`, enter a blocker of some layer, after `from`
/// and up to `to`, all in voxels, and none before.
pub(super) fn way<'a>(
    cone: &ConeAtPose,
    searches: impl Iterator<Item = &'a Search<'a>> + Clone,
    begin: f32,
    [from, to]: [f32; 2],
) -> Way {
    let mut layers = searches.clone().map(|search| &search.layer.blockers);
    let mut begin = clear(cone, searches.clone(), begin);
    for _ in 0..EMPTY {
        let section = cone.section(begin, begin + SECTION);
        // A ray may leave the grid where the section does.
        if layers
            .clone()
            .any(|blockers| section.intersection(&blockers.window()) != section || blockers.any_in(&section))
        {
            let mut is_across =
                || layers.any(|blockers| Across::of(blockers, cone, begin, SECTION, to).is_some());
            return if begin > from && is_across() { Way::Returns } else { Way::Clear(begin) };
        }
        begin = clear(cone, searches.clone(), begin + SECTION);
    }
    Way::Clear(begin)
}
