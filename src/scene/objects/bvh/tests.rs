//! A small skeleton whose poses are worked by hand, and compared with a chain of quaternions.

use glam::DQuat;

use super::*;
use crate::objects::keypoints::{ANKLES, EARS, ELBOWS, HIPS, JOINTS, KNEES, NOSE, SHOULDERS, WRISTS};

/// Bones by name and parent, with where each begins in its parent's frame, in centimetres: a person who stands with
/// hanging arms, y up, the left at +x, facing +z.
const BODY: [(&str, &str, [f64; 3]); 16] = [
    ("Hips", "", [0., 0., 0.]),
    ("Spine", "Hips", [0., 20., 0.]),
    ("Neck", "Spine", [0., 35., 0.]),
    ("Head", "Neck", [0., 10., 0.]),
    ("LeftShoulder", "Spine", [5., 30., 0.]),
    ("LeftArm", "LeftShoulder", [13., 0., 0.]),
    ("LeftForeArm", "LeftArm", [0., -30., 0.]),
    ("LeftHand", "LeftForeArm", [0., -26., 0.]),
    ("RightArm", "Spine", [-18., 30., 0.]),
    ("RightForeArm", "RightArm", [0., -30., 0.]),
    ("RightHand", "RightForeArm", [0., -26., 0.]),
    ("LeftUpLeg", "Hips", [10., 0., 0.]),
    ("LeftLeg", "LeftUpLeg", [0., -42., 0.]),
    ("LeftFoot", "LeftLeg", [0., -41., 0.]),
    ("RightUpLeg", "Hips", [-10., 0., 0.]),
    ("RightLeg", "RightUpLeg", [0., -42., 0.]),
];

/// The text of a file with these names of bones, and frames of a number for each channel: six of the hips, three
/// (Zrotation Xrotation Yrotation) of all others, in the order of the file, in which children follow their parent.
fn file(named: &dyn Fn(&str) -> String, frames: &[Vec<f64>]) -> String {
    fn bone(of: &str, depth: usize, named: &dyn Fn(&str) -> String, text: &mut String) {
        for (name, parent, [x, y, z]) in BODY.iter().chain([&("RightFoot", "RightLeg", [0., -41., 0.])]) {
            if *parent != of {
                continue;
            }
            let pad = "\t".repeat(depth);
            let (word, channels) = match depth {
                0 => ("ROOT", "6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"),
                _ => ("JOINT", "3 Zrotation Xrotation Yrotation"),
            };
            *text += &format!(
                "{pad}{word} {}\n{pad}{{\n{pad}\tOFFSET {x} {y} {z}\n{pad}\tCHANNELS {channels}\n",
                named(name)
            );
            bone(name, depth + 1, named, text);
            if ["Head", "LeftHand", "RightHand", "LeftFoot", "RightFoot"].contains(name) {
                *text += &format!("{pad}\tEnd Site\n{pad}\t{{\n{pad}\t\tOFFSET 0 -8 0\n{pad}\t}}\n");
            }
            *text += &format!("{pad}}}\n");
        }
    }
    let mut text = String::from("HIERARCHY\n");
    bone("", 0, named, &mut text);
    text += &format!("MOTION\nFrames: {}\nFrame Time: 0.04\n", frames.len());
    for frame in frames {
        text += &(frame.iter().map(f64::to_string).collect::<Vec<_>>().join(" ") + "\n");
    }
    text
}

/// The bones in the order of the file.
fn order() -> Vec<(&'static str, &'static str, [f64; 3])> {
    let all = [&BODY[..], &[("RightFoot", "RightLeg", [0., -41., 0.])]].concat();
    let mut order: Vec<(&str, &str, [f64; 3])> = Vec::new();
    let mut open = vec![all[0]];
    while let Some(bone) = open.pop() {
        order.push(bone);
        open.extend(all.iter().filter(|(_, parent, _)| *parent == bone.0).rev());
    }
    order
}

/// A frame in which the hips are 90 cm high and these bones are turned, in degrees about z, x and y.
fn frame(turned: &[(&str, [f64; 3])]) -> Vec<f64> {
    let turn = |name: &str| turned.iter().find(|(of, _)| *of == name).map_or([0.0; 3], |(_, turn)| *turn);
    [0., 90., 0.].into_iter().chain(order().iter().flat_map(|(name, ..)| turn(name))).collect()
}

fn motion() -> MotionFile {
    let path = "walk.bvh".into();
    MotionFile { path, scale: 0.01, up: Up::Y, bones: BTreeMap::new(), time_s: 0.0, centred: false }
}

fn read(text: &str) -> Result<Bvh, String> {
    Bvh::parse("walk.bvh".as_ref(), text.into()).map_err(|e| e.to_string())
}

fn same(name: &str) -> String {
    name.into()
}

#[track_caller]
fn assert_near(joints: &Keypoints, joint: usize, expected: [f64; 3]) {
    let found = joints[joint].unwrap();
    let off = (found - DVec3::from_array(expected)).length();
    assert!(off < 1e-9, "{} at {found}, expected {expected:?}", JOINTS[joint]);
}

#[test]
fn a_person_stands_as_the_skeleton_is_drawn() {
    let bvh = read(&file(&same, &[frame(&[])])).unwrap();
    let joints = bvh.keypoints(&motion()).unwrap();
    // y up becomes z up, +z becomes −y: who faces +z faces −y, the left is +x.
    assert_near(&joints, HIPS[0], [0.1, 0.0, 0.9]);
    assert_near(&joints, ANKLES[1], [-0.1, 0.0, 0.07]);
    assert_near(&joints, SHOULDERS[0], [0.18, 0.0, 1.4]);
    assert_near(&joints, WRISTS[1], [-0.18, 0.0, 0.84]);
    // The head begins at 1.55 m.
    assert_near(&joints, NOSE, [0.0, -0.1, 1.6]);
    assert_near(&joints, EARS[0], [0.07, 0.0, 1.61]);
    assert_eq!(joints.iter().flatten().count(), 17);
    let z_up = bvh.keypoints(&MotionFile { up: Up::Z, ..motion() }).unwrap();
    assert_near(&z_up, SHOULDERS[0], [0.18, 1.4, 0.0]);
    let inches = bvh.keypoints(&MotionFile { scale: 0.0254, ..motion() }).unwrap();
    assert_near(&inches, HIPS[0], [0.254, 0.0, 90.0 * 0.0254]);
}

#[test]
fn bones_turn_in_the_order_of_their_channels() {
    // The left arm is lifted to the side, then the forearm bends forward: in its own frame, which the arm has turned.
    let turned = [("LeftArm", [90., 0., 0.]), ("LeftForeArm", [0., -90., 0.])];
    let joints = read(&file(&same, &[frame(&turned)])).unwrap().keypoints(&motion()).unwrap();
    assert_near(&joints, ELBOWS[0], [0.18 + 0.3, 0.0, 1.4]);
    // Without the bend the hand is further to the side; about the arm's x, which points up now, −90° takes it to +z.
    assert_near(&joints, WRISTS[0], [0.48, -0.26, 1.4]);
    // Two turns of one bone: z first in the product, so that x turns about an axis that z has turned.
    let turned = [("LeftUpLeg", [90., -90., 0.])];
    let joints = read(&file(&same, &[frame(&turned)])).unwrap().keypoints(&motion()).unwrap();
    assert_near(&joints, KNEES[0], [0.1, -0.42, 0.9]);
    // A head that is turned to the left by 90° about y looks along +x.
    let joints =
        read(&file(&same, &[frame(&[("Neck", [0., 0., 90.])])])).unwrap().keypoints(&motion()).unwrap();
    assert_near(&joints, NOSE, [0.1, 0.0, 1.6]);
    assert_near(&joints, EARS[0], [0.0, 0.07, 1.61]);
}

/// Against quaternions, which the reader does not use, at random.
#[test]
fn a_chain_of_quaternions_agrees() {
    use rand::{RngExt, SeedableRng};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
    let frames: Vec<Vec<f64>> = (0..20)
        .map(|_| (0..6 + 3 * (order().len() - 1)).map(|_| random.random_range(-180.0..180.0)).collect())
        .collect();
    let bvh = read(&file(&same, &frames)).unwrap();
    for (number, frame) in frames.iter().enumerate() {
        let time_s = number as f64 * 0.04;
        let joints = bvh.keypoints(&MotionFile { time_s, ..motion() }).unwrap();
        let mut placed: BTreeMap<&str, (DVec3, DQuat)> = BTreeMap::new();
        let mut values = frame[3..].chunks(3);
        for (name, parent, offset) in order() {
            let [z, x, y] = values.next().unwrap() else { panic!("three") };
            let turn = DQuat::from_rotation_z(z.to_radians())
                * DQuat::from_rotation_x(x.to_radians())
                * DQuat::from_rotation_y(y.to_radians());
            let own = match placed.get(parent) {
                Some((place, before)) => (*place + *before * DVec3::from_array(offset), *before * turn),
                None => (DVec3::from_slice(&frame[..3]), turn),
            };
            placed.insert(name, own);
        }
        let bones = [
            ("LeftHand", WRISTS[0]),
            ("RightHand", WRISTS[1]),
            ("LeftFoot", ANKLES[0]),
            ("RightFoot", ANKLES[1]),
        ];
        for (bone, joint) in bones.into_iter().chain([("LeftArm", SHOULDERS[0]), ("RightLeg", KNEES[1])]) {
            let at = placed[bone].0;
            assert_near(&joints, joint, [0.01 * at.x, -0.01 * at.z, 0.01 * at.y]);
        }
        let (head, turn) = placed["Head"];
        let nose = 0.01 * head + turn * DVec3::new(0.0, 0.05, 0.1);
        assert_near(&joints, NOSE, [nose.x, -nose.z, nose.y]);
    }
}

#[test]
fn the_nearest_frame_is_taken_and_the_ends_are_held() {
    let at = |x: f64| [vec![x], frame(&[])[1..].to_vec()].concat();
    let bvh = read(&file(&same, &[at(0.), at(1.), at(2.)])).unwrap();
    assert_eq!(bvh.span_s(), [0.0, 0.08]);
    for (time_s, frame) in
        [(-1.0, 0.0), (0.0, 0.0), (0.019, 0.0), (0.021, 1.0), (0.04, 1.0), (0.07, 2.0), (1e9, 2.0)]
    {
        let joints = bvh.keypoints(&MotionFile { time_s, ..motion() }).unwrap();
        assert_near(&joints, HIPS[0], [0.1 + 0.01 * frame, 0.0, 0.9]);
    }
    // One pose often has no time.
    let pose = file(&same, &[frame(&[])]).replace("Frame Time: 0.04", "Frame Time: 0");
    assert_eq!(read(&pose).unwrap().span_s(), [0.0, 0.0]);
    assert_near(
        &read(&pose).unwrap().keypoints(&MotionFile { time_s: 2.0, ..motion() }).unwrap(),
        HIPS[0],
        [0.1, 0.0, 0.9],
    );
}

#[test]
fn who_is_centred_stands_above_the_origin_and_faces_x() {
    // At (3, 7) and turned by 70° about the vertical.
    let mut elsewhere = frame(&[("Hips", [0., 0., 70.]), ("LeftArm", [20., 30., 40.])]);
    (elsewhere[0], elsewhere[2]) = (300., -700.);
    let bvh = read(&file(&same, &[elsewhere, frame(&[("LeftArm", [20., 30., 40.])])])).unwrap();
    let joints = |time_s, centred| bvh.keypoints(&MotionFile { time_s, centred, ..motion() }).unwrap();
    assert_near(
        &joints(0.0, false),
        NOSE,
        [3.0 + 0.1 * libm::sin(70f64.to_radians()), 7.0 - 0.1 * libm::cos(70f64.to_radians()), 1.6],
    );
    let centred = joints(0.0, true);
    assert_near(&centred, NOSE, [0.1, 0.0, 1.6]);
    assert_near(&centred, HIPS[0], [0.0, 0.1, 0.9]);
    // The same person, wherever they stood.
    let other = joints(0.04, true);
    for joint in 0..17 {
        assert_near(&centred, joint, other[joint].unwrap().to_array());
    }
}

#[test]
fn bones_are_known_by_their_usual_names() {
    let expected = read(&file(&same, &[frame(&[])])).unwrap().keypoints(&motion()).unwrap();
    let mixamo = |name: &str| format!("mixamorig:{name}");
    let mixamo_7 = |name: &str| format!("mixamorig7_{name}");
    let renamed = |pairs: &'static [(&'static str, &'static str)]| {
        move |name: &str| {
            pairs.iter().find(|(from, _)| *from == name).map_or(format!("my {name}"), |(_, to)| (*to).into())
        }
    };
    let biovision = renamed(&[
        ("LeftShoulder", "LeftCollar"),
        ("LeftArm", "LeftShoulder"),
        ("LeftForeArm", "LeftElbow"),
        ("LeftHand", "LeftWrist"),
        ("RightArm", "RightShoulder"),
        ("RightForeArm", "RightElbow"),
        ("RightHand", "RightWrist"),
        ("LeftUpLeg", "LeftHip"),
        ("LeftLeg", "LeftKnee"),
        ("LeftFoot", "LeftAnkle"),
        ("RightUpLeg", "RightHip"),
        ("RightLeg", "RightKnee"),
        ("RightFoot", "RightAnkle"),
        ("Head", "Head"),
    ]);
    let unreal = renamed(&[
        ("LeftShoulder", "clavicle_l"),
        ("LeftArm", "upperarm_l"),
        ("LeftForeArm", "lowerarm_l"),
        ("LeftHand", "hand_l"),
        ("RightArm", "upperarm_r"),
        ("RightForeArm", "lowerarm_r"),
        ("RightHand", "hand_r"),
        ("LeftUpLeg", "thigh_l"),
        ("LeftLeg", "calf_l"),
        ("LeftFoot", "foot_l"),
        ("RightUpLeg", "thigh_r"),
        ("RightLeg", "calf_r"),
        ("RightFoot", "foot_r"),
        ("Head", "head"),
    ]);
    let biped = renamed(&[
        ("LeftShoulder", "Bip01 L Clavicle"),
        ("LeftArm", "Bip01 L UpperArm"),
        ("LeftForeArm", "Bip01 L Forearm"),
        ("LeftHand", "Bip01 L Hand"),
        ("RightArm", "Bip01 R UpperArm"),
        ("RightForeArm", "Bip01 R Forearm"),
        ("RightHand", "Bip01 R Hand"),
        ("LeftUpLeg", "Bip01 L Thigh"),
        ("LeftLeg", "Bip01 L Calf"),
        ("LeftFoot", "Bip01 L Foot"),
        ("RightUpLeg", "Bip01 R Thigh"),
        ("RightLeg", "Bip01 R Calf"),
        ("RightFoot", "Bip01 R Foot"),
        ("Head", "Bip01 Head"),
    ]);
    let all: [&dyn Fn(&str) -> String; 5] = [&mixamo, &mixamo_7, &biovision, &unreal, &biped];
    for named in all {
        let found = read(&file(named, &[frame(&[])])).unwrap().keypoints(&motion()).unwrap();
        assert_eq!(found, expected, "{}", named("LeftArm"));
    }
    // Others are named; what is named goes before what is usual.
    let own = |name: &str| if name == "LeftHand" { "Pfote".into() } else { same(name) };
    let bvh = read(&file(&own, &[frame(&[])])).unwrap();
    let with = |bones: &[(&str, &str)]| {
        let bones = bones.iter().map(|(joint, bone)| ((*joint).into(), (*bone).into())).collect();
        bvh.keypoints(&MotionFile { bones, ..motion() }).map_err(|e| e.to_string())
    };
    let error = with(&[]).unwrap_err();
    assert!(
        error.contains("walk.bvh: none of its bones has a usual name of the one at left_wrist: name it"),
        "{error}"
    );
    assert!(error.contains("there are Hips, Spine, Neck"), "{error}");
    assert_eq!(with(&[("left_wrist", "Pfote")]).unwrap(), expected);
    let without = with(&[
        ("left_wrist", ""),
        ("head", ""),
        ("nose", "Neck"),
        ("right_elbow", "RightHand"),
        ("right_wrist", ""),
    ])
    .unwrap();
    assert_eq!((without[WRISTS[0]], without[WRISTS[1]], without[EARS[0]]), (None, None, None));
    assert_near(&without, NOSE, [0.0, 0.0, 1.45]);
    assert_near(&without, ELBOWS[1], [-0.18, 0.0, 0.84]);
    let error = with(&[("left_wrist", "pfote")]).unwrap_err();
    assert!(
        error.contains("walk.bvh: bones.left_wrist = \"pfote\": no bone has that name; there are"),
        "{error}"
    );
}

/// Skeletons with a bone at the joint and one beyond it, both of which others use for that joint.
#[test]
fn each_joint_has_the_bone_of_its_own() {
    let renamed = |pairs: &'static [(&'static str, &'static str)]| {
        move |name: &str| {
            pairs.iter().find(|(from, _)| *from == name).map_or(name.to_string(), |(_, to)| (*to).into())
        }
    };
    let choose = |named: &dyn Fn(&str) -> String, bones: &[(&str, &str)]| {
        let bones = bones.iter().map(|(joint, bone)| ((*joint).into(), (*bone).into())).collect();
        read(&file(named, &[frame(&[])]))
            .unwrap()
            .keypoints(&MotionFile { bones, ..motion() })
            .map_err(|e| e.to_string())
    };
    // Knees above, ankles and feet below: what is called a foot is not the ankle.
    let with_feet = renamed(&[("LeftUpLeg", "L_Hip"), ("LeftLeg", "L_Ankle"), ("LeftFoot", "L_Foot")]);
    let joints = choose(&with_feet, &[("left_knee", "")]).unwrap();
    assert_near(&joints, ANKLES[0], [0.1, 0.0, 0.48]);
    let with_hands = renamed(&[("LeftForeArm", "left_wrist"), ("LeftHand", "left_hand")]);
    assert_near(&choose(&with_hands, &[("left_elbow", "")]).unwrap(), WRISTS[0], [0.18, 0.0, 1.1]);
    // A bone that is the hip is not the knee, too, whatever its name is.
    let legs = renamed(&[("LeftUpLeg", "Left leg"), ("LeftLeg", "Left shin")]);
    assert_near(&choose(&legs, &[("left_hip", "Left leg")]).unwrap(), KNEES[0], [0.1, 0.0, 0.48]);
    let twice = choose(&same, &[("left_hip", "LeftUpLeg"), ("left_knee", "LeftUpLeg")]).unwrap_err();
    assert!(twice.contains("bones.left_knee = \"LeftUpLeg\": is the bone of left_hip, too"), "{twice}");
    let none_left = choose(&same, &[("left_hip", "LeftLeg")]).unwrap_err();
    assert!(none_left.contains("usual name of the one at left_knee"), "{none_left}");
    // A handle for animators that is called like a joint hangs on something else.
    let handle = renamed(&[("Neck", "LeftFoot"), ("LeftFoot", "Foot_L")]);
    assert_near(&choose(&handle, &[]).unwrap(), ANKLES[0], [0.1, 0.0, 0.07]);
}

#[test]
fn lines_behind_the_frames_are_not_read() {
    let two = file(&same, &[frame(&[]), frame(&[("LeftUpLeg", [0.0, 90.0, 0.0])])]);
    let one = read(&two.replacen("Frames: 2", "Frames: 1", 1)).unwrap();
    assert_eq!((one.span_s(), one.motion.behind), ([0.0, 0.0], 1));
    assert_near(&one.keypoints(&MotionFile { time_s: 9.0, ..motion() }).unwrap(), KNEES[0], [0.1, 0.0, 0.48]);
}

#[test]
fn what_is_wrong_is_named() {
    let good = file(&same, &[frame(&[]), frame(&[])]);
    let refused = |text: &str, expected: &str| {
        let read = read(text).and_then(|bvh| bvh.keypoints(&motion()).map_err(|e| e.to_string()));
        let error = read.expect_err(expected);
        assert!(error.contains(expected), "{error:?} lacks {expected:?}");
    };
    let changed = |from: &str, to: &str, expected: &str| {
        assert!(good.contains(from), "{from}");
        refused(&good.replacen(from, to, 1), expected);
    };
    refused("", "ends before MOTION");
    refused("MOTION\n", "line 1: must begin with HIERARCHY");
    refused("solid part\n", "line 1: must begin with HIERARCHY: is it a BVH file?");
    refused(&good[..good.find("MOTION").unwrap()], "ends before MOTION");
    changed("OFFSET 0 20 0", "OFFSET 0 2o 0", "line 8: OFFSET = 0 2o 0: must be three numbers");
    changed("OFFSET 0 20 0", "OFFSET 0 20", "must be three numbers");
    changed("CHANNELS 3", "CHANNELS 4", "CHANNELS = 4 Zrotation Xrotation Yrotation: must be a count");
    changed("Yrotation", "Wrotation", "must be a count and as many of");
    changed("JOINT Spine", "ROOT Spine", "a JOINT must be inside of a ROOT");
    changed("JOINT Neck", "JOINT Spine", "JOINT \"Spine\": must have a name of its own");
    changed("JOINT Neck", "JOINT", "must have a name of its own");
    changed("JOINT Neck", "JOINED Neck", "JOINED where one of HIERARCHY, ROOT, JOINT");
    changed("\t\tEnd Site", "", "a { that belongs to no bone");
    changed("MOTION", "}\nMOTION", "a } too many");
    changed("MOTION", "ROOT Other\n{\n}\nMOTION", "a second ROOT: one person a file");
    changed("MOTION", "OFFSET 0 0 0\nMOTION", "an OFFSET outside of all bones");
    changed("MOTION", "CHANNELS 0\nMOTION", "CHANNELS outside of all bones");
    changed("Frames: 2", "Frames: 0", "Frames = 0: must be 1 or more");
    changed("Frames: 2", "Frames: 3", "has 2 frames and declares 3: each is a line");
    changed("Frames: 2", "Frame: 2", "lacks `Frames:` behind MOTION");
    changed("Frame Time: 0.04", "Frame Time: 0", "Frame Time = 0: must be seconds from");
    changed("Frame Time: 0.04", "Frame Time: nan", "Frame Time = nan: must be seconds from");
    changed("0.04\n0 90", "0.04\n0 nan", "frame 0 is no line of 54 numbers");
    changed("0.04\n0 90", "0.04\n90", "frame 0 is no line of 54 numbers");
    changed("0.04\n0 90", "0.04\n0 900000", "must be within 1000 m of the origin: is its unit right?");
    changed("OFFSET -10 0 0", "OFFSET 10 0 0", "its left and its right hip are on one spot");
    for length in 0..good.len() {
        let _ = read(&good[..length]).map(|bvh| bvh.keypoints(&motion()));
    }
}
