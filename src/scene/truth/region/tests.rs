//! Regions whose voxels can be counted by hand, against their rules, and those that cannot be.

use super::*;
use crate::pose::Pose;
use crate::truth::RadarTruth;
use perirobot_march::voxel::Grid;

/// An empty scene of 0.05 m voxels over the paper's cell.
fn empty_voxel() -> Truth {
    let grid = Grid { voxel_size_m: 0.05, origin: [-60, -40, 0], size: [121, 81, 61] };
    let blank = BitGrid::new(grid.window());
    Truth {
        grid,
        occupied: blank.clone().into(),
        blockers: blank.clone().into(),
        radar: RadarTruth { blockers: blank.clone().into(), speeds_mm_s: Vec::new() },
        shades: None,
        ignored: blank.clone(),
        human: blank.clone(),
        robot: blank.clone(),
        robot_volume: blank,
        objects: Vec::new(),
    }
}

/// A region of a scene that stands still.
fn region(name: &str, shape: &RegionShape, truth: &Truth) -> Result<Region> {
    super::region(name, shape, truth, &|role| {
        Arc::new(if role == Role::Robot { truth.robot_volume.clone() } else { truth.human.clone() })
    })
}

#[test]
fn the_papers_regions_have_the_papers_sizes() {
    let truth = empty_voxel();
    let robot = RegionShape::Sphere { center_m: DVec3::new(0.0, 0.0, 1.0), radius_m: 1.5 };
    let robot = region("robot", &robot, &truth).unwrap();
    assert_eq!(robot.voxels.count(), 104_732);
    assert!(robot.cut_share > 0.0, "the floor cuts the sphere");
    let human = RegionShape::Box { min_m: DVec3::new(-0.25, -1.45, 0.0), max_m: DVec3::new(0.9, 0.0, 1.95) };
    let human = region("human", &human, &truth).unwrap();
    assert_eq!((human.voxels.count(), human.cut_share), (26_013, 0.0));
}

#[test]
fn a_small_sphere_is_counted_by_hand() {
    let truth = empty_voxel();
    // Around a voxel's centre: strictly within 1 voxel there is only the voxel itself; just over 1, seven.
    let at = |radius_m| {
        let shape = RegionShape::Sphere { center_m: DVec3::new(0.025, 0.025, 1.025), radius_m };
        region("ball", &shape, &truth).map(|r| (r.voxels.count(), r.voxels.window().min))
    };
    assert_eq!(at(0.05).unwrap(), (1, [60, 40, 20]));
    assert_eq!(at(0.0501).unwrap(), (7, [59, 39, 19]));
}

#[test]
fn a_human_box_grows_by_its_margins() {
    let mut truth = empty_voxel();
    truth.human.set([60, 40, 10]);
    truth.human.set([62, 40, 30]);
    let margin = DVec3::new(0.3, 0.1, 0.0);
    let shape = RegionShape::HumanBox { object: None, margin_min_m: margin, margin_max_m: DVec3::ZERO };
    let human = region("human", &shape, &truth).unwrap();
    assert_eq!(human.voxels.window(), Window::from_corners([54, 38, 10], [62, 40, 30]));
    assert_eq!(human.voxels.count(), 9 * 3 * 21);
}

#[test]
fn regions_that_cannot_be_are_refused() {
    let mut truth = empty_voxel();
    let far = RegionShape::Sphere { center_m: DVec3::new(50.0, 0.0, 0.0), radius_m: 1.0 };
    assert!(region("far", &far, &truth).unwrap_err().to_string().contains("outside the grid"));
    let tiny = RegionShape::Sphere { center_m: DVec3::ZERO, radius_m: 0.001 };
    assert!(region("tiny", &tiny, &truth).unwrap_err().to_string().contains("no voxel"));
    let big = RegionShape::Sphere { center_m: DVec3::ZERO, radius_m: 1500.0 };
    assert!(region("big", &big, &truth).unwrap_err().to_string().contains("radius_m = 1500"));
    let nobody = RegionShape::HumanBox { object: None, margin_min_m: DVec3::ZERO, margin_max_m: DVec3::ZERO };
    assert!(region("human", &nobody, &truth).is_err());
    let unit = RegionShape::Box { min_m: DVec3::ZERO, max_m: DVec3::ONE };
    let mut everything = BitGrid::new(truth.grid.window());
    (0..61).for_each(|z| (0..81).for_each(|y| everything.set_run(0, 121, y, z)));
    truth.ignored = everything;
    assert!(region("unit", &unit, &truth).unwrap_err().to_string().contains("interior"));
}

fn sphere(center_m: [f64; 3], radius_m: f64) -> RegionShape {
    RegionShape::Sphere { center_m: DVec3::from_array(center_m), radius_m }
}

fn voxels(shape: &RegionShape, truth: &Truth) -> BitGrid {
    region("some", shape, truth).unwrap().voxels.to_window(truth.grid.window())
}

#[test]
fn a_half_sphere_is_the_side_of_its_normal_with_the_plane() {
    let truth = empty_voxel();
    let center_m = DVec3::new(0.025, 0.025, 1.025);
    let half =
        |normal: DVec3| voxels(&RegionShape::HalfSphere { center_m, radius_m: 0.1001, normal }, &truth);
    // Within two voxels of a centre: 33, 13 of them in a plane through it.
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let (up, down) = (half(axis), half(-axis));
        assert_eq!((up.count(), down.count()), (10 + 13, 10 + 13), "{axis}");
        let mut both = up.clone();
        both.keep(&down);
        assert_eq!(both.count(), 13, "{axis}");
    }
    for normal in [DVec3::new(1.0, 1.0, 0.0), DVec3::new(-3.0, 1.0, 2.0), DVec3::new(0.0, -1.0, 5.0)] {
        let q15 = normal.normalize().to_array().map(|n| (n * 32_768.0).round() as i64);
        let ball = voxels(&sphere(center_m.to_array(), 0.1001), &truth);
        let expected: Vec<_> = ball
            .voxels()
            .filter(|voxel| (0..3).map(|r| q15[r] * (voxel[r] - [60, 40, 20][r]) as i64).sum::<i64>() >= 0)
            .collect();
        assert_eq!(half(normal).voxels().collect::<Vec<_>>(), expected, "{normal}");
        assert_eq!(half(normal * 1e-6), half(normal));
    }
    // A plane between centres: no voxel has its centre on it.
    let between =
        RegionShape::HalfSphere { center_m: DVec3::new(0.0, 0.0, 1.0), radius_m: 0.3, normal: DVec3::Z };
    let whole = voxels(&sphere([0.0, 0.0, 1.0], 0.3), &truth).count();
    assert_eq!(2 * voxels(&between, &truth).count(), whole);
}

#[test]
fn unions_and_differences_are_those_of_their_voxels() {
    let mut truth = empty_voxel();
    truth.ignored.set_run(60, 64, 40, 18);
    let one = sphere([0.2, 0.1, 0.3], 0.6);
    let two = RegionShape::Box { min_m: DVec3::new(0.1, -0.2, -0.5), max_m: DVec3::new(1.5, 0.6, 0.6) };
    let three = sphere([0.3, 0.0, 0.9], 0.4);
    let [a, b, c] = [&one, &two, &three].map(|shape| voxels(shape, &truth));
    let mut expected = a.clone();
    expected.add(&b);
    expected.add(&c);
    let union = RegionShape::Union(vec![one.clone(), two.clone(), three.clone()]);
    assert_eq!(voxels(&union, &truth), expected);
    assert_eq!(voxels(&RegionShape::Union(vec![one.clone(), one.clone()]), &truth), a);
    let mut expected = a.clone();
    expected.remove(&b);
    expected.remove(&c);
    let difference = RegionShape::Difference(vec![one.clone(), two.clone(), three.clone()]);
    assert_eq!(voxels(&difference, &truth), expected);
    let mut expected = b.clone();
    expected.remove(&voxels(&difference, &truth));
    assert_eq!(voxels(&RegionShape::Difference(vec![two, difference.clone()]), &truth), expected);
    let gone =
        region("gone", &RegionShape::Difference(vec![one.clone(), union]), &truth).unwrap_err().to_string();
    assert!(gone.contains("region \"gone\": difference: the others leave nothing"), "{gone}");
}

#[test]
fn what_is_cut_off_a_combination_counts_its_voxels_once() {
    let truth = empty_voxel();
    let cube = |low: f64, high: f64| RegionShape::Box {
        min_m: DVec3::new(0.0, 0.0, low),
        max_m: DVec3::new(0.1, 0.1, high),
    };
    let share = |shape: &RegionShape| region("some", shape, &truth).unwrap().cut_share;
    // Layers of 2 × 2 voxels from −4 to 3 and from −2 to 7: the union is 12 high, 4 of it below the floor.
    let (low, high) = (cube(-0.2, 0.2), cube(-0.1, 0.4));
    assert_eq!((share(&low), share(&high)), (0.5, 0.2));
    assert_eq!(share(&RegionShape::Union(vec![low.clone(), high.clone()])), 4.0 / 12.0);
    // −2 to 7 less −4 to 3 is 4 to 7: nothing of it is cut; the other way round all of it is.
    assert_eq!(share(&RegionShape::Difference(vec![high.clone(), low.clone()])), 0.0);
    let below = region("below", &RegionShape::Difference(vec![low, high]), &truth).unwrap_err().to_string();
    assert!(below.contains("outside the grid"), "{below}");
}

#[test]
fn a_mesh_is_cut_to_the_grid() {
    let truth = empty_voxel();
    let mesh = crate::objects::primitive::cuboid(DVec3::splat(1.0));
    let whole = region("zone", &RegionShape::Mesh(Arc::new(mesh.clone())), &truth).unwrap();
    assert_eq!((whole.voxels.count(), whole.cut_share), (20 * 20 * 10, 0.5));
    assert_eq!(whole.voxels.window(), Window::from_corners([50, 30, 0], [69, 49, 9]));
    let mut open = mesh;
    open.triangles.pop();
    let open = region("zone", &RegionShape::Mesh(Arc::new(open)), &truth).unwrap_err().to_string();
    assert!(open.contains("region \"zone\": mesh: is not watertight"), "{open}");
}

#[test]
fn a_robots_reach_is_a_sphere_around_its_base() {
    let mut truth = empty_voxel();
    let object = |name: &str, role, reach| {
        Arc::new(ObjectVoxels {
            name: name.into(),
            role,
            stops_rays: true,
            stops_radar: true,
            triangles: 0,
            watertight: None,
            bounds_m: [DVec3::ZERO; 2],
            reach,
            voxels: BitGrid::new(Window::from_corners([0; 3], [-1; 3])),
            keypoints: None,
            warnings: Vec::new(),
        })
    };
    let arm =
        Some(RobotReach { base_m: DVec3::new(0.1, 0.2, 0.8), radius_m: 1.3, world_from_root: Pose::ORIGIN });
    truth.objects.push(object("gripper", Role::Robot, None));
    truth.objects.push(object("operator", Role::Human, None));
    let reach = |object: Option<&str>| RegionShape::RobotReach {
        object: object.map(str::to_string),
        tool_m: 0.2,
        within_limits: None,
        planes: Vec::new(),
    };
    let error = |truth: &Truth, name| region("all", &reach(name), truth).unwrap_err().to_string();
    assert!(
        error(&truth, None).contains("robot_reach: no robot has a known reach: give the robot as a urdf")
    );
    assert!(error(&truth, Some("gripper")).contains("robot_reach.object = \"gripper\": no robot has"));
    let operator = error(&truth, Some("operator"));
    assert!(operator.contains("robot_reach.object = \"operator\": the scene's robots are [\"gripper\"]"));
    truth.objects.push(object("arm", Role::Robot, arm));
    let expected = voxels(&sphere([0.1, 0.2, 0.8], 1.5), &truth);
    assert_eq!(voxels(&reach(None), &truth), expected);
    assert_eq!(voxels(&reach(Some("arm")), &truth), expected);
    // Two planes keep it before a wall and above a table: what is in both half spaces.
    let planes = [
        SafetyPlane { point_m: DVec3::new(0.4, 0.0, 0.0), normal: DVec3::new(-2.0, 0.5, 0.0) },
        SafetyPlane { point_m: DVec3::new(0.0, 0.0, 0.6), normal: DVec3::Z },
    ];
    let cut =
        RegionShape::RobotReach { object: None, tool_m: 0.2, within_limits: None, planes: planes.to_vec() };
    let is_before = |voxel: &[i32; 3]| {
        planes.iter().all(|plane| {
            let q15 = plane.normal.normalize().to_array().map(|n| (n * 32_768.0).round() as i64);
            let point_q16 = truth.grid.position_q16(plane.point_m);
            (0..3).map(|r| q15[r] * ((i64::from(voxel[r]) << 16) + 32_768 - point_q16[r])).sum::<i64>() >= 0
        })
    };
    let before: Vec<_> = expected.voxels().filter(is_before).collect();
    assert!(before.len() > 1000 && before.len() < expected.count() as usize / 2, "{}", before.len());
    assert_eq!(voxels(&cut, &truth).voxels().collect::<Vec<_>>(), before);
    truth.objects.push(object("second", Role::Robot, arm));
    assert!(error(&truth, None).contains("[\"arm\", \"second\"] all have a reach"));
    assert_eq!(voxels(&reach(Some("arm")), &truth), expected);
}

/// Voxels here and there, some at the edges of the grid.
fn dots(truth: &Truth, more: [i32; 3]) -> BitGrid {
    let mut dots = BitGrid::new(truth.grid.window());
    [[0, 40, 10], [3, 44, 12], [60, 0, 60], [61, 3, 57], more].into_iter().for_each(|voxel| dots.set(voxel));
    dots.trim()
}

#[test]
fn near_the_robot_is_what_a_plain_search_finds_inside_the_grid_and_outside() {
    let mut truth = empty_voxel();
    truth.robot_volume = dots(&truth, [20, 20, 20]);
    let robot: Vec<_> = truth.robot_volume.voxels().collect();
    let squared = |a: [i32; 3], b: [i32; 3]| (0..3).map(|r| (a[r] - b[r]).pow(2)).sum::<i32>();
    // 3.4 voxels squared are 11.56: below 12. Exactly three voxels are far enough: below 9. No distance: the robot itself.
    for (distance_m, most) in [(0.17, 11), (0.15, 8), (0.0, 0)] {
        let shape = RegionShape::Separation { swept: false, distance_m };
        let found = region("near", &shape, &truth).unwrap();
        let near = |voxel: &[i32; 3]| robot.iter().any(|&other| squared(*voxel, other) <= most);
        let all: Vec<_> = BitGrid::full(truth.grid.window().grown(5)).voxels().filter(near).collect();
        let inside: Vec<_> =
            all.iter().copied().filter(|&voxel| truth.grid.window().contains(voxel)).collect();
        assert_eq!(found.voxels.voxels().collect::<Vec<_>>(), inside, "{distance_m} m");
        assert_eq!(found.cut_share, (all.len() - inside.len()) as f64 / all.len() as f64, "{distance_m} m");
        let cut = most > 0;
        assert_eq!(found.cut_at, [[cut, false], [cut, false], [false, cut]], "{distance_m} m");
    }
}

#[test]
fn what_moves_is_in_regions_as_it_was_swept() {
    let mut truth = empty_voxel();
    truth.robot_volume = dots(&truth, [20, 20, 20]);
    let (robot, people) = (dots(&truth, [40, 40, 30]), dots(&truth, [50, 50, 5]));
    let of = |shape: &RegionShape| {
        let swept_by: SweptBy =
            &|role| Arc::new(if role == Role::Robot { robot.clone() } else { people.clone() });
        super::region("moved", shape, &truth, swept_by).map(|found| found.voxels.trim())
    };
    assert_eq!(of(&RegionShape::Swept { role: Role::Robot }).unwrap(), robot);
    assert_eq!(of(&RegionShape::Swept { role: Role::Human }).unwrap(), people);
    let near = |swept| of(&RegionShape::Separation { swept, distance_m: 0.06 }).unwrap();
    let window = truth.grid.window();
    let has = |swept: bool, voxel| near(swept).to_window(window).get(voxel);
    assert!(has(true, [41, 40, 30]) && !has(true, [21, 20, 20]));
    assert!(has(false, [21, 20, 20]) && !has(false, [41, 40, 30]));
}

#[test]
fn distances_without_a_robot_or_that_no_memory_holds_are_refused() {
    let mut truth = empty_voxel();
    let near = |truth: &Truth, distance_m| {
        let shape = RegionShape::Separation { swept: false, distance_m };
        region("near", &shape, truth).unwrap_err().to_string()
    };
    assert!(near(&truth, 1.0).contains("region \"near\": no object of the scene is a robot in the grid"));
    let nobody = region("all", &RegionShape::Swept { role: Role::Human }, &truth).unwrap_err().to_string();
    assert!(nobody.contains("region \"all\": no object of the scene with role = \"human\" is in the grid"));
    truth.robot_volume = dots(&truth, [20, 20, 20]);
    for distance_m in [40.0, 1e3, 1e9] {
        assert!(near(&truth, distance_m).contains("take larger voxels, or check the times of [stopping]"));
    }
}
