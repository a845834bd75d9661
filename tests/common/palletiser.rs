//! The meshes of `scenes/palletiser/`, as an integrator's CAD program would export them.

use perirobot_scene::objects::Mesh;

use super::glb::{GlbNode, group, part, slab};
use super::stl;

/// The lowest and the highest corner of a box.
type Corners = ([f64; 3], [f64; 3]);

/// What is fixed to the floor: conveyor, fence with its posts, pillar, pedestal, cabinet and a magazine of pallets.
pub(crate) fn plant() -> GlbNode {
    let conveyor = [
        ([-5.95, -0.35, 0.62], [-1.0, 0.35, 0.8]),
        ([-5.95, -0.41, 0.6], [-1.0, -0.35, 0.9]),
        ([-5.95, 0.35, 0.6], [-1.0, 0.41, 0.9]),
        ([-1.0, -0.41, 0.6], [-0.94, 0.41, 1.0]),
        ([-5.2, -0.4, 0.0], [-5.1, 0.4, 0.62]),
        ([-3.3, -0.4, 0.0], [-3.2, 0.4, 0.62]),
        ([-1.3, -0.4, 0.0], [-1.2, 0.4, 0.62]),
        ([-2.6, -0.3, 0.25], [-2.0, 0.3, 0.62]),
    ];
    // Open at the gate in the west, for the conveyor, and for pallets in the east; the north side is of sheet metal.
    let fence = [
        ([-3.82, -3.42, 0.15], [-3.78, -2.9, 2.2]),
        ([-3.82, -1.9, 0.15], [-3.78, -0.55, 2.2]),
        ([-3.82, 0.55, 0.15], [-3.78, 3.42, 2.2]),
        ([-3.78, -3.42, 0.15], [3.62, -3.38, 2.2]),
        ([3.58, -3.38, 0.15], [3.62, -2.6, 2.2]),
        ([3.58, 2.6, 0.15], [3.62, 3.38, 2.2]),
    ];
    let posts = [
        [-3.8, -3.4],
        [-3.8, -2.9],
        [-3.8, -1.9],
        [-3.8, -0.55],
        [-3.8, 0.55],
        [-3.8, 3.4],
        [-0.1, -3.4],
        [3.6, -3.4],
        [3.6, -2.6],
        [3.6, 2.6],
        [3.6, 3.4],
    ];
    let posts = posts.map(|[x, y]| ([x - 0.04, y - 0.04, 0.0], [x + 0.04, y + 0.04, 2.3]));
    let children = vec![
        part("Pillar", [2.3, -0.6, 0.0], [2.7, -0.2, 5.95]),
        part("Pedestal", [-0.4, -0.4, 0.0], [0.4, 0.4, 0.4]),
        parts("Conveyor", "Part", &conveyor),
        parts("Fence", "Panel", &fence),
        parts("Posts", "Post", &posts),
        part("Sheet metal", [-3.76, 3.38, 0.1], [3.56, 3.42, 2.2]),
        part("Cabinet", [-3.3, -3.36, 0.0], [-1.9, -2.86, 2.0]),
        part("Magazine", [-2.9, 2.1, 0.0], [-1.5, 3.1, 1.9]),
    ];
    group("Plant", children)
}

/// A group of boxes of one name.
fn parts(name: &'static str, child: &'static str, boxes: &[Corners]) -> GlbNode {
    group(name, boxes.iter().map(|(low, high)| part(child, *low, *high)).collect())
}

/// A pallet of 1200 × 800 × 144 mm: boards and blocks.
pub(crate) fn pallet() -> Vec<u8> {
    let across = |x: f64, width: f64, y: [f64; 2], z: [f64; 2]| {
        slab([x - width / 2.0, y[0], z[0]], [x + width / 2.0, y[1], z[1]])
    };
    let along = |y: f64, width: f64, z: [f64; 2]| {
        slab([-600.0, y - width / 2.0, z[0]], [600.0, y + width / 2.0, z[1]])
    };
    let columns = [-527.5, 0.0, 527.5];
    let mut bodies = Vec::new();
    for (y, width) in [(-350.0, 100.0), (0.0, 145.0), (350.0, 100.0)] {
        bodies.push(along(y, width, [0.0, 22.0]));
        let ends = [y - width / 2.0, y + width / 2.0];
        bodies.extend(columns.map(|x| across(x, 145.0, ends, [22.0, 100.0])));
    }
    bodies.extend(columns.map(|x| across(x, 145.0, [-400.0, 400.0], [100.0, 122.0])));
    let top = [(-327.5, 145.0), (-170.0, 100.0), (0.0, 145.0), (170.0, 100.0), (327.5, 145.0)];
    bodies.extend(top.map(|(y, width)| along(y, width, [122.0, 144.0])));
    millimetres(&bodies)
}

/// The robot's gripper, which hangs below its flange: a plate and two jaws.
pub(crate) fn gripper() -> Vec<u8> {
    millimetres(&[
        slab([-60.0, -60.0, -80.0], [60.0, 60.0, 0.0]),
        slab([-250.0, -200.0, -110.0], [250.0, 200.0, -80.0]),
        slab([-250.0, -230.0, -330.0], [250.0, -200.0, -80.0]),
        slab([-250.0, 200.0, -330.0], [250.0, 230.0, -80.0]),
    ])
}

fn millimetres(bodies: &[Mesh]) -> Vec<u8> {
    stl::bytes(bodies, "millimetres, z up")
}
