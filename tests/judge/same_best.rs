//! Every command names the same choice of poses as the best, and no command line is printed twice.

use std::fs;
use std::path::Path;

use crate::common::program::{Folder, Outcome, perirobot, text};

/// `scenes/judge.toml`, swept in a folder of its own.
fn swept() -> Folder {
    let folder = Folder::new();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    folder.write("study.toml", fs::read(scenes.join("judge.toml")).unwrap());
    fs::create_dir(folder.path("paper")).unwrap();
    for file in ["scene1.toml", "scene1_operator.csv", "table.glb", "ur10.urdf"] {
        fs::copy(scenes.join("paper").join(file), folder.path("paper").join(file)).unwrap();
    }
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    folder
}

#[track_caller]
fn run(command: &[&str]) -> Outcome {
    let outcome = perirobot(command);
    assert!(matches!(outcome.code, Some(0 | 4)), "{command:?}: {}", outcome.stderr);
    outcome
}

/// The poses that begin a line of a text, as in `camera:left-wall/0/0;camera:left-wall/3/0 · 2 camera · points;points`.
fn first_poses(text: &str) -> String {
    let line = text.lines().find(|line| line.starts_with("camera:") && line.contains(" · "));
    line.unwrap_or_else(|| panic!("no poses in {text}")).split(" · ").next().unwrap().into()
}

#[test]
fn sweep_why_judge_and_report_agree_on_the_best() {
    let folder = swept();
    let (study, out) = (folder.path("study.toml"), folder.path("out"));
    let told = run(&["sweep", text(&study), "--out", text(&out), "--backend", "cpu"]).stdout;
    let best = first_poses(&told);
    assert!(told.contains(&format!("--pose '{best}'")), "{told}");
    let why = run(&["why", text(&out), "--best", "1", "--backend", "cpu"]).stdout;
    assert_eq!(first_poses(&why), best, "{why}");
    let judged = run(&["judge", text(&out), "--backend", "cpu"]).stdout;
    assert_eq!(first_poses(&judged), best, "{judged}");
    run(&["report", text(&out), "--best", "1", "--backend", "cpu"]);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains(&format!("<p>2 camera ({best})</p>")), "{best} is recommended");
}

/// Without requirements the best of the score that is asked for.
#[test]
fn without_requirements_they_agree_as_well() {
    let folder = Folder::new();
    let told = folder.sweep(&[]);
    assert_eq!(told.code, Some(0), "{}", told.stderr);
    let out = folder.path("out");
    let why = run(&["why", text(&out), "--best", "1", "--backend", "cpu"]).stdout;
    run(&["report", text(&out), "--best", "1", "--backend", "cpu"]);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    let best = why.lines().find(|line| line.contains(" · scene ")).unwrap().split(" · ").next().unwrap();
    let pose = best.split(':').next_back().unwrap();
    assert!(page.contains(&format!("({best})</p>")), "{best} is recommended");
    assert!(told.stdout.contains(pose), "{pose} in {}", told.stdout);
}

#[test]
fn a_picture_is_drawn_by_one_command() {
    let folder = swept();
    let judged = run(&["judge", text(&folder.path("out")), "--backend", "cpu"]).stdout;
    let mut commands: Vec<String> = judged
        .lines()
        .filter(|line| line.contains("perirobot render"))
        .map(|line| line.split(" --out ").next().unwrap().into())
        .collect();
    let all = commands.len();
    commands.sort_unstable();
    commands.dedup();
    assert_eq!(commands.len(), all, "{judged}");
    let same = "(same command as for 7 of 10 body parts are seen, as planned)";
    assert!(judged.contains(same), "{judged}");
    assert!(judged.contains(" requirements met (3 of 5 verdicts are PASS)"), "{judged}");
}

#[test]
fn without_a_pose_the_choices_are_named() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/approach.toml");
    let out = Folder::new();
    let out = out.path("out");
    let outcome = perirobot(&["approach", text(&scenes), "--out", text(&out)]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stdout);
    let said = "--pose is missing: the study has 3 choices of poses: write one of camera:wall/front, camera:wall/back, \
                camera:wall/front;camera:wall/back";
    assert!(outcome.stderr.contains(said), "{}", outcome.stderr);
    let outcome = perirobot(&[
        "approach",
        text(&scenes),
        "--combination",
        "both",
        "--out",
        text(&out),
        "--voxel-size",
        "0.1",
    ]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
}
