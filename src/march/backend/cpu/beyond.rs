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
//! Walls and floors behind a region: of a camera's tiles that see it, half in the paper's first experiment. Floats decide
//! only whether this is proved.

use super::across::BlockerLayer;
use super::cast::SECTION;
use super::cone::ConeAtPose;
use super::first_hit::Search;

/// The most sections of a cone without blockers that are looked at.
const EMPTY: usize = 16;

/// How the rays of a cone go.
pub(super) enum ConeCourse {
    /// All enter a blocker between the distances that were asked for, and none before.
    Returns,
    /// None has entered one up to so far, in voxels.
    Clear(f32),
}

/// How far the rays of a cone have surely entered no blocker of any layer, that have entered none up to `from`.
pub(super) fn clear<'a>(cone: &ConeAtPose, searches: impl Iterator<Item = &'a Search<'a>>, from: f32) -> f32 {
    searches.map(|search| cone.clear(search, from)).fold(f32::MAX, f32::min)
}

/// Whether all rays of a cone, none of which has entered a blocker up to `begin`, enter a blocker of some layer, after `from`
/// and up to `to`, all in voxels, and none before.
pub(super) fn way<'a>(
    cone: &ConeAtPose,
    searches: impl Iterator<Item = &'a Search<'a>> + Clone,
    begin: f32,
    [from, to]: [f32; 2],
) -> ConeCourse {
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
                || layers.any(|blockers| BlockerLayer::new(blockers, cone, begin, SECTION, to).is_some());
            return if begin > from && is_across() { ConeCourse::Returns } else { ConeCourse::Clear(begin) };
        }
        begin = clear(cone, searches.clone(), begin + SECTION);
    }
    ConeCourse::Clear(begin)
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::cone::Cone;
    use super::super::first_hit::Layer;
    use super::super::packet::{Packets, RAYS};
    use super::super::test_camera::camera;
    use super::*;
    use crate::backend::GridPose;
    use crate::march;
    use crate::voxel::{BitGrid, Window};

    const SIZE: [u32; 3] = [70, 60, 50];

    /// A room with a few boxes and single voxels in it, and holes in its walls.
    fn cell(random: &mut ChaCha8Rng) -> BitGrid {
        let window = Window { min: [0; 3], size: SIZE };
        let mut blockers = BitGrid::full(window);
        let mut inside = BitGrid::new(window);
        inside.set_all(&Window::from_corners([1; 3], SIZE.map(|n| n as i32 - 2)));
        blockers.remove(&inside);
        let mut below = |n: u32| (random.next_u32() % n) as i32;
        for _ in 0..6 {
            let corner: [i32; 3] = std::array::from_fn(|r| below(SIZE[r]));
            let size = std::array::from_fn(|_| 1 + below(20) as u32);
            blockers.set_all(&Window { min: corner, size });
        }
        let mut holes = BitGrid::new(window);
        for _ in 0..60 {
            blockers.set(std::array::from_fn(|r| below(SIZE[r])));
            holes.set(std::array::from_fn(|r| below(SIZE[r])));
        }
        blockers.remove(&holes);
        blockers
    }

    /// When a ray enters its first blocker, step by step.
    fn first_q16(blockers: &BitGrid, pose: &GridPose, dir_q15: [i32; 3]) -> Option<u32> {
        let begin = march::launch(pose.origin_q16, pose.axis_q15, dir_q15);
        let mut crossings = march::crossings(begin).take_while(|to| blockers.window().contains(to.voxel));
        crossings.find(|to| blockers.get(to.voxel)).map(|to| to.t_q16)
    }

    #[test]
    fn tiles_return_where_every_ray_does_and_are_clear_where_none_has_hit() {
        let mut random = ChaCha8Rng::seed_from_u64(19);
        let camera = camera([60.0; 2]);
        let packets = Packets::new(&camera);
        let (mut returns, mut late) = (0, 0);
        for _ in 0..24 {
            let layer = Layer::new(cell(&mut random));
            let mut share = || f64::from(random.next_u32()) / f64::from(u32::MAX);
            let turn = glam::DQuat::from_xyzw(share() - 0.5, share() - 0.5, share() - 0.5, share() - 0.5);
            let turn = glam::DMat3::from_quat(turn.normalize()).transpose();
            let axis_q15 = turn.to_cols_array_2d().map(|row| row.map(|x| (x * 32_768.0).round() as i32));
            let place = |r: usize| ((0.1 + 0.8 * share()) * f64::from(SIZE[r]) * 65_536.0) as i32;
            let origin_q16 = [0, 1, 2].map(place);
            let [from, to] = [20.0 * share() as f32, 40.0 + 40.0 * share() as f32];
            let pose = GridPose { origin_q16, axis_q15, draws: 0, truly: None };
            let search = Search::new(&layer, 0, origin_q16.map(|x| x >> 16));
            for packet in 0..packets.count() {
                let cone = Cone::new(&packets, &[packet]).place(&pose);
                let way = way(&cone, [&search].into_iter(), 0.0, [from, to]);
                for lane in 0..RAYS {
                    let dir_q15 = packets.dirs_q15(packet).map(|dirs| dirs[lane]);
                    let first = first_q16(&layer.blockers, &pose, dir_q15);
                    let voxels = first.map_or(f32::MAX, |t_q16| t_q16 as f32 / 65_536.0);
                    match way {
                        ConeCourse::Returns => {
                            assert!(voxels > from && voxels < to, "{voxels} of {from} to {to}")
                        }
                        ConeCourse::Clear(clear) => assert!(voxels >= clear, "{voxels}, clear up to {clear}"),
                    }
                }
                match way {
                    ConeCourse::Returns => returns += 1,
                    ConeCourse::Clear(clear) => late += usize::from(clear > 10.0),
                }
            }
        }
        assert!(returns > 300 && late > 300, "{returns} tiles return, {late} are clear for long");
    }
}
