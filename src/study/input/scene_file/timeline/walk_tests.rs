use super::*;
use crate::diagnostics::Place;

fn walk(corners: &[[f64; 3]], step_m: f64) -> Result<Walk> {
    let file =
        WalkFile { path_m: corners.iter().copied().map(Triple).collect(), step_m, speed_m_s: Some(0.5) };
    moments(&Place::new("cell.toml".as_ref()), &file)
}

#[test]
fn places_are_a_step_apart_and_face_along_the_path() {
    // 1 m along x, then 0.8 m along y, in steps of 0.5 m: a corner in the middle of the third, and an end after 0.3 m.
    let walk = walk(&[[1.0, 2.0, 0.0], [2.0, 2.0, 0.0], [2.0, 2.8, 0.0]], 0.5).unwrap();
    let expected = [[1.0, 2.0, 0.0], [1.5, 2.0, 0.0], [2.0, 2.0, 0.0], [2.0, 2.5, 0.0], [2.0, 2.8, 0.0]];
    assert_eq!(walk.position_m.len(), expected.len());
    for (found, expected) in walk.position_m.iter().zip(expected) {
        assert!((*found - DVec3::from_array(expected)).length() < 1e-9, "{found}");
    }
    let ahead = [DVec3::X, DVec3::X, DVec3::X, DVec3::Y, DVec3::Y];
    for (heading, ahead) in walk.heading.iter().zip(ahead) {
        assert!((*heading * DVec3::X - ahead).length() < 1e-9, "{heading}");
    }
    // At 0.5 m/s: 3.6 s in all.
    let expected = [0.5, 1.0, 1.0, 0.8, 0.3];
    assert!(walk.dwell_s.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-9));
}

#[test]
fn a_path_that_steps_divide_has_no_moment_twice() {
    let walk = walk(&[[0.0; 3], [0.3, 0.0, 0.0]], 0.1).unwrap();
    assert_eq!(walk.position_m.len(), 4);
    // A lift faces as it did.
    let lift = self::walk(&[[0.0; 3], [0.0, -1.0, 0.0], [0.0, -1.0, 1.0]], 1.0).unwrap();
    assert!((lift.heading[2] * DVec3::X - DVec3::NEG_Y).length() < 1e-9);
}

#[test]
fn walks_that_cannot_be() {
    let wrong = |corners: &[[f64; 3]], step_m: f64| walk(corners, step_m).err().unwrap().to_string();
    assert!(wrong(&[[0.0; 3]], 0.1).contains("fewer than two corners"));
    assert!(wrong(&[[0.0; 3], [0.0; 3]], 0.1).contains("path_m[1] = [0.0, 0.0, 0.0]: must differ"));
    assert!(wrong(&[[0.0; 3], [1.0, 0.0, 0.0]], 0.0).contains("step_m = 0"));
    assert!(
        wrong(&[[0.0; 3], [1e3, 0.0, 0.0]], 0.01).contains("makes more than 10000 moments; 0.100 m or more")
    );
}
