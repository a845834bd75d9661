//! Pads of 2 × 3 voxels in a cell of 10 × 10 × 6.

use super::*;
use crate::sensor::Extent;
use crate::sensor::kinds::pad::Pad;
use crate::sensor::prism::Prism;

fn pad(height_m: f64, tare: bool) -> Pad {
    Pad {
        column: Prism::from_corners(DVec3::ZERO, DVec3::new(2.0, 3.0, height_m)),
        tare,
        otherwise_free: true,
    }
}

/// Half a voxel up, so that its own layer is 0 and a height of 3 ends at the centres of layer 3.
const CORNER: [f64; 3] = [1.0, 2.0, 0.5];

#[test]
fn a_column_begins_in_the_layer_above_the_pad_and_ends_below_its_height() {
    let truth = empty([10, 10, 6], 1.0);
    let at = facing(&truth, CORNER, [1.0, 0.0, 0.0]);
    assert_eq!(says(&pad(3.0, true), 0, &at), Says::Free(block([1, 2, 1], [2, 4, 2])));
    assert_eq!(says(&pad(3.01, true), 0, &at), Says::Free(block([1, 2, 1], [2, 4, 3])));
    assert_eq!(says(&pad(90.0, true), 0, &at), Says::Free(block([1, 2, 1], [2, 4, 5])), "cut by the ceiling");
    // On a boundary the pad's own layer is the upper one.
    let raised = facing(&truth, [1.0, 2.0, 1.0], [1.0, 0.0, 0.0]);
    assert_eq!(says(&pad(2.0, true), 0, &raised), Says::Free(block([1, 2, 2], [2, 4, 2])));
}

#[test]
fn only_what_stands_in_the_first_layer_above_presses() {
    let whole = block([1, 2, 1], [2, 4, 2]);
    for (voxel, on) in [
        ([1, 2, 1], true),
        ([2, 4, 1], true),
        ([1, 2, 0], false),
        ([1, 2, 2], false),
        ([0, 2, 1], false),
        ([3, 2, 1], false),
        ([2, 5, 1], false),
    ] {
        let mut truth = empty([10, 10, 6], 1.0);
        put(&mut truth, Role::Human, &[voxel], None);
        let expected = if on { Says::Occupied(whole.clone()) } else { Says::Free(whole.clone()) };
        let at = facing(&truth, CORNER, [1.0, 0.0, 0.0]);
        assert_eq!(says(&pad(3.0, true), 0, &at), expected, "{voxel:?}");
        assert_eq!(says(&pad(3.0, false), 0, &at), expected, "{voxel:?}");
    }
}

#[test]
fn a_tared_pad_feels_what_comes_and_goes() {
    for (role, felt) in [(Role::Environment, false), (Role::Human, true), (Role::Robot, true)] {
        let mut truth = empty([10, 10, 6], 1.0);
        put(&mut truth, role, &[[2, 3, 1]], None);
        let at = facing(&truth, CORNER, [1.0, 0.0, 0.0]);
        let pressed = |tare| matches!(says(&pad(3.0, tare), 0, &at), Says::Occupied(_));
        assert_eq!((pressed(true), pressed(false)), (felt, true), "{role:?}");
    }
    // A person on a table's leg: the voxel is both.
    let mut truth = empty([10, 10, 6], 1.0);
    put(&mut truth, Role::Environment, &[[2, 3, 1]], None);
    put(&mut truth, Role::Human, &[[2, 3, 1]], None);
    let at = facing(&truth, CORNER, [1.0, 0.0, 0.0]);
    assert!(matches!(says(&pad(3.0, true), 0, &at), Says::Occupied(_)));
    // Not occupied: what is in a person and has no surface presses nothing.
    truth.occupied = BitGrid::new(truth.grid.window()).into();
    let at = facing(&truth, CORNER, [1.0, 0.0, 0.0]);
    assert!(matches!(says(&pad(3.0, true), 0, &at), Says::Free(_)));
}

#[test]
fn silence_may_certify_nothing() {
    let truth = empty([10, 10, 6], 1.0);
    let silent = Pad { otherwise_free: false, ..pad(3.0, true) };
    assert_eq!(says(&silent, 0, &facing(&truth, CORNER, [1.0, 0.0, 0.0])), Says::Nothing);
}

#[test]
fn a_turned_pad_turns_about_its_corner() {
    let truth = empty([10, 10, 6], 1.0);
    // Facing +y: its 2 m go along y, its 3 m along −x.
    let at = facing(&truth, [5.0, 2.0, 0.5], [0.0, 1.0, 0.0]);
    assert_eq!(says(&pad(2.0, true), 0, &at), Says::Free(block([2, 2, 1], [4, 3, 1])));
    let pan = Pose::upright(DVec3::new(5.0, 2.0, 0.5), DVec3::X, 90f64.to_radians());
    let at = station(&truth, Setting::Pose(pan));
    assert_eq!(says(&pad(2.0, true), 0, &at), Says::Free(block([2, 2, 1], [4, 3, 1])));
}

#[test]
fn a_pad_lies_on_the_floor_as_a_whole() {
    let truth = empty([10, 10, 6], 1.0);
    let check = |x, y, height_m| pad(height_m, true).check(&facing(&truth, [x, y, 0.5], [1.0, 0.0, 0.0]));
    assert_eq!(check(8.0, 7.0, 3.0), Ok(()), "up to the walls");
    for (x, y) in [(8.01, 7.0), (8.0, 7.01), (-0.01, 0.0), (0.0, -0.01)] {
        let error = check(x, y, 3.0).unwrap_err();
        assert!(
            error.to_string().contains("partly outside the floor, x 0.00 to 10.00 m and y 0.00 to 10.00 m"),
            "{error}"
        );
    }
    // 0.5 + 0.9 is below the centres of layer 1.
    assert!(check(1.0, 1.0, 0.9).unwrap_err().to_string().contains("height_m"));
    assert_eq!(check(1.0, 1.0, 1.01), Ok(()));
}

#[test]
fn who_stands_outside_the_window_is_felt_all_the_same() {
    let mut truth = empty([10, 10, 6], 1.0);
    put(&mut truth, Role::Human, &[[1, 2, 1]], None);
    let window = Window::from_corners([2, 3, 2], [9, 9, 5]);
    let at = Station { window, ..facing(&truth, CORNER, [1.0, 0.0, 0.0]) };
    assert_eq!(says(&pad(3.0, true), 0, &at), Says::Occupied(block([2, 3, 2], [2, 4, 2])));
    let Extent::Only(reach) = pad(3.0, true).reach(&at) else { panic!("a pad casts no rays") };
    assert_eq!(reach.voxels().collect::<Vec<_>>(), block([1, 2, 1], [2, 4, 2]));
}
