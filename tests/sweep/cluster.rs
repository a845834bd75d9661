//! `perirobot cluster`: the scripts it writes, carried out by stand-ins for the engines' commands and for the
//! sweep, which do as they are told and write down what they were told. `engines.rs` has the engines
//! themselves.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use crate::common::program::{Folder, perirobot, text};

/// A sweep that ends with the code in `code`, or with 75 after USR1 where it says `wait`; it adds a row where
/// there is a file `add`. A merge says so.
const SWEEP: &str = r#"#!/bin/sh
cd "$(dirname "$0")" || exit 9
printf '%s\n' "$@" >>told
[ "$1" = sweep ] || exit 0
folder="out dir's/shard-${SLURM_ARRAY_TASK_ID-}${HQ_TASK_ID-}-of-4"
mkdir -p "$folder"
if [ -e add ]; then echo row >>"$folder/counts.journal"; fi
code=$(head -n 1 code)
sed -i 1d code
[ "$code" != wait ] || { trap 'exit 75' USR1; touch ready; while :; do sleep 0.05; done; }
exit "${code:-0}"
"#;

/// Writes down what it was told; answers like Slurm.
const SLURM: &str = r#"#!/bin/sh
printf '%s' "${0##*/}" >>"$CALLS/calls"
printf ' %s' "$@" >>"$CALLS/calls"
echo >>"$CALLS/calls"
case ${0##*/} in
    sbatch) echo '17;cluster' ;;
    scontrol) [ "$1" = requeue ] || printf 'A = 1\nMaxArraySize            = %s\n' "$(cat "$CALLS/limit")" ;;
esac
"#;

/// A folder with the stand-ins and a script of 4 shards.
struct Cell(Folder);

impl Cell {
    fn new(engine: &str) -> Cell {
        let cell = Cell(Folder::new());
        for (name, script) in [("a sweep", SWEEP), ("sbatch", SLURM), ("scontrol", SLURM)] {
            cell.0.write(name, script);
            fs::set_permissions(cell.0.path(name), fs::Permissions::from_mode(0o755)).unwrap();
        }
        cell.0.write("limit", "1001");
        cell.0.write("code", "");
        let (study, out) = (cell.0.path("study.toml"), cell.0.path("out dir's"));
        let (program, script) = (cell.0.path("a sweep"), cell.0.path("job.sh"));
        let fixed = ["cluster", engine, text(&study), "--shards", "4", "--out", text(&out)];
        let more =
            ["--program", text(&program), "--script", text(&script), "--tries", "2", "--", "--noiseless"];
        let outcome = perirobot(&[&fixed[..], &more[..]].concat());
        assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(0), ""), "{}", outcome.stderr);
        cell
    }

    /// Runs the script in a role, with these variables in its environment.
    fn start(&self, role: &[&str], variables: &[(&str, &str)]) -> Child {
        let folder = self.0.path("");
        let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap());
        let mut command = Command::new("sh");
        command.arg(self.0.path("job.sh")).args(role).envs(variables.iter().copied());
        command.env("PATH", path).env("CALLS", &folder).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().unwrap()
    }

    #[track_caller]
    fn run(&self, role: &[&str], variables: &[(&str, &str)]) -> (Option<i32>, String) {
        let output = self.start(role, variables).wait_with_output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8(said).unwrap())
    }

    /// What a stand-in wrote down; nothing if it was not called.
    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.path(name)).unwrap_or_default()
    }
}

/// A task of Slurm whose array has the number of another task.
const TASK: [(&str, &str); 3] =
    [("SLURM_ARRAY_TASK_ID", "3"), ("SLURM_ARRAY_JOB_ID", "17"), ("SLURM_JOB_ID", "17")];

#[test]
fn slurm_is_given_an_array_and_a_merge_that_waits_for_it() {
    let cell = Cell::new("slurm");
    let (code, said) = cell.run(&[], &[]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.starts_with("job 17 sweeps in 4 tasks, then job 17 merges"), "{said}");
    let calls = cell.read("calls");
    let calls: Vec<&str> = calls.lines().collect();
    let [asked, array, merge] = calls[..] else { panic!("{calls:?}") };
    assert_eq!(asked, "scontrol show config");
    assert!(array.starts_with("sbatch --parsable --job-name=perirobot-study --array=0-3 "), "{array}");
    assert!(array.ends_with("/job.sh shard"), "{array}");
    assert!(merge.contains(" --dependency=afterany:17 ") && merge.ends_with("/job.sh merge"), "{merge}");
    assert!(cell.0.path("out dir's/logs").is_dir());
}

#[test]
fn slurm_with_smaller_arrays_is_given_nothing() {
    let cell = Cell::new("slurm");
    cell.0.write("limit", "3");
    let (code, said) = cell.run(&[], &[]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("at most 3 tasks here") && said.contains("--shards 3"), "{said}");
    assert!(!cell.read("calls").contains("sbatch"));
}

#[test]
fn a_task_sweeps_its_shard_and_the_merge_merges() {
    let cell = Cell::new("slurm");
    assert_eq!(cell.run(&["shard"], &TASK), (Some(0), String::new()));
    let (study, out) = (cell.0.path("study.toml"), cell.0.path("out dir's"));
    let sweep = format!(
        "sweep\n{}\n--out\n{}\n--shard\nauto/4\n--threads\n1\n--noiseless\n",
        study.display(),
        out.display()
    );
    assert_eq!(cell.read("told"), sweep);
    assert_eq!(cell.run(&["merge"], &[]), (Some(0), String::new()));
    assert_eq!(cell.read("told"), format!("{sweep}merge\n{}\n", out.display()));
    assert_eq!(cell.read("calls"), "");
}

/// A task whose sweep ends with `code`, with or without new rows, after so many restarts: is it put back?
#[track_caller]
fn put_back(code: &str, new_rows: bool, restarts: &str) -> bool {
    let cell = Cell::new("slurm");
    cell.0.write("code", format!("{code}\n"));
    if new_rows {
        cell.0.write("add", "");
    }
    let restarts = [("SLURM_RESTART_COUNT", restarts)];
    let (ended, said) = cell.run(&["shard"], &[&TASK[..], &restarts[..]].concat());
    assert_eq!(ended, code.parse().ok(), "{said}");
    match cell.read("calls").as_str() {
        "" => false,
        // The task and no other: 17 alone would be all of them.
        "scontrol requeue 17_3\n" => true,
        calls => panic!("{calls}"),
    }
}

#[test]
fn what_was_stopped_or_failed_goes_back_into_the_queue() {
    assert!(put_back("75", true, "0"));
    assert!(put_back("75", true, "99"), "rows were added");
    assert!(put_back("137", false, "1"));
    assert!(put_back("3", true, "2"));
}

#[test]
fn what_another_try_would_not_change_does_not_go_back() {
    for code in ["0", "1", "2"] {
        assert!(!put_back(code, true, "0"), "{code}");
    }
    assert!(!put_back("75", false, "2"), "tried twice, and no row was added");
    assert!(!put_back("137", false, "2"), "tried twice, and no row was added");
}

/// A task that waits for a signal is sent it; returns its code and what was called.
fn signalled(signal: &str) -> (Option<i32>, String) {
    let cell = Cell::new("slurm");
    cell.0.write("code", "wait\n");
    cell.0.write("add", "");
    let task = cell.start(&["shard"], &TASK);
    while !cell.0.path("ready").exists() {
        sleep(Duration::from_millis(10));
    }
    let kill = |signal: &str, process: String| {
        assert!(Command::new("kill").args([signal, &process]).status().unwrap().success());
    };
    kill(signal, task.id().to_string());
    if signal == "-TERM" {
        // Slurm sends it to the sweep, too; this one knows USR1 only.
        let children = Command::new("pgrep").args(["-P", &task.id().to_string()]).output().unwrap();
        kill("-USR1", String::from_utf8(children.stdout).unwrap().trim().into());
    }
    let output = task.wait_with_output().unwrap();
    (output.status.code(), cell.read("calls"))
}

#[test]
fn the_notice_before_the_time_limit_reaches_the_sweep() {
    assert_eq!(signalled("-USR1"), (Some(75), "scontrol requeue 17_3\n".into()));
}

#[test]
fn a_task_that_slurm_ends_is_left_to_slurm() {
    assert_eq!(signalled("-TERM"), (Some(75), String::new()));
}

#[test]
fn a_task_of_hyperqueue_goes_on_while_it_adds_rows() {
    let cell = Cell::new("hyperqueue");
    fs::create_dir_all(cell.0.path("out dir's/logs")).unwrap();
    cell.0.write("add", "");
    cell.0.write("code", "75\n75\n0\n");
    // A worker that Slurm started has the number of its own task, too.
    let numbers = [("HQ_TASK_ID", "2"), ("SLURM_ARRAY_TASK_ID", "9"), ("JOB_COMPLETION_INDEX", "9")];
    assert_eq!(cell.run(&["shard"], &numbers), (Some(0), String::new()));
    assert_eq!(cell.read("out dir's/shard-2-of-4/counts.journal"), "row\nrow\nrow\n");

    cell.0.write("code", "75\n137\n0\n");
    assert_eq!(cell.run(&["shard"], &[("HQ_TASK_ID", "2")]).0, Some(137));
    fs::remove_file(cell.0.path("add")).unwrap();
    cell.0.write("code", "75\n0\n");
    assert_eq!(cell.run(&["shard"], &[("HQ_TASK_ID", "2")]).0, Some(75));
    assert!(cell.0.path("out dir's/logs/shard-2.out").exists());
}

#[track_caller]
fn refused(arguments: &[&str], expected: &[&str]) {
    let outcome = perirobot(&[&["cluster"], arguments].concat());
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(2), ""), "{arguments:?}");
    for part in expected {
        assert!(outcome.stderr.contains(part), "{arguments:?}: no {part:?} in {}", outcome.stderr);
    }
}

#[test]
fn bad_arguments_are_refused() {
    let tiny = "scenes/tiny.toml";
    refused(&["slurm", tiny, "--shards", "0"], &["--shards 0", "at least 2"]);
    refused(&["hyperqueue", tiny, "--shards", "14"], &["--shards 14", tiny, "13 choices"]);
    refused(&["slurm", tiny, "--shards", "1002"], &["--shards 1002"]);
    refused(&["slurm", "a\nb.toml", "--shards", "2"], &["STUDY", "invisible character (\\u{a})"]);
    refused(&["slurm", tiny, "--shards", "2", "--out", "a\nb"], &["--out", "invisible character"]);
    refused(&["slurm", "none.toml", "--shards", "2"], &["none.toml"]);
    refused(&["slurm", tiny, "--shards", "2", "--", "--bogus"], &["after `--`: ", "--bogus"]);
    refused(&["slurm", tiny, "--shards", "2", "--", "--restart"], &["--restart after `--`"]);
    refused(&["slurm", tiny, "--shards", "2", "--", "--table", "csv"], &["--table after `--`", "the merge"]);
    refused(&["slurm", tiny, "--shards", "2", "--time-limit", "1"], &["--time-limit 1", "5 minutes"]);
    refused(&["kubernetes", tiny, "--shards", "2"], &["--image", "--claim"]);
}
