//! Sweeps in parts, and the parts put together: what a single run would have left, byte for byte, or a
//! refusal that names what is missing and how to make it.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common::program::{Folder, Outcome, names, perirobot, text};
use crate::common::running::same_bytes;
use serde_json::Value;

/// A study with noise, two scenes, repeats and a combination, so that shards cut through all of them; swept
/// whole.
fn whole() -> Folder {
    let folder = Folder::noisy();
    let both = "[[combination]]\nsensors = [\"camera\"]\n[[combination]]\nname = \"both\"\nsensors = [\"camera\", \"lidar\"]\n";
    folder.edit("study.toml", "", both);
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    fs::rename(folder.path("out"), folder.path("whole")).unwrap();
    folder
}

/// How many choices of poses the study has: 8 of the camera, 8 × 3 of both.
const CHOICES: usize = 32;

#[track_caller]
fn shard(folder: &Folder, shard: &str) {
    let outcome = folder.sweep(&["--shard", shard]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(outcome.stdout.contains("when all are: perirobot merge"), "{}", outcome.stdout);
}

fn merge(folder: &Folder, more: &[&str]) -> Outcome {
    perirobot(&[&["merge", text(&folder.path("out"))], more].concat())
}

/// The merge must fail, saying all this, and write nothing.
#[track_caller]
fn refused(folder: &Folder, more: &[&str], told: &[&str]) {
    let outcome = merge(folder, more);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    for part in told {
        assert!(outcome.stderr.contains(part), "no {part:?} in {}", outcome.stderr);
    }
    for name in ["counts.journal", "manifest.json", "results.csv", "poses.csv"] {
        assert!(!folder.path("out").join(name).exists(), "{name} was written");
    }
}

fn manifest(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("manifest.json")).unwrap()).unwrap()
}

#[test]
fn shards_merge_into_the_bytes_of_a_single_run() {
    let folder = whole();
    for shards in [1, 2, 3, CHOICES] {
        for number in (0..shards).rev() {
            shard(&folder, &format!("{number}/{shards}"));
        }
        for command in ["summary", "report"] {
            let outcome = perirobot(&[command, text(&folder.path("out"))]);
            assert_eq!(outcome.code, Some(2), "{command}");
            let cure = "these are shards: merge them with `perirobot merge`";
            assert!(outcome.stderr.contains(cure), "{command}: {}", outcome.stderr);
        }
        let outcome = merge(&folder, &[]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        assert!(outcome.stdout.contains(&format!("{shards} shards merged")), "{}", outcome.stdout);
        // Once more changes nothing, nor does what is its own part.
        assert_eq!(merge(&folder, &[]).code, Some(0));
        let outcome = merge(&folder, &[text(&folder.path("out"))]);
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(outcome.stderr.contains("is both a shard and the output folder"), "{}", outcome.stderr);
        same_bytes(&folder.path("whole"), &folder.path("out"));
        let [mut one, mut other] = ["whole", "out"].map(|name| manifest(&folder.path(name)));
        assert_eq!(other["runs"].as_array().unwrap().len(), shards);
        for manifest in [&mut one, &mut other] {
            manifest["runs"].take();
            manifest["about"]["command"].take();
        }
        assert_eq!(one, other);
        let [one, other] =
            ["whole", "out"].map(|name| perirobot(&["summary", text(&folder.path(name))]).stdout);
        assert_eq!(one, other);
        fs::remove_dir_all(folder.path("out")).unwrap();
    }
}

#[test]
fn shards_from_other_places_are_named_one_by_one() {
    let folder = whole();
    shard(&folder, "0/2");
    shard(&folder, "1/2");
    for (from, to) in [("out/shard-0-of-2", "here"), ("out/shard-1-of-2", "there")] {
        fs::rename(folder.path(from), folder.path(to)).unwrap();
    }
    let (here, there) = (folder.path("here"), folder.path("there"));
    refused(&folder, &[], &["has no shard folders (shard-0-of-4)"]);
    let outcome = merge(&folder, &[text(&there), text(&here), "--table", "both"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    same_bytes(&folder.path("whole"), &folder.path("out"));
    assert!(folder.path("out/results.parquet").exists());
}

#[test]
fn what_is_missing_is_named_with_the_command_that_makes_it() {
    let folder = whole();
    shard(&folder, "0/3");
    let (study, out) = (folder.path("study.toml"), folder.path("out"));
    let command = |k: u32| {
        format!("perirobot sweep {} --out {} --backend cpu --shard {k}/3\n", text(&study), text(&out))
    };
    refused(
        &folder,
        &[],
        &[
            "shard 1 of 3 is missing; to compute it:",
            &command(1),
            "shard 2 of 3 is missing",
            command(2).trim(),
        ],
    );
    // Whatever the folder is called, and however it was made.
    let odd = folder.path("a --shard 9/9 b");
    let outcome = perirobot(&[
        "sweep",
        text(&study),
        "--out",
        text(&odd),
        "--backend",
        "cpu",
        "--restart",
        "--shard",
        "0/2",
    ]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let outcome = perirobot(&["merge", text(&odd)]);
    let told = format!("perirobot sweep {} --out '{}' --backend cpu --shard 1/2\n", text(&study), text(&odd));
    assert!(outcome.stderr.contains(&told), "{}", outcome.stderr);
    // One that was stopped before its end.
    shard(&folder, "2/3");
    shard(&folder, "1/3");
    let journal =
        fs::File::options().write(true).open(folder.path("out/shard-1-of-3/counts.journal")).unwrap();
    journal.set_len(journal.metadata().unwrap().len() / 2).unwrap();
    drop(journal);
    // 32 choices × 2 scenes × 2 repeats × 3 regions in 2 representations of a camera, and 2 × 2 of both.
    refused(&folder, &[], &["shard 1 of 3 lacks ", command(1).trim()]);
    shard(&folder, "1/3");
    assert_eq!(merge(&folder, &[]).code, Some(0));
    same_bytes(&folder.path("whole"), &out);
}

#[test]
fn shards_that_do_not_belong_together_are_refused() {
    let folder = whole();
    shard(&folder, "0/2");
    shard(&folder, "1/2");
    let of_two = ["out/shard-0-of-2", "out/shard-1-of-2"].map(|name| folder.path(name));
    let [zero, one] = of_two.each_ref().map(|path| text(path));
    refused(&folder, &[zero, zero], &["is the same shard as", "name each once"]);
    refused(&folder, &[one], &["shard 0 of 2 is missing"]);
    shard(&folder, "1/3");
    let third = folder.path("out/shard-1-of-3");
    refused(&folder, &[zero, text(&third)], &["shard-1-of-3: is one of 3 shards, ", "one of 2"]);
    refused(&folder, &[], &["is one of"]);
    refused(&folder, &[zero, text(&folder.path("nowhere"))], &["nowhere"]);
    refused(&folder, &[zero, text(&folder.path("whole"))], &["is one of 1 shards"]);

    folder.edit("study.toml", "seed = 7", "seed = 8");
    let other = folder.path("other");
    let study = folder.path("study.toml");
    let sweep = ["sweep", text(&study), "--out", text(&other), "--backend", "cpu", "--shard", "1/2"];
    assert_eq!(perirobot(&sweep).code, Some(0));
    let other = other.join("shard-1-of-2");
    refused(&folder, &[zero, text(&other)], &["belongs to another sweep than", "study.seed was 7, is 8"]);
}

#[test]
fn a_shard_that_is_damaged_is_not_merged() {
    let folder = whole();
    shard(&folder, "0/2");
    shard(&folder, "1/2");
    let path = folder.path("out/shard-1-of-2/counts.journal");
    let mut bytes = fs::read(&path).unwrap();
    bytes[128 + 88 * 3 + 20] ^= 4;
    fs::write(&path, bytes).unwrap();
    refused(&folder, &[], &["shard 1 of 2 lacks 1 of "]);
    shard(&folder, "1/2");
    assert_eq!(merge(&folder, &[]).code, Some(0));
    same_bytes(&folder.path("whole"), &folder.path("out"));
}

#[test]
fn a_merge_does_not_overwrite_another_sweep() {
    let folder = whole();
    shard(&folder, "0/2");
    shard(&folder, "1/2");
    folder.edit("study.toml", "seed = 7", "seed = 8");
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let before = fs::read(folder.path("out/counts.journal")).unwrap();
    let outcome = merge(&folder, &[]);
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("contains another sweep"), "{}", outcome.stderr);
    assert!(fs::read(folder.path("out/counts.journal")).unwrap() == before);
}

#[test]
fn a_merge_writes_only_where_it_may() {
    let folder = whole();
    for number in ["0/2", "1/2"] {
        shard(&folder, number);
    }
    let of_two = ["out/shard-0-of-2", "out/shard-1-of-2"].map(|name| folder.path(name));
    let [zero, one] = of_two.each_ref().map(|path| text(path));
    // Into a shard, and onto a file that is something else.
    let before = fs::read(folder.path("out/shard-0-of-2/counts.journal")).unwrap();
    let outcome = perirobot(&["merge", zero, zero, one]);
    assert_eq!(outcome.code, Some(2));
    assert!(
        outcome.stderr.contains("contains shard 0 of 2: name another output folder"),
        "{}",
        outcome.stderr
    );
    assert!(fs::read(folder.path("out/shard-0-of-2/counts.journal")).unwrap() == before);
    folder.write("out/counts.journal", [b'x'; 300]);
    let outcome = merge(&folder, &[]);
    assert_eq!(outcome.code, Some(2));
    assert!(
        outcome.stderr.contains("is not a journal of perirobot; name another output folder"),
        "{}",
        outcome.stderr
    );
    assert_eq!(fs::read(folder.path("out/counts.journal")).unwrap(), [b'x'; 300]);
    fs::remove_file(folder.path("out/counts.journal")).unwrap();
    // What a killed merge left goes; what is not ours stays.
    for name in
        ["results.csv.0123456789abcdef.part", "results.csv.mine.part", "results.parquet", "disagreement.json"]
    {
        folder.write(&format!("out/{name}"), "old");
    }
    assert_eq!(merge(&folder, &[]).code, Some(0));
    let mut expected = ["shard-0-of-2", "shard-1-of-2", "results.csv.mine.part"].map(String::from).to_vec();
    expected.extend(names(&folder.path("whole")));
    expected.sort();
    assert_eq!(names(&folder.path("out")), expected);
}

#[test]
fn more_shards_than_files_can_be_open() {
    let folder = whole();
    for number in 0..CHOICES {
        shard(&folder, &format!("{number}/{CHOICES}"));
    }
    let out = folder.path("out");
    let script = "ulimit -n 20; exec \"$@\"";
    let merge = ["-c", script, "sh", env!("CARGO_BIN_EXE_perirobot"), "merge", text(&out)];
    let output = Command::new("sh").args(merge).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    same_bytes(&folder.path("whole"), &out);
}

#[test]
fn engines_say_which_shard_it_is() {
    let folder = whole();
    let (study, out) = (folder.path("study.toml"), folder.path("out"));
    let sweep = |shard: &str, variables: &[(&str, &str)]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_perirobot"));
        command.args(["sweep", text(&study), "--out", text(&out), "--backend", "cpu", "--shard", shard]);
        for name in ["SLURM_ARRAY_TASK_ID", "HQ_TASK_ID", "JOB_COMPLETION_INDEX"] {
            command.env_remove(name);
        }
        command.envs(variables.iter().copied()).output().unwrap()
    };
    // Other counts than N are the engines' affair: of an array that was put back, this task is the only one.
    let numbers = [
        &[("SLURM_ARRAY_TASK_ID", "2"), ("SLURM_ARRAY_TASK_COUNT", "1")][..],
        &[("HQ_TASK_ID", "0")],
        &[("JOB_COMPLETION_INDEX", "1")],
    ];
    for variables in numbers {
        let output = sweep("auto/3", variables);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    assert_eq!(names(&out), ["shard-0-of-3", "shard-1-of-3", "shard-2-of-3"]);
    assert_eq!(merge(&folder, &[]).code, Some(0));
    same_bytes(&folder.path("whole"), &out);
    for variables in [&[][..], &[("HQ_TASK_ID", "3")], &[("HQ_TASK_ID", "0"), ("JOB_COMPLETION_INDEX", "0")]]
    {
        assert_eq!(sweep("auto/3", variables).status.code(), Some(2), "{variables:?}");
    }
}

#[test]
fn there_are_no_more_shards_than_choices() {
    let folder = whole();
    let outcome = folder.sweep(&["--shard", "0/33"]);
    assert_eq!(outcome.code, Some(2));
    let told = format!("--shard 0/33: has no work: the study has only {CHOICES} choices of poses");
    assert!(outcome.stderr.contains(&told), "{}", outcome.stderr);
    assert!(!folder.path("out").exists());
    for wrong in ["3/3", "x/3", "3", "-1/3"] {
        assert_eq!(folder.sweep(&[&format!("--shard={wrong}")]).code, Some(2), "{wrong}");
    }
}

#[test]
fn a_merge_tells_the_verdicts_that_the_sweep_told() {
    let folder = Folder::new();
    let require = "\n[[require]]\nname = \"seen\"\nscore = \"f1\"\nregion = \"robot\"\nat_least = 0.1\n";
    folder.edit("study.toml", "", require);
    let verdicts = |outcome: &Outcome| {
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let (_, told) = outcome.stdout.split_once("\nRequirements, as planned").expect("verdicts");
        let (told, command) = told.split_once("\nnext: perirobot judge ").expect("the command");
        let (told, _) = told.split_once("\n\n").expect("a line between");
        assert!(command.contains(" --pose "), "{command}");
        told.to_string()
    };
    let whole = verdicts(&folder.sweep(&[]));
    assert!(whole.contains("seen (as planned): F1 in region robot is 0."), "{whole}");
    fs::remove_dir_all(folder.path("out")).unwrap();
    ["0/2", "1/2"].into_iter().for_each(|number| shard(&folder, number));
    assert_eq!(verdicts(&merge(&folder, &[])), whole);
    // Of a study that is not there, or has changed, nothing is told but that.
    folder.edit("study.toml", "name = \"robot\"\nsphere", "name = \"tool\"\nsphere");
    folder.edit("study.toml", "region = \"robot\"", "region = \"tool\"");
    for _ in 0..2 {
        let outcome = merge(&folder, &[]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let told = "study.toml: ";
        let untold = "; its requirements are not judged";
        assert!(outcome.stderr.contains(told) && outcome.stderr.contains(untold), "{}", outcome.stderr);
        assert!(!outcome.stdout.contains("Requirements"), "{}", outcome.stdout);
        let _ = fs::remove_file(folder.path("study.toml"));
    }
}
