//! The region that a robot reaches within the limits of its joints, against its box turned by hand.

use glam::DVec3;
use perirobot_march::voxel::BitGrid;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

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
