//! Which voxels are a person's, and of which part of the body: the nearest of the person's limbs decides.

use glam::DVec3;

use super::Truth;
use crate::objects::Role;
use crate::objects::mannequin::{Limb, limbs};
use perirobot_march::metrics::BodyPart;
use perirobot_march::voxel::{BitGrid, BodyVoxel, Grid, People};

/// The people of a scene. A voxel of several is the first one's.
pub fn people(truth: &Truth, min_hits: u32) -> People {
    let mut left = BitGrid::clone(&truth.occupied);
    let humans = truth.objects.iter().filter(|object| object.role == Role::Human);
    let mut voxels = Vec::new();
    for (human, person) in humans.zip(0..) {
        let limbs = human.keypoints.as_ref().map_or_else(Vec::new, limbs);
        let mut own = human.voxels.clone();
        own.keep(&left);
        left.remove(&own);
        let of_person =
            |voxel| BodyVoxel { voxel, person, part: part_at(middle_m(&truth.grid, voxel), &limbs) };
        voxels.extend(own.voxels().map(of_person));
    }
    People { min_hits, voxels }
}

/// The part of the nearest limb, the first of several.
fn part_at(place_m: DVec3, limbs: &[Limb]) -> BodyPart {
    let away = limbs.iter().map(|limb| (limb.away_m(place_m), limb.part));
    let nearest = away.reduce(|nearest, other| if other.0 < nearest.0 { other } else { nearest });
    nearest.map_or(BodyPart::Body, |(_, part)| part)
}

/// The centre of a voxel in the world.
fn middle_m(grid: &Grid, voxel: [i32; 3]) -> DVec3 {
    grid.corner_m(voxel) + DVec3::splat(grid.voxel_size_m / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A limb along y, one of x, and a ball.
    const LIMBS: [Limb; 3] = [
        Limb { part: BodyPart::Torso, ends_m: [DVec3::ZERO, DVec3::Y], radius_m: 0.3 },
        Limb { part: BodyPart::LeftForearm, ends_m: [DVec3::ZERO, DVec3::X], radius_m: 0.1 },
        Limb { part: BodyPart::Head, ends_m: [DVec3::new(0.0, 2.0, 0.0); 2], radius_m: 0.2 },
    ];

    #[track_caller]
    fn check(x: f64, y: f64, expected: BodyPart) {
        assert_eq!(part_at(DVec3::new(x, y, 0.0), &LIMBS), expected, "at ({x}, {y})");
    }

    #[test]
    fn the_nearest_flesh_decides_the_first_limb_of_several() {
        check(0.0, 0.5, BodyPart::Torso);
        check(1.5, 0.0, BodyPart::LeftForearm);
        check(0.0, 3.0, BodyPart::Head);
        // As far from both bones: the thicker one's flesh is nearer.
        check(0.5, 0.5, BodyPart::Torso);
        // 0.7 from the torso's flesh, 0.7 from the forearm's.
        check(1.0, 0.8, BodyPart::Torso);
        check(1.0, 0.79, BodyPart::LeftForearm);
        assert_eq!(part_at(DVec3::ZERO, &[]), BodyPart::Body, "without a bone");
    }
}
