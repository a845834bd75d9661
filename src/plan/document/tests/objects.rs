//! Objects of scene files: where they are read, and what a move writes.

use super::*;

const SCENE: &str = r#"# A cell.
interior = "free"

[[object]]
name = "table"                           # of oak
box = { size_m = [1.0, 0.6, 0.95] }
position_m = [0.12345, 0, 0.5]           # its middle
rpy_deg = [90, 1.5, 30.55]

[[object]]
name = "robot"
urdf = "robot.urdf"
[object.snapshots]                       # one entry for each moment
joints_deg = [{ turn = 0 }, { turn = 5 }]

[[object]]
name = "operator"
mannequin = "operator.csv"
[object.snapshots]
position_m = [
    [0.6, -0.4, 0],                      # away
    [0, 0, 0],
]
rpy_deg = [[0, 0, 90], [0, 0, 180]]

[[object]]
name = "crate"
box = { size_m = [1, 1, 1] }
quaternion = { w = 1, x = 0, y = 0, z = 0 }
"#;

fn to(position_m: [f64; 3], yaw_deg: f64, entry: usize) -> ObjectMove {
    ObjectMove {
        position_m: Some(position_m),
        yaw_deg: Some(yaw_deg),
        position_entry: entry,
        yaw_entry: entry,
    }
}

fn go(object: &str, to: ObjectMove) -> Edit {
    Edit::MoveObject { file: "cell.toml".into(), object: object.into(), to }
}

fn document() -> Document {
    let mut document = Document::new("seed = 1\n".into());
    document.add_scene("cell.toml", SCENE);
    document
}

/// The scene after a move, by replacements in its text.
#[track_caller]
fn assert_written(edit: &Edit, replaced: &[[&str; 2]]) {
    let mut document = document();
    document.apply(edit, None, &Known::default()).unwrap();
    let mut expected = SCENE.to_string();
    for [from, to] in replaced {
        assert!(expected.contains(from), "{from}");
        expected = expected.replacen(from, to, 1);
    }
    let texts: Vec<&str> = document.texts().collect();
    assert_eq!(texts, ["seed = 1\n", &expected]);
}

#[test]
fn only_the_numbers_that_change_are_written() {
    // What stays is not rounded.
    assert_written(
        &go("table", to([0.12345, 0.30049, 0.5], 30.55, 0)),
        &[["[0.12345, 0, 0.5]", "[0.12345, 0.3, 0.5]"]],
    );
    assert_written(&go("table", to([0.12345, 0.0, 0.5], -210.04, 0)), &[["30.55]", "150]"]]);
    assert_written(
        &go("robot", to([1.0, -0.0, 0.0], 0.0, 0)),
        &[["urdf = \"robot.urdf\"\n", "urdf = \"robot.urdf\"\nposition_m = [1, 0, 0]\n"]],
    );
    assert_written(
        &go("robot", to([0.0; 3], 12.34, 0)),
        &[["urdf = \"robot.urdf\"\n", "urdf = \"robot.urdf\"\nrpy_deg = [0, 0, 12.3]\n"]],
    );
    assert_written(&go("robot", to([0.0; 3], 0.0, 0)), &[]);
    let at = ObjectMove { yaw_deg: None, ..to([0.25, 0.0, 0.0], 0.0, 0) };
    let after = "quaternion = { w = 1, x = 0, y = 0, z = 0 }";
    assert_written(&go("crate", at), &[[after, &format!("{after}\nposition_m = [0.25, 0, 0]")]]);
}

#[test]
fn a_place_of_a_moment_is_written_alone() {
    assert_written(&go("operator", to([0.6, -0.5, 0.0], 90.0, 0)), &[["[0.6, -0.4, 0]", "[0.6, -0.5, 0]"]]);
    assert_written(
        &go("operator", to([0.1, 0.0, 0.0], -90.0, 1)),
        &[["    [0, 0, 0],\n", "    [0.1, 0, 0],\n"], ["[0, 0, 180]", "[0, 0, -90]"]],
    );
}

#[test]
fn places_are_read_as_they_are_written() {
    let all = object_places(SCENE);
    let names: Vec<&str> = all.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names, ["table", "robot", "operator", "crate"]);
    assert_eq!(all[0].positions_m, [[0.12345, 0.0, 0.5]]);
    assert_eq!((&all[0].yaws_deg, all[0].has_position_list), (&Some(vec![30.55]), false));
    assert_eq!((&all[1].positions_m[..], &all[1].yaws_deg), (&[[0.0; 3]][..], &Some(vec![0.0])));
    assert_eq!(all[2].positions_m, [[0.6, -0.4, 0.0], [0.0; 3]]);
    assert_eq!((&all[2].yaws_deg, all[2].has_yaw_list), (&Some(vec![90.0, 180.0]), true));
    assert_eq!(all[3].yaws_deg, None);
    assert_eq!(object_places("object = ["), []);
    let study = "[[candidate]]\nobject = \"robot\"\nwith = [\"pedestal\"]\nx_m = 0\ny_m = 0\n";
    assert_eq!(candidate_objects(study), ["robot", "pedestal"]);
}

#[test]
fn a_move_that_cannot_be_written_changes_nothing() {
    let far = ObjectMove { position_m: Some([2e6, 0.0, 0.0]), ..Default::default() };
    let unturned = ObjectMove { yaw_deg: Some(f64::NAN), ..Default::default() };
    let gone = Edit::MoveObject { file: "other.toml".into(), object: "table".into(), to: far };
    for (edit, expected) in [
        (go("nobody", far), "object \"nobody\": is not in the scene file"),
        (go("table", far), "object \"table\": position_m = [2000000.0, 0.0, 0.0]"),
        (go("table", unturned), "object \"table\": yaw_deg = NaN"),
        (go("crate", to([0.0; 3], 5.0, 0)), "object \"crate\": is turned by a quaternion"),
        (go("operator", to([0.0; 3], 5.0, 2)), "object \"operator\": entry = 2: must be an entry of"),
        (gone, "scene file \"other.toml\": cannot be edited here: files that can be: [\"cell.toml\"]"),
    ] {
        let mut document = document();
        let error = document.apply(&edit, None, &Known::default()).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
        assert!(!document.is_changed() && !document.can_undo());
    }
}

#[test]
fn one_history_has_the_steps_of_all_files() {
    let mut document = document();
    let known = Known::default();
    let texts = |document: &Document| document.texts().map(String::from).collect::<Vec<_>>();
    let mut states = vec![texts(&document)];
    let typed = Edit::SetText { text: "seed = 2\n".into() };
    for (edit, gesture) in [
        (go("table", to([1.0, 0.0, 0.5], 30.55, 0)), 1),
        (typed, 2),
        (go("operator", to([0.0, 1.0, 0.0], 90.0, 0)), 3),
        (go("operator", to([0.0, 2.0, 0.0], 90.0, 0)), 3),
    ] {
        document.apply(&edit, Some(gesture), &known).unwrap();
        states.push(texts(&document));
    }
    let title = |lines: &[DiffLine]| -> Vec<String> {
        lines.iter().filter(|line| line.kind == LineKind::File).map(|line| line.text.clone()).collect()
    };
    assert_eq!(title(&document.difference("study.toml")), ["study.toml", "cell.toml"]);
    // The last two are one gesture.
    for state in [2, 1, 0] {
        assert!(document.undo());
        assert_eq!(texts(&document), states[state]);
    }
    assert!(!document.undo() && !document.is_changed());
    assert_eq!(document.difference("study.toml"), []);
    // A file that joins later is the same in all steps.
    document.add_scene("second.toml", SCENE);
    assert!(document.redo());
    assert_eq!(title(&document.difference("study.toml")), ["cell.toml"]);
    assert_eq!(document.texts().last(), Some(SCENE));
    // What others write into a file is followed in all steps that did not change it.
    let theirs = format!("# theirs\n{SCENE}");
    document.follow_scene(2, &theirs);
    assert!(document.redo() && document.redo());
    assert_eq!(texts(&document)[..2], states[4][..]);
    assert_eq!(document.texts().last(), Some(&*theirs));
    document.saved();
    assert!(!document.is_changed());
}
