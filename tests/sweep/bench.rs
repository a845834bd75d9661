//! `perirobot bench`: the shape of its tables, and counts that are equal. No time is asserted.

use crate::common::program::{Folder, perirobot, text};
use perirobot_march::backend::cpu::SimdLevel;

const TINY: &str = "scenes/tiny.toml";

/// Runs a bench of single rounds; it must succeed.
#[track_caller]
fn bench(arguments: &[&str]) -> String {
    let outcome = perirobot(&[&["bench", "--seconds", "0", "--poses", "2"], arguments].concat());
    assert_eq!(outcome.code, Some(0), "{}{}", outcome.stdout, outcome.stderr);
    outcome.stdout
}

/// The cells of the lines of all tables, headings and rules left out.
fn lines(stdout: &str) -> Vec<Vec<&str>> {
    let rows = stdout.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| backend"));
    rows.map(|row| row.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

#[test]
fn a_table_for_each_size_and_each_sensor_that_casts() {
    let stdout = bench(&[TINY, "--voxel-size", "0.1,0.05", "--backend", "cpu", "--threads", "2"]);
    let levels: Vec<_> = SimdLevel::all().into_iter().map(SimdLevel::name).collect();
    let mut names = vec!["oracle, 1 thread".to_owned()];
    names.extend(levels.iter().map(|level| format!("cpu, 1 thread, {level}")));
    let on_all = if levels.len() > 1 { vec![levels[0], levels[levels.len() - 1]] } else { levels };
    names.extend(on_all.iter().map(|level| format!("cpu, 2 threads, {level}")));
    let found = lines(&stdout);
    // Two sizes, each with the camera and the lidar.
    assert_eq!(found.iter().map(|line| line[0]).collect::<Vec<_>>(), vec![names; 4].concat(), "{stdout}");
    for line in &found {
        assert_eq!(line.len(), 7, "{line:?}");
        line[1..].iter().for_each(|cell| assert!(cell.parse::<f64>().is_ok(), "{line:?}"));
        assert_eq!(line[6], "1", "one round: {line:?}");
    }
    assert_eq!(found[0][5], "1.0", "the oracle is its own measure");
    let headings: Vec<_> = stdout.lines().filter(|line| line.starts_with("## ")).collect();
    assert_eq!(headings, ["## scenes/tiny.toml, 10 cm", "## scenes/tiny.toml, 5 cm"]);
    assert!(stdout.contains("robot of 831 voxels, human of 960 voxels"), "{stdout}");
    assert!(stdout.contains("camera: 2 scene-poses, 4608 rays"), "{stdout}");
    assert_eq!(stdout.matches("All counts equal the oracle's.").count(), 4, "{stdout}");
}

#[test]
fn only_the_oracle() {
    let stdout = bench(&[TINY, "--voxel-size", "0.1", "--backend", "oracle"]);
    assert!(lines(&stdout).iter().all(|line| line[0] == "oracle, 1 thread"), "{stdout}");
}

#[test]
fn nothing_to_measure_is_an_error() {
    let folder = Folder::new();
    let study = folder.path("study.toml");
    let written = std::fs::read_to_string(&study).unwrap();
    let (before, _) = written.split_once("[[sensor]]").unwrap();
    let pad = "[[sensor]]\nname = \"pad\"\nkind = \"pad\"\nsize_m = [0.4, 0.4]\nheight_m = 1.0\n\
               [[sensor.poses]]\nname = \"floor\"\nlist = [{ name = \"a\", position_m = [0, 0, 0.3] }]\n";
    folder.write("study.toml", format!("{before}{pad}"));
    let outcome = perirobot(&["bench", text(&study), "--voxel-size", "0.1"]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("study.toml: no combination casts rays"), "{}", outcome.stderr);
    for wrong in ["0", "x", "0.1,-1"] {
        let outcome =
            perirobot(&["bench", TINY, "--voxel-size", wrong, "--backend", "oracle", "--seconds", "0"]);
        assert_eq!(outcome.code, Some(2), "{wrong}: {}", outcome.stderr);
    }
}
