//! The page of the cheapest set that passes: the sentence first, then a table and a chart of the front, and each set with
//! its plan, mounting sheets and verdicts.

use std::fs;

use serde_json::Value;

use super::report::edit_json;
use crate::common::program::{Folder, choose, perirobot, rows, text};
use crate::common::purchase::folder;

/// The page of an answer.
#[track_caller]
fn page(folder: &Folder) -> String {
    let out = folder.path("out");
    let outcome = perirobot(&["report", text(&out), "--best", "1", "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    fs::read_to_string(out.join("report.html")).unwrap()
}

/// What the page says of the answer before all else: words without elements.
#[track_caller]
fn found(page: &str) -> String {
    let begin = "<main><section id=\"answer\"><div class=\"found\">";
    let (_, rest) = page.split_once(begin).expect("the answer is the first of all");
    words(rest.split_once("</div>").unwrap().0)
}

/// Rows of the table of the front, cell by cell.
#[track_caller]
fn front(page: &str) -> Vec<Vec<String>> {
    let (_, rest) = page.split_once("<div id=\"purchase\">").unwrap();
    let (_, rest) = rest.split_once("<tbody>").unwrap();
    let each = rest.split_once("</tbody>").unwrap().0.split("</tr>").filter(|row| !row.is_empty());
    each.map(|row| row.split("</td>").map(words).collect()).collect()
}

/// Text without elements.
fn words(html: &str) -> String {
    let plain = html.split('<').map(|part| part.split_once('>').map_or(part, |(_, words)| words));
    let plain = plain.collect::<String>();
    [("&quot;", "\""), ("&lt;", "<"), ("&gt;", ">"), ("&amp;", "&")]
        .iter()
        .fold(plain, |text, (spelt, letter)| text.replace(spelt, letter))
}

#[test]
fn the_page_begins_with_the_sentence_of_the_terminal() {
    let folder = folder();
    folder.edit("study.toml", "", "[choose]\nfront = \"speed\"\n");
    let outcome = choose(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let (page, sentence) = (page(&folder), outcome.stdout.lines().next().unwrap());
    let found = found(&page);
    assert!(found.starts_with(&format!("{sentence}.proven: no cheaper set of the 6 ")), "{found}");
    assert!(!found.contains("The study has other requirements"), "{found}");
    let (_, summary) = page.split_once("<p class=\"summary\">").unwrap();
    let facts: Vec<&str> = summary.split_once("</p>").unwrap().0.split(" · ").collect();
    let set = &rows(&folder.path("out/cheapest.csv"))[0];
    assert_eq!(facts[0].split(' ').next(), Some(set["sensors"].as_str()), "{facts:?}");
    assert_eq!((facts[1], facts[3]), (set["cost"].as_str(), "the robot may run at 0.5 m/s"), "{facts:?}");
    assert!(facts[2].starts_with("passes ") && facts[4].ends_with(" of the floor is blind"), "{facts:?}");
    // The rows are those of the table beside it.
    let (shown, written) = (front(&page), rows(&folder.path("out/cheapest.csv")));
    assert_eq!(shown.len(), 4);
    for (shown, written) in shown.iter().zip(&written) {
        let verdict = if written["cost"].is_empty() { "✗ FAIL" } else { "✓ PASS" };
        let proof = if written["cost"].is_empty() { "no set" } else { "proven" };
        let aim = match written["aim"].as_str() {
            "all" => "all requirements".to_string(),
            _ => format!("{} m/s", written["value"]),
        };
        assert_eq!(shown[..5], [&aim, verdict, &written["cost"], &written["sensors"], proof], "{shown:?}");
        match written["cost"].is_empty() {
            true => {
                assert!(shown[5].contains("comes nearer") && shown[5].contains("move the entry"), "{shown:?}")
            }
            false => assert_eq!((&shown[5], shown[6].contains("✓ PASS yes: ")), (&written["poses"], true)),
        }
    }
    // A shape for each speed; all that can be clicked on opens something.
    let (_, chart) = page.split_once("cost by speed of the robot").unwrap();
    let chart = chart.split_once("</svg>").unwrap().0;
    for (class, count) in [("PASS", 2), ("FAIL", 1), ("OPEN", 0), ("spot", 2)] {
        assert_eq!(chart.matches(&format!("class=\"{class}\"")).count(), count, "{class}");
    }
    let opened = page.split("data-opens=\"").skip(1).map(|rest| rest.split_once('"').unwrap().0);
    let opened: Vec<&str> = opened.collect();
    assert!(opened.contains(&"set-0") && opened.len() >= 5, "{opened:?}");
    for id in opened {
        assert!(page.contains(&format!("id=\"{id}\"")), "nothing is {id}");
    }
    let (_, set) = page.split_once("<details class=\"aside\" id=\"set-0\">").unwrap();
    let set = set.split_once("</details>").unwrap().0;
    for part in ["; the robot may run at 0.5 m/s.", "<li class=\"PASS\">", "<svg", "Mounting sheet A: narrow"]
    {
        assert!(set.contains(part), "no {part}");
    }
}

#[test]
fn what_was_stopped_shows_its_bound() {
    let folder = folder();
    folder.edit("study.toml", "", "[choose]\nfront = \"speed\"\n");
    assert_eq!(choose(&folder, "out", &[]).code, Some(0));
    edit_json(&folder.path("out/cheapest.json"), |report| {
        report["stopped"] = true.into();
        for point in [0, 1] {
            report["points"][point]["proven"] = false.into();
            report["points"][point]["no_set_below"] = 250.5.into();
        }
        report["points"][3]["proven"] = false.into();
        report["points"][3]["reasons"] = Value::Array(Vec::new());
    });
    let page = page(&folder);
    let found = found(&page);
    let bound = "stopped: a cheaper set may pass, but none below 250.5; this one costs 501 ";
    assert!(found.contains(bound) && !found.contains("proven"), "{found}");
    assert!(
        page.contains("the cheapest set that was found to pass all requirements; none below 250.5 passes")
    );
    let shown = front(&page);
    let proofs: Vec<&str> = shown.iter().map(|row| row[4].as_str()).collect();
    assert_eq!(proofs, ["none below 250.5", "none below 250.5", "proven", "none found"]);
    assert_eq!(shown[3][1], "? OPEN");
    let (_, chart) = page.split_once("cost by speed of the robot").unwrap();
    let chart = chart.split_once("</svg>").unwrap().0;
    for (class, count) in [("PASS", 1), ("FAIL", 0), ("OPEN", 2), ("bound", 1)] {
        assert_eq!(chart.matches(&format!("class=\"{class}\"")).count(), count, "{class}");
    }
}

#[test]
fn what_a_requirement_costs_is_shown() {
    let folder = folder();
    folder.edit("study.toml", "", "[choose]\nfront = \"requirements\"\n");
    assert_eq!(choose(&folder, "out", &[]).code, Some(0));
    let page = page(&folder);
    let shown = front(&page);
    assert_eq!(shown[1][..3], ["all but “nobody comes near”", "✓ PASS", "250.5 (250.5 less)"]);
    assert_eq!(shown[2][2], "501 (saves nothing)", "the other requirement costs nothing");
    assert!(
        shown[0][6].starts_with("✓ PASS yes: ") && shown[1][6].starts_with("✗ FAIL no: 1 of 2 "),
        "{shown:?}"
    );
    assert!(!page.contains("cost by speed"));
    // Of another study it is told that the answer is not of it.
    folder.edit("study.toml", "cost = 450", "cost = 451");
    assert!(found(&self::page(&folder)).contains("The study has other requirements or costs now"));
}

#[test]
fn why_nothing_passes_is_told_first() {
    let folder = folder();
    folder.edit("study.toml", "at_most = 0.9", "at_most = 0.01");
    let outcome = choose(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(4), "{}", outcome.stderr);
    let page = page(&folder);
    let found = found(&page);
    assert!(
        found.starts_with("no allowed set passes all; 2 sensors for 501 meet 1 of 2 requirements"),
        "{found}"
    );
    let why = "the robot's surroundings are known: all listed poses together have unknown 0.0";
    assert!(found.contains(why) && found.contains("list more places, or ask for less"), "{found}");
    assert!(page.contains(
        "the set that comes nearest: the cheapest for all but “the robot's surroundings are known”"
    ));
    let shown = front(&page);
    assert_eq!((shown[0][1].as_str(), shown[1][1].as_str()), ("✗ FAIL", "✓ PASS"));
    assert!(shown[1][0].ends_with(": the nearest") && shown[1][6].starts_with("✗ FAIL no: "), "{shown:?}");
    // Without any set there is nothing to show.
    let begin = fs::read_to_string(folder.path("study.toml")).unwrap();
    let (first, rest) = begin.split_once("[[require]]").unwrap();
    let (_, second) = rest.split_once("[[require]]").unwrap();
    folder.write("study.toml", format!("{first}[[require]]{second}"));
    assert_eq!(choose(&folder, "nothing", &[]).code, Some(4));
    let outcome = perirobot(&["report", text(&folder.path("nothing"))]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    let words =
        "no set to show: no allowed set of the listed poses passes, nor does any come near; \"the robot's";
    assert!(
        outcome.stderr.contains(words) && outcome.stderr.contains("list more places"),
        "{}",
        outcome.stderr
    );
}
