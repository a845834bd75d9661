//! Tables that are right, in each layout, and every way in which they can be wrong.

use super::*;
use crate::objects::mannequin::require_body;
use crate::objects::mannequin::tests::standing;

fn coco(text: &str) -> Result<Keypoints, Issue> {
    parse(text, JointLayout::Coco17)
}

fn rows(named: bool) -> Vec<String> {
    (standing().iter().zip(JOINTS))
        .map(|(p, joint)| {
            let p = p.unwrap();
            let name = if named { format!("{joint}, ") } else { String::new() };
            format!("{name}{},{}, {}", p.x, p.y, p.z)
        })
        .collect()
}

#[test]
fn rows_with_names_and_without_are_read() {
    assert_eq!(coco(&rows(false).join("\n")).unwrap(), standing());
    let text = format!("# by hand\njoint,x_m,y_m,z_m\r\n{}\n\n", rows(true).join("\n# next\n"));
    assert_eq!(coco(&text).unwrap(), standing());
    let unknown =
        [(true, "left_wrist,,,"), (false, ",,"), (false, "nan,NaN,nan"), (true, "left_wrist,nan,,nan")];
    for (named, empty) in unknown {
        let mut rows = rows(named);
        rows[9] = empty.into();
        let mut expected = standing();
        expected[9] = None;
        assert_eq!(coco(&rows.join("\n")).unwrap(), expected);
    }
}

#[test]
fn what_is_seen_with_no_confidence_is_unknown() {
    let mut expected = standing();
    expected[9] = None;
    for named in [false, true] {
        let with = |(joint, row): (usize, String)| format!("{row},{}", if joint == 9 { 0.0 } else { 0.2 });
        let header = if named { "joint,x_m,y_m,z_m,confidence" } else { "x_m,y_m,z_m,confidence" };
        let rows: Vec<String> = rows(named).into_iter().enumerate().map(with).collect();
        assert_eq!(coco(&format!("{header}\n{}", rows.join("\n"))).unwrap(), expected);
        assert_eq!(coco(&rows.join("\n")).unwrap(), expected, "without the header");
    }
}

#[test]
fn numbers_that_fill_gaps_are_told() {
    let told = |changes: &[(usize, &str)]| {
        let mut rows = rows(false);
        changes.iter().for_each(|(row, text)| rows[*row] = (*text).into());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("person.csv");
        std::fs::write(&path, rows.join("\n")).unwrap();
        let sources = Sources::from_main(&path);
        KeypointFile { path, layout: JointLayout::Coco17 }.read(&sources).map(|_| sources.take_remarks())
    };
    assert_eq!(told(&[]).unwrap(), [""; 0]);
    assert_eq!(
        told(&[(1, "0,0,0"), (9, "nan,nan,nan"), (10, "-nan(ind),1.#QNAN,")]).unwrap(),
        [""; 0],
        "faces and gaps"
    );
    let remarks = told(&[(9, "0,0,0"), (16, "0.0,-0,0")]).unwrap();
    assert!(
        remarks.len() == 1
            && remarks[0].contains("left_wrist and right_ankle at exactly 0, 0, 0: leave the cells"),
        "{remarks:?}"
    );
    let remarks = told(&[(9, "-1,-1,-1"), (16, "-1,-1,-1")]).unwrap();
    assert!(
        remarks.len() == 1 && remarks[0].contains("left_wrist and right_ankle at exactly -1, -1, -1"),
        "{remarks:?}"
    );
    let zeros: Vec<(usize, &str)> = (0..17).map(|row| (row, "0,0,0")).collect();
    let error = told(&zeros).unwrap_err().to_string();
    assert!(error.contains("all of its joints are at [0, 0, 0]: give each its own place"), "{error}");
    for first in [0, 1] {
        let counted = rows(false)
            .iter()
            .enumerate()
            .map(|(row, text)| (row, format!("{},{text}", row + first)))
            .collect::<Vec<_>>();
        let counted: Vec<(usize, &str)> = counted.iter().map(|(row, text)| (*row, text.as_str())).collect();
        let error = told(&counted).unwrap_err().to_string();
        assert!(
            error.contains("person.csv: x_m is the number of the row in each row: remove the column"),
            "{error}"
        );
        for unknown in [",,,", "4,,,"] {
            let mut gap = counted.clone();
            gap[4].1 = unknown;
            let error = told(&gap).unwrap_err().to_string();
            assert!(
                error.contains("x_m is the number of the row") && error.contains(": remove the column"),
                "{error}"
            );
        }
    }
}

#[test]
fn halpe_begins_with_cocos() {
    let mut rows = rows(true);
    rows.extend(JointLayout::Halpe26.joints()[17..].iter().map(|joint| format!("{joint},1,2,3")));
    let text = rows.join("\n");
    assert_eq!(parse(&text, JointLayout::Halpe26).unwrap(), standing());
    let error = coco(&text).unwrap_err().to_string();
    assert_eq!(error, "line 18: more than 17 joints: one row for each joint of layout \"coco-17\"");
    let error = parse(&rows[..17].join("\n"), JointLayout::Halpe26).unwrap_err().to_string();
    assert!(error.starts_with("has 17 joints: layout \"halpe-26\" has 26"), "{error}");
}

/// Somebody of SMPL who looks straight ahead along x: each joint at a place of its own, the head 30° ahead of the neck.
fn smpl() -> Vec<String> {
    let sin30 = 0.5;
    let cos30 = 3f64.sqrt() / 2.0;
    let place = |(number, joint): (usize, &&str)| match *joint {
        "neck" => format!("{joint},0.2,0.3,1.4"),
        "head" => format!("{joint},{},0.3,{}", 0.2 + 0.1 * sin30, 1.4 + 0.1 * cos30),
        "left_shoulder" => format!("{joint},0.2,0.5,1.4"),
        "right_shoulder" => format!("{joint},0.2,0.1,1.4"),
        _ => format!("{joint},{number},{},{}", 2 * number, 3 * number),
    };
    JointLayout::Smpl24.joints().iter().enumerate().map(place).collect()
}

#[test]
fn smpl_gives_limbs_and_a_face_by_its_head() {
    let rows = smpl();
    let joints = parse(&rows.join("\n"), JointLayout::Smpl24).unwrap();
    // The numbers of these joints are those of the model.
    for (joint, number) in
        [(HIPS[0], 1), (HIPS[1], 2), (KNEES[0], 4), (KNEES[1], 5), (ANKLES[0], 7), (ANKLES[1], 8)]
            .into_iter()
            .chain([(ELBOWS[0], 18), (ELBOWS[1], 19), (WRISTS[0], 20), (WRISTS[1], 21)])
    {
        let expected = DVec3::new(1.0, 2.0, 3.0) * f64::from(number);
        assert_eq!(joints[joint], Some(expected), "{}", JOINTS[joint]);
    }
    let (x, z) = (0.25, 1.4 + 0.05 * 3f64.sqrt());
    let expected = [
        [x + 0.1, 0.3, z + 0.05],
        [x + 0.08, 0.33, z + 0.08],
        [x + 0.08, 0.27, z + 0.08],
        [x, 0.37, z + 0.06],
        [x, 0.23, z + 0.06],
    ];
    for (joint, expected) in expected.into_iter().enumerate() {
        let off = (joints[joint].unwrap() - DVec3::from_array(expected)).length();
        assert!(off < 1e-12, "{} at {:?}, expected {expected:?}", JOINTS[joint], joints[joint]);
    }
    // What the face is made from must be known.
    for lost in [12, 15, 16] {
        let mut rows = rows.clone();
        rows[lost] = format!("{},,,", JointLayout::Smpl24.joints()[lost]);
        let joints = parse(&rows.join("\n"), JointLayout::Smpl24).unwrap();
        assert_eq!(joints[..5], [None; 5], "without {}", JointLayout::Smpl24.joints()[lost]);
        assert!(joints[HIPS[0]].is_some());
    }
    let mut wrong = rows;
    wrong.swap(1, 2);
    let error = parse(&wrong.join("\n"), JointLayout::Smpl24).unwrap_err().to_string();
    assert!(
        error.contains("joint = right_hip: must be left_hip (the order of layout \"smpl-24\")"),
        "{error}"
    );
}

#[track_caller]
fn assert_refused(text: &str, expected: &str) {
    let what = coco(text).expect_err(expected);
    assert!(what.to_string().contains(expected), "{what:?} lacks {expected:?}");
}

#[test]
fn what_is_wrong_is_named() {
    let with_row = |row: usize, text: &str| {
        let mut rows = rows(true);
        rows[row] = text.into();
        rows.join("\n")
    };
    assert_refused(&with_row(2, "left_eye,0,0,0"), "line 3 (right_eye): joint = left_eye: must be right_eye");
    assert_refused(&with_row(2, "right_eye,0,0"), "line 3 (right_eye): x_m = right_eye");
    assert_refused(&with_row(2, "right_eye,0,0,0,1,0"), "must be x_m,y_m,z_m, with the joint's name before");
    assert_refused(&with_row(2, "0,0"), "must be x_m,y_m,z_m, with the joint's name before");
    for bad in ["-0.1", "nan", "sure"] {
        assert_refused(
            &with_row(2, &format!("right_eye,0,0,0,{bad}")),
            &format!("confidence = {bad}: must be 0 (unknown)"),
        );
    }
    assert_refused(&with_row(16, "right_ankle,0,,1"), "line 17 (right_ankle): y_m = : must be metres");
    for bad in ["nan", "inf", "1480mm", "1480"] {
        assert_refused(&with_row(0, &format!("nose,0,0,{bad}")), &format!("z_m = {bad}: must be metres"));
    }
    assert_refused(&with_row(0, "joint,y_m,x_m,z_m"), "line 1 (nose): joint = joint");
    assert_refused("", "has 0 joints: layout \"coco-17\" has 17");
    assert_refused(&rows(true)[..16].join("\n"), "has 16 joints");
    assert_refused(&(rows(true).join("\n") + "\nnose,0,0,0"), "line 18: more than 17 joints");
    assert_refused(&",,\n".repeat(17), "all joints are empty");
    assert_refused(&rows(true).join("\n").replace(',', ";"), "line 1: columns are separated by semicolons");
    for row in ["right_eye,0,5,0,5,1,5", "right_eye,0,\"0,5\",1"] {
        assert_refused(&with_row(2, row), ": numbers have a decimal comma: write 1.5, not 1,5");
    }
}

#[test]
fn joints_that_draw_no_body_are_keypoints_but_no_person() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ankle.csv");
    std::fs::write(&path, ",,\n".repeat(16) + "0,0,0").unwrap();
    let mut ankle = [None; 17];
    ankle[16] = Some(DVec3::ZERO);
    let file = KeypointFile { path: path.clone(), layout: JointLayout::Coco17 };
    let read = file.read(&Sources::from_main(&path)).unwrap();
    assert_eq!(read, ankle);
    let error = require_body(read, &path).unwrap_err().to_string();
    assert!(error.contains("ankle.csv: no two neighbouring joints are known"), "{error}");
    assert_eq!(require_body(standing(), &path).unwrap(), standing());
}

#[test]
fn joints_turn_and_move_as_a_surface_does() {
    let mut keypoints = [None; 17];
    keypoints[4] = Some(DVec3::new(1.0, 2.0, 3.0));
    // Half a turn about x, exact: y and z change their sign.
    let moved = transform(&keypoints, DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0), DVec3::new(10.0, 20.0, 30.0));
    assert_eq!(moved[4], Some(DVec3::new(11.0, 18.0, 27.0)));
    assert_eq!(moved.iter().flatten().count(), 1);
}
