//! `count` in a combination: several equal sensors score as that many sensors with the same poses do, once for
//! each set of poses, in every command.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::common::program::{self, Folder, perirobot, refused, text};
use crate::common::running::same_bytes;
use crate::common::{self, Random};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use perirobot_march::backend::Backend;
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::backend::gpu::Gpu;
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::metrics::Confusion;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::columns::pose_names;
use perirobot_sweep::scoring::run;

/// The small study with a combination.
fn folder(combination: &str) -> Folder {
    let folder = Folder::new();
    folder.edit("study.toml", "", &format!("[[combination]]\nname = \"together\"\n{combination}\n"));
    folder
}

type Rows = BTreeMap<(String, usize, usize), Confusion>;

/// Counts by poses, representation and region, in the order of the choices.
fn rows(study: &Study, backend: &mut dyn Backend) -> (Vec<String>, Rows) {
    let combination = &study.combinations[0];
    let rows = run(study, &World::prepare_all(study).unwrap(), backend).unwrap();
    let names =
        (0..combination.choices()).map(|choice| pose_names(study, combination, choice)).collect::<Vec<_>>();
    let key = |choice: usize, way, region| (names[choice].clone(), way, region);
    let counts =
        rows.iter().map(|row| (key(row.choice, row.representation, row.region), row.counts)).collect();
    (names, counts)
}

fn load(folder: &Folder) -> Study {
    Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap()
}

/// Sensors in the order they speak, as a list of TOML.
fn listed(cameras: &[&str], lidar_first: bool) -> String {
    let mut all = cameras.to_vec();
    all.insert(if lidar_first { 0 } else { all.len() }, "lidar");
    format!("{all:?}")
}

/// Equal cameras of the small study beside a LIDAR; and as many different ones with the same poses.
fn both_ways(count: usize, pattern: &str, fusion: &str, lidar_first: bool) -> [Study; 2] {
    let poses = format!("[{pattern:?}, \"random/0\", \"random/1\"]");
    let equal = folder(&format!(
        "sensors = {}\ncount = {{ camera = {count} }}\nposes = {{ camera = {poses} }}\nfusion = {fusion:?}",
        listed(&["camera"], lidar_first)
    ));
    let names = &["camera", "second", "third"][..count];
    let all: Vec<String> = names.iter().map(|name| format!("{name} = {poses}")).collect();
    let different = folder(&format!(
        "sensors = {}\nposes = {{ {} }}\nfusion = {fusion:?}",
        listed(names, lidar_first),
        all.join(", ")
    ));
    let text = program::STUDY;
    let keys = &text[text.find("kind = \"rgbd\"").unwrap()..text.find("[[sensor.poses]]").unwrap()];
    for name in &names[1..] {
        let like = format!("[[sensor]]\nname = {name:?}\n{keys}same_poses_as = \"camera\"\n[[combination]]");
        different.edit("study.toml", "[[combination]]", &like);
    }
    [equal, different].map(|folder| load(&folder))
}

/// Of different sensors those choices count in which the poses of the cameras ascend.
#[test]
fn equal_sensors_score_as_different_ones_with_the_same_poses() {
    let mut random = Random(8);
    let cpu = || Cpu::new(Some(1)).unwrap();
    for case in 0..8 {
        let (count, pattern) = (1 + case % 3, random.of(&["wall/*", "*/1*", "wall/?/0", "wall/1/1"]));
        let (fusion, lidar_first) = (random.of(&["occupied_wins", "octomap"]), random.one_in(2));
        let place = format!("case {case}: {count} in {pattern}, {fusion}, LIDAR first: {lidar_first}");
        let [equal, different] = both_ways(count, pattern, fusion, lidar_first);
        let (found_names, found) = rows(&equal, &mut cpu());
        let (names, counts) = rows(&different, &mut cpu());
        let combination = &different.combinations[0];
        let is_camera = |sensor: usize| different.sensors[sensor].kind.name() == "rgbd";
        let ascends = |choice: &usize| {
            let all = combination.choice(*choice).into_iter().zip(&combination.members);
            let cameras = all.filter(|(_, member)| is_camera(member.sensor));
            cameras.map(|(candidate, _)| candidate).is_sorted_by(|a, b| a < b)
        };
        let as_equal = |name: &str| name.replace("second:", "camera:").replace("third:", "camera:");
        let expected_names: Vec<&String> =
            (0..combination.choices()).filter(ascends).map(|choice| &names[choice]).collect();
        assert!(!expected_names.is_empty(), "{place}");
        let called: Vec<String> = expected_names.iter().map(|name| as_equal(name)).collect();
        assert_eq!(found_names, called, "{place}");
        let expected: Rows = counts
            .iter()
            .filter(|((name, ..), _)| expected_names.contains(&name))
            .map(|((name, way, region), counts)| ((as_equal(name), *way, *region), *counts))
            .collect();
        assert_eq!(found, expected, "{place}");
        // One case tells of the other backends: they are asked for no more than for any combination.
        if case == 2 {
            assert_eq!(rows(&equal, &mut Oracle::default()).1, expected, "oracle, {place}");
            if let Some(adapter) = common::adapter() {
                assert_eq!(rows(&equal, &mut Gpu::new(&adapter).unwrap()).1, expected, "gpu, {place}");
            }
        }
    }
}

const THREE: &str = "sensors = [\"lidar\", \"camera\"]\ncount = { camera = 3 }";

/// 3 of the LIDAR times 56 of three cameras in 8 poses.
const CHOICES: usize = 3 * 56;

const POSES: &str = "lidar:posts/leaning;camera:wall/0/1;camera:wall/2/0;camera:random/1";
const TURNED: &str = "lidar:posts/leaning;camera:random/1;camera:wall/2/0;camera:wall/0/1";

#[track_caller]
fn done(arguments: &[&str]) -> String {
    let outcome = perirobot(arguments);
    assert_eq!(outcome.code, Some(0), "{arguments:?}: {}", outcome.stderr);
    outcome.stdout
}

#[test]
fn every_command_takes_them() {
    let folder = folder(THREE);
    let (study, out, shards) = (folder.path("study.toml"), folder.path("out"), folder.path("shards"));
    let (study, out, shards) = (text(&study), text(&out), text(&shards));
    let told = done(&["check", study, "--backend", "cpu"]);
    assert!(told.contains(&format!("together  {CHOICES} choices of poses")), "{told}");
    done(&["sweep", study, "--out", out, "--backend", "cpu"]);
    let results = fs::read_to_string(Path::new(out).join("scores.csv")).unwrap();
    let all = results.lines().filter(|line| line.contains(",together,") && line.starts_with("*,")).count();
    assert_eq!(all % CHOICES, 0, "{all} rows");
    assert!(results.contains(POSES) && !results.contains(TURNED), "each set of poses once");
    for shard in ["0/3", "1/3", "2/3"] {
        done(&["sweep", study, "--out", shards, "--backend", "cpu", "--shard", shard]);
    }
    done(&["merge", shards]);
    same_bytes(Path::new(out), Path::new(shards));
    let told = done(&["summary", out, "--combination", "together"]);
    assert!(told.contains("together"), "{told}");
    for poses in [POSES, TURNED] {
        let other = "lidar:posts/upright;camera:wall/0/0;camera:wall/1/0;camera:wall/2/0";
        let told = done(&["compare", out, "--pose", poses, "--pose", other]);
        assert!(told.contains(POSES), "{told}");
        let told = done(&["why", out, "--pose", poses, "--backend", "cpu"]);
        assert!(told.contains("unknown"), "{told}");
        let picture = folder.path("x.png");
        done(&["render", study, "--pose", poses, "--out", text(&picture), "--backend", "cpu"]);
        let files = folder.path("files");
        done(&["export", out, "--pose", poses, "--out", text(&files), "--backend", "cpu"]);
        for name in
            ["evidence-camera.bt", "evidence-camera-2.bt", "evidence-camera-3.bt", "evidence-lidar.bt"]
        {
            assert!(files.join(name).exists(), "{name}");
        }
        fs::remove_dir_all(files).unwrap();
    }
    let twice = POSES.replace("camera:wall/2/0", "camera:wall/0/1");
    let outcome = perirobot(&["why", out, "--pose", &twice]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("no such choice of poses"), "{}", outcome.stderr);
    done(&["report", out, "--backend", "cpu", "--best", "2"]);
    let page = fs::read_to_string(Path::new(out).join("report.html")).unwrap();
    let packed = page.split_once("id=\"data\">").unwrap().1.split_once("</script>").unwrap().0;
    let packed = BASE64_STANDARD.decode(packed).unwrap();
    let data = std::io::read_to_string(flate2::read::GzDecoder::new(&packed[..])).unwrap();
    assert!(data.contains("\"candidates\":[0,1,2,3,4,5,6,7],\"count\":3}"), "its script numbers the choices");
    let told = done(&["verify-backends", study, "--backend", "cpu", "--poses", "3"]);
    assert!(told.contains("= together"), "{told}");
}

#[test]
fn what_can_be_wrong_with_a_count() {
    let cameras = "sensors = [\"camera\"]\nposes = { camera = [\"wall/*\"] }";
    let each = "combination \"together\".count";
    for (count, expected) in [
        (
            "{ camera = 0 }",
            format!("{each}.camera = 0: must be from 1 to 6: no two are in one of its 6 poses"),
        ),
        ("{ camera = 7 }", format!("{each}.camera = 7: must be from 1 to 6")),
        ("{ camera = -1 }", "found -1, wanted a whole number from 0".into()),
        ("{ camera = 1.5 }", "found 1.5, wanted a whole number from 0".into()),
        ("{ lidar = 2 }", format!("{each} = \"lidar\": is not among its sensors [\"camera\"]")),
        ("3", "found 3, wanted a table".into()),
    ] {
        refused(&folder(&format!("{cameras}\ncount = {count}")), &[], &["study.toml", &expected]);
    }
    let twice = "sensors = [\"camera\", \"camera\"]";
    refused(
        &folder(twice),
        &[],
        &["\"camera\": stands twice: name each sensor once, and say in `count` how many"],
    );
    // 2,002 poses: 1,335,334,000 sets of three.
    let many = folder("sensors = [\"camera\"]\ncount = { camera = 3 }");
    many.edit("study.toml", "random = { count = 2", "random = { count = 1996");
    let expected = "combination \"together\": 1335334000 choices of poses in 1 representations, each 3 times";
    refused(&many, &[], &[expected, "more than 1000000000 rows"]);
    let more = "random = { count = 1996";
    refused(
        &many,
        &[("study.toml", more, "random = { count = 1000"), ("study.toml", "camera = 3", "camera = 64")],
        &["more than"],
    );
}

/// Without a name it is called by its sensors.
#[test]
fn a_combination_is_called_by_how_many_it_has() {
    let folder = folder(THREE);
    folder.edit("study.toml", "name = \"together\"\n", "");
    assert_eq!(load(&folder).combinations[0].name, "lidar + 3 camera");
}
