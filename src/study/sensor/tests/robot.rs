//! What the controller knows of a hollow robot.

use super::*;
use crate::sensor::Extent;
use crate::sensor::kinds::known_robot::KnownRobot;
use perirobot_march::voxel::Window;

#[test]
fn the_robot_is_known_inside_and_out() {
    let mut truth = empty([9, 9, 9], 0.05);
    let mut hull = block([2; 3], [6; 3]);
    hull.retain(|voxel| voxel.iter().any(|c| [2, 6].contains(c)));
    put(&mut truth, Role::Robot, &hull, None);
    put(&mut truth, Role::Human, &[[8, 8, 8]], None);
    let all = |truth: &Truth| {
        let claim = KnownRobot.claims(&station(truth, Setting::Fixed)).swap_remove(0);
        claim.planes.unwrap().occupied.voxels().collect::<Vec<_>>()
    };
    // With `interior = "free"` the truth calls the inside free, and it would be a false alarm.
    hull.sort_by_key(|&[x, y, z]| [z, y, x]);
    assert_eq!(all(&truth), hull);
    block([3; 3], [5; 3]).into_iter().for_each(|voxel| truth.ignored.set(voxel));
    assert_eq!(all(&truth), block([2; 3], [6; 3]));
    let window = Window::from_corners([4, 0, 0], [8, 8, 8]);
    let at = Station { window, ..station(&truth, Setting::Fixed) };
    let claim = KnownRobot.claims(&at).swap_remove(0);
    let Planes { occupied, free, .. } = claim.planes.unwrap();
    assert_eq!(occupied.voxels().collect::<Vec<_>>(), block([4, 2, 2], [6, 6, 6]));
    assert!(!claim.cast && free.is_empty());
    let Extent::Only(reach) = KnownRobot.reach(&at) else { panic!("it casts no rays") };
    assert_eq!(reach.voxels().collect::<Vec<_>>(), block([2; 3], [6; 3]));
    assert_eq!((KnownRobot.log_odds(0), KnownRobot.takes_poses()), ([3511, 0], false));
    let nobody = empty([4, 4, 4], 0.05);
    assert!(
        KnownRobot
            .check(&station(&nobody, Setting::Fixed))
            .unwrap_err()
            .to_string()
            .contains("role = \"robot\"")
    );
}

#[test]
fn a_robot_in_the_corner_of_the_grid_is_closed_by_itself() {
    // A cup that only the grid's side would close has no inside.
    let mut truth = empty([5, 5, 5], 0.05);
    let mut cup = block([0; 3], [4, 4, 2]);
    cup.retain(|voxel| voxel[0] % 4 == 0 || voxel[1] % 4 == 0 || voxel[2] == 0);
    put(&mut truth, Role::Robot, &cup, None);
    let Extent::Only(reach) = KnownRobot.reach(&station(&truth, Setting::Fixed)) else { panic!() };
    assert_eq!(reach, truth.robot);
}
