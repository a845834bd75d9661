//! The region that a robot reaches within the limits of its joints, against its box turned by hand.

use glam::{DAffine3, DMat3, DVec3};
use perirobot_march::voxel::BitGrid;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::common::program::{Folder, refused};

/// An arm of one metre, 0.1 m thick, that turns 0.5 m high about z.
const ARM: &str = r#"<robot name="arm"><link name="base"/>
<link name="arm"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></collision></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.5"/><axis xyz="0 0 1"/>
<limit lower="-1.5" upper="3" effort="1" velocity="1"/></joint></robot>"#;

/// The usual study with this arm instead of its scene's robot, at a place and turned a little at each of two moments.
fn cell() -> Folder {
    let folder = Folder::new();
    folder.write("arm.urdf", ARM);
    folder.write(
        "cell.toml",
        "[[object]]\nname = \"arm\"\nurdf = \"arm.urdf\"\nposition_m = [0.1, -0.2, 0.05]\nrpy_deg = [0, 0, 20]\ninterior = \"occupied\"\n\
         [object.snapshots]\njoints_deg = [{ turn = 0 }, { turn = 50 }]\n\
         [[object]]\nname = \"operator\"\nrole = \"human\"\nbox = { size_m = [0.2, 0.2, 1] }\nposition_m = [1.2, 1, 0.5]\n",
    );
    folder
}

fn study(regions: &str) -> String {
    format!(
        "[grid]\nvoxel_size_m = 0.05\nbounds_m = {{ min = [-1.5, -1.5, 0], max = [1.5, 1.5, 1.2] }}\n\
         [[scene]]\nfile = \"cell.toml\"\n{regions}\n\
         [[sensor]]\nname = \"pad\"\nkind = \"pad\"\nsize_m = [0.5, 0.5]\n\
         [[sensor.poses]]\nname = \"floor\"\nlist = [{{ position_m = [0.5, 0.5, 0] }}]\n"
    )
}

fn reach(name: &str, keys: &str) -> String {
    format!("[[region]]\nname = \"{name}\"\nrobot_reach = {{ {keys} }}\n")
}

/// How far a place is from the arm at some angle within limits, in metres; angles are tried a tenth of a degree apart.
fn distance_m(at: DVec3, [from, to]: [f64; 2]) -> f64 {
    let from_base = at - DVec3::new(0.1, -0.2, 0.55);
    let of_angle = |degrees: f64| {
        let (sin, cos) = (degrees + 20.0).to_radians().sin_cos();
        let own = DVec3::new(
            cos * from_base.x + sin * from_base.y,
            cos * from_base.y - sin * from_base.x,
            from_base.z,
        );
        let outside = (own - DVec3::new(0.5, 0.0, 0.0)).abs() - DVec3::new(0.5, 0.05, 0.05);
        outside.max(DVec3::ZERO).length()
    };
    let steps = ((to - from) / 0.1).ceil() as u32;
    (0..=steps).map(|step| of_angle((from + 0.1 * f64::from(step)).min(to))).fold(f64::MAX, f64::min)
}

#[test]
fn a_region_has_all_that_the_arm_reaches_and_little_more() {
    let folder = cell();
    let regions = [
        reach("ball", ""),
        reach("own", "joint_limits = true"),
        reach("narrow", "joint_limits = true, limits_deg = { turn = [-10, 45] }"),
        reach("cut", "joint_limits = true, planes = [{ point_m = [0.4, 0, 0], normal = [-1, 0, 0] }]"),
        reach("tool", "joint_limits = true, tool_m = 1.2"),
        "[[region]]\nname = \"swept\"\nswept = \"robot\"\n".into(),
    ];
    folder.write("study.toml", study(&regions.concat()));
    let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
    let worlds = World::prepare(&study, 0).unwrap();
    let grid = worlds[0].grid;
    let voxels = |world: &World, name: &str| -> BitGrid {
        world.regions.iter().find(|region| region.name == name).unwrap().voxels.to_window(grid.window())
    };
    let (own, narrow) = (voxels(&worlds[0], "own"), voxels(&worlds[0], "narrow"));
    // Two voxels, and a third of one for the joint.
    let more_m = (2.0 + 2.0 / 5.0) * 0.05;
    let (mut inside, mut filled) = (0, 0);
    for voxel in BitGrid::full(grid.window()).voxels() {
        let at = (grid.corner_m(voxel) + grid.corner_m(voxel.map(|v| v + 1))) / 2.0;
        for (region, limits) in [(&own, [-1.5f64.to_degrees(), 3f64.to_degrees()]), (&narrow, [-10.0, 45.0])]
        {
            let away_m = distance_m(at, limits);
            inside += usize::from(away_m == 0.0);
            filled += usize::from(region.get(voxel));
            assert!(away_m > 0.0 || region.get(voxel), "{at} is reached within {limits:?}");
            assert!(
                away_m < more_m || !region.get(voxel),
                "{at} is {away_m} m from what is reached within {limits:?}"
            );
        }
    }
    assert!(inside > 2000 && filled < 4 * inside, "{inside}, {filled}");
    // It stays where it is while the arm turns, and holds the arm at every moment.
    assert_eq!(voxels(&worlds[1], "own"), own);
    let mut outside = voxels(&worlds[0], "swept");
    assert!(outside.count() > 50);
    outside.remove(&own);
    assert!(outside.is_empty(), "{} voxels of the arm", outside.count());
    let kept = |voxel: &[i32; 3]| grid.corner_m(*voxel).x + 0.025 <= 0.4;
    let expected: Vec<_> = own.voxels().filter(kept).collect();
    assert_eq!(voxels(&worlds[0], "cut").voxels().collect::<Vec<_>>(), expected);
    // A tool that is longer than the arm reaches around the joint.
    assert!(voxels(&worlds[0], "tool").count() > 3 * own.count());
}

/// A long arm in small voxels: what its tool encloses belongs to the region, also where points of its surface are farther
/// apart than voxels.
#[test]
fn a_region_is_not_hollow_in_small_voxels() {
    let folder = cell();
    let long = ARM.replace("0.5 0 0\"/><geometry><box size=\"1 ", "1.25 0 0\"/><geometry><box size=\"2.5 ");
    let tip = "<link name=\"tip\"/><joint name=\"weld\" type=\"fixed\"><parent link=\"arm\"/><child link=\"tip\"/>\
               <origin xyz=\"2.5 0 0\"/></joint></robot>";
    folder.write(
        "arm.urdf",
        long.replace("-1.5", "-0.05").replace("upper=\"3\"", "upper=\"0.05\"").replace("</robot>", tip),
    );
    folder.edit(
        "cell.toml",
        "position_m = [0.1, -0.2, 0.05]\nrpy_deg = [0, 0, 20]",
        "position_m = [-2.5, 0, 0.5]",
    );
    folder.edit("cell.toml", "[{ turn = 0 }, { turn = 50 }]", "[{ turn = 0 }, { turn = 1 }]");
    let text = study(&reach("own", "joint_limits = true, tool_m = 0.8"))
        .replace("voxel_size_m = 0.05", "voxel_size_m = 0.02");
    folder.write("study.toml", text.replace("max = [1.5, 1.5, 1.2]", "max = [1.5, 1.5, 2]"));
    let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
    let worlds = World::prepare(&study, 0).unwrap();
    let (grid, region) = (worlds[0].grid, &worlds[0].regions[0].voxels);
    let region = region.to_window(grid.window());
    // The middle of the tool's ball, 1 m high.
    let middle = |voxel: &[i32; 3]| (grid.corner_m(*voxel) - DVec3::new(0.0, 0.0, 1.0)).length() < 0.6;
    let missing =
        BitGrid::full(grid.window()).voxels().filter(middle).filter(|voxel| !region.get(*voxel)).count();
    assert_eq!(missing, 0);
}

/// A joint that turns a box: where it is on the link before, its axis, its limits in degrees, and the box.
struct Turn {
    xyz: [f64; 3],
    rpy: [f64; 3],
    axis: [f64; 3],
    limits_deg: [f64; 2],
    size: [f64; 3],
}

const ELBOW: [Turn; 2] = [
    Turn {
        xyz: [0.0, 0.0, 0.3],
        rpy: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        limits_deg: [-40.0, 95.0],
        size: [0.9, 0.1, 0.1],
    },
    Turn {
        xyz: [0.45, 0.0, 0.05],
        rpy: [0.2, 0.0, 0.4],
        axis: [0.0, 0.6, 0.8],
        limits_deg: [-110.0, 20.0],
        size: [0.7, 0.08, 0.06],
    },
];

/// Its axes are those of usual arms of six joints.
const SIX: [Turn; 6] = [
    Turn {
        xyz: [0.0, 0.0, 0.2],
        rpy: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        limits_deg: [-170.0, 60.0],
        size: [0.1; 3],
    },
    Turn {
        xyz: [0.0, 0.07, 0.0],
        rpy: [0.0, 0.3, 0.0],
        axis: [0.0, 1.0, 0.0],
        limits_deg: [-60.0, 30.0],
        size: [0.8, 0.1, 0.1],
    },
    Turn {
        xyz: [0.4, 0.0, 0.0],
        rpy: [0.0, 0.5, 0.1],
        axis: [0.0, 1.0, 0.0],
        limits_deg: [-90.0, 45.0],
        size: [0.6, 0.08, 0.08],
    },
    Turn {
        xyz: [0.3, 0.0, 0.0],
        rpy: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        limits_deg: [-180.0, 180.0],
        size: [0.1, 0.06, 0.06],
    },
    Turn {
        xyz: [0.08, 0.0, 0.0],
        rpy: [0.0; 3],
        axis: [0.0, -1.0, 0.0],
        limits_deg: [-20.0, 100.0],
        size: [0.08; 3],
    },
    Turn {
        xyz: [0.06, 0.0, 0.0],
        rpy: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        limits_deg: [-90.0, 90.0],
        size: [0.02, 0.2, 0.05],
    },
];

fn chain(turns: &[Turn]) -> String {
    let words = |numbers: [f64; 3]| numbers.map(|number| number.to_string()).join(" ");
    let mut text = "<robot name=\"arm\"><link name=\"l0\"/>".to_string();
    for (before, Turn { xyz, rpy, axis, limits_deg, size }) in turns.iter().enumerate() {
        let (link, [low, high]) = (before + 1, limits_deg.map(f64::to_radians));
        text += &format!(
            "<link name=\"l{link}\"><collision><geometry><box size=\"{}\"/></geometry></collision></link>\
             <joint name=\"j{link}\" type=\"revolute\"><parent link=\"l{before}\"/><child link=\"l{link}\"/>\
             <origin xyz=\"{}\" rpy=\"{}\"/><axis xyz=\"{}\"/>\
             <limit lower=\"{low}\" upper=\"{high}\" effort=\"1\" velocity=\"1\"/></joint>",
            words(*size),
            words(*xyz),
            words(*rpy),
            words(*axis)
        );
    }
    text + "</robot>"
}

/// Where the links are in the cell, for angles of the joints.
fn frames(turns: &[Turn], angles_deg: &[f64]) -> Vec<DAffine3> {
    let about = |[x, y, z]: [f64; 3]| {
        DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x)
    };
    let base = about([0.0, 0.0, 20f64.to_radians()]);
    let mut frame = DAffine3::from_mat3_translation(base, DVec3::new(0.1, -0.2, 0.05));
    let each = turns.iter().zip(angles_deg).map(|(Turn { xyz, rpy, axis, .. }, angle)| {
        let turned = about(*rpy) * DMat3::from_axis_angle(DVec3::from(*axis), angle.to_radians());
        frame *= DAffine3::from_mat3_translation(turned, DVec3::from(*xyz));
        frame
    });
    each.collect()
}

#[test]
fn whatever_the_joints_of_a_chain_do_its_links_and_its_tool_stay_in_the_region() {
    const TOOL_M: f64 = 0.15;
    let mut random = ChaCha8Rng::seed_from_u64(6);
    for (turns, limits) in [
        (&ELBOW[..], ""),
        (&SIX[..], ""),
        (&SIX[..], ", limits_deg = { j1 = [-30, 40], j3 = [-20, 5], j5 = [0, 60] }"),
    ] {
        let folder = cell();
        folder.write("arm.urdf", chain(turns));
        folder.edit("cell.toml", "[{ turn = 0 }, { turn = 50 }]", "[{ j1 = 0 }, { j1 = 30 }]");
        let keys = format!("joint_limits = true, tool_m = {TOOL_M}{limits}");
        folder.write("study.toml", study(&reach("own", &keys)));
        let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
        let world = World::prepare(&study, 0).unwrap().remove(0);
        let grid = world.grid;
        let region = world.regions[0].voxels.to_window(grid.window());
        let narrower = |joint: usize| match (limits.is_empty(), joint) {
            (false, 0) => [-30.0, 40.0],
            (false, 2) => [-20.0, 5.0],
            (false, 4) => [0.0, 60.0],
            _ => turns[joint].limits_deg,
        };
        let (mut inside, mut ends) = (0, 0);
        for _ in 0..5000 {
            let angles: Vec<f64> = (0..turns.len())
                .map(|joint| {
                    let [low, high] = narrower(joint);
                    // Also the limits themselves.
                    low + (high - low) * random.random_range(-0.2..1.2f64).clamp(0.0, 1.0)
                })
                .collect();
            let frames = frames(turns, &angles);
            let mut unit = || DVec3::from_array([0; 3].map(|_| random.random_range(-1.0..=1.0)));
            let boxes = frames.iter().zip(turns);
            let mut places: Vec<DVec3> = boxes
                .map(|(frame, turn)| frame.transform_point3(unit() * DVec3::from(turn.size) / 2.0))
                .collect();
            places.push(frames[turns.len() - 1].translation + unit().normalize() * TOOL_M);
            for (index, at) in places.into_iter().enumerate() {
                let cell = ((at - grid.corner_m([0; 3])) / grid.voxel_size_m).floor();
                let size = DVec3::from_array(grid.size.map(|count| count as f64));
                if cell.cmpge(DVec3::ZERO).all() && cell.cmplt(size).all() {
                    let voxel = cell.to_array().map(|v| v as i32);
                    assert!(region.get(voxel), "{angles:?}: {at}");
                    inside += 1;
                    ends += usize::from(index == turns.len());
                }
            }
        }
        let filled = region.count() as f64 / BitGrid::full(grid.window()).count() as f64;
        assert!(inside > 10_000 && ends > 2_000 && filled < 0.9, "{inside}, {ends}, {filled}");
    }
}

#[test]
fn limits_that_cannot_be() {
    for (keys, expected) in [
        ("limits_deg = { turn = [0, 1] }", "robot_reach: limits_deg and limits_m belong to a region within"),
        (
            "joint_limits = true, limits_deg = { turn = [0, 200] }",
            "robot_reach: limits_deg.turn = [0.0, 200.0]: must be within",
        ),
        ("joint_limits = true, limits_m = { turn = [0, 1] }", "turns: write its degrees under limits_deg"),
        ("joint_limits = true, limits_deg = { lift = [0, 1] }", "has no such joint; there are turn"),
        (
            "joint_limits = true, object = \"operator\"",
            "robot_reach.object = \"operator\": the scene's robots are [\"arm\"]",
        ),
    ] {
        let folder = cell();
        folder.write("study.toml", study(&reach("own", "joint_limits = true")));
        let edit = [("study.toml", "joint_limits = true", keys)];
        refused(&folder, &edit, &["study.toml", "region \"own\"", expected]);
    }
}
