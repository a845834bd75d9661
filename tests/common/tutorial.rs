//! The meshes of `scenes/tutorial/`, as CAD programs would export them.

use glam::DVec3;
use perirobot_scene::objects::primitive::cylinder;

use super::glb::{GlbNode, group, part, slab};
use super::stl;

/// A hall of 5 x 4 x 3 m with a workplace behind fences, and the dimensions that somebody forgot to hide.
pub(crate) fn cell() -> GlbNode {
    let hall = vec![
        part("Floor", [-2.6, -2.1, -0.1], [2.6, 2.1, 0.0]),
        part("Ceiling", [-2.6, -2.1, 3.0], [2.6, 2.1, 3.1]),
        part("Wall left", [-2.6, 2.0, 0.0], [2.6, 2.1, 3.0]),
        part("Wall right", [-2.6, -2.1, 0.0], [2.6, -2.0, 3.0]),
        part("Wall back", [-2.6, -2.0, 0.0], [-2.5, 2.0, 3.0]),
        part("Wall front", [2.5, -2.0, 0.0], [2.6, 2.0, 3.0]),
    ];
    let workplace = vec![
        part("Pedestal", [-0.2, 0.6, 0.0], [0.2, 1.0, 0.6]),
        part("Bench top", [-0.6, -0.3, 0.75], [0.6, 0.3, 0.8]),
        part("Bench left", [-0.6, -0.3, 0.0], [-0.5, 0.3, 0.75]),
        part("Bench right", [0.5, -0.3, 0.0], [0.6, 0.3, 0.75]),
        part("Cabinet", [1.6, 1.2, 0.0], [2.4, 1.9, 1.9]),
    ];
    let fence = vec![
        part("Fence left", [-1.32, -0.3, 0.1], [-1.28, 2.0, 2.0]),
        part("Fence right", [1.28, -0.3, 0.1], [1.32, 2.0, 2.0]),
    ];
    let children = vec![
        group("Hall", hall),
        group("Workplace", workplace),
        group("Fence", fence),
        part("Dimensions", [-0.6, -0.31, 0.0], [0.6, -0.3, 2.5]),
    ];
    group("Cell", children)
}

/// A gearbox as STL, in millimetres with y up: a housing on a foot, with a shaft along z.
pub(crate) fn gearbox() -> Vec<u8> {
    let mut shaft = cylinder(30.0, 160.0, 1.0);
    shaft.vertices.iter_mut().for_each(|vertex| *vertex += DVec3::new(60.0, 140.0, 120.0));
    let housing = slab([-120.0, 30.0, -80.0], [120.0, 220.0, 80.0]);
    let foot = slab([-150.0, 0.0, -100.0], [150.0, 30.0, 100.0]);
    stl::bytes(&[foot, housing, shaft], "millimetres, y up")
}
