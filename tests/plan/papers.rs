//! The report and the mounting sheets of the present plan, as a click makes them.

use std::fs;

use serde_json::{Value, json};

use crate::common::program::{perirobot, text};
use crate::planner::Planner;

/// Makes a paper, and returns its address.
fn made(planner: &Planner, kind: &str) -> String {
    let (status, lines) = planner.send("POST", "/paper", &json!({ "kind": kind }).to_string());
    let lines = String::from_utf8(lines).unwrap();
    assert_eq!(status, 200, "{lines}");
    let last: Value = serde_json::from_str(lines.lines().last().unwrap()).unwrap();
    last["ready"].as_str().unwrap_or_else(|| panic!("{lines}")).into()
}

/// A paper, as a tab without the token gets it.
fn shown(planner: &Planner, address: &str) -> String {
    let (status, page) = planner.send_without_token("GET", address);
    assert_eq!(status, 200, "{page}");
    page
}

/// What a script of a page reads.
fn part<'a>(page: &'a str, id: &str) -> &'a str {
    let begin = format!("<script type=\"text/plain\" id=\"{id}\">");
    page.split_once(&begin).unwrap().1.split_once("</script>").unwrap().0
}

/// The verdicts of a judged report.
fn verdicts(page: &str) -> &str {
    page.split_once("<p class=\"overall").unwrap().1.split_once("</ul>").unwrap().0
}

#[test]
fn a_report_is_that_of_a_sweep_of_the_saved_study() {
    let folder = tempfile::tempdir().unwrap();
    let cell = folder.path().join("cell");
    assert_eq!(perirobot(&["init", "--template", "laboratory", text(&cell)]).code, Some(0));
    let study = cell.join("study.toml");
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    let sensor = planner.get("/state")["placed"][0]["sensor"].clone();
    let at = json!({ "position_m": [0.3, -1.2, 2.1], "pan_deg": 90, "tilt_deg": -30, "roll_deg": 0 });
    planner.post("/edit", json!({ "edit": "add", "sensor": sensor, "at": at, "gesture": 1 }));
    let note = "with changes that are not saved in study.toml";
    let before = shown(&planner, &made(&planner, "report"));
    assert!(before.contains(note) && before.contains("Mounting sheet B: "));
    let sheets = shown(&planner, &made(&planner, "sheets"));
    assert!(sheets.contains(note) && sheets.contains("Mounting sheet B: "), "{sheets}");
    assert!(!sheets.contains("<script"), "sheets need no script");

    planner.post("/save", json!({ "overwrite": false }));
    let after = shown(&planner, &made(&planner, "report"));
    assert!(!after.contains(note));
    // The letters are those of the planner.
    let placed = planner.get("/state")["placed"].clone();
    for one in placed.as_array().unwrap() {
        let [letter, sensor, pose] = ["letter", "sensor", "pose"].map(|key| one[key].as_str().unwrap());
        assert!(after.contains(&format!("Mounting sheet {letter}: {sensor}, {pose}")), "{one}");
    }
    planner.end();
    let out = folder.path().join("out");
    let commands: [(&[&str], i32); 3] = [
        (&["sweep", text(&study), "--out", text(&out)], 0),
        (&["judge", text(&out)], 4),
        (&["report", text(&out)], 0),
    ];
    for (words, code) in commands {
        let outcome = perirobot(&[words, &["--backend", "oracle"]].concat());
        assert_eq!(outcome.code, Some(code), "{}", outcome.stderr);
    }
    let swept = fs::read_to_string(out.join("report.html")).unwrap();
    assert_eq!(verdicts(&after), verdicts(&swept));
    for id in ["cells", "numbers", "charts"] {
        assert!(part(&after, id) == part(&swept, id), "{id}");
        assert_eq!(part(&before, id), part(&after, id), "{id}");
    }
}

#[test]
fn a_paper_has_an_address_that_cannot_be_guessed() {
    let folder = tempfile::tempdir().unwrap();
    let planner = Planner::start_in(folder.path(), &["--backend", "cpu"]);
    planner.post("/open", json!({ "template": "laboratory", "folder": "cell" }));
    let first = made(&planner, "sheets");
    assert_eq!(first.len(), "/paper/".len() + 32);
    for wrong in ["/paper/", "/paper/0", "/paper", &first[..first.len() - 1]] {
        assert_ne!(planner.send_without_token("GET", wrong).0, 200, "{wrong}");
    }
    assert_eq!(planner.send_without_token("POST", &first).0, 403);
    // Only the newest four are kept.
    for _ in 0..3 {
        made(&planner, "sheets");
    }
    assert_eq!(planner.send_without_token("GET", &first).0, 200);
    made(&planner, "sheets");
    assert_eq!(planner.send_without_token("GET", &first).0, 404);
    planner.post("/edit", json!({ "edit": "remove", "index": 0, "gesture": 1 }));
    let words = planner.refused("/paper", json!({ "kind": "report" }), 400);
    assert!(words.contains("no sensor is placed"), "{words}");
    planner.refused("/paper", json!({ "kind": "poem" }), 400);
    planner.end();
}
