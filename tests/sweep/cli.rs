//! The program from arguments to files: what a sweep writes, what decides it and what must not, and the way
//! back in.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::common::program::{Folder, Outcome, names, perirobot, text};
use perirobot_march::voxel::Grid;
use perirobot_scene::objects::{build::build, octomap};
use perirobot_scene::source::Sources;
use perirobot_scene::truth::{voxelize, voxelize_all};
use perirobot_study::input::{Overrides, Study, load_scene};
use serde_json::Value;

const TINY: &str = "scenes/tiny.toml";

/// Sweeps a study into a folder; it must succeed.
#[track_caller]
fn sweep(study: &str, out: &Path, more: &[&str]) -> Outcome {
    let backend: &[&str] = if more.contains(&"--backend") { &[] } else { &["--backend", "cpu"] };
    let outcome = perirobot(&[&["sweep", study, "--out", text(out)], backend, more].concat());
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    outcome
}

#[track_caller]
fn read(out: &Path, name: &str) -> String {
    fs::read_to_string(out.join(name)).unwrap()
}

fn manifest(out: &Path) -> Value {
    serde_json::from_str(&read(out, "manifest.json")).unwrap()
}

/// The rows of a table, each from column to value.
fn rows(table: &str) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    reader.deserialize().collect::<Result<_, _>>().unwrap()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> u64 {
    row[column].parse().unwrap()
}

/// The six labels that share out a region.
const LABELS: [&str; 6] = ["tp", "fp", "fn", "tn", "uo", "uf"];

#[test]
fn a_sweep_writes_its_files() {
    let folder = Folder::new();
    let out = folder.path("new/out");
    let outcome = sweep(TINY, &out, &[]);
    assert_eq!(names(&out), ["counts.journal", "manifest.json", "poses.csv", "results.csv", "scores.csv"]);
    for shown in ["Best poses by ", "kappa", "human_seen", "all positions together", "stuck at", "on cpu"] {
        assert!(outcome.stdout.contains(shown), "no {shown:?} in {}", outcome.stdout);
    }
    assert!(outcome.stderr.contains("running on cpu"), "{}", outcome.stderr);

    let study = Study::load(Path::new(TINY), &Overrides::default()).unwrap();
    let poses = read(&out, "poses.csv");
    assert_eq!(
        poses.lines().next().unwrap(),
        "sensor,pose,group,x_m,y_m,z_m,qw,qx,qy,qz,inflation_m,on,place"
    );
    let results = read(&out, "results.csv");
    assert_eq!(
        results.lines().next().unwrap(),
        "scene,snapshot,repeat,combination,poses,representation,region,tp,fp,fn,tn,uo,uf,tp_human,fn_human,\
         uo_human,tp_robot,fn_robot,uo_robot,hit_human,people,people_detected,parts,parts_detected,parts_missed,\
         f1,kappa,human_seen,human_claimed,unknown,false_alarm,seen_twice,twice,hit_human_twice"
    );
    let mut expected = Vec::new();
    for scene in &study.scenes {
        for sensor in &study.sensors {
            for candidate in &sensor.candidates {
                for (region, _) in &study.regions {
                    let pose = format!("{}:{}", sensor.name, candidate.name);
                    expected.push([scene.name.clone(), sensor.name.clone(), pose, region.clone()]);
                }
            }
        }
    }
    let rows = rows(&results);
    let columns = ["scene", "combination", "poses", "region"];
    let found: Vec<[String; 4]> = rows.iter().map(|row| columns.map(|c| row[c].clone())).collect();
    assert_eq!(found, expected, "rows in study order");
    assert_eq!(rows.len(), 13 * 2);
    assert!(rows.iter().any(|row| row["poses"] == "camera:wall/1/1"), "names as in the issue");

    let manifest = manifest(&out);
    let regions = manifest["scenes"][0]["regions"].as_array().unwrap();
    for row in &rows {
        assert_eq!(
            [&row["snapshot"], &row["repeat"], &row["representation"]].map(String::as_str),
            ["0", "0", "points"]
        );
        let region = regions.iter().find(|r| r["name"] == row["region"].as_str()).unwrap();
        let sum: u64 = LABELS.iter().map(|label| number(row, label)).sum();
        assert_eq!(sum, region["voxels"].as_u64().unwrap(), "{row:?}");
        for role in ["human", "robot"] {
            for label in ["tp", "fn", "uo"] {
                assert!(number(row, &format!("{label}_{role}")) <= number(row, label), "{row:?}");
            }
        }
    }
    // A person is there, in parts, of which some are seen from somewhere, and those that are not have names.
    let sum = |column: &str| rows.iter().map(|row| number(row, column)).sum::<u64>();
    for [some, all] in [["people_detected", "people"], ["parts_detected", "parts"], ["hit_human", "tp_human"]]
    {
        assert!(0 < sum(some) && sum(some) <= sum(all), "{some} {}, {all} {}", sum(some), sum(all));
    }
    for row in &rows {
        let missed = row["parts_missed"].split('+').filter(|name| !name.is_empty()).count() as u64;
        assert_eq!(missed, number(row, "parts") - number(row, "parts_detected"), "of one person: {row:?}");
    }
    // The scores are those of the columns beside them.
    for row in &rows {
        let [tp, fp, fn_, tn, uo, uf] = LABELS.map(|label| number(row, label) as f64);
        let [tp_human, fn_human, uo_human] =
            ["tp_human", "fn_human", "uo_human"].map(|c| number(row, c) as f64);
        let s = tp + fp + fn_ + tn + uo + uf;
        for (column, score) in [
            ("f1", 2.0 * tp / (2.0 * tp + fp + fn_ + uf + uo)),
            ("human_seen", number(row, "hit_human") as f64 / (tp_human + fn_human + uo_human)),
            ("human_claimed", tp_human / (tp_human + fn_human + uo_human)),
            ("unknown", (uo + uf) / s),
            ("false_alarm", fp / (fp + tn)),
            ("seen_twice", number(row, "twice") as f64 / s),
        ] {
            let found = if row[column].is_empty() { f64::NAN } else { row[column].parse().unwrap() };
            assert!(
                found == score || (found.is_nan() && score.is_nan()),
                "{column}: {found}, expected {score}"
            );
        }
    }
    assert!(rows.iter().any(|row| number(row, "tp_human") > 0 && number(row, "tn") > 0));
    for key in ["about", "fingerprint", "semantics_version", "seed", "voxel_size_m", "shard"] {
        assert!(!manifest[key].is_null(), "{key}");
    }
    for key in ["backend", "device", "began_unix_s", "prepare_s", "sweep_s", "poses_per_s", "faults"] {
        assert!(!manifest["runs"][0][key].is_null(), "{key}");
    }
    assert_eq!(
        (&manifest["runs"][0]["poses"], &manifest["runs"][0]["ended"]),
        (&13.into(), &"finished".into())
    );
    assert_eq!(manifest["about"]["study"]["text"].as_str().unwrap(), study.text);
    for key in ["occupied_sha256", "blockers_sha256", "human_sha256", "robot_sha256"] {
        assert_eq!(manifest["scenes"][0][key].as_str().unwrap().len(), 64, "{key}");
    }
}

#[test]
fn bytes_do_not_depend_on_threads_or_backend() {
    let folder = Folder::new();
    let outs = ["one", "two", "oracle"].map(|name| folder.path(name));
    sweep(TINY, &outs[0], &["--threads", "1"]);
    sweep(TINY, &outs[1], &["--threads", "2"]);
    sweep(TINY, &outs[2], &["--backend", "oracle"]);
    for name in ["poses.csv", "results.csv", "scores.csv"] {
        let first = read(&outs[0], name);
        assert!(outs[1..].iter().all(|out| read(out, name) == first), "{name}");
    }
    let [one, two, oracle] = outs.map(|out| manifest(&out));
    for key in one.as_object().unwrap().keys().filter(|key| !["about", "runs"].contains(&key.as_str())) {
        assert!(one[key] == two[key] && one[key] == oracle[key], "{key}");
    }
    // Rays that end in nothing, and rays that certify what they passed.
    folder.edit("study.toml", "range_m = [0.2, 3.0]", "range_m = [0.2, 0.9]");
    folder.edit("study.toml", "range_m = [0.1, 5.0]", "range_m = [0.1, 0.8]\nno_return = \"free\"");
    let study = folder.path("study.toml");
    let [cpu, plain] = ["cpu", "oracle"].map(|backend| {
        let out = folder.path(&format!("short-{backend}"));
        sweep(text(&study), &out, &["--backend", backend]);
        read(&out, "results.csv")
    });
    assert!(cpu == plain, "{cpu}\n{plain}");
    assert_eq!(one["runs"][0]["backend"], "cpu");
    assert_eq!(oracle["runs"][0]["backend"], "oracle");
}

#[test]
fn poses_read_back_are_the_same_poses() {
    let folder = Folder::new();
    let (lattice, table) = (folder.path("lattice"), folder.path("table"));
    sweep(TINY, &lattice, &[]);
    fs::copy(lattice.join("poses.csv"), folder.path("poses.csv")).unwrap();
    let tiny = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(TINY)).unwrap();
    let cell = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tiny/cell.toml");
    folder.write("cell.toml", fs::read(cell).unwrap());
    // Each sensor's poses give way to the table; a sensor takes its own rows.
    let mut study = String::new();
    for part in tiny.replace("tiny/cell.toml", "cell.toml").split("[[sensor]]") {
        let kept = part.split("[[sensor.poses]]").next().unwrap();
        let heading = if study.is_empty() { "" } else { "[[sensor]]" };
        let poses =
            if study.is_empty() { "" } else { "[[sensor.poses]]\nname = \"t\"\ncsv = \"poses.csv\"\n" };
        study += &format!("{heading}{kept}{poses}");
    }
    folder.write("study.toml", study);
    sweep(text(&folder.path("study.toml")), &table, &[]);

    let counts = |out: &Path| -> Vec<Vec<String>> {
        let rows = rows(&read(out, "results.csv"));
        rows.into_iter().map(|mut row| (row.remove("poses"), row.into_values().collect()).1).collect()
    };
    assert_eq!(counts(&lattice), counts(&table));
    assert_eq!(manifest(&lattice)["scenes"][0]["placements"], manifest(&table)["scenes"][0]["placements"]);
    assert!(read(&table, "poses.csv").contains("camera,t/wall/0/0,t,-1,-0.75,1.2,"));
}

#[test]
fn an_existing_folder_gets_new_files_and_keeps_what_is_not_ours() {
    let folder = Folder::new();
    let out = folder.path("out");
    fs::create_dir(&out).unwrap();
    for name in ["results.csv", "notes.txt"] {
        fs::write(out.join(name), "old").unwrap();
    }
    sweep(TINY, &out, &["--restart"]);
    let expected = ["counts.journal", "manifest.json", "notes.txt", "poses.csv", "results.csv", "scores.csv"];
    assert_eq!(names(&out), expected);
    assert!(read(&out, "results.csv").starts_with("scene,") && read(&out, "notes.txt") == "old");
}

#[test]
fn the_voxel_size_of_the_command_line_wins() {
    let folder = Folder::new();
    let (study, coarse) = (folder.path("study"), folder.path("coarse"));
    sweep(TINY, &study, &[]);
    sweep(TINY, &coarse, &["--voxel-size", "0.2"]);
    let (study, coarse_manifest) = (manifest(&study), manifest(&coarse));
    assert_eq!((&study["voxel_size_m"], &coarse_manifest["voxel_size_m"]), (&0.1.into(), &0.2.into()));
    assert_ne!(study["scenes"][0]["grid"]["size"], coarse_manifest["scenes"][0]["grid"]["size"]);
}

/// What a ray has passed is free and where it ended is not, unless it looked through something.
#[test]
fn sensors_do_not_err_where_nothing_is_see_through() {
    let folder = Folder::new();
    let wrong = |row: &BTreeMap<String, String>| number(row, "fn") + number(row, "fp") > 0;
    for certified in [false, true] {
        if certified {
            folder.edit("study.toml", "range_m = [0.2, 3.0]", "range_m = [0.2, 3.0]\nno_return = \"free\"");
        }
        sweep(text(&folder.path("study.toml")), &folder.path("out"), &["--restart"]);
        let rows = rows(&read(&folder.path("out"), "results.csv"));
        assert!(rows.iter().any(|row| number(row, "tp") > 0));
        assert_eq!(rows.iter().find(|row| wrong(row)), None);
    }
    // The crate of glass: now rays say free where the crate is.
    folder.edit("cell.toml", "box = {", "optical = \"see_through\"\nbox = {");
    sweep(text(&folder.path("study.toml")), &folder.path("out"), &["--restart"]);
    let rows = rows(&read(&folder.path("out"), "results.csv"));
    assert!(rows.iter().any(|row| number(row, "fn") > 0) && rows.iter().all(|row| number(row, "fp") == 0));
}

#[test]
fn the_seed_moves_random_poses_and_nothing_else() {
    let folder = Folder::new();
    let lines = |out: &Path, name: &str, random: bool| -> Vec<String> {
        let text = read(out, name);
        text.lines().filter(|line| line.contains("random/") == random).map(String::from).collect()
    };
    let (one, two) = (folder.path("one"), folder.path("two"));
    sweep(text(&folder.path("study.toml")), &one, &[]);
    folder.edit("study.toml", "seed = 7", "seed = 8");
    sweep(text(&folder.path("study.toml")), &two, &[]);
    for name in ["poses.csv", "results.csv"] {
        assert_eq!(lines(&one, name, false), lines(&two, name, false), "{name}");
        assert!(!lines(&one, name, true).is_empty());
        assert_ne!(lines(&one, name, true), lines(&two, name, true), "{name}");
    }
}

#[test]
fn help_says_what_a_user_must_know() {
    for (arguments, fragments) in [
        (&["--help"][..], &["sweep", "summary", "verify-backends", "devices", "voxelize", "Exit codes"][..]),
        (
            &["sweep", "--help"],
            &[
                "--out",
                "--voxel-size",
                "--backend",
                "--threads",
                "--adapter",
                "--restart",
                "--shard",
                "exit code is 75",
            ],
        ),
        (&["summary", "--help"], &["--region", "--combination", "--score", "scores.csv", "baselines"]),
        (&["verify-backends", "--help"], &["--poses", "--pose", "--all", "oracle", "Exits 1"]),
        (&["devices", "--help"], &["Vulkan"]),
        (&["voxelize", "--help"], &["--out", "--voxel-size", ".bt", "octovis"]),
        (&["--version"], &[env!("CARGO_PKG_VERSION")]),
    ] {
        let outcome = perirobot(arguments);
        assert_eq!(outcome.code, Some(0), "{arguments:?}");
        for fragment in fragments {
            assert!(outcome.stdout.contains(fragment), "no {fragment:?} in {arguments:?}");
        }
    }
}

#[test]
fn verify_backends_finds_no_difference_between_cpu_and_oracle() {
    let outcome = perirobot(&["verify-backends", TINY, "--all", "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}{}", outcome.stdout, outcome.stderr);
    assert!(outcome.stdout.contains("\n0 differences between oracle and cpu\n"), "{}", outcome.stdout);
    let one = perirobot(&["verify-backends", TINY, "--pose", "posts/leaning", "--backend", "cpu"]);
    // The sensor and the combination of it alone, each on two backends.
    assert_eq!((one.code, one.stdout.matches("lidar").count()), (Some(0), 4), "{}", one.stdout);
    assert!(!one.stdout.contains("camera"), "{}", one.stdout);
    let as_in_results =
        perirobot(&["verify-backends", TINY, "--pose", "lidar:posts/leaning", "--backend", "cpu"]);
    assert_eq!(as_in_results.stdout.matches("lidar").count(), 4, "{}", as_in_results.stderr);
    let itself = perirobot(&["verify-backends", TINY, "--backend", "oracle"]);
    assert_eq!(itself.code, Some(2), "the oracle is not held against itself");
}

#[test]
fn a_scene_goes_out_as_an_octomap_and_comes_back() {
    let folder = Folder::new();
    let out = folder.path("scene1.bt");
    let outcome = perirobot(&["voxelize", "scenes/paper/scene1.toml", "--out", text(&out)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    for shown in ["operator", "human", "watertight", "121 × 81 × 61"] {
        assert!(outcome.stdout.contains(shown), "no {shown:?} in {}", outcome.stdout);
    }
    let path = Path::new("scenes/paper/scene1.toml");
    let sources = Sources::from_main(path);
    let spec = load_scene(path, &sources).unwrap();
    let scene = build(&spec, &sources, 0.05).unwrap();
    let grid = voxelize::grid_over(&voxelize::scene_extent(&scene, 0.05).unwrap(), 0.05).unwrap();
    let truth = voxelize_all(&scene, grid).unwrap().remove(0);
    let map = octomap::read(&out, &Sources::from_main(&out)).unwrap();
    assert_eq!((map.resolution_m, map.occupied.len() as u64), (0.05, truth.occupied.count()));
    let inside = |key: &[i32; 3]| truth.occupied.get(std::array::from_fn(|r| key[r] - grid.origin[r]));
    assert!(map.occupied.iter().all(inside));
    assert_eq!(folder.names(), ["cell.toml", "scene1.bt", "study.toml"]);
}

/// Of the map of a building the part around a cell is used.
#[test]
fn bounds_cut_a_part_out_of_a_large_map() {
    let folder = Folder::new();
    // Pillars every 2 m for 400 m: 4,000 voxels, and a grid has at most 1,023 on an axis.
    let map = octomap::write(0.1, [-2000, 3, 0], [4000, 1, 12], &|k| Some(k[0] % 20 == 0));
    fs::write(folder.path("hall.bt"), map).unwrap();
    folder.edit("cell.toml", "", "[[object]]\nname = \"hall\"\noctomap = \"hall.bt\"\n");
    let whole = folder.sweep(&[]);
    assert_eq!(whole.code, Some(2), "{}", whole.stderr);
    assert!(whole.stderr.contains("bounds_m around the part that matters"), "{}", whole.stderr);
    folder.edit(
        "study.toml",
        "[grid]",
        "[grid]\nbounds_m = { min = [-1.5, -1.5, -0.1], max = [1.5, 1.5, 1.9] }",
    );
    let part = folder.sweep(&[]);
    assert_eq!(part.code, Some(0), "{}", part.stderr);
    // At x = 0 stands one pillar of 12 voxels, and the next are outside.
    let path = folder.path("cell.toml");
    let sources = Sources::from_main(&path);
    let scene = build(&load_scene(&path, &sources).unwrap(), &sources, 0.1).unwrap();
    let grid = Grid { voxel_size_m: 0.1, origin: [-15, -15, -1], size: [31, 31, 21] };
    let truth = voxelize_all(&scene, grid).unwrap().remove(0);
    let hall = truth.objects.iter().find(|object| object.name == "hall").unwrap();
    assert_eq!(hall.voxels.count(), 12);
}

#[test]
fn a_sweep_that_is_told_no_folder_names_one() {
    let folder = Folder::new();
    let home = folder.path("home");
    fs::create_dir(&home).unwrap();
    let sweep = || {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_perirobot"));
        command.current_dir(&home).args(["sweep", "../study.toml", "--backend", "cpu"]);
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, told) = sweep();
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("results go to out/study\n"), "{told}");
    assert!(home.join("out/study/results.csv").exists());
    // The same again goes on there.
    let (code, told) = sweep();
    assert!(code == Some(0) && told.contains("are finished already"), "{told}");
}
