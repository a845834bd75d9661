//! What a stranger, a copy that was cut short or a broken disk may leave in the folder of a sweep: it is
//! refused with exit code 2 in words that name the file, before it costs time or memory.

use std::fs;

use crate::common::program::{self, Folder, perirobot, text};
use perirobot_sweep::results::journal::{Journal, JournalHeader, Locked, Shard};
use perirobot_sweep::results::manifest::Manifest;
use serde_json::{Value, json};

/// A folder with the small study, swept: 8 and 3 choices of poses, one block of 33 rows.
fn swept(more: &[&str]) -> Folder {
    let folder = Folder::new();
    let outcome = folder.sweep(more);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    folder
}

/// Whatever reads the results of a sweep must refuse the folder, in words that hold all of `expected`.
#[track_caller]
fn unread(folder: &Folder, expected: &[&str]) {
    ["summary", "why", "report"].into_iter().for_each(|command| refused(folder, command, expected));
}

/// The command must refuse the folder in words that hold all of `expected`, and give terminals nothing to
/// obey.
#[track_caller]
fn refused(folder: &Folder, command: &str, expected: &[&str]) {
    let ask = || perirobot(&[command, text(&folder.path("out"))]);
    // A child that another test is starting holds this program's locks until it is a program of its own.
    let still_locked = |outcome: &program::Outcome| outcome.code == Some(75);
    let outcome = (0..100).map(|_| ask()).find(|outcome| !still_locked(outcome)).unwrap_or_else(ask);
    let what = format!("{command}, {expected:?}: {:?}\n{}", outcome.code, outcome.stderr);
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(2), ""), "{what}");
    for fragment in expected {
        assert!(outcome.stderr.contains(fragment), "no {fragment:?} in {what}");
    }
    assert!(!outcome.stderr.contains("panicked") && !outcome.stderr.contains('\u{1b}'), "{what}");
}

/// Begins the journal of a folder anew, without rows, with a header that is right but for what is changed;
/// its fingerprint is the manifest's.
fn begin(folder: &Folder, name: &str, change: impl FnOnce(&mut JournalHeader)) {
    let out = folder.path(name);
    let mut header = Journal::read(&out).unwrap().header().clone();
    header.fingerprint = Manifest::read(&out).unwrap().fingerprint();
    change(&mut header);
    drop(Locked::open(&out).unwrap().begin(header).unwrap());
}

/// Changes the manifest.
fn edit(folder: &Folder, change: impl FnOnce(&mut Value)) {
    let path = folder.path("out/manifest.json");
    let mut manifest: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    change(&mut manifest);
    fs::write(&path, serde_json::to_vec_pretty(&manifest).unwrap()).unwrap();
}

#[test]
fn a_journal_that_keeps_other_rows_than_its_shard_is_not_believed() {
    let folder = swept(&[]);
    // A whole without rows would be finished, and asking for one of them a panic.
    for kept in [0..0, 33..33] {
        begin(&folder, "out", |header| header.kept = kept.clone());
        unread(&folder, &["counts.journal: has a damaged beginning"]);
        begin_anew(&folder);
    }
    for kept in [0..3, 3..33, 0..32] {
        begin(&folder, "out", |header| header.kept = kept.clone());
        let rows = format!("has rows {kept:?} of each block as shard 0 of 1");
        unread(&folder, &["counts.journal", &rows, "11 choices of poses", "sweep again"]);
    }
    for (number, of) in [(5, 3), (1, 1), (0, 0)] {
        begin(&folder, "out", |header| header.shard = Shard { number, of });
        unread(&folder, &["counts.journal: has a damaged beginning"]);
        begin_anew(&folder);
    }
    // The rows of the last of four billion shards are the last choice's; there cannot be so many.
    let last = Shard { number: u32::MAX - 1, of: u32::MAX };
    begin(&folder, "out", |header| (header.shard, header.kept) = (last, 30..33));
    unread(&folder, &["has rows 30..33", "shard 4294967294 of 4294967295"]);
}

/// A journal that can be read again.
fn begin_anew(folder: &Folder) {
    fs::remove_file(folder.path("out/counts.journal")).unwrap();
    assert_eq!(folder.sweep(&["--restart"]).code, Some(0));
}

#[test]
fn rows_that_are_promised_take_no_time() {
    let folder = swept(&[]);
    edit(&folder, |manifest| manifest["repeats"] = json!(30_000_000));
    begin(&folder, "out", |header| header.blocks = 30_000_000);
    unread(&folder, &["is not finished: 990000000 rows are missing"]);
    edit(&folder, |manifest| manifest["repeats"] = json!(40_000_000));
    begin(&folder, "out", |header| header.blocks = 40_000_000);
    unread(&folder, &["manifest.json: has an impossible number of rows: 1320000000 (repeats = 40000000)"]);
}

#[test]
fn what_a_merge_lacks_is_told_in_part() {
    let folder = Folder::new();
    assert_eq!(folder.sweep(&["--shard", "10/11"]).code, Some(0));
    let absent: Vec<String> =
        (0..10).map(|n| format!("\n  shard {n} of 11 is missing; to compute it")).collect();
    let absent: Vec<&str> = absent.iter().map(String::as_str).collect();
    refused(&folder, "merge", &absent);
    // Now the last one lacks its rows, too.
    begin(&folder, "out/shard-10-of-11", |_| {});
    refused(&folder, "merge", &[&absent[..], &["\n  and 1 more\n"]].concat());
    fs::rename(folder.path("out/shard-10-of-11"), folder.path("out/shard-2-of-11")).unwrap();
    begin(&folder, "out/shard-2-of-11", |header| (header.shard.number, header.kept) = (2, 6..9));
    let lacks = ["\n  shard 1 of 11 is missing", "\n  shard 2 of 11 lacks 3 of 3 rows", "\n  and 1 more\n"];
    refused(&folder, "merge", &lacks);
}

#[test]
fn manifests_that_promise_nonsense_are_refused() {
    let twice = json!([[[0, 2], [1, 3]]]);
    let many = |value: Value| Value::Array(vec![value; 40]);
    for (change, expected) in [
        (
            &(|m: &mut Value| m["sensors"][0]["representations"] = json!([])) as &dyn Fn(&mut Value),
            &["combination \"camera\" must have a representation of each sensor"][..],
        ),
        (
            // 2⁴⁰ names.
            &|m| {
                m["sensors"][0]["representations"] = json!(["a", "b"]);
                m["combinations"][0]["sensors"] = many(json!("camera"));
                m["combinations"][0]["poses"] = many(json!([[0, 1]]));
            },
            &["combination \"camera\"", "not too many together"],
        ),
        (&|m| m["combinations"][0]["poses"] = twice.clone(), &["\"camera\" has poses of \"camera\" twice"]),
        (&|m| m["combinations"][0]["poses"] = json!([[[2, 3], [0, 1]]]), &["has poses of \"camera\" twice"]),
        (&|m| m["combinations"][0]["poses"] = json!([[[0, 9]]]), &["unknown poses of \"camera\""]),
        (
            &|m| m["combinations"][0]["poses"] = json!([[[0, 600_000_000], [0, 600_000_000]]]),
            &["has 1200000003 poses in its combinations, but at most 1000000000 are possible"],
        ),
        (&|m| m["combinations"][0]["name"] = json!("\u{1b}[2J"), &["\"\\u{1b}[2J\" has control characters"]),
        (&|m| m["scenes"][0]["name"] = json!("a\nb"), &["the name \"a\\nb\" has control characters"]),
        (&|m| m["scenes"][0]["regions"][1]["name"] = json!("\u{9b}"), &["\"\\u{9b}\" has control"]),
        (&|m| m["sensors"][1]["representations"] = json!(["\u{7}"]), &["\"\\u{7}\" has control"]),
        (&|m| m["sensors"][1]["poses"] = json!(u64::MAX), &["poses.csv: ends after line 12"]),
    ] {
        let folder = swept(&[]);
        edit(&folder, change);
        unread(&folder, &[expected, &["sweep again"]].concat());
    }
    let folder = swept(&[]);
    folder.edit("out/poses.csv", "wall/0/0,wall", "wall/0/0,\u{1b}[2J");
    unread(&folder, &["poses.csv: line 2, column group: \"\\u{1b}[2J\" has control characters"]);
}

#[test]
fn what_a_manifest_says_cannot_steer_a_terminal() {
    let folder = swept(&[]);
    edit(&folder, |manifest| manifest["about"]["command"] = json!(["perirobot\u{1b}]0;x\u{7}", "sweep\r"]));
    begin(&folder, "out", |_| {});
    unread(&folder, &["33 rows are missing", "'perirobot\\u{1b}]0;x\\u{7}' 'sweep\\u{d}'\n"]);
}

#[test]
fn only_regular_files_of_a_sane_size_are_read() {
    let folder = swept(&[]);
    for name in ["manifest.json", "poses.csv", "counts.journal"] {
        let (path, aside) = (folder.path("out").join(name), folder.path(name));
        fs::rename(&path, &aside).unwrap();
        fs::create_dir(&path).unwrap();
        unread(&folder, &[name, "is not a regular file"]);
        fs::remove_dir(&path).unwrap();
        if name != "counts.journal" {
            // All of it is a hole.
            fs::File::create(&path).unwrap().set_len((1 << 30) + 1).unwrap();
            unread(&folder, &[name, "has 1073741825 bytes: at most 1024 MiB are read"]);
        }
        fs::rename(&aside, &path).unwrap();
    }
    // Nobody writes to the pipe: to open it would be to wait.
    #[cfg(unix)]
    {
        fs::remove_file(folder.path("out/counts.journal")).unwrap();
        let made = std::process::Command::new("mkfifo").arg(folder.path("out/counts.journal")).status();
        assert!(made.unwrap().success());
        unread(&folder, &["counts.journal", "is not a regular file"]);
    }
}
