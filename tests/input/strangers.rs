//! Files, names and places that somebody else chose: nothing that a terminal or a browser would obey comes
//! out, nothing takes long or stops the program, and what may pass is not called wrong.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::thread::sleep;
use std::time::Duration;

use crate::common::program::{Folder, Outcome, names, perirobot, text};
use crate::common::running::Running;
use base64::{Engine, prelude::BASE64_STANDARD};
use sha2::{Digest, Sha256};

/// Fails unless it ended so, with these words.
#[track_caller]
fn ended(outcome: &Outcome, code: i32, words: &[&str]) {
    assert_eq!(outcome.code, Some(code), "{}", outcome.stderr);
    for word in words {
        assert!(outcome.stderr.contains(word), "no {word:?} in {}", outcome.stderr);
    }
    assert!(!outcome.stderr.contains("panicked"), "{}", outcome.stderr);
}

#[test]
fn no_text_moves_a_terminal() {
    let folder = Folder::new();
    let evil = folder.path("\u{1b}[2Jevil\u{202e}");
    fs::create_dir(&evil).unwrap();
    for name in ["study.toml", "cell.toml"] {
        fs::copy(folder.path(name), evil.join(name)).unwrap();
    }
    let study = evil.join("study.toml");
    let (study, out, spelt) = (text(&study), text(&evil).to_string(), "\\u{1b}[2Jevil\\u{202e}");
    for (arguments, code) in [
        (&["check", study, "--poses", "0"][..], 0),
        (&["-v", "sweep", study, "--out", &out, "--backend", "cpu"], 0),
        (&["check", &out], 2),
        (&["check", study, "--memory", &out], 2),
    ] {
        let outcome = perirobot(arguments);
        assert_eq!(outcome.code, Some(code), "{}", outcome.stderr);
        let said = outcome.stdout + &outcome.stderr;
        assert!(!said.contains(['\u{1b}', '\u{202e}']), "{said:?}");
        assert!(said.contains(spelt), "{said}");
    }
}

#[test]
fn names_have_an_end() {
    let folder = Folder::new();
    let (long, study) = ("x".repeat(65_536), folder.path("study.toml"));
    folder.edit("study.toml", "name = \"robot\"", &format!("name = \"{long}\""));
    folder.edit("cell.toml", "name = \"crate\"", &format!("name = \"{long}\""));
    let outcome = perirobot(&["check", text(&study)]);
    ended(&outcome, 2, &["region \"xxxx", "object \"xxxx", "its name has more than 1000 characters"]);
    folder.edit("study.toml", &long, &long[..1000]);
    folder.edit("cell.toml", &long, &long[..1000]);
    ended(&perirobot(&["check", text(&study), "--poses", "0"]), 0, &[]);
}

#[test]
fn xml_with_too_many_attributes_is_not_parsed() {
    let folder = Folder::new();
    let attributes: String = (0..200_000).map(|i| format!(" a{i}='1'")).collect();
    folder.write("arm.urdf", format!("<robot name='arm'>\n<link name='base'{attributes}/></robot>"));
    folder.edit("cell.toml", "", "[[object]]\nname = \"robot\"\nurdf = \"arm.urdf\"\n");
    let outcome = perirobot(&["check", text(&folder.path("study.toml"))]);
    ended(&outcome, 2, &["arm.urdf: line 2: an element has more than 256 attributes"]);
    folder.write("arm.urdf", "<robot name='arm'><link name='base'><collision><geometry><mesh filename='base.dae'/></geometry></collision></link></robot>");
    folder.write("base.dae", format!("<COLLADA{attributes}/>"));
    let outcome = perirobot(&["check", text(&folder.path("study.toml"))]);
    ended(&outcome, 2, &["base.dae: line 1: an element has more than 256 attributes"]);
}

#[test]
fn threads_have_an_end_and_may_be_missing() {
    let folder = Folder::new();
    let study = folder.path("study.toml");
    let outcome = perirobot(&["check", text(&study), "--threads", "65535"]);
    ended(&outcome, 2, &["65535", "1..=1024"]);
    // Room for the program, not for the stacks of so many threads.
    let script = "ulimit -v 1500000; exec \"$@\"";
    let check = ["-c", script, "sh", env!("CARGO_BIN_EXE_perirobot"), "check", text(&study)];
    let limited = |more: &[&str]| {
        let output = Command::new("sh").args(check).args(more).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Outcome { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    };
    // Where memory ends just as a thread that was started asks for its own, the standard library aborts: then
    // once more.
    let mut outcomes = (0..50).map(|_| limited(&["--backend", "cpu", "--threads", "1024"]));
    let outcome = outcomes.find(|outcome| outcome.code.is_some()).expect("one that was not aborted");
    assert_eq!(outcome.code, Some(3), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("error: cannot start 1024 threads"), "{}", outcome.stderr);
    ended(&limited(&["--backend", "cpu", "--threads", "1", "--poses", "0"]), 0, &[]);
}

/// The memory of a process is a regular file that cannot be read at its beginning: an input/output error.
#[test]
fn a_disk_that_fails_is_not_the_users_fault() {
    let folder = Folder::new();
    folder.edit("cell.toml", "", "[[object]]\nname = \"map\"\noctomap = \"/proc/self/mem\"\n");
    let study = folder.path("study.toml");
    let check = ["check", text(&study), "--allow-outside"];
    ended(&perirobot(&check), 3, &["/proc/self/mem: cannot be read: Input/output error"]);
    ended(&folder.sweep(&["--allow-outside"]), 3, &["/proc/self/mem: cannot be read: Input/output error"]);
    folder.edit("study.toml", "file = \"cell.toml\"", "file = \"/proc/self/mem\"");
    ended(&perirobot(&check), 3, &["scene[0].file: /proc/self/mem: cannot be read: Input/output error"]);
    // What is wrong in any case stays wrong.
    folder.edit("study.toml", "file = \"/proc/self/mem\"", "file = \"gone.toml\"");
    ended(&perirobot(&check), 2, &["gone.toml: cannot be read"]);
}

#[test]
fn a_place_that_cannot_be_written_is_found_before_anything_is_computed() {
    let folder = Folder::new();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let out = folder.path("out");
    // Were the study read first, it would be told that it is gone.
    fs::rename(folder.path("study.toml"), folder.path("away.toml")).unwrap();
    let page = folder.path("no/such/page.html");
    let outcome = perirobot(&["report", text(&out), "--out", text(&page)]);
    ended(&outcome, 2, &["no/such/page.html: cannot be written"]);
    fs::create_dir(folder.path("out/reasons.csv")).unwrap();
    ended(&perirobot(&["why", text(&out)]), 2, &["out/reasons.csv: cannot be written"]);
    fs::rename(folder.path("away.toml"), folder.path("study.toml")).unwrap();
    fs::remove_dir(folder.path("out/reasons.csv")).unwrap();
    ended(&perirobot(&["why", text(&out)]), 0, &[]);
}

/// Waits for a part in a folder.
fn part(folder: &Path) -> String {
    loop {
        let part = names(folder).into_iter().find(|name| name.ends_with(".part"));
        if let Some(part) = part {
            return part;
        }
        sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_report_that_is_stopped_leaves_nothing() {
    let folder = Folder::new();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let out = folder.path("out");
    let before = names(&out);
    let report = || {
        let report = Running::start(&["report", text(&out), "--backend", "cpu"]);
        (part(&out), report)
    };
    for (signal, stays) in [("TERM", false), ("INT", false), ("KILL", true)] {
        let (part, mut report) = report();
        assert!(part.starts_with("report.html."), "{part}");
        assert!(report.signal(signal));
        assert_eq!(report.end().code, None, "ended by {signal}");
        assert_eq!(names(&out).contains(&part), stays, "{signal}");
    }
    // What could not be tidied then, the next run tidies.
    assert_eq!(perirobot(&["report", text(&out), "--best", "1"]).code, Some(0));
    let mut expected = [&before[..], &["report.html".into()]].concat();
    expected.sort();
    assert_eq!(names(&out), expected);
}

#[test]
fn a_page_runs_its_own_scripts_only() {
    let folder = Folder::new();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    assert_eq!(perirobot(&["report", text(&folder.path("out")), "--best", "1"]).code, Some(0));
    let page = fs::read_to_string(folder.path("out/report.html")).unwrap();
    let (_, rest) = page.split_once("http-equiv=\"Content-Security-Policy\" content=\"").unwrap();
    let policy = rest.split('"').next().unwrap();
    assert!(policy.starts_with("default-src 'none'; script-src 'sha256-"), "{policy}");
    let scripts: Vec<&str> =
        page.split("<script>").skip(1).map(|rest| rest.split("</script>").next().unwrap()).collect();
    assert_eq!(scripts.len(), 1);
    for script in scripts {
        let hash = format!("'sha256-{}'", BASE64_STANDARD.encode(Sha256::digest(script.as_bytes())));
        assert!(policy.contains(&hash), "{hash} is not in {policy}");
    }
    let scripts = policy.split("; ").find(|rule| rule.starts_with("script-src ")).unwrap();
    assert!(!scripts.contains("unsafe"), "{policy}");
}
