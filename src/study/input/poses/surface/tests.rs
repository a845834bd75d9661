use std::path::Path;

use super::super::tests::source;
use super::super::{GroupExtras, expand};
use super::*;
use crate::input::load_scene;
use crate::sensor::{Candidate, MountLink};
use perirobot_scene::objects::spec::SceneSpec;
use perirobot_scene::source::Sources;

/// A hall of 6 m × 4 m × 3 m on z = 0 with a beam across it under its ceiling, which touches both walls, a post of 1 m on
/// the floor, a fence in one file and an arm.
const CELL: &str = r#"[[object]]
name = "hall"
room = { size_m = [6, 4, 3] }
position_m = [0, 0, 1.5]
[[object]]
name = "beam"
box = { size_m = [0.2, 4, 0.2] }
position_m = [1, 0, 2.5]
[[object]]
name = "post"
cylinder = { radius_m = 0.05, height_m = 1 }
position_m = [-2, 0, 0.5]
[[object]]
name = "fence"
mesh = "fence.obj"
position_m = [0, 1, 0]
rpy_deg = [0, 0, 90]
[[object]]
name = "arm"
urdf = "arm.urdf"
snapshots = { joints_deg = [{ turn = 0 }, { turn = 90 }] }
[[object]]
name = "cart"
box = { size_m = [1, 1, 1] }
position_m = [0, 0, 0.5]
snapshots = { position_m = [[0, 0, 0.5], [1, 0, 0.5]] }
[[object]]
name = "operator"
role = "human"
box = { size_m = [0.4, 0.4, 1.8] }
position_m = [0, -1, 0.9]
"#;

/// Two boards of 1 m, 2 m apart along x, which face −y and end 1 m above the floor.
const FENCE: &str =
    "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 3 0 0\nv 4 0 0\nv 4 0 1\nv 3 0 1\nf 1 2 3 4\nf 5 6 7 8\n";

const ARM: &str = r#"<robot name="arm"><link name="base"><collision><geometry><box size="0.3 0.3 0.3"/></geometry></collision></link>
<link name="hand"><collision><origin xyz="0 0 0.5"/><geometry><box size="0.1 0.1 1"/></geometry></collision></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"#;

fn write(folder: &Path, cell: &str) {
    for (name, text) in [("cell.toml", cell), ("fence.obj", FENCE), ("arm.urdf", ARM)] {
        std::fs::write(folder.join(name), text).unwrap();
    }
}

/// The poses of an entry in scenes.
fn expand_in(
    cells: &[&str],
    stance: Stance,
    link: Option<&str>,
    entry: &str,
) -> Result<(Vec<Candidate>, GroupExtras)> {
    let folders: Vec<_> = cells.iter().map(|_| tempfile::tempdir().unwrap()).collect();
    let sources = &Sources::from_main(&folders[0].path().join("study.toml")).allow_outside();
    let scene = |(cell, folder): (&&str, &tempfile::TempDir)| {
        write(folder.path(), cell);
        load_scene(&folder.path().join("cell.toml"), sources).unwrap()
    };
    let scenes: Vec<SceneSpec> = cells.iter().zip(&folders).map(scene).collect();
    let on = link.map(|link| MountLink { object: "arm".into(), link: link.into() });
    let surfaces = &Surfaces::default();
    let source = PoseSource { stance, on: on.as_ref(), scenes: &scenes, ..source(sources, surfaces) };
    let mut candidates = Vec::new();
    let entry: PosesFile = toml::from_str(&format!("name = \"g\"\n{entry}")).unwrap();
    let extras = expand(&Place::new(Path::new("study.toml")), &entry, &source, &mut candidates)?;
    Ok((candidates, extras))
}

fn poses(entry: &str) -> Vec<Candidate> {
    expand_in(&[CELL], Stance::Facing, None, entry).unwrap().0
}

#[track_caller]
fn refused(cells: &[&str], link: Option<&str>, entry: &str, expected: &str) {
    let what = expand_in(cells, Stance::Facing, link, entry).err().expect("it is refused").to_string();
    assert!(what.contains(expected), "{what}");
}

/// Each pose by its name, its place, and the way that it looks, in thousandths.
fn told(candidates: &[Candidate]) -> Vec<(&str, [f64; 3], [i64; 3])> {
    let one = |candidate: &'_ Candidate| {
        let pose = candidate.setting.pose();
        let ahead = pose.link().x_axis.to_array().map(|part| (part * 1000.0).round() as i64);
        (pose.position_m.to_array(), ahead)
    };
    candidates.iter().map(|c| (c.name.strip_prefix("g/").unwrap(), one(c).0, one(c).1)).collect()
}

#[test]
fn a_beam_has_poses_on_its_free_sides() {
    // 4 m have two places of 2 m; the ends are at the walls, where no sensor has room.
    let found = poses("surface = { object = \"beam\", spacing_m = 2, off_m = 0.1 }");
    let expected = [
        ("-x/0/0", [0.8, -1.0, 2.5], [-1000, 0, 0]),
        ("-x/1/0", [0.8, 1.0, 2.5], [-1000, 0, 0]),
        ("+x/0/0", [1.2, -1.0, 2.5], [1000, 0, 0]),
        ("+x/1/0", [1.2, 1.0, 2.5], [1000, 0, 0]),
        ("-z/0/0", [1.0, -1.0, 2.3], [0, 0, -1000]),
        ("-z/1/0", [1.0, 1.0, 2.3], [0, 0, -1000]),
        ("+z/0/0", [1.0, -1.0, 2.7], [0, 0, 1000]),
        ("+z/1/0", [1.0, 1.0, 2.7], [0, 0, 1000]),
    ];
    assert_eq!(told(&found), expected);
    // Names are the same when sides are left out; turns are those of a lattice.
    let turned = poses(
        "surface = { object = \"beam\", spacing_m = 2, off_m = 0.1, sides = [\"-z\"] }\n\
         orientations_deg = [{}, { tilt = 30 }]",
    );
    let looks = told(&turned);
    assert_eq!(
        looks.iter().map(|(name, ..)| *name).collect::<Vec<_>>(),
        ["-z/0/0", "-z/0/1", "-z/1/0", "-z/1/1"]
    );
    assert_eq!((looks[1].1, looks[1].2), ([1.0, -1.0, 2.3], [500, 0, -866]));
}

#[test]
fn posts_and_rooms_face_into_the_cell() {
    let post = poses("surface = { object = \"post\", spacing_m = 0.5, sides = [\"+x\", \"+z\"] }");
    let expected = [
        ("+x/0/0", [-1.9, 0.0, 0.25], [1000, 0, 0]),
        ("+x/1/0", [-1.9, 0.0, 0.75], [1000, 0, 0]),
        ("+z/0/0", [-2.0, 0.0, 1.05], [0, 0, 1000]),
    ];
    assert_eq!(told(&post), expected);
    let below = poses("surface = { object = \"post\", spacing_m = 0.5 }");
    assert!(below.iter().all(|pose| !pose.name.contains("-z")), "it stands on the floor of the hall");
    let hall = poses("surface = { object = \"hall\", spacing_m = 3, sides = [\"-z\", \"+y\"] }");
    let expected = [
        ("+y/0/0", [-1.5, -1.95, 1.5], [0, 1000, 0]),
        ("+y/1/0", [1.5, -1.95, 1.5], [0, 1000, 0]),
        ("-z/0/0", [-1.5, 0.0, 2.95], [0, 0, -1000]),
        ("-z/1/0", [1.5, 0.0, 2.95], [0, 0, -1000]),
    ];
    assert_eq!(told(&hall), expected);
    // On the ceiling at x = 1 it would be in the beam, if that were higher.
    let high = CELL.replace("position_m = [1, 0, 2.5]", "position_m = [1.5, 0, 2.9]");
    let entry = "surface = { object = \"hall\", spacing_m = 3, sides = [\"-z\"] }";
    let (found, _) = expand_in(&[&high], Stance::Facing, None, entry).unwrap();
    assert_eq!(told(&found), [("-z/0/0", [-1.5, 0.0, 2.95], [0, 0, -1000])]);
}

#[test]
fn a_mesh_is_read_and_turned_with_its_object() {
    // A quarter turn: what faces −y faces +x, and x goes along y.
    let fence = poses("surface = { object = \"fence\", spacing_m = 1 }");
    let expected = [("+x/0/0", [0.05, 1.5, 0.5], [1000, 0, 0]), ("+x/1/0", [0.05, 4.5, 0.5], [1000, 0, 0])];
    assert_eq!(told(&fence), expected);
    let towards =
        |x: i32| format!("surface = {{ object = \"fence\", spacing_m = 1, sides_towards_m = [{x}, 0, 0] }}");
    assert_eq!(poses(&towards(3)), fence);
    refused(&[CELL], None, &towards(-3), "surface: object \"fence\": has no side that faces the wanted way");
}

#[test]
fn a_link_has_poses_in_its_own_frame() {
    let (found, _) =
        expand_in(&[CELL], Stance::Facing, Some("hand"), "surface = { spacing_m = 0.5, sides = [\"-y\"] }")
            .unwrap();
    let expected =
        [("-y/0/0", [0.0, -0.1, 0.25], [0, -1000, 0]), ("-y/1/0", [0.0, -0.1, 0.75], [0, -1000, 0])];
    assert_eq!(told(&found), expected);
    let entry = "surface = { spacing_m = 0.5 }";
    refused(&[CELL], Some("hnad"), entry, "there is no link \"hnad\"; there are base, hand");
    let other = "surface = { object = \"beam\", spacing_m = 0.5 }";
    refused(
        &[CELL],
        Some("hand"),
        other,
        "surface.object = \"beam\": must be \"arm\", whose link carries the sensor",
    );
}

#[test]
fn a_heading_stands_in_for_a_side_that_has_none() {
    let entry = "surface = { object = \"post\", spacing_m = 1, sides = [\"+y\", \"+z\"] }";
    let upright = |entry: &str| expand_in(&[CELL], Stance::Upright, None, entry).unwrap().0;
    let top = ("+z/0/0", [-2.0, 0.0, 1.05], [1000, 0, 0]);
    assert_eq!(told(&upright(entry)), [("+y/0/0", [-2.0, 0.1, 0.5], [0, 1000, 0]), top]);
    let towards = upright(&format!("{entry}\nfacing = [0, -1, 0]"));
    assert_eq!(told(&towards)[1], ("+z/0/0", [-2.0, 0.0, 1.05], [0, -1000, 0]));
    // A camera that looked that way would look into the post.
    let camera = poses(&format!("{entry}\nfacing = [0, -1, 0]"));
    assert_eq!(told(&camera), [("+z/0/0", [-2.0, 0.0, 1.05], [0, -1000, 0])]);
}

#[test]
fn between_poses_of_a_flat_side_others_are_possible() {
    let entry = "surface = { object = \"hall\", spacing_m = 1.5, sides = [\"+y\", \"-z\"] }\n\
                 orientations_deg = [{}, { pan = 20 }]";
    let (candidates, extras) = expand_in(&[CELL], Stance::Facing, None, entry).unwrap();
    assert_eq!(extras.surface.unwrap().object, "hall");
    // 6 m × 3 m have 4 × 2 places, 6 m × 4 m have 4 × 2.
    let ranges: Vec<_> =
        extras.spreads.iter().map(|spread| (spread.candidates.clone(), spread.steps())).collect();
    assert_eq!(ranges, [(0..16, [1.5, 0.0, 1.5, 20.0, 0.0]), (16..32, [1.5, 1.5, 0.0, 20.0, 0.0])]);
    assert_eq!(candidates.len(), 32);
    let post = "surface = { object = \"post\", spacing_m = 0.5, sides = [\"+x\"] }";
    let (_, round) = expand_in(&[CELL], Stance::Facing, None, post).unwrap();
    assert_eq!(round.spreads[0].steps(), [0.0, 0.0, 0.5, 0.0, 0.0], "along it");
    // Askew, the steps are along no axis.
    let askew = CELL.replace("position_m = [1, 0, 2.5]", "position_m = [1, 0, 2.5]\nrpy_deg = [0, 0, 30]");
    let beam = "surface = { object = \"beam\", spacing_m = 0.5, sides = [\"-z\"] }";
    let (_, askew) = expand_in(&[&askew], Stance::Facing, None, beam).unwrap();
    assert_eq!(askew.spreads, []);
}

#[test]
fn wrong_entries_are_refused() {
    for (entry, expected) in [
        (
            "surface = { object = \"baem\", spacing_m = 1 }",
            "study.toml: poses \"g\".surface.object = \"baem\": must be an object of a scene: [\"arm\", \"beam\", \
             \"cart\", \"fence\", \"hall\", \"post\"]; did you mean \"beam\"?",
        ),
        ("surface = { spacing_m = 1 }", "name an object of a scene"),
        (
            "surface = { object = \"beam\", spacing_m = 0 }",
            "surface.spacing_m = 0: must be a length in metres from 0.001",
        ),
        (
            "surface = { object = \"beam\", spacing_m = 1, off_m = -1 }",
            "surface.off_m = -1: must be a length",
        ),
        ("surface = { object = \"operator\", spacing_m = 1 }", "object \"operator\": is a person"),
        (
            "surface = { object = \"cart\", spacing_m = 1 }",
            "moves from one snapshot of scene \"cell\" to another",
        ),
        ("surface = { object = \"arm\", spacing_m = 1 }", "or move with a link of a robot: name it in on"),
        ("surface = { object = \"beam\", spacing_m = 1, sides = [] }", "sides = [\"-z\"]"),
        (
            "surface = { object = \"beam\", spacing_m = 1, sides = [\"+y\"] }",
            "object \"beam\": its one place is inside of it or of another object",
        ),
        (
            "surface = { object = \"beam\", spacing_m = 1 }\nx_m = 1",
            "give one of: x_m, y_m and z_m (a lattice); surface",
        ),
        ("list = []\nsurface = { object = \"beam\", spacing_m = 1 }", "give one of"),
        ("surface = { object = \"hall\", spacing_m = 0.001 }", "widen spacing_m"),
    ] {
        refused(&[CELL], None, entry, expected);
    }
}

#[test]
fn a_surface_is_the_same_in_every_scene() {
    let entry = "surface = { object = \"beam\", spacing_m = 2, sides = [\"-z\"] }";
    let other = |from: &str, to: &str| CELL.replace(from, to);
    let without = "[[object]]\nname = \"floor\"\nplane = { size_m = [1, 1] }\n";
    let (found, _) = expand_in(&[without, CELL, CELL], Stance::Facing, None, entry).unwrap();
    assert_eq!(found, poses(entry), "a scene need not have it");
    let moved = other("position_m = [1, 0, 2.5]", "position_m = [1, 0, 2.4]");
    refused(&[CELL, &moved], None, entry, "object \"beam\": stands elsewhere in scene \"cell\" and in scene");
    let longer = other("[0.2, 4, 0.2]", "[0.2, 3, 0.2]");
    refused(&[CELL, &longer], None, entry, "object \"beam\": has another shape in scene");
    // What is in the way in one scene is in the way in all.
    let box_below = format!(
        "{CELL}[[object]]\nname = \"lamp\"\nbox = {{ size_m = [1, 1, 1] }}\nposition_m = [1, 1, 2]\n"
    );
    let (left, _) = expand_in(&[CELL, &box_below], Stance::Facing, None, entry).unwrap();
    assert_eq!(told(&left), [("-z/0/0", [1.0, -1.0, 2.35], [0, 0, -1000])]);
}
