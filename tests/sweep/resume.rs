//! Sweeps that are ended before they have: by a kill at any moment, a signal, the clock, a full disk. The
//! same command goes on, and what it leaves is what a quiet run leaves, byte for byte. A folder of something
//! else is not gone on with.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::common::program::{Folder, Outcome, names, perirobot, text};
use crate::common::running::{Running, long, same_bytes, size};
use crate::common::{self, Random, say};

const JOURNAL: &str = "out/counts.journal";
const CPU: &[&str] = &["--backend", "cpu"];

/// A file's name and bytes.
type File = (String, Vec<u8>);

/// What a quiet run of the long study leaves, and how long it takes.
static QUIET: LazyLock<(Vec<File>, Duration)> = LazyLock::new(|| {
    let folder = Folder::new();
    long(&folder);
    let begin = Instant::now();
    let outcome = Running::sweep(&folder, &[]).end();
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let out = folder.path("out");
    let files = names(&out).into_iter().map(|name| (name.clone(), fs::read(out.join(name)).unwrap()));
    (files.collect(), begin.elapsed())
});

/// A folder with the long study, and with what a quiet run makes of it in `quiet`.
fn quiet() -> Folder {
    let folder = Folder::new();
    long(&folder);
    fs::create_dir(folder.path("quiet")).unwrap();
    for (name, bytes) in &QUIET.0 {
        fs::write(folder.path("quiet").join(name), bytes).unwrap();
    }
    folder
}

/// The same command once more; it must finish.
#[track_caller]
fn go_on(folder: &Folder) -> Outcome {
    let outcome = Running::sweep(folder, &[]).end();
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    same_bytes(&folder.path("quiet"), &folder.path("out"));
    outcome
}

/// The runs that a manifest tells of.
fn runs(out: &Path) -> Vec<serde_json::Value> {
    let text = fs::read(out.join("manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_slice(&text).unwrap();
    manifest["runs"].as_array().unwrap().clone()
}

/// Sweeps until it has killed so many runs, each at a random moment, and compares whatever finishes. Each run
/// is on one of `backends`.
fn killed(kills: u32, backends: &[&[&str]]) {
    let (folder, whole) = (quiet(), QUIET.1);
    let mut random = Random(whole.as_nanos() as u64);
    let (mut killed, mut finished, mut left) = (0, 0, 0);
    while killed < kills || finished == 0 {
        let mut run = Running::sweep(&folder, random.of(backends));
        // From before it reads the study to when it has written more than there was.
        let rows = size(&folder.path(JOURNAL));
        let _ = killed % 2 == 0 || run.until_rows(&folder.path(JOURNAL), rows);
        sleep(whole.mul_f64(f64::from(random.below(1000)) / 5000.0));
        // Now and then a signal first, so that the kill meets a run that is about to stop.
        if random.one_in(4) {
            run.signal(["INT", "TERM", "USR1"][random.below(3) as usize]);
        }
        if killed < kills {
            run.signal("KILL");
        }
        let outcome = run.end();
        match outcome.code {
            None => {
                killed += 1;
                left += u32::from(size(&folder.path(JOURNAL)) > 128);
            }
            Some(0) => {
                finished += 1;
                same_bytes(&folder.path("quiet"), &folder.path("out"));
                let all = ["counts.journal", "manifest.json", "poses.csv", "results.csv", "scores.csv"];
                assert_eq!(names(&folder.path("out")), all, "what was half-written is gone");
                fs::remove_dir_all(folder.path("out")).unwrap();
            }
            // A signal while it sets about to listen ends it as it ends any program.
            Some(75) => {}
            Some(code) => panic!("exit code {code}: {}", outcome.stderr),
        }
    }
    say(&format!(
        "{killed} runs killed, {left} of them with rows; {finished} sweeps finished, differences: 0"
    ));
}

#[test]
fn a_sweep_that_is_killed_again_and_again_ends_as_a_quiet_one() {
    killed(5, &[CPU]);
}

/// `PERIROBOT_KILLS=200 cargo test --test sweep resume::soak -- --ignored` for more.
#[test]
#[ignore = "takes minutes"]
fn soak() {
    let kills =
        std::env::var("PERIROBOT_KILLS").map_or(60, |text| text.parse().expect("PERIROBOT_KILLS: a number"));
    let gpu = common::on_adapter();
    let mut backends = vec![CPU; 3];
    backends.extend(gpu.iter().map(|gpu| &gpu[..]));
    killed(kills, &backends);
}

#[test]
fn a_signal_finishes_the_batch_and_says_how_to_go_on() {
    let folder = quiet();
    let mut rows = 0;
    for (signal, name) in [("INT", "Ctrl-C (SIGINT)"), ("TERM", "SIGTERM"), ("USR1", "SIGUSR1")] {
        let mut run = Running::sweep(&folder, &[]);
        assert!(run.until_rows(&folder.path(JOURNAL), rows));
        run.signal(signal);
        let outcome = run.end();
        assert_eq!(outcome.code, Some(75), "{signal}: {}", outcome.stderr);
        rows = size(&folder.path(JOURNAL));
        let ended = format!("stopped by {name}");
        assert!(outcome.stderr.contains(&ended), "{}", outcome.stderr);
        assert!(
            outcome.stderr.contains("scene-poses are left; to go on: perirobot sweep"),
            "{}",
            outcome.stderr
        );
        assert_eq!(runs(&folder.path("out")).last().unwrap()["ended"], ended);
        assert!(!folder.path("out/results.csv").exists(), "no table before the end");
    }
    let outcome = go_on(&folder);
    assert!(outcome.stderr.contains("scene-poses are finished already"), "{}", outcome.stderr);
    let ends: Vec<_> = runs(&folder.path("out")).iter().map(|run| run["poses"].as_u64().unwrap()).collect();
    assert_eq!((ends.len(), ends.iter().sum::<u64>()), (4, 622), "each is counted once: {ends:?}");

    // A finished sweep is not run again, and its tables come out the same.
    fs::remove_file(folder.path("out/results.csv")).unwrap();
    go_on(&folder);
    assert_eq!(runs(&folder.path("out")).len(), 4);
}

#[test]
fn the_clock_stops_a_sweep_and_the_next_goes_on() {
    let folder = quiet();
    let limit = format!("{}s", QUIET.1.as_secs_f64() / 4.0);
    let mut stopped = 0;
    loop {
        let outcome = Running::sweep(&folder, &["--max-time", &limit]).end();
        match outcome.code {
            Some(75) => {
                assert!(outcome.stderr.contains("stopped by --max-time"), "{}", outcome.stderr);
                stopped += 1;
            }
            Some(0) => break,
            code => panic!("{code:?}: {}", outcome.stderr),
        }
    }
    assert!(stopped > 0);
    same_bytes(&folder.path("quiet"), &folder.path("out"));
}

/// 200 snapshots of a person who walks through a fine grid: more work than a signal takes to arrive.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_is_heard_while_scenes_are_made_ready() {
    let folder = Folder::new();
    let places: Vec<String> =
        (0..200).map(|i| format!("[0.1, {}, 0.65]", -0.6 + 0.005 * f64::from(i))).collect();
    let moving = format!("snapshots = {{ position_m = [{}] }}", places.join(", "));
    folder.edit("cell.toml", "position_m = [0.1, -0.45, 0.65]", &moving);
    folder.edit("study.toml", "voxel_size_m = 0.1", "voxel_size_m = 0.02");
    let mut sweep = Running::sweep(&folder, &[]);
    sweep.until_it_catches_signals();
    assert!(sweep.signal("TERM"));
    let outcome = sweep.end();
    assert_eq!(outcome.code, Some(75), "{}", outcome.stderr);
    let told = "stopped by SIGTERM while scenes were made ready; to go on: perirobot sweep";
    assert!(outcome.stderr.contains(told), "{}", outcome.stderr);
    assert!(!folder.path("out").exists());
}

#[test]
fn no_time_at_all_is_time_for_nothing() {
    let folder = Folder::new();
    let outcome = folder.sweep(&["--max-time", "0s"]);
    assert_eq!(outcome.code, Some(75), "{}", outcome.stderr);
    assert!(
        outcome.stderr.contains("stopped by --max-time while scenes were made ready"),
        "{}",
        outcome.stderr
    );
    assert!(!folder.path("out").exists());
    for wrong in ["soon", "-1s", "1e99h"] {
        let outcome = folder.sweep(&[&format!("--max-time={wrong}")]);
        assert_eq!(outcome.code, Some(2), "{wrong}");
        assert!(outcome.stderr.contains("--max-time"), "{}", outcome.stderr);
    }
    assert_eq!(folder.sweep(&["--max-time=1e12d"]).code, Some(0), "longer than any clock runs");
}

/// Files may not grow beyond a limit: to a program that is a disk which is full, but for the words.
fn sweep_with_a_full_disk(folder: &Folder, blocks: u64) -> Outcome {
    let (study, out) = (folder.path("study.toml"), folder.path("out"));
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
    let fixed =
        ["-c", &script, "sh", env!("CARGO_BIN_EXE_perirobot"), "sweep", text(&study), "--out", text(&out)];
    let output = std::process::Command::new("sh").args(fixed).args(["--backend", "cpu"]).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Outcome { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

#[test]
fn a_full_disk_loses_nothing() {
    let folder = quiet();
    let blocks_of = |file: &str| size(&folder.path("quiet").join(file)) / 512 + 1;
    let [poses, journal, results] = ["poses.csv", "counts.journal", "results.csv"].map(blocks_of);
    assert!(poses < journal && journal < results, "{poses} {journal} {results}");
    // Room for a part of the journal, then for all of it, but not for the table.
    for (blocks, file, finished) in [(poses, "counts.journal", false), (journal, "results.csv", true)] {
        let outcome = sweep_with_a_full_disk(&folder, blocks);
        assert_eq!(outcome.code, Some(3), "{}", outcome.stderr);
        assert!(
            outcome.stderr.contains(file) && outcome.stderr.contains("cannot be written"),
            "{}",
            outcome.stderr
        );
        assert!(outcome.stderr.contains("run the same command again"), "{}", outcome.stderr);
        let left = names(&folder.path("out"));
        assert_eq!(left, ["counts.journal", "manifest.json", "poses.csv"], "nothing half-written");
        assert_eq!(runs(&folder.path("out")).last().unwrap()["ended"] == "finished", finished);
    }
    let outcome = go_on(&folder);
    assert!(outcome.stderr.contains("622 of 622 scene-poses are finished already"), "{}", outcome.stderr);
}

#[test]
fn two_runs_do_not_share_a_folder() {
    let folder = quiet();
    let mut run = Running::sweep(&folder, &[]);
    assert!(run.until_rows(&folder.path(JOURNAL), 0));
    for restart in [&[][..], &["--restart"]] {
        let other = folder.sweep(restart);
        assert_eq!(other.code, Some(75), "{}", other.stderr);
        assert!(other.stderr.contains("another run uses this folder"), "{}", other.stderr);
    }
    let summary = perirobot(&["summary", text(&folder.path("out"))]);
    assert_eq!(summary.code, Some(75));
    assert!(summary.stderr.contains("a run still uses this folder"), "{}", summary.stderr);
    let outcome = run.end();
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    same_bytes(&folder.path("quiet"), &folder.path("out"));
}

#[test]
fn damaged_rows_are_counted_again() {
    let folder = quiet();
    let (quiet, out) = (folder.path("quiet"), folder.path("out"));
    fs::create_dir(&out).unwrap();
    for name in ["counts.journal", "manifest.json"] {
        fs::copy(quiet.join(name), out.join(name)).unwrap();
    }
    let mut bytes = fs::read(out.join("counts.journal")).unwrap();
    let (early, late) = (128 + 88 * 10 + 5, bytes.len() - 88 * 20 - 1);
    bytes[early] ^= 1;
    bytes[late] ^= 0x80;
    bytes.truncate(bytes.len() - 70);
    fs::write(out.join("counts.journal"), bytes).unwrap();
    let outcome = go_on(&folder);
    // The two that were changed, and the one that was cut through; the last one is only missing.
    assert!(outcome.stderr.contains("3 rows are damaged and are counted again"), "{}", outcome.stderr);
}

/// Sweeps the small study, changes something, and sweeps again.
#[track_caller]
fn after(change: impl FnOnce(&Folder)) -> (Folder, Outcome) {
    let folder = Folder::new();
    folder.write("body.stl", fs::read("tests/fuzz/corpus/stl/binary.stl").unwrap());
    folder.edit("cell.toml", "", "[[object]]\nname = \"body\"\nmesh = \"body.stl\"\n");
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    change(&folder);
    let outcome = folder.sweep(&[]);
    (folder, outcome)
}

#[test]
fn a_changed_study_is_refused_with_what_changed() {
    type Change = fn(&Folder);
    let changes: [(Change, &[&str]); 5] = [
        (|f| f.edit("study.toml", "seed = 7", "seed = 8"), &["study.seed was 7, is 8"]),
        (|f| f.edit("study.toml", "z_m = [1.2]", "z_m = [1.2, 1.3]"), &["study.sensor[0].poses[0].z_m"]),
        (
            |f| f.edit("cell.toml", "radius_m = 0.12", "radius_m = 0.13"),
            &["scene_files[0].says.object[3].sphere.radius_m was 0.12, is 0.13"],
        ),
        (
            |f| {
                let mut bytes = fs::read(f.path("body.stl")).unwrap();
                bytes[0] ^= 1;
                f.write("body.stl", bytes);
            },
            &["files.", "body.stl differs"],
        ),
        (
            |f| {
                fs::rename(f.path("body.stl"), f.path("other.stl")).unwrap();
                f.edit("cell.toml", "body.stl", "other.stl");
            },
            &["scene_files[0].says.object[6].mesh was \"body.stl\", is \"other.stl\""],
        ),
    ];
    for (change, told) in changes {
        let (folder, outcome) = after(change);
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        for part in [&["contains another sweep", "--restart", "another folder"], told].concat() {
            assert!(outcome.stderr.contains(part), "no {part:?} in {}", outcome.stderr);
        }
        // It is still what it was, until it is begun anew.
        let before = fs::read(folder.path("out/results.csv")).unwrap();
        let outcome = folder.sweep(&["--restart"]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        fs::rename(folder.path("out"), folder.path("quiet")).unwrap();
        assert_eq!(folder.sweep(&[]).code, Some(0));
        same_bytes(&folder.path("quiet"), &folder.path("out"));
        assert!(!before.is_empty());
    }
    let outcome = {
        let folder = Folder::new();
        folder.sweep(&[]);
        folder.sweep(&["--voxel-size", "0.05"])
    };
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("voxel_size_m was 0.1, is 0.05"), "{}", outcome.stderr);
}

#[test]
fn what_decides_nothing_may_change() {
    let (folder, outcome) = after(|folder| {
        folder.edit("study.toml", "seed = 7", "# the third\nseed   = 7");
        folder.edit("cell.toml", "interior = \"free\"", "interior = 'free' # hollow");
    });
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("11 of 11 scene-poses are finished already"), "{}", outcome.stderr);
    assert_eq!(runs(&folder.path("out")).len(), 1);
}

#[test]
fn a_sweep_begun_on_one_device_goes_on_on_another() {
    let Some(gpu) = common::on_adapter() else { return };
    let folder = quiet();
    let mut rows = 0;
    for backend in [CPU, &gpu] {
        let mut run = Running::sweep(&folder, backend);
        assert!(run.until_rows(&folder.path(JOURNAL), rows));
        run.signal("TERM");
        let outcome = run.end();
        assert_eq!(outcome.code, Some(75), "{}", outcome.stderr);
        rows = size(&folder.path(JOURNAL));
    }
    go_on(&folder);
    let runs = runs(&folder.path("out"));
    let backends: Vec<_> = runs.iter().map(|run| run["backend"].as_str().unwrap()).collect();
    assert_eq!(backends, ["cpu", "gpu", "cpu"]);
    assert!(runs[1]["verified"].as_u64().unwrap() >= 3, "{}", runs[1]);
}

#[test]
fn tables_without_a_journal_are_not_lost() {
    let folder = Folder::new();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let before = fs::read(folder.path("out/results.csv")).unwrap();
    fs::remove_file(folder.path(JOURNAL)).unwrap();
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(
        outcome.stderr.contains("results.csv: belongs to an earlier sweep")
            && outcome.stderr.contains("--restart")
    );
    assert!(fs::read(folder.path("out/results.csv")).unwrap() == before);
    assert_eq!(folder.sweep(&["--restart"]).code, Some(0));
}

#[test]
fn a_study_s_own_file_is_not_written_over() {
    let folder = Folder::new();
    let table = "pose,x_m,y_m,z_m,qw,qx,qy,qz\nmine,0,0,1.2,1,0,0,0\n";
    folder.write("poses.csv", table);
    folder.edit(
        "study.toml",
        "[[sensor.poses]]\nname = \"random\"",
        "[[sensor.poses]]\nname = \"own\"\ncsv = \"poses.csv\"\n[[sensor.poses]]\nname = \"random\"",
    );
    let (study, out) = (folder.path("study.toml"), folder.path("."));
    let outcome = perirobot(&["sweep", text(&study), "--out", text(&out), "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("poses.csv: is a file of the study"), "{}", outcome.stderr);
    assert_eq!(fs::read_to_string(folder.path("poses.csv")).unwrap(), table);
    assert_eq!(folder.sweep(&[]).code, Some(0));
}

#[test]
fn what_is_said_to_go_on_does_not_begin_anew() {
    let folder = Folder::new();
    let outcome = folder.sweep(&["--restart", "--max-time", "0s"]);
    assert_eq!(outcome.code, Some(75));
    assert!(outcome.stderr.contains("to go on: perirobot sweep") && !outcome.stderr.contains("--restart"));
}

#[cfg(target_os = "linux")]
#[test]
fn nobody_has_to_listen() {
    let folder = Folder::new();
    let (study, out) = (folder.path("study.toml"), folder.path("out"));
    let sweep = |more: &[&str]| {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_perirobot"));
        command.args(["sweep", text(&study), "--out", text(&out), "--backend", "cpu"]).args(more);
        command.stdout(std::process::Stdio::null()).stderr(full).status().unwrap().code()
    };
    assert_eq!(sweep(&["--max-time", "0s"]), Some(75));
    assert_eq!(sweep(&["--progress", "json", "-vv"]), Some(0));
    assert_eq!(sweep(&["--voxel-size", "0.05"]), Some(2));
}

#[test]
fn a_file_that_is_no_journal_is_not_overwritten() {
    let folder = Folder::new();
    fs::create_dir(folder.path("out")).unwrap();
    folder.write(JOURNAL, [b'x'; 300]);
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    let told = "counts.journal: is not a journal of perirobot; name another folder, or move it away";
    assert!(outcome.stderr.contains(told) && !outcome.stderr.contains("--restart"), "{}", outcome.stderr);
    assert_eq!(fs::read(folder.path(JOURNAL)).unwrap(), [b'x'; 300]);
    assert_eq!(folder.sweep(&["--restart"]).code, Some(0));
}
