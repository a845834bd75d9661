use std::path::Path;

use glam::{DQuat, DVec3};

use super::*;
use crate::objects::urdf::{load, parse};
use crate::source::Sources;

/// A link that is a small ball.
fn link(name: &str) -> String {
    format!("<link name='{name}'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>")
}

fn joint(name: &str, kind: &str, [parent, child]: [&str; 2], more: &str) -> String {
    format!(
        "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>{more}</joint>"
    )
}

fn model(parts: &[String]) -> RobotModel {
    parse(Path::new("arm.urdf"), &format!("<robot name='arm'>{}</robot>", parts.concat())).unwrap()
}

const TURN: &str = "<axis xyz='0 0 2'/><limit lower='-1.5708' upper='3.14159' effort='1' velocity='1'/>";
const SLIDE: &str = "<axis xyz='1 0 0'/><limit lower='0.1' upper='0.5' effort='1' velocity='1'/>";

/// Two arms in a plane, 1 m and 0.5 m long, on a post of 0.2 m; the second carries a slide along it.
fn planar() -> RobotModel {
    model(&[
        link("hand"),
        link("upper"),
        link("base"),
        link("lower"),
        joint("elbow", "revolute", ["upper", "lower"], &format!("<origin xyz='1 0 0'/>{TURN}")),
        joint("shoulder", "revolute", ["base", "upper"], &format!("<origin xyz='0 0 0.2'/>{TURN}")),
        joint("slide", "prismatic", ["lower", "hand"], &format!("<origin xyz='0.5 0 0'/>{SLIDE}")),
    ])
}

fn values(angles_deg: &[(&str, f64)], travels_m: &[(&str, f64)]) -> JointValues {
    let map = |pairs: &[(&str, f64)]| pairs.iter().map(|(name, v)| (name.to_string(), *v)).collect();
    JointValues { angles_deg: map(angles_deg), travels_m: map(travels_m) }
}

#[track_caller]
fn assert_at(model: &RobotModel, values: &JointValues, link: &str, expected: [f64; 3]) {
    let place = model.link_names().position(|name| name == link).unwrap();
    let found = model.pose(values).unwrap()[place].translation;
    assert!((found - DVec3::from(expected)).length() < 1e-9, "{link} is at {found}, not {expected:?}");
}

#[test]
fn a_planar_arm_stands_where_the_sums_of_its_angles_say() {
    let arm = planar();
    assert_eq!(arm.link_names().collect::<Vec<_>>(), ["base", "upper", "lower", "hand"]);
    let bent = values(&[("shoulder", 30.0), ("elbow", 60.0)], &[("slide", 0.25)]);
    // cos 30° = √3/2; the second arm points along y.
    let elbow = 3f64.sqrt() / 2.0;
    assert_at(&arm, &bent, "base", [0.0, 0.0, 0.0]);
    assert_at(&arm, &bent, "upper", [0.0, 0.0, 0.2]);
    assert_at(&arm, &bent, "lower", [elbow, 0.5, 0.2]);
    assert_at(&arm, &bent, "hand", [elbow, 0.5 + 0.75, 0.2]);
    assert_at(&arm, &values(&[("shoulder", -90.0)], &[("slide", 0.1)]), "hand", [0.0, -1.6, 0.2]);
}

#[test]
fn axes_may_point_anywhere() {
    // A third of a turn about (1, 1, 1) takes x to y, and y to z.
    let turn = about(DVec3::ONE / 3f64.sqrt(), 120f64.to_radians());
    for (from, to) in [(DVec3::X, DVec3::Y), (DVec3::Y, DVec3::Z), (DVec3::Z, DVec3::X)] {
        assert!((turn * from - to).length() < 1e-15, "{from}");
    }
    // Rolled by −90°, the joint's z is its parent's y, and turns x down.
    let more = "<origin xyz='0 0 1' rpy='-1.5707963267948966 0 0'/><axis xyz='0 0 1'/>";
    let tip = "<origin xyz='1 0 0'/>";
    let arm = model(&[
        link("base"),
        link("arm"),
        link("tip"),
        joint("wheel", "continuous", ["base", "arm"], more),
        joint("weld", "fixed", ["arm", "tip"], tip),
    ]);
    assert_at(&arm, &values(&[("wheel", 90.0)], &[]), "tip", [0.0, 0.0, 0.0]);
    assert_at(&arm, &values(&[("wheel", -90.0 - 3600.0)], &[]), "tip", [0.0, 0.0, 2.0]);
    for value in [f64::NAN, f64::INFINITY] {
        assert!(arm.pose(&values(&[("wheel", value)], &[])).is_err(), "{value}");
    }
}

#[track_caller]
fn assert_refused(model: &RobotModel, values: &JointValues, expected: &str) {
    assert_eq!(model.pose(values).unwrap_err().to_string(), expected);
}

#[test]
fn wrong_joint_values_say_what_would_be_right() {
    let arm = planar();
    let slide = [("slide", 0.2)];
    assert_refused(
        &arm,
        &values(&[("shoulder", 200.0)], &slide),
        "joints_deg.shoulder = 200: must be from -90.0002 to 179.9998 degrees, its limits in arm.urdf",
    );
    assert_refused(
        &arm,
        &values(&[], &[("slide", 0.51)]),
        "joints_m.slide = 0.51: must be from 0.1 to 0.5 metres, its limits in arm.urdf",
    );
    assert_refused(
        &arm,
        &values(&[], &[]),
        "no joints_m.slide: the joint cannot be at 0, its limits in arm.urdf are 0.1 to 0.5 metres; give it a value",
    );
    assert_refused(
        &arm,
        &values(&[("wrist", 1.0)], &slide),
        "joints_deg.wrist = 1: arm.urdf has no such joint; there are shoulder, elbow, slide",
    );
    assert_refused(
        &arm,
        &values(&[("slide", 1.0)], &[]),
        "joints_deg.slide = 1: slides: write its metres under joints_m",
    );
    assert_refused(
        &arm,
        &values(&[], &[("elbow", 1.0)]),
        "joints_m.elbow = 1: turns: write its degrees under joints_deg",
    );
    assert!(arm.pose(&values(&[("elbow", f64::NAN)], &slide)).is_err());
    // 180° passes a limit of 3.14159.
    assert!(arm.pose(&values(&[("elbow", 180.0)], &slide)).is_ok());
    assert!(arm.pose(&values(&[("elbow", 180.01)], &slide)).is_err());
    let stiff = model(&[link("a"), link("b"), joint("weld", "fixed", ["a", "b"], "")]);
    assert_refused(
        &stiff,
        &values(&[("weld", 0.0)], &[]),
        "joints_deg.weld = 0: is a fixed joint; take its value away",
    );
    assert_refused(
        &stiff,
        &values(&[("x", 0.0)], &[]),
        "joints_deg.x = 0: arm.urdf has no such joint; none of its joints move",
    );
}

#[test]
fn reach_is_the_longest_chain_from_where_the_robot_begins() {
    // 0.2 + 1 + 0.5 + 0.5 of travel.
    assert!((planar().reach_m() - 2.2).abs() < 1e-12);
    let far = |world: &str| {
        model(&[
            world.into(),
            link("base"),
            link("arm"),
            link("sign"),
            joint("weld", "fixed", ["world", "base"], "<origin xyz='0 0 5'/>"),
            joint("turn", "revolute", ["base", "arm"], &format!("<origin xyz='0 3 4'/>{TURN}")),
            joint("hook", "fixed", ["base", "sign"], "<origin xyz='1 0 0'/>"),
        ])
    };
    // An empty world is no part of the robot; one with a body is.
    let (empty, solid) = (far("<link name='world'/>"), far(&link("world")));
    assert_eq!((empty.reach_m(), solid.reach_m()), (5.0, 10.0));
    let pose = Pose { position_m: DVec3::X, rotation: DQuat::IDENTITY };
    let linkage = |model: &RobotModel| model.linkage(&model.pose(&JointValues::default()).unwrap(), &pose);
    assert_eq!(linkage(&empty).base_m, DVec3::new(1.0, 0.0, 5.0));
    assert_eq!(linkage(&solid).base_m, DVec3::X);
}

#[test]
fn links_follow_the_robot_into_the_world() {
    let arm = planar();
    let placed = arm.pose(&values(&[("shoulder", 90.0)], &[("slide", 0.5)])).unwrap();
    // A quarter turn about z, on top of the shoulder's.
    let world_from_root = Pose::from_rotation(
        DVec3::new(1.0, 2.0, 3.0),
        about(DVec3::Z, 90f64.to_radians()),
        RotationFrame::Link,
    );
    let linkage = arm.linkage(&placed, &world_from_root);
    let hand = linkage.link("hand").unwrap();
    assert!((hand.position_m - DVec3::new(-1.0, 2.0, 3.2)).length() < 1e-12, "{}", hand.position_m);
    assert!((hand.link() * DVec3::X + DVec3::X).length() < 1e-12);
    let what = linkage.link("tool").unwrap_err();
    assert_eq!(what.to_string(), "there is no link \"tool\"; there are base, upper, lower, hand");
}

/// The shipped arm.
fn ur10() -> RobotModel {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/paper/ur10.urdf");
    load(&path, &Default::default(), &Default::default(), &Sources::from_main(&path)).unwrap()
}

fn ur10_values(angles_deg: [f64; 6]) -> JointValues {
    let names = ["shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"];
    let named = names.iter().zip(angles_deg).map(|(name, angle)| (format!("{name}_joint"), angle));
    JointValues { angles_deg: named.collect(), ..JointValues::default() }
}

#[test]
fn the_ur10s_tool_is_where_its_lengths_say() {
    let arm = ur10();
    // Stretched along x: a2 + a3; beside it d4 + d6; d5 hangs down from d1.
    let stretched = ur10_values([0.0; 6]);
    assert_at(&arm, &stretched, "tool0", [0.612 + 0.5723, 0.1639 + 0.0922, 0.1273 - 0.1157]);
    assert_at(&arm, &stretched, "forearm_link", [0.612, 0.0, 0.1273]);
    // Stretched up, with d5 on top of d1 + a2 + a3.
    let upright = ur10_values([0.0, -90.0, 0.0, -90.0, 0.0, 0.0]);
    let z = 0.1273 + 0.612 + 0.5723 + 0.1157;
    assert_at(&arm, &upright, "tool0", [0.0, 0.1639 + 0.0922, z]);
    // The same turned by 90° about z.
    let turned = ur10_values([90.0, -90.0, 0.0, -90.0, 0.0, 77.0]);
    assert_at(&arm, &turned, "tool0", [-0.1639 - 0.0922, 0.0, z]);
    // Upper arm up, forearm forward, d5 forward, too (the three turns add up to −90°), the tool down.
    let reaching = ur10_values([0.0, -90.0, 90.0, -90.0, -90.0, 0.0]);
    assert_at(&arm, &reaching, "wrist_1_link", [0.5723, 0.1639, 0.1273 + 0.612]);
    assert_at(&arm, &reaching, "tool0", [0.5723 + 0.1157, 0.1639, 0.1273 + 0.612 - 0.0922]);
    let reach = 0.1273 + 0.612 + 0.5723f64.hypot(0.1639) + 0.1157 + 0.0922;
    assert!((arm.reach_m() - reach).abs() < 1e-12);
}

/// Rz(angle) Tz(d) Tx(a) Rx(alpha), written out as Denavit and Hartenberg's matrix.
fn dh(angle_deg: f64, d: f64, a: f64, alpha_deg: f64) -> DAffine3 {
    let (s, c) = angle_deg.to_radians().sin_cos();
    let (sa, ca) = alpha_deg.to_radians().sin_cos();
    DAffine3 {
        matrix3: DMat3::from_cols(
            DVec3::new(c, s, 0.0),
            DVec3::new(-s * ca, c * ca, sa),
            DVec3::new(s * sa, -c * sa, ca),
        ),
        translation: DVec3::new(a * c, a * s, d),
    }
}

#[test]
fn the_ur10_agrees_with_its_denavit_hartenberg_parameters_everywhere() {
    let arm = ur10();
    let tool = arm.link_names().position(|name| name == "tool0").unwrap();
    #[rustfmt::skip]
    let rows = [
        [0.1273, 0.0, 90.0], [0.0, -0.612, 0.0], [0.0, -0.5723, 0.0],
        [0.1639, 0.0, 90.0], [0.1157, 0.0, -90.0], [0.0922, 0.0, 0.0],
    ];
    // ROS turns the arm's own base by half a turn.
    let base = dh(180.0, 0.0, 0.0, 0.0);
    for angles in [
        [145.0, -90.0, 120.0, -30.0, 90.0, 0.0],
        [-310.0, 17.0, -179.0, 359.0, 33.0, -71.0],
        [12.0, -34.0, 56.0, -78.0, 91.0, -123.0],
    ] {
        let expected =
            rows.iter().zip(angles).fold(base, |t, ([d, a, alpha], angle)| t * dh(angle, *d, *a, *alpha));
        let found = arm.pose(&ur10_values(angles)).unwrap()[tool];
        assert!(found.abs_diff_eq(expected, 1e-12), "{angles:?}: {found} is not {expected}");
    }
}

#[test]
fn the_ur10_has_the_limits_of_the_real_one() {
    let arm = ur10();
    assert!(arm.pose(&ur10_values([360.0, -360.0, 180.0, 360.0, 360.0, -360.0])).is_ok());
    for joint in 0..6 {
        let mut angles = [0.0; 6];
        angles[joint] = if joint == 2 { 180.1 } else { -360.1 };
        assert!(arm.pose(&ur10_values(angles)).is_err(), "{joint}");
    }
}

/// A hand whose second finger goes where the first leads, and a wheel that turns as far as that in radians.
fn hand(mimic: &str, of_finger: &str) -> RobotModel {
    let limits = "<limit lower='0' upper='0.04' effort='1' velocity='1'/>";
    model(&[
        link("palm"),
        link("left"),
        link("right"),
        link("wheel"),
        joint("wheel", "continuous", ["palm", "wheel"], &format!("<axis xyz='0 0 1'/>{mimic}")),
        joint("right", "prismatic", ["palm", "right"], &format!("<axis xyz='0 -1 0'/>{limits}{of_finger}")),
        joint("left", "prismatic", ["palm", "left"], &format!("<axis xyz='0 1 0'/>{limits}")),
    ])
}

#[test]
fn joints_that_mimic_others_go_where_these_lead() {
    let chain = "<mimic joint='right' multiplier='100' offset='-1'/>";
    let hand_of = |of_finger: &str| hand(chain, of_finger);
    let arm = hand_of("<mimic joint='left'/>");
    let open = values(&[], &[("left", 0.03)]);
    assert_at(&arm, &open, "left", [0.0, 0.03, 0.0]);
    assert_at(&arm, &open, "right", [0.0, -0.03, 0.0]);
    // 100 × 0.03 − 1 radians.
    let wheel = arm.link_names().position(|name| name == "wheel").unwrap();
    let turned = arm.pose(&open).unwrap()[wheel].matrix3 * DVec3::X;
    assert!((turned - DVec3::new(2f64.cos(), 2f64.sin(), 0.0)).length() < 1e-12, "{turned}");
    let told = |model: &RobotModel, values: &JointValues| model.pose(values).unwrap_err().to_string();
    assert!(
        told(&arm, &values(&[], &[("right", 0.01)]))
            .contains("joints_m.right = 0.01: mimics \"left\": take its value away, and give that joint one")
    );
    // Joints that follow are none to be given values.
    let strange = told(&arm, &values(&[], &[("thumb", 0.01)]));
    assert!(strange.contains("has no such joint; there are left"), "{strange}");
    assert!(!strange.contains("right"), "{strange}");
    let twice = told(&hand_of("<mimic joint='left' multiplier='2'/>"), &open);
    assert!(twice.contains("joint \"right\" mimics \"left\", and is at 0.06 metres then"), "{twice}");
    assert!(twice.contains("0 to 0.04 metres") && twice.contains("give \"left\" another value"), "{twice}");
}

#[test]
fn mimics_lead_somewhere() {
    let refused = |mimic: &str, of_finger: &str| {
        let limits = "<axis xyz='0 1 0'/><limit lower='0' upper='0.04' effort='1' velocity='1'/>";
        let text = format!(
            "<robot name='hand'>{}{}{}{}{}{}{}</robot>",
            link("palm"),
            link("left"),
            link("right"),
            link("lid"),
            joint("left", "prismatic", ["palm", "left"], &format!("{limits}{mimic}")),
            joint("right", "prismatic", ["palm", "right"], &format!("{limits}{of_finger}")),
            joint("lid", "fixed", ["palm", "lid"], "<mimic joint='nothing'/>"),
        );
        parse(Path::new("hand.urdf"), &text).map(drop).map_err(|error| error.to_string())
    };
    assert_eq!(refused("", "<mimic joint='left'/>"), Ok(()), "a fixed joint has nothing to mimic with");
    for (mimic, of_finger, expected) in [
        ("", "<mimic joint='thumb'/>", "joint \"right\": mimics \"thumb\", which is no joint of the file"),
        ("", "<mimic joint='lid'/>", "joint \"right\": mimics \"lid\", which is fixed"),
        ("<mimic joint='right'/>", "<mimic joint='left'/>", "mimics joints that mimic each other in a ring"),
        ("", "<mimic joint='right'/>", "joint \"right\": mimics joints that mimic each other in a ring"),
        (
            "",
            "<mimic joint='left' multiplier='inf'/>",
            "<mimic multiplier = inf offset = 0>: must be numbers",
        ),
    ] {
        let told = refused(mimic, of_finger).unwrap_err();
        assert!(told.contains(expected), "no {expected:?} in {told:?}");
    }
}
