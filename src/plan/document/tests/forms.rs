//! Files as other people and programs write them: other line ends, no last line end, tables in braces, dotted keys.

use super::*;

/// One study in several forms: a camera with a wall, and a plan.
const BLOCKS: &str = "\
[[sensor]]
name = \"camera\"
[[sensor.poses]]
name = \"wall\"
list = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }, { position_m = [1, 0, 1], facing = [1, 0, 0] }]

[[combination]]
name = \"planned\"
sensors = [\"camera\"]
poses = { camera = [\"wall/0\"] }
";
const HEADERS: &str = "\
[[sensor]]
  name = \"camera\"
  noise.std_m = 0
  [[sensor.poses]]
    name = 'wall'
    [[sensor.poses.list]]
      position_m = [0, 0, 1]
      facing = [1, 0, 0]
    [[sensor.poses.list]]
      position_m = [
        1, # along the wall
        0, 1,
      ]
      facing = [1, 0, 0]

[[combination]]
name = \"planned\"
sensors = [
    \"camera\",   # ours
    # and more to come
]
[combination.poses]
camera = [
    \"wall/0\", # first
]
[combination.count]
camera = 1
";
const INLINE: &str = "\
sensor = [{ name = \"camera\", poses = [
    # the wall
    { name = \"wall\", list = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }, { position_m = [1, 0, 1], facing = [1, 0, 0] }] },
] }]
combination = [{ name = \"planned\", sensors = [\"camera\"], poses = { camera = [\"wall/0\"] } }]
seed = 1";
const DOTTED: &str = "\
seed = 1
[[sensor]]
name = \"camera\"
poses = [{ name = \"wall\", list = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }, { position_m = [1, 0, 1], facing = [1, 0, 0] }] }]
[[combination]]
name = \"planned\"
poses.camera = [\"wall/0\"]   # first
sensors = [\"camera\"]
count.camera = 1";
const SPACED: &str = "\
sensor = [
  {
    name = \"camera\",
    poses = [
      {
        name = \"wall\", # a wall
        list = [
          { position_m = [0, 0, 1], facing = [1, 0, 0] },
          { position_m = [1, 0, 1], facing = [1, 0, 0] }, # the second
          # no third
        ],
      },
    ],
  },
]
[[combination]]
name = \"planned\"
sensors = [\"camera\"]
poses = {
  # one
  camera = [\"wall/0\"]
}
";

/// What the plan of a text means, read by another reader than ours.
fn meaning(text: &str) -> Vec<(String, [f64; 3])> {
    let study: toml::Table = toml::from_str(text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let named = |list: &str, name: &str| {
        let all = study[list].as_array().unwrap().iter();
        all.map(|one| one.as_table().unwrap()).find(|one| one["name"].as_str() == Some(name)).unwrap().clone()
    };
    let planned = named("combination", "planned");
    let mut all = Vec::new();
    for sensor in planned["sensors"].as_array().unwrap() {
        let sensor = sensor.as_str().unwrap();
        let poses = planned["poses"][sensor].as_array().unwrap();
        let count =
            planned.get("count").and_then(|count| count.get(sensor)).map_or(1, |n| n.as_integer().unwrap());
        assert_eq!(count, poses.len() as i64, "{text}");
        for pose in poses {
            let (group, name) = pose.as_str().unwrap().split_once('/').unwrap();
            let groups = named("sensor", sensor)["poses"].as_array().unwrap().clone();
            let group = groups.iter().find(|one| one["name"].as_str() == Some(group)).unwrap();
            let list = group["list"].as_array().unwrap();
            let own =
                |i: usize| list[i].get("name").map_or(i.to_string(), |name| name.as_str().unwrap().into());
            let entry = &list[(0..list.len()).find(|&i| own(i) == name).unwrap()];
            let number =
                |value: &toml::Value| value.as_float().unwrap_or_else(|| value.as_integer().unwrap() as f64);
            let position: Vec<f64> = entry["position_m"].as_array().unwrap().iter().map(number).collect();
            all.push((sensor.into(), position.try_into().unwrap()));
        }
    }
    all
}

fn camera() -> Known {
    known(&[("camera", &["wall/0", "wall/1"])])
}

fn model(x_m: f64) -> Edit {
    Edit::Add { device: Device::Model("d455".into()), at: at([x_m, 0.0, 0.0], 0.0, 0.0), cost: None }
}

#[test]
fn each_form_of_a_study_can_be_edited() {
    let to = |x_m| at([x_m, 0.5, 2.0], 30.0, -10.0);
    let edits = [
        place("camera", "wall/1"),
        Edit::Move { index: 0, at: to(2.0) },
        add("camera", to(3.0)),
        Edit::Move { index: 2, at: Pose6 { roll_deg: 5.0, ..to(4.0) } },
        model(5.0),
        Edit::Remove { index: 1 },
        Edit::Copy { index: 2, at: to(6.0) },
        Edit::Snap { index: 0, pose: "wall/0".into() },
        Edit::Remove { index: 3 },
        Edit::Remove { index: 2 },
        Edit::Remove { index: 1 },
    ];
    let camera_at = |x: f64| ("camera".to_string(), if x < 2.0 { [x, 0.0, 1.0] } else { [x, 0.5, 2.0] });
    let model_at = |x: f64| ("d455".to_string(), if x == 5.0 { [x, 0.0, 0.0] } else { [x, 0.5, 2.0] });
    let expected = [
        vec![camera_at(0.0), camera_at(1.0)],
        vec![camera_at(2.0), camera_at(1.0)],
        vec![camera_at(2.0), camera_at(1.0), camera_at(3.0)],
        vec![camera_at(2.0), camera_at(1.0), camera_at(4.0)],
        vec![camera_at(2.0), camera_at(1.0), camera_at(4.0), model_at(5.0)],
        vec![camera_at(2.0), camera_at(4.0), model_at(5.0)],
        vec![camera_at(2.0), camera_at(4.0), model_at(5.0), model_at(6.0)],
        vec![camera_at(0.0), camera_at(4.0), model_at(5.0), model_at(6.0)],
        vec![camera_at(0.0), camera_at(4.0), model_at(5.0)],
        vec![camera_at(0.0), camera_at(4.0)],
        vec![camera_at(0.0)],
    ];
    for form in [BLOCKS, HEADERS, INLINE, DOTTED, SPACED] {
        for is_windows in [false, true] {
            let text = if is_windows { form.replace('\n', "\r\n") } else { form.to_string() };
            for text in [text.clone(), text.trim_end().to_string()] {
                let mut document = Document::new(text.clone());
                for (edit, expected) in edits.iter().zip(&expected) {
                    let before = document.text().to_string();
                    if let Err(e) = document.apply(edit, None, &camera()) {
                        panic!("{edit:?}: {e}\n{before}");
                    }
                    let after = document.text();
                    assert_eq!(meaning(after), *expected, "{edit:?}\n{before}\n=>\n{after}");
                    assert!(keeps_comments(&before, after), "{edit:?}\n{before}\n=>\n{after}");
                    let (ends, windows) = (after.matches('\n').count(), after.matches("\r\n").count());
                    assert_eq!(windows, if is_windows { ends } else { 0 }, "{edit:?}\n{after:?}");
                }
                while document.undo() {}
                assert_eq!(document.text(), text);
            }
        }
    }
}

#[test]
fn comments_behind_values_stay() {
    let text = edited(HEADERS, &camera(), &[place("camera", "wall/1"), model(1.0)]);
    for part in [
        "    \"camera\",   # ours\n    \"d455\",\n    # and more to come\n",
        "    \"wall/0\", # first\n    \"wall/1\",\n",
        "        1, # along the wall\n        0, 1,\n",
        "camera = 2\n",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let text = edited(DOTTED, &camera(), &[place("camera", "wall/1"), model(1.0)]);
    let part = "poses.camera = [\"wall/0\", \"wall/1\"]   # first\nposes.d455 = [\"planned/0\"]\nsensors = ";
    assert!(text.contains(part) && text.ends_with("count.camera = 2"), "{text}");
}

#[test]
fn a_list_in_headers_is_moved_in_its_place() {
    let study = HEADERS.replace("'wall'", "'planned'").replace("wall/0", "planned/0");
    let known = known(&[("camera", &["planned/0", "planned/1"])]);
    let moved = edited(&study, &known, &[Edit::Move { index: 0, at: at([0.0, 0.0, 1.5], -3.0, 4.5) }]);
    let new =
        "position_m = [0, 0, 1.5]\n      facing = [1, 0, 0]\n      pan_deg = -3\n      tilt_deg = 4.5\n";
    assert_eq!(moved, study.replacen("position_m = [0, 0, 1]\n      facing = [1, 0, 0]\n", new, 1));
    let copied = edited(&study, &known, &[Edit::Copy { index: 0, at: at([2.0, 0.0, 1.0], 0.0, 0.0) }]);
    let new = "[[sensor.poses.list]]\nname = \"2\"\nposition_m = [2, 0, 1]\nfacing = [1, 0, 0]\n";
    assert!(copied.contains(new), "{copied}");
    assert_eq!(meaning(&copied), [("camera".into(), [0.0, 0.0, 1.0]), ("camera".into(), [2.0, 0.0, 1.0])]);
}

#[test]
fn poses_of_tables_and_draws_are_written_out() {
    let study = "\
[[sensor]]
name = \"camera\"
[[sensor.poses]]
name = \"From a table\"
csv = \"poses.csv\"
[[sensor.poses]]
name = \"wall\"   # a lattice
x_m = [0, 1]
y_m = 0
z_m = 2
facing = [0, 1, 0]

[[sensor]]
name = \"other\"
same_poses_as = \"camera\"
cost = 1
";
    let mut known = known(&[("camera", &[]), ("other", &[])]);
    let third = 1.0 / 3.0;
    let poses = [("from-a-table/a/b", third), ("from-a-table/1", 2.0), ("wall/0/0", 3.0)];
    for sensor in &mut known.sensors {
        let pose = |x_m| {
            rounded(&at([0.0; 3], 10.0, 20.0), Stance::Facing).moved_to([x_m, 0.0, 0.0].into(), 0.0, 0.0)
        };
        sensor.poses = poses.iter().map(|(name, x_m)| (name.to_string(), Some(pose(*x_m)))).collect();
    }
    let text = edited(study, &known, &[add("other", at([9.0, 0.0, 0.0], 0.0, 0.0))]);
    let (before, own) = text.split_once("name = \"other\"\n").unwrap();
    assert!(study.starts_with(before.trim_end()), "{text}");
    assert!(own.starts_with("cost = 1\n[[sensor.poses]]\nname = \"From a table\"\nlist = [\n"), "{text}");
    let lattice = "[[sensor.poses]]\nname = \"wall\"   # a lattice\nx_m = [0, 1]\ny_m = 0\nz_m = 2\nfacing = [0, 1, 0]\n";
    assert!(own.contains(lattice), "{text}");
    let read: toml::Table = toml::from_str(&text).unwrap();
    let listed = &read["sensor"][1]["poses"][0]["list"];
    assert_eq!(listed[0]["name"].as_str(), Some("a/b"));
    assert_eq!(listed[0]["position_m"][0].as_float().map(f64::to_bits), Some(third.to_bits()));
    let rotation = known.sensors[0].poses[0].1.unwrap().rotation;
    for (key, part) in ["x", "y", "z", "w"].iter().zip(rotation.to_array()) {
        let value = &listed[0]["quaternion"][key];
        let value = value.as_float().unwrap_or_else(|| value.as_integer().unwrap() as f64);
        assert_eq!(value, part, "{key}");
    }
}

#[test]
fn what_cannot_be_read_is_told_and_left() {
    let plan = |poses: &str| BLOCKS.replace("poses = { camera = [\"wall/0\"] }", poses);
    for (text, words) in [
        ("sensor = [".to_string(), "not TOML"),
        (plan("poses = { camera = [\"wall/*\"] }"), "\"wall/*\" may be several poses"),
        (plan("poses = { camera = [\"wall/0\", \"wall/1\"] }"), "there are 1 of \"camera\" and 2 poses"),
        (plan("poses = { camera = \"wall/0\" }"), "combination[0].poses.camera: not a list of names"),
        (plan("poses = {}"), "no pose is named for \"camera\""),
    ] {
        let mut document = Document::new(text.clone());
        let error = document.plan(&camera()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
        let error = document.apply(&place("camera", "wall/1"), None, &camera()).unwrap_err().to_string();
        assert!(error.contains(words) && document.text() == text, "{error}");
        // The text can be mended as a whole, and what has nothing to do with the plan as ever.
        let cost = Edit::SetCost { sensor: "camera".into(), cost: 1.0 };
        assert_eq!(document.apply(&cost, None, &camera()).is_ok(), words != "not TOML");
        document.apply(&Edit::SetText { text: BLOCKS.into() }, None, &camera()).unwrap();
        assert_eq!(document.plan(&camera()).unwrap().len(), 1);
        while document.undo() {}
        assert_eq!(document.text(), text);
    }
}

#[test]
fn comments_inside_what_is_removed_stay() {
    let study = "\
[[sensor]]
name = \"camera\"
[[sensor.poses]]
name = \"planned\"
list = [
    { name = \"0\", position_m = [0, 0, 1], facing = [1, 0, 0] },
    {
        # over the door
        name = \"1\", position_m = [1, 0, 1],
        facing = [1, 0, 0],
    },
    { name = \"2\", position_m = [2, 0, 1], facing = [1, 0, 0] }
]

[[combination]]
name = \"planned\"
# two of them
sensors = [\"camera\"]
count = { camera = 3 }
poses = { camera = [\"planned/0\", \"planned/1\", \"planned/2\"] }

[choose]
always = [
    # there for years
    \"camera:planned/0\",
]
at_most = 2
";
    let known = known(&[("camera", &["planned/0", "planned/1", "planned/2"])]);
    let two = edited(study, &known, &[Edit::Remove { index: 1 }]);
    let expected = study.replace(
        "    {\n        # over the door\n        name = \"1\", position_m = [1, 0, 1],\n        facing = [1, 0, 0],\n    },\n",
        "        # over the door\n",
    );
    let expected = expected.replace("camera = 3", "camera = 2").replace("\"planned/1\", ", "");
    assert_eq!(two, expected);
    let none = edited(&two, &known, &[Edit::Remove { index: 1 }, Edit::Remove { index: 0 }]);
    assert!(none.ends_with("# two of them\n\n[choose]\n    # there for years\nat_most = 2\n"), "{none}");
    assert!(keeps_comments(study, &none) && !none.contains("combination"), "{none}");
}
