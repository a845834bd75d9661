//! The text that each edit writes.

use super::*;

/// A study as people write one.
const STUDY: &str = "\
# A cell.
[[sensor]]
name = \"camera\"          # above the bench
cost = 650.0             # a guess
# its places:
[[sensor.poses]]
name = \"wall\"
x_m = [0, 1]
y_m = 0
z_m = 2.5
facing = [0, 1, 0]
# the end of the camera

# A scanner.
[[sensor]]
name = \"scanner\"
[[sensor.poses]]
name = \"bench\"
list = [{ position_m = [0, -0.4, 0.3], facing = [0, -1, 0] }]

[[approach.entry]]
name = \"door\"
box = { min_m = [0, 0, 0], max_m = [1.0, 1, 2] }   # as built
";

fn cell() -> Known {
    known(&[("camera", &["wall/0/0", "wall/1/0"]), ("scanner", &["bench/0"])])
}

#[test]
fn the_first_plan_leaves_what_is_scored() {
    let text = edited(STUDY, &cell(), &[place("camera", "wall/1/0")]);
    let new = "\
list = [{ position_m = [0, -0.4, 0.3], facing = [0, -1, 0] }]

[[combination]]
sensors = [\"camera\"]

[[combination]]
sensors = [\"scanner\"]

[[combination]]
name = \"planned\"
sensors = [\"camera\"]
poses = { camera = [\"wall/1/0\"] }
";
    assert_eq!(text, STUDY.replace("list = [{ position_m = [0, -0.4, 0.3], facing = [0, -1, 0] }]\n", new));
    // Where there are combinations, none is added.
    let study = STUDY.to_string() + "\n[[combination]]\nsensors = [\"scanner\"]\n\n[choose]\nat_most = 3\n";
    let text = edited(&study, &cell(), &[place("scanner", "bench/0")]);
    let planned = "\n[[combination]]\nname = \"planned\"\nsensors = [\"scanner\"]\nposes = { scanner = [\"bench/0\"] }\n";
    assert_eq!(text, study.replace("\n[choose]", &(planned.to_string() + "\n[choose]")));
    // What was placed can be removed again.
    assert_eq!(edited(&study, &cell(), &[place("scanner", "bench/0"), Edit::Remove { index: 0 }]), study);
}

/// A study with a plan of one camera.
fn planned() -> String {
    STUDY.to_string()
        + "\n[[combination]]\nname = \"planned\"   # by hand\nsensors = [\"camera\"]   # one\nposes = { camera = [\"wall/0/0\"] }\n"
}

/// The plan at the end of a text.
#[track_caller]
fn plan_of(text: &str) -> &str {
    text.split_once("name = \"planned\"   # by hand\n").unwrap_or_else(|| panic!("{text}")).1
}

#[test]
fn sensors_join_and_leave_a_plan() {
    let two = edited(&planned(), &cell(), &[place("scanner", "bench/0")]);
    let expected = "sensors = [\"camera\", \"scanner\"]   # one\nposes = { camera = [\"wall/0/0\"], scanner = [\"bench/0\"] }\n";
    assert_eq!(plan_of(&two), expected);
    let three = edited(&two, &cell(), &[place("camera", "wall/1/0")]);
    let expected = "sensors = [\"camera\", \"scanner\"]   # one\nposes = { camera = [\"wall/0/0\", \"wall/1/0\"], scanner = [\"bench/0\"] }\n\
                    count = { camera = 2 }\n";
    assert_eq!(plan_of(&three), expected);
    let (first, last) = (Edit::Remove { index: 0 }, Edit::Remove { index: 2 });
    let expected = "sensors = [\"camera\", \"scanner\"]   # one\nposes = { camera = [\"wall/1/0\"], scanner = [\"bench/0\"] }\n";
    assert_eq!(plan_of(&edited(&three, &cell(), &[first])), expected);
    let expected = "sensors = [\"camera\"]   # one\nposes = { camera = [\"wall/0/0\", \"wall/1/0\"] }\ncount = { camera = 2 }\n";
    assert_eq!(plan_of(&edited(&three, &cell(), &[last])), expected);
    let snap = Edit::Snap { index: 0, pose: "wall/1/0".into() };
    assert_eq!(
        plan_of(&edited(&planned(), &cell(), &[snap])),
        plan_of(&planned()).replace("wall/0/0", "wall/1/0")
    );
    // The empty plan is gone, and nothing else.
    assert_eq!(edited(&planned(), &cell(), &[Edit::Remove { index: 0 }]), STUDY);
}

#[test]
fn a_dragged_pose_is_listed() {
    let study = planned();
    let moved =
        edited(&study, &cell(), &[Edit::Move { index: 0, at: at([1.2346, 0.0, 2.5], 100.04, -20.0) }]);
    let expected = study
        .replace(
            "facing = [0, 1, 0]\n# the end of the camera\n",
            "facing = [0, 1, 0]\n# the end of the camera\n[[sensor.poses]]\nname = \"planned\"\nlist = [\n    { name = \"0\", \
             position_m = [1.235, 0, 2.5], facing = [0, 1, 0], pan_deg = 10, tilt_deg = -20 },\n]\n",
        )
        .replace("{ camera = [\"wall/0/0\"] }", "{ camera = [\"planned/0\"] }");
    assert_eq!(moved, expected);
    // Dragged on, it keeps its name.
    let on = edited(&moved, &cell(), &[Edit::Move { index: 0, at: at([1.5, -0.25, 2.5], -90.0, 0.0) }]);
    let line = "{ name = \"0\", position_m = [1.5, -0.25, 2.5], facing = [0, -1, 0] },";
    assert!(on.contains(line), "{on}");
    let rolled = Pose6 { roll_deg: 3.0, ..at([1.5, -0.25, 2.5], 25.0, -20.0) };
    let rolled = edited(&on, &cell(), &[Edit::Move { index: 0, at: rolled }]);
    let line = "{ name = \"0\", position_m = [1.5, -0.25, 2.5], rpy_deg = [3, 20, 25] },";
    assert!(rolled.contains(line), "{rolled}");
    let level = edited(&rolled, &cell(), &[Edit::Move { index: 0, at: at([1.235, 0.0, 2.5], 100.0, -20.0) }]);
    assert_eq!(level, moved);
    // Names are never given twice while others exist.
    let copies = [1.0, 2.0].map(|x| Edit::Copy { index: 0, at: at([x, 0.0, 2.5], 90.0, 0.0) });
    let three = edited(&moved, &cell(), &copies);
    let line = "    { name = \"2\", position_m = [2, 0, 2.5], facing = [0, 1, 0] },\n]\n";
    assert!(three.contains(line) && three.contains("{ camera = 3 }"), "{three}");
    let two = edited(&three, &cell(), &[Edit::Remove { index: 1 }]);
    assert!(two.contains("[\"planned/0\", \"planned/2\"]") && !two.contains("name = \"1\""), "{two}");
    // The list goes with the last.
    let snap = |pose: &str| Edit::Snap { index: 0, pose: pose.into() };
    assert_eq!(edited(&moved, &cell(), &[snap("wall/0/0")]), study);
    assert_eq!(edited(&moved, &cell(), &[Edit::Remove { index: 0 }]), STUDY);
}

#[test]
fn a_device_of_the_catalogue_becomes_a_sensor() {
    let device = Device::Model("d455".into());
    let study = planned();
    let text =
        edited(&study, &cell(), &[Edit::Add { device, at: at([0.0, 0.0, 3.0], 20.0, -90.0), cost: None }]);
    let sensor = "
[[sensor]]
name = \"d455\"
model = \"d455\"
[[sensor.poses]]
name = \"planned\"
list = [
    { name = \"0\", position_m = [0, 0, 3], facing = [0, 0, -1], pan_deg = 20 },
]

[[approach.entry]]";
    let expected = study.replacen("\n[[approach.entry]]", sensor, 1);
    let expected = expected
        .replace("sensors = [\"camera\"]   # one", "sensors = [\"camera\", \"d455\"]   # one")
        .replace("{ camera = [\"wall/0/0\"] }", "{ camera = [\"wall/0/0\"], d455 = [\"planned/0\"] }");
    assert_eq!(text, expected);
    // It goes with its last pose.
    assert_eq!(edited(&text, &cell(), &[Edit::Remove { index: 1 }]), study);
    let again =
        Edit::Add { device: Device::Model("d455".into()), at: at([1.0, 0.0, 3.0], 0.0, 0.0), cost: None };
    assert!(edited(&text, &cell(), &[again]).contains("name = \"d455-2\"\nmodel = \"d455\""));
}

#[test]
fn a_new_sensor_has_a_cost_if_all_others_have() {
    let study = STUDY.replace("name = \"scanner\"\n", "name = \"scanner\"\ncost = 3000.0\n");
    let add = |cost| Edit::Add { device: Device::Model("d455".into()), at: at([0.0; 3], 0.0, 0.0), cost };
    let mut document = Document::new(study.clone());
    let error = document.apply(&add(None), None, &cell()).unwrap_err().to_string();
    assert!(
        error.starts_with("model \"d455\": has no cost, and every sensor of the study has one"),
        "{error}"
    );
    assert!(document.apply(&add(Some(-1.0)), None, &cell()).is_err() && document.text() == study);
    let text = edited(&study, &cell(), &[add(Some(700.0)), add(None)]);
    // The second costs what the first does.
    assert_eq!(text.matches("model = \"d455\"\ncost = 700\n").count(), 2, "{text}");
    // A list price stays one.
    let listed = text.replace("model = \"d455\"\ncost = 700\n", "model = \"d455\"\ncost = \"list\"\n");
    let third = edited(&listed, &cell(), &[add(None)]);
    assert_eq!(third.matches("model = \"d455\"\ncost = \"list\"\n").count(), 3, "{third}");
    let mut known = cell();
    known.models[0].cost = Some(99.5);
    assert!(edited(&study, &known, &[add(None)]).contains("model = \"d455\"\ncost = 99.5\n"));
    known.models[0].keys = vec![("noise".into(), "{ std_m = 0 }".into())];
    assert!(
        edited(&study, &known, &[add(None)])
            .contains("cost = 99.5\nnoise = { std_m = 0 }\n[[sensor.poses]]\n")
    );
}

#[test]
fn numbers_are_changed_where_they_stand() {
    let cost = |cost| Edit::SetCost { sensor: "camera".into(), cost };
    let changed = |edit: Edit| edited(STUDY, &cell(), &[edit]);
    assert_eq!(changed(cost(700.0)), STUDY.replace("650.0 ", "700.0 "));
    assert_eq!(changed(cost(650.0)), STUDY);
    assert_eq!(changed(cost(99.5)), STUDY.replace("650.0 ", "99.5 "));
    let scanner = changed(Edit::SetCost { sensor: "scanner".into(), cost: 3000.0 });
    assert_eq!(scanner, STUDY.replace("\"scanner\"\n", "\"scanner\"\ncost = 3000\n"));
    let door = |min_m, max_m| Edit::SetBox {
        table: BoxTable::Entry,
        name: "door".into(),
        shape: ShapeEdit::Box { min_m, max_m },
    };
    let moved = changed(door([0.0, 0.1204, 0.0], [1.0, 1.5, 2.0]));
    let expected = STUDY
        .replace("min_m = [0, 0, 0], max_m = [1.0, 1, 2]", "min_m = [0, 0.12, 0], max_m = [1.0, 1.5, 2]");
    assert_eq!(moved, expected);
    assert_eq!(changed(door([0.0; 3], [1.0, 1.0, 2.0])), STUDY);
    let ball = "[[region]]\nname = \"near\"\nsphere = { center_m = [0, 0, 1], radius_m = 1.5 }\n";
    let shape = ShapeEdit::Sphere { center_m: [0.0, 0.5, 1.0], radius_m: 2.0 };
    let edit = Edit::SetBox { table: BoxTable::Region, name: "near".into(), shape };
    assert_eq!(edited(ball, &cell(), &[edit]), ball.replace("0, 0, 1", "0, 0.5, 1").replace("1.5", "2.0"));
    let budget = |budget| Edit::SetBudget { budget };
    let choose = "[choose]\nat_most = 3\nbudget = 5000.0   # ours\n";
    assert_eq!(edited(choose, &cell(), &[budget(Some(4000.0))]), choose.replace("5000", "4000"));
    assert_eq!(edited(choose, &cell(), &[budget(None)]), "[choose]\nat_most = 3\n");
    assert_eq!(
        edited("[choose]\nat_most = 3", &cell(), &[budget(Some(9.0))]),
        "[choose]\nat_most = 3\nbudget = 9"
    );
}

#[test]
fn noise_may_be_mixed_by_a_key_of_the_whole_file() {
    let bare = "# ours\n[[sensor]]\nname = \"camera\"\n";
    assert_eq!(edited(bare, &cell(), &[Edit::MixNoise]), format!("mixed_noise = true\n{bare}"));
    let keyed = "voxel_size_m = 0.05 # fine\n\n[[sensor]]\nname = \"camera\"\n";
    let expected = keyed.replace("# fine\n", "# fine\nmixed_noise = true\n");
    assert_eq!(edited(keyed, &cell(), &[Edit::MixNoise]), expected);
    let said = "mixed_noise = false\n\n[[sensor]]\nname = \"camera\"\n";
    assert_eq!(edited(said, &cell(), &[Edit::MixNoise]), said.replace("false", "true"));
}

#[test]
fn the_budget_of_a_study_that_looks_for_nothing_is_refused() {
    let edit = Edit::SetBudget { budget: Some(5.0) };
    let error = Document::new(STUDY.into()).apply(&edit, None, &cell()).unwrap_err().to_string();
    assert!(error.contains("write [choose] into the file"), "{error}");
    let priced = STUDY.replace("\"scanner\"\n", "\"scanner\"\ncost = 1\n") + "\n[[require]]\nname = \"a\"\n";
    assert_eq!(edited(&priced, &cell(), &[edit]), priced.clone() + "\n[choose]\nbudget = 5\n");
}

#[test]
fn what_hangs_there_already_is_the_first_plan() {
    let study = STUDY.to_string() + "\n[choose]\nalways = [\"camera:wall/1/0\"]\nat_most = 2\n";
    let document = Document::new(study.clone());
    assert_eq!(document.plan(&cell()).unwrap(), [PlacedName::new("camera", "wall/1/0")]);
    let text = edited(&study, &cell(), &[place("scanner", "bench/0")]);
    assert!(text.contains("poses = { camera = [\"wall/1/0\"], scanner = [\"bench/0\"] }"), "{text}");
    assert!(text.contains("always = [\"camera:wall/1/0\"]"), "{text}");
    // What is removed does not come back.
    let empty = edited(&study, &cell(), &[Edit::Remove { index: 0 }]);
    assert_eq!(empty, study.replace("always = [\"camera:wall/1/0\"]\n", ""));
}

#[test]
fn other_combinations_keep_their_poses() {
    let study = "\
[[sensor]]
name = \"camera\"
[[sensor.poses]]
name = \"wall\"
list = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }]
[[sensor.poses]]
name = \"planned\"
list = [
    # beside the door
    { name = \"7\", position_m = [0, 0, 2], facing = [1, 0, 0] },   # low
    { position_m = [1, 0, 2], facing = [1, 0, 0] },
    { position_m = [2, 0, 2], facing = [1, 0, 0] }
]

[[sensor]]
name = \"other\"
same_poses_as = \"camera\"   # the same places

[[combination]]
name = \"mine\"
sensors = [\"camera\"]
poses = { camera = [\"planned/7\"] }

[[combination]]
name = \"planned\"
sensors = [\"camera\", \"other\"]
count = { camera = 3 }
poses = { camera = [\"planned/7\", \"planned/1\", \"planned/2\"], other = [\"planned/2\"] }
";
    let poses: &[&str] = &["wall/0", "planned/7", "planned/1", "planned/2"];
    let known = known(&[("camera", poses), ("other", poses)]);
    // Moved, the pose of another combination stays where it is.
    let moved = edited(study, &known, &[Edit::Move { index: 0, at: at([5.0, 0.0, 2.0], 0.0, 0.0) }]);
    let added = ",\n    { name = \"8\", position_m = [5, 0, 2], facing = [1, 0, 0] }\n]";
    let expected = study.replace("facing = [1, 0, 0] }\n]\n", &format!("facing = [1, 0, 0] }}{added}\n"));
    let expected = expected.replace("[\"planned/7\", \"planned/1\"", "[\"planned/8\", \"planned/1\"");
    assert_eq!(moved, expected);
    // So does that of a sensor which has the same.
    let moved = edited(study, &known, &[Edit::Move { index: 2, at: at([5.0, 0.0, 2.0], 0.0, 0.0) }]);
    assert!(moved.contains("position_m = [2, 0, 2]") && moved.contains("\"planned/8\"], other"), "{moved}");
    // A pose that only the plan has goes, and those behind it keep the names that were their numbers.
    let removed = edited(study, &known, &[Edit::Remove { index: 1 }]);
    let expected = study
        .replace("    { position_m = [1, 0, 2], facing = [1, 0, 0] },\n", "")
        .replace(
            "{ position_m = [2, 0, 2], facing = [1, 0, 0] }",
            "{ position_m = [2, 0, 2], facing = [1, 0, 0], name = \"2\" }",
        )
        .replace("count = { camera = 3 }", "count = { camera = 2 }")
        .replace("\"planned/1\", ", "");
    assert_eq!(removed, expected);
    let kept = edited(study, &known, &[Edit::Remove { index: 0 }]);
    assert!(kept.contains("name = \"7\"") && kept.contains("# beside the door"), "{kept}");
    // A sensor with the poses of another gets its own, to be moved alone.
    let own = edited(study, &known, &[Edit::Move { index: 3, at: at([6.0, 0.0, 2.0], 0.0, 0.0) }]);
    assert!(!own.contains("same_poses_as") && own.matches("name = \"wall\"").count() == 2, "{own}");
    assert!(own.contains("other = [\"planned/8\"]") && own.contains("position_m = [2, 0, 2]"), "{own}");
}

#[test]
fn edits_that_do_not_fit_change_nothing() {
    let study =
        planned() + "\n[[region]]\nname = \"near\"\nsphere = { center_m = [0, 0, 1], radius_m = 1.5 }\n";
    let edit_box = |name: &str, min_m| Edit::SetBox {
        table: BoxTable::Entry,
        name: name.into(),
        shape: ShapeEdit::Box { min_m, max_m: [1.0; 3] },
    };
    let near = Edit::SetBox {
        table: BoxTable::Region,
        name: "near".into(),
        shape: ShapeEdit::Box { min_m: [0.0; 3], max_m: [1.0; 3] },
    };
    let far = at([1e9, 0.0, 0.0], 0.0, 0.0);
    for (edit, words) in [
        (place("lidar", "wall/0/0"), "sensor \"lidar\": is not in the study"),
        (place("camera", "wall/9/0"), "pose = \"wall/9/0\": must be a pose of \"camera\", as \"wall/0/0\""),
        (place("camera", "wall/0/0"), "one is at \"wall/0/0\" already"),
        (add("lidar", at([0.0; 3], 0.0, 0.0)), "is not in the study"),
        (add("camera", far), "position_m"),
        (
            Edit::Add { device: Device::Model("x".into()), at: at([0.0; 3], 0.0, 0.0), cost: None },
            "model = \"x\"",
        ),
        (Edit::Move { index: 1, at: at([0.0; 3], 0.0, 0.0) }, "index = 1: must be a number below 1"),
        (Edit::Move { index: 0, at: at([0.0, 0.0, f64::NAN], 0.0, 0.0) }, "position_m"),
        (Edit::Copy { index: 0, at: at([0.0; 3], 0.0, 91.0) }, "tilt_deg = 91"),
        (Edit::Remove { index: 9 }, "index = 9"),
        (Edit::Snap { index: 0, pose: "wall".into() }, "pose = \"wall\""),
        (Edit::SetCost { sensor: "camera".into(), cost: -1.0 }, "cost = -1"),
        (Edit::SetCost { sensor: "camera".into(), cost: f64::NAN }, "cost = NaN"),
        (Edit::SetBudget { budget: Some(f64::INFINITY) }, "budget = inf"),
        (edit_box("window", [0.0; 3]), "entry \"window\": is not in the study"),
        (edit_box("door", [0.0, 1.0, 0.0]), "max_m"),
        (edit_box("door", [0.0, f64::NAN, 0.0]), "NaN is not a length"),
        (near, "region \"near\": is not a box"),
    ] {
        let mut document = Document::new(study.clone());
        let error = document.apply(&edit, None, &cell()).unwrap_err().to_string();
        assert!(error.contains(words), "{edit:?}: {error}");
        assert!(document.text() == study && !document.can_undo() && !document.is_changed(), "{edit:?}");
    }
}

#[test]
fn edits_are_read_from_json() {
    let read = |json: &str| serde_json::from_str::<EditRequest>(json).unwrap();
    let request = read(
        r#"{"edit": "move", "index": 2, "at": {"position_m": [1, 2, 3], "pan_deg": 4.5}, "gesture": 7}"#,
    );
    assert_eq!(request.edit, Edit::Move { index: 2, at: at([1.0, 2.0, 3.0], 4.5, 0.0) });
    assert_eq!(request.gesture, Some(7));
    let model = read(r#"{"edit": "add", "model": "d455", "at": {"position_m": [0, 0, 0]}}"#);
    assert_eq!(
        model.edit,
        Edit::Add { device: Device::Model("d455".into()), at: at([0.0; 3], 0.0, 0.0), cost: None }
    );
    let sensor = read(r#"{"edit": "set_sensor", "index": 0, "sensor": "lidar"}"#);
    assert_eq!(sensor.edit, Edit::SetSensor { index: 0, device: Device::Sensor("lidar".into()), cost: None });
    let ball =
        read(r#"{"edit": "set_box", "table": "region", "name": "a", "center_m": [0, 0, 0], "radius_m": 1}"#);
    let shape = ShapeEdit::Sphere { center_m: [0.0; 3], radius_m: 1.0 };
    assert_eq!(ball.edit, Edit::SetBox { table: BoxTable::Region, name: "a".into(), shape });
    assert_eq!(read(r#"{"edit": "set_budget", "budget": null}"#).edit, Edit::SetBudget { budget: None });
}

/// Devices of the study's own catalogue come before those that ship, with their costs.
#[test]
fn own_devices_can_be_added() {
    let folder = tempfile::tempdir().unwrap();
    let root = root().join("scenes");
    std::fs::create_dir(folder.path().join("tiny")).unwrap();
    std::fs::copy(root.join("tiny/cell.toml"), folder.path().join("tiny/cell.toml")).unwrap();
    let ours = "[[model]]\nname = \"ours\"\n[model.keys]\nkind = \"lidar\"\nfov_deg = [360, 20]\nresolution_deg = 4\n\
                range_m = [0.1, 5]\ncost = 380\n";
    std::fs::write(folder.path().join("ours.toml"), ours).unwrap();
    let text = std::fs::read_to_string(root.join("tiny.toml")).unwrap();
    let text = format!("catalogue = \"ours.toml\"\n{text}");
    let path = folder.path().join("study.toml");
    std::fs::write(&path, &text).unwrap();
    let study = Study::load(&path, &Overrides::default()).unwrap();
    let known = Known::new(&study);
    let first = &known.models[0];
    assert_eq!((first.name.as_str(), first.stance, first.cost), ("ours", Stance::Upright, Some(380.0)));
    assert_eq!(known.models[1..], Known::catalogue().models[..]);
    let add =
        Edit::Add { device: Device::Model("ours".into()), at: at([0.0, 0.0, 1.0], 0.0, 0.0), cost: None };
    let edited = edited(&text, &known, &[add]);
    assert!(edited.contains("model = \"ours\"\ncost = 380\n"), "{edited}");
    let found = load(&path, &edited);
    assert_eq!(found.sensors.last().unwrap().kind.name(), "lidar");
}
