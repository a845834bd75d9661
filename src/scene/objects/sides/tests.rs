use super::*;
use crate::objects::primitive;

fn grid(spacing_m: f64) -> SideGrid {
    SideGrid { spacing_m, margin_m: None, most: 1000 }
}

/// The places of a side and the directions away from it, in millimetres and thousandths.
fn rounded(side: &Side) -> Vec<[[i64; 3]; 2]> {
    let whole = |v: DVec3| v.to_array().map(|number| (number * 1000.0).round() as i64);
    side.places.iter().map(|place| [whole(place.at_m), whole(place.normal)]).collect()
}

#[test]
fn a_box_has_six_sides_with_rows_about_their_middles() {
    let beam = primitive::cuboid(DVec3::new(2.0, 0.2, 0.3));
    let sides = beam.sides(&grid(0.5)).unwrap();
    assert_eq!(sides.iter().map(|side| side.way).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
    assert!(sides.iter().all(|side| side.is_flat));
    // Four places of 0.5 m in 2 m, a quarter of a metre from the ends; one on a side that is narrower.
    let along = [-750, -250, 250, 750];
    assert_eq!(rounded(&sides[0]), [[[-1000, 0, 0], [-1000, 0, 0]]]);
    assert_eq!(rounded(&sides[3]), along.map(|x| [[x, 100, 0], [0, 1000, 0]]));
    assert_eq!(rounded(&sides[4]), along.map(|x| [[x, 0, -150], [0, 0, -1000]]));
    // 1.9 m have room for three only: the ends are at least a quarter of a metre away.
    let short = primitive::cuboid(DVec3::new(1.9, 0.2, 0.3)).sides(&grid(0.5)).unwrap();
    assert_eq!(rounded(&short[4]), [-500, 0, 500].map(|x| [[x, 0, -150], [0, 0, -1000]]));
    // With a margin of 0.1 m there is room for 1.8 / 0.5 = 3 steps.
    let close = SideGrid { margin_m: Some(0.1), ..grid(0.5) };
    assert_eq!(rounded(&beam.sides(&close).unwrap()[4]), along.map(|x| [[x, 0, -150], [0, 0, -1000]]));
    let closer = SideGrid { margin_m: Some(0.0), ..grid(0.5) };
    let ends = [-1000, -500, 0, 500, 1000];
    assert_eq!(rounded(&beam.sides(&closer).unwrap()[4]), ends.map(|x| [[x, 0, -150], [0, 0, -1000]]));
}

#[test]
fn a_post_has_four_quarters_and_two_ends() {
    let post = primitive::cylinder(0.05, 1.0, 0.0005);
    let sides = post.sides(&grid(0.4)).unwrap();
    assert_eq!(sides.iter().map(|side| side.way).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
    // A height of 1 m has two places of 0.4 m; each quarter is narrower, and its middle looks along its axis.
    assert_eq!(rounded(&sides[1]), [-200, 200].map(|z| [[50, 0, z], [1000, 0, 0]]));
    assert_eq!(rounded(&sides[2]), [-200, 200].map(|z| [[0, -50, z], [0, -1000, 0]]));
    assert_eq!(rounded(&sides[5]), [[[0, 0, 500], [0, 0, 1000]]]);
}

#[test]
fn the_walls_of_a_room_face_inwards() {
    let hall = primitive::room(DVec3::new(4.0, 3.0, 2.0));
    let sides = hall.sides(&grid(1.5)).unwrap();
    // The wall at −x faces +x: 3 m and 2 m have two places and one.
    assert_eq!(rounded(&sides[1]), [-750, 750].map(|y| [[-2000, y, 0], [1000, 0, 0]]));
    assert!(!Enclosed::new(&hall).contains(DVec3::ZERO), "it is no body");
}

#[test]
fn posts_of_one_mesh_have_their_own_places() {
    let post = primitive::cuboid(DVec3::new(0.1, 0.1, 1.0));
    let mut fence = post.clone();
    fence.append(&post.clone().transform(glam::DQuat::IDENTITY, DVec3::X * 1.3));
    // Their corners are close to each other, but no triangle joins them.
    let sides = fence.sides(&grid(1.0)).unwrap();
    let front: Vec<_> = sides.iter().filter(|side| side.way == 2).flat_map(rounded).collect();
    assert_eq!(front, [0, 1300].map(|x| [[x, -50, 0], [0, -1000, 0]]));
}

#[test]
fn nothing_is_placed_over_a_hole() {
    // An L of 2 m in the xy plane; its places are a metre apart.
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let vertices = vec![at(0., 0.), at(2., 0.), at(2., 1.), at(1., 1.), at(1., 2.), at(0., 2.)];
    let corners: Vec<DVec3> = vertices.clone();
    let cut = crate::objects::polygon::triangles(&corners).unwrap();
    let shape = Mesh { vertices, triangles: cut.iter().map(|t| t.map(|n| n as u32)).collect() };
    let sides = shape.sides(&grid(1.0)).unwrap();
    assert_eq!(sides.len(), 1);
    let found: Vec<[i64; 3]> = rounded(&sides[0]).into_iter().map(|[at, _]| at).collect();
    assert_eq!(found, [[500, 500, 0], [500, 1500, 0], [1500, 500, 0]]);
    assert!(!sides[0].is_flat, "a corner of its grid has no place");
}

#[test]
fn thin_sides_and_triangles_without_area_have_no_places() {
    let sheet = primitive::cuboid(DVec3::new(1.0, 1.0, 0.019));
    let sides = sheet.sides(&grid(1.0)).unwrap();
    let filled: Vec<usize> =
        sides.iter().filter(|side| !side.places.is_empty()).map(|side| side.way).collect();
    assert_eq!(filled, [4, 5]);
    let line = Mesh { vertices: vec![DVec3::ZERO, DVec3::X, 2.0 * DVec3::X], triangles: vec![[0, 1, 2]] };
    assert_eq!(line.sides(&grid(0.1)).unwrap(), []);
}

#[test]
fn too_many_places_are_refused_before_they_are_made() {
    let wall = primitive::cuboid(DVec3::new(100.0, 0.1, 100.0));
    let refused = wall.sides(&grid(1e-5)).unwrap_err().to_string();
    assert!(refused.contains("widen spacing_m"), "{refused}");
}

#[test]
fn the_inside_of_bodies_is_known() {
    let mut both = primitive::cuboid(DVec3::ONE);
    both.append(&primitive::sphere(0.5, 0.001).transform(glam::DQuat::IDENTITY, DVec3::X));
    let enclosed = Enclosed::new(&both);
    for (point, inside) in [
        ([0.0, 0.0, 0.0], true),
        ([0.49, 0.49, 0.49], true),
        ([0.51, 0.4, 0.4], false),
        ([0.51, 0.0, 0.0], true),
        ([1.49, 0.0, 0.0], true),
        ([1.6, 0.0, 0.0], false),
        ([0.0, 0.0, -3.0], false),
        // Behind the box, seen along the line that is followed.
        ([-0.6, -0.84, -1.71], false),
    ] {
        assert_eq!(enclosed.contains(DVec3::from_array(point)), inside, "{point:?}");
    }
}
