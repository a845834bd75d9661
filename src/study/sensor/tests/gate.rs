//! A curtain one voxel thick before a zone of two.

use super::*;
use crate::sensor::gate::Gate;
use crate::sensor::prism::Prism;
use crate::sensor::{Extent, Stance};

fn gate(otherwise_free: bool) -> Gate {
    let between = |low: [f64; 3], high: [f64; 3]| Prism::between(low.into(), high.into());
    Gate {
        gate: between([0.0, 0.0, 0.0], [1.0, 4.0, 2.0]),
        zone: between([1.0, 0.0, 0.0], [3.0, 4.0, 2.0]),
        otherwise_free,
    }
}

#[test]
fn whatever_is_in_the_box_switches_the_zone() {
    let zone = block([1, 0, 0], [2, 3, 1]);
    for (voxel, on) in
        [([0, 0, 0], true), ([0, 3, 1], true), ([1, 0, 0], false), ([0, 4, 0], false), ([0, 0, 2], false)]
    {
        let mut truth = empty([8, 8, 4], 1.0);
        put(&mut truth, Role::Environment, &[voxel], None);
        let here = station(&truth, Setting::Fixed);
        let [free, unknown] = [true, false].map(|free| says(&gate(free), 0, &here));
        if on {
            assert_eq!(
                (free, unknown),
                (Says::Occupied(zone.clone()), Says::Occupied(zone.clone())),
                "{voxel:?}"
            );
        } else {
            assert_eq!((free, unknown), (Says::Free(zone.clone()), Says::Nothing), "{voxel:?}");
        }
    }
}

#[test]
fn a_pose_carries_box_and_zone() {
    let mut truth = empty([8, 8, 4], 1.0);
    put(&mut truth, Role::Human, &[[7, 2, 1]], None);
    // Facing −x from (8, 6): the box is x 7…8, y 2…6, the zone x 5…7.
    let at = facing(&truth, [8.0, 6.0, 0.0], [-1.0, 0.0, 0.0]);
    let zone = block([5, 2, 0], [6, 5, 1]);
    assert_eq!(says(&gate(true), 0, &at), Says::Occupied(zone.clone()));
    let Extent::Only(reach) = gate(true).reach(&at) else { panic!("a gate casts no rays") };
    assert_eq!(reach.voxels().collect::<Vec<_>>(), zone);
    assert_eq!((gate(true).stance(), gate(true).log_odds(0)), (Stance::Level, [3511, -405]));
}

#[test]
fn box_and_zone_hold_a_voxel_of_the_grid() {
    let truth = empty([8, 8, 4], 1.0);
    let check = |x| gate(true).check(&facing(&truth, [x, 0.0, 0.0], [1.0, 0.0, 0.0]));
    assert_eq!(check(6.0), Ok(()));
    assert!(check(7.0).unwrap_err().to_string().starts_with("zone: its volume holds no voxel"));
    assert!(check(8.0).unwrap_err().to_string().starts_with("box: its volume holds no voxel"));
    // Without a pose it is in the world's frame, and stretches no grid.
    assert_eq!(gate(true).settings(), [("here".to_string(), Setting::Fixed)]);
}
