//! The page of a sweep: it holds the numbers of results.csv, needs nothing from anywhere else, and takes no
//! name for HTML. `browser.rs` opens it in a browser.

use std::collections::HashMap;
use std::fs;
use std::io::Read;
use std::path::Path;

use crate::common::program::{Folder, perirobot, text};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

/// The page of the small study in a folder, and what the program said.
#[track_caller]
fn report(folder: &Folder, more: &[&str]) -> String {
    let swept = folder.sweep(&[]);
    assert_eq!(swept.code, Some(0), "{}", swept.stderr);
    let out = folder.path("out");
    let outcome = perirobot(&[&["report", text(&out), "--backend", "cpu"], more].concat());
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(outcome.stdout.contains("report.html ("), "{}", outcome.stdout);
    fs::read_to_string(out.join("report.html")).unwrap()
}

/// What an element of the page holds.
#[track_caller]
fn held<'a>(page: &'a str, id: &str) -> &'a str {
    let (_, rest) = page.split_once(&format!("id=\"{id}\">")).unwrap_or_else(|| panic!("no element {id}"));
    rest.split_once("</script>").unwrap().0
}

pub(super) fn unpacked(page: &str, id: &str) -> Vec<u8> {
    let gzip = STANDARD.decode(held(page, id)).unwrap();
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(&gzip[..]).read_to_end(&mut bytes).unwrap();
    bytes
}

/// Classes from their runs; there are so many kinds of them.
fn classes(bytes: &[u8], part: &Value, kinds: u64) -> Vec<usize> {
    let [begin, end] = [0, 1].map(|i| part[i].as_u64().unwrap() as usize);
    let (mut all, mut number, mut shift) = (Vec::new(), 0u64, 0);
    for byte in &bytes[begin..end] {
        number |= u64::from(byte & 127) << shift;
        shift += 7;
        if byte & 128 == 0 {
            all.extend(std::iter::repeat_n((number % kinds) as usize, (number / kinds) as usize));
            (number, shift) = (0, 0);
        }
    }
    all
}

/// The rows of results.csv by scene, combination, poses, representation and region.
fn rows(folder: &Folder) -> HashMap<[String; 5], HashMap<String, String>> {
    let mut csv = csv::Reader::from_path(folder.path("out/results.csv")).unwrap();
    let each = csv.deserialize().map(|row| row.unwrap());
    each.map(|row: HashMap<String, String>| (key_of(&row), row)).collect()
}

fn key_of(row: &HashMap<String, String>) -> [String; 5] {
    ["scene", "combination", "poses", "representation", "region"].map(|name| row[name].clone())
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap()
}

/// The key of a row, by numbers of the page's data.
fn key(data: &Value, series: usize, choice: usize, region: usize) -> [String; 5] {
    let series = &data["series"][series];
    let combination = &data["combinations"][series["combination"].as_u64().unwrap() as usize];
    let representation = &combination["representations"][series["representation"].as_u64().unwrap() as usize];
    // One member each, in the small study.
    let member = &combination["members"][0];
    let sensor = &data["sensors"][member["sensor"].as_u64().unwrap() as usize];
    let pose = &sensor["poses"][member["candidates"][choice].as_u64().unwrap() as usize];
    let text = |value: &Value| value.as_str().unwrap().to_string();
    [
        text(&data["scenes"][0]["name"]),
        text(&combination["name"]),
        format!("{}:{}", text(&sensor["name"]), text(&pose["name"])),
        text(representation),
        text(&data["regions"][region]),
    ]
}

#[test]
fn scores_and_voxels_are_those_of_the_sweep() {
    let folder = Folder::new();
    let page = report(&folder, &["--best", "3"]);
    let data: Value = serde_json::from_slice(&unpacked(&page, "data")).unwrap();
    let rows = rows(&folder);
    let numbers = unpacked(&page, "numbers");
    let number = |i: usize| f32::from_le_bytes(numbers[4 * i..4 * i + 4].try_into().unwrap());
    let (regions, measures, mut compared) = (list(&data["regions"]).len(), list(&data["measures"]), 0);
    for (s, series) in list(&data["series"]).iter().enumerate() {
        let block = &series["scores"]["over"];
        let [count, begin] = ["count", "begin"].map(|name| block[name].as_u64().unwrap() as usize);
        for region in 0..regions {
            for (m, measure) in measures.iter().enumerate() {
                for choice in 0..count {
                    // There is one scene, and so one extent.
                    let found = number(begin + (region * measures.len() + m) * count + choice);
                    let row = &rows[&key(&data, s, choice, region)];
                    let wanted = &row[measure["name"].as_str().unwrap()];
                    let same = if wanted.is_empty() {
                        found.is_nan()
                    } else {
                        found == wanted.parse::<f32>().unwrap()
                    };
                    assert!(same, "{measure}: {found}, not {wanted} of {row:?}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 100, "{compared}");
    // The largest and the smallest of each score, of all poses of a series.
    let charts = page.clone() + &String::from_utf8(unpacked(&page, "charts")).unwrap();
    for (s, series) in list(&data["series"]).iter().enumerate() {
        let count = series["scores"]["over"]["count"].as_u64().unwrap() as usize;
        for (region, m) in (0..regions).flat_map(|region| (0..measures.len()).map(move |m| (region, m))) {
            let name = measures[m]["name"].as_str().unwrap();
            let values =
                (0..count).filter_map(|choice| rows[&key(&data, s, choice, region)][name].parse().ok());
            let values: Vec<f64> = values.collect();
            let ends = [f64::min, f64::max].map(|end| values.iter().copied().reduce(end));
            let plotted = plotted(&charts, [region, m, s]);
            assert_eq!(plotted.is_some(), ends[0].is_some(), "{name} in region {region}");
            if let (Some((words, places, near)), [Some(least), Some(largest)]) = (plotted, ends) {
                let [first, last] = [least, largest].map(|value| written(name, value));
                assert!(words.contains(&format!(": {first} to {last}, quartiles ")), "{words}");
                let is_near = |(place, value): (f64, f64)| (place - value).abs() <= near;
                assert!(places.into_iter().zip([least, largest]).all(is_near), "{places:?}: {words}");
            }
            let title = format!("{} in region", if m == 0 { "F1" } else { name });
            assert!(page.contains(&title), "no table of {name}");
        }
    }
    // At least three choices of each sensor, in three regions.
    let voxels = voxels_compared(&page, &data, &rows, &reasons(&folder));
    assert!(voxels >= 3 * 2 * 3, "{voxels}");
}

/// A score as the page writes it.
fn written(name: &str, value: f64) -> String {
    match name {
        "f1" | "kappa" => format!("{value:.3}"),
        _ if value == 0.0 || value == 1.0 => format!("{}\u{a0}%", value * 100.0),
        _ => format!("{:.1}\u{a0}%", (value * 1000.0).round() / 10.0),
    }
}

/// The row of a series in the chart of a region and score: what it tells, the values at its ends, and how exact these are.
fn plotted(charts: &str, [region, score, series]: [usize; 3]) -> Option<(String, [f64; 2], f64)> {
    let (_, chart) = charts.split_once(&format!("data-region=\"{region}\" data-score=\"{score}\"")).unwrap();
    let chart = chart.split("data-region").next().unwrap();
    let (axis, svg) = chart.split_once("<svg")?;
    let [zero, one] = ["zero", "one"].map(|name| {
        let (_, rest) = axis.split_once(&format!("data-{name}=\"")).unwrap();
        rest.split('"').next().unwrap().parse::<f64>().unwrap()
    });
    let svg = format!("<svg{}</svg>", svg.split("</svg>").next().unwrap());
    let document = roxmltree::Document::parse(&svg).unwrap();
    let number = series.to_string();
    let row = document.descendants().find(|node| node.attribute("data-series") == Some(&number))?;
    let [x, width] = ["x", "width"].map(|name| row.attribute(name).unwrap().parse::<f64>().unwrap());
    let words = row.first_element_child().unwrap().text().unwrap().to_string();
    // Places are tenths of a unit; a row is at least two units wide, to be hit with a mouse.
    let width = if width > 2.0 { width } else { 0.0 };
    let values = [x, x + width].map(|place| (place - zero) / (one - zero));
    Some((words, values, if width > 0.0 { 0.3 } else { 2.3 } / (one - zero)))
}

/// Voxels of reasons.csv, occupied and free, by the key of a row and the page's words for the cause.
fn reasons(folder: &Folder) -> HashMap<([String; 5], String), [String; 2]> {
    let outcome = perirobot(&["why", text(&folder.path("out")), "--all", "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let mut csv = csv::Reader::from_path(folder.path("out/reasons.csv")).unwrap();
    let each = csv.deserialize().map(|row| row.unwrap());
    let words = |row: &HashMap<String, String>| match row["reason"].as_str() {
        "hidden" => format!("hidden by {}", row["object"]),
        "blind" => format!("lost to {}, too near to the lens", row["object"]),
        "no_return" => "nothing behind to return the ray".into(),
        "silent" => "under a switch that is off".into(),
        other => other.replace('_', " "),
    };
    let voxels =
        |row: &HashMap<String, String>| ["voxels_occupied", "voxels_free"].map(|name| row[name].clone());
    each.map(|row: HashMap<String, String>| ((key_of(&row), words(&row)), voxels(&row))).collect()
}

/// Counts the voxels of each verdict in the page's labels, and how often they were those of results.csv, and
/// those of each cause those of reasons.csv.
fn voxels_compared(
    page: &str,
    data: &Value,
    rows: &HashMap<[String; 5], HashMap<String, String>>,
    reasons: &HashMap<([String; 5], String), [String; 2]>,
) -> usize {
    let (bytes, scene) = (unpacked(page, "cells"), &data["cells"]["moments"][0]);
    let truth = classes(&bytes, &scene["truth"], 5);
    let regions: Vec<_> = list(&scene["regions"]).iter().map(|part| classes(&bytes, part, 2)).collect();
    let mut compared = 0;
    for labels in list(&data["cells"]["labels"]) {
        let causes = list(&labels["causes"]);
        let mut said = classes(&bytes, &labels["labels"], 2 + causes.len() as u64).into_iter();
        let in_some = |i: usize| regions.iter().any(|region| region[i] == 1);
        let label: Vec<Option<usize>> =
            (0..truth.len()).map(|i| in_some(i).then(|| said.next().unwrap())).collect();
        assert_eq!(said.next(), None, "as many labels as voxels of regions");
        for (region, cells) in regions.iter().enumerate() {
            let count = |there: bool, wanted: &dyn Fn(usize) -> bool| {
                let all = (0..truth.len()).filter(|&i| cells[i] == 1 && label[i].is_some_and(wanted));
                all.filter(|&i| (truth[i] != 0) == there).count().to_string()
            };
            let of = |name: &str| labels[name].as_u64().unwrap() as usize;
            let key = key(data, of("series"), of("choice"), region);
            let found =
                [1, 0].map(|wanted| [true, false].map(|there| count(there, &|label| label == wanted)));
            let unknown = [true, false].map(|there| count(there, &|label| label > 1));
            let wanted = ["tp", "fp", "fn", "tn", "uo", "uf"].map(|name| rows[&key][name].clone());
            assert_eq!([found[0].clone(), found[1].clone(), unknown].concat(), wanted, "{key:?}");
            for (number, cause) in causes.iter().enumerate() {
                let words = cause["words"].as_str().unwrap().to_string();
                let found = [true, false].map(|there| count(there, &|label| label == 2 + number));
                let wanted = reasons.get(&(key.clone(), words.clone()));
                let none = || ["0".to_string(), "0".to_string()];
                assert_eq!(found, wanted.cloned().unwrap_or_else(none), "{words}: {key:?}");
            }
            compared += 1;
        }
    }
    compared
}

#[test]
fn the_page_stands_alone_and_says_what_it_is() {
    let folder = Folder::new();
    let page = report(&folder, &["--best", "1"]);
    for said in [
        "A planning aid, not a validation",
        "Mounting sheet A: ",
        "What it misses in scene ",
        "fingerprint",
        "towards −x",
        "best by human seen",
        "as the study says",
    ] {
        assert!(page.contains(said), "no {said:?}");
    }
    for away in ["src=\"http", "href=\"http", "@import", "url(http", "<link"] {
        assert!(!page.contains(away), "{away:?} in the page");
    }
    assert!(page.len() < 400_000, "{} bytes", page.len());
    // Each cell of the best placements has a header, each poses' name and place being one cell.
    let (_, table) = page.split_once("<table class=\"best\">").unwrap();
    let headers = table.split_once("</thead>").unwrap().0.matches("<th>").count();
    let (_, row) = table.split_once("<td data-name=\"sensors\">").unwrap();
    assert_eq!(row.split_once("</tr>").unwrap().0.matches("</td>").count(), headers);
    // Keys as they are in the file are for the appendix, not for whom mounts the sensor.
    let (_, sheet) = page.split_once("Mounting sheet A: ").unwrap();
    let sheet = sheet.split_once("</table>").unwrap().0;
    assert!(sheet.contains("range ") && !sheet.contains("range_m"), "{sheet}");
}

#[test]
fn names_are_no_html() {
    let folder = Folder::new();
    let nasty = r#"</script><b onclick=\"x\">&'"#;
    folder.edit("study.toml", "name = \"posts\"", &format!("name = \"{nasty}\""));
    folder.edit("study.toml", "name = \"robot\"", &format!("name = \"{nasty}\""));
    let page = report(&folder, &["--best", "1"]);
    assert!(!page.contains("<b onclick"), "a name became an element");
    let spelt = "&lt;/script&gt;&lt;b onclick=&quot;x&quot;&gt;&amp;'";
    assert!(page.contains(spelt), "a name is missing");
    let data: Value = serde_json::from_slice(&unpacked(&page, "data")).unwrap();
    assert_eq!(data["regions"][0], nasty.replace('\\', ""));
}

#[test]
fn folders_that_cannot_be_reported_are_refused() {
    let folder = Folder::new();
    folder.sweep(&[]);
    let out = folder.path("out");
    let fails = |arguments: &[&str], expected: &str| {
        let outcome = perirobot(&[&["report"], arguments].concat());
        assert_eq!(outcome.code, Some(2), "{arguments:?}: {}", outcome.stderr);
        assert!(outcome.stderr.contains(expected), "no {expected:?} in {}", outcome.stderr);
    };
    fails(
        &[text(&folder.path("nowhere"))],
        "is not a folder: name one written by `perirobot sweep` or `perirobot choose`",
    );
    fails(&[text(&out), "--out", text(&out)], "is a folder: name a file");
    folder.edit("study.toml", "seed = 7", "seed = 8");
    fails(&[text(&out)], "seed was 7, is 8");
    fs::remove_file(folder.path("study.toml")).unwrap();
    fails(&[text(&out)], "study.toml");
    assert!(!out.join("report.html").exists(), "nothing is left of what failed");
}

pub(super) const BOTH: &str = "camera:wall/front;camera:wall/back";

/// Of `scenes/approach.toml`, with voxels of 10 cm, swept in a folder of its own. Two cameras are the best by what it
/// requires, that little is unknown.
pub(super) fn shelf() -> Folder {
    let folder = Folder::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    folder.write("study.toml", fs::read(root.join("approach.toml")).unwrap());
    folder.edit("study.toml", "approach/cell.toml", "cell.toml");
    folder.edit("study.toml", "voxel_size_m = 0.05", "voxel_size_m = 0.1");
    folder.edit("study.toml", "resolution_px = [320, 240]", "resolution_px = [80, 60]");
    folder.write("cell.toml", fs::read(root.join("approach/cell.toml")).unwrap());
    let swept = folder.sweep(&[]);
    assert_eq!(swept.code, Some(0), "{}", swept.stderr);
    folder
}

/// The page of a folder that was swept, after a command has written into it.
#[track_caller]
fn after(folder: &Folder, command: &[&str]) -> String {
    let out = folder.path("out");
    if let [command, arguments @ ..] = command {
        let outcome = perirobot(&[&[command, text(&out)], arguments].concat());
        assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
    }
    let outcome = perirobot(&["report", text(&out), "--best", "1", "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    fs::read_to_string(out.join("report.html")).unwrap()
}

/// Changes something in a file of JSON.
#[track_caller]
pub(super) fn edit_json(path: &Path, edit: impl Fn(&mut Value)) {
    let before: Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
    let mut after = before.clone();
    edit(&mut after);
    assert_ne!(before, after);
    fs::write(path, serde_json::to_vec(&after).unwrap()).unwrap();
}

/// The report of a folder must be refused, in words that hold all of `expected`.
#[track_caller]
fn refused(out: &Path, expected: &[&str]) {
    let outcome = perirobot(&["report", text(out), "--best", "1", "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    let words = expected.iter().all(|part| outcome.stderr.contains(part));
    assert!(words, "not all of {expected:?} in {}", outcome.stderr);
}

const NEAR: &str = "How near a person gets unnoticed, as perirobot approach has found";
const WHAT_IF: &str = "What if: how near a person gets unnoticed";
const PLAN: &str = "<img src=\"data:image/svg+xml;base64,";

#[test]
fn ways_in_are_those_of_the_shown_choice_as_planned() {
    let folder = shelf();
    let out = folder.path("out");
    fs::write(out.join("floor-old-standing.svg"), "<svg/>").unwrap();
    let both = ["approach", "--pose", BOTH, "--out", text(&out)];
    let page = after(&folder, &both);
    assert!(page.contains(NEAR) && !page.contains(WHAT_IF), "a table of the choice");
    // Three bodies on the floor, with nobody else and with people as cover.
    assert_eq!(page.matches(PLAN).count(), 6);
    assert!(!page.contains("floor-old"), "a plan of no row");
    assert!(!page.contains("fence between"), "the floor has one height");
    let found = fs::read(out.join("approach.json")).unwrap();
    edit_json(&out.join("approach.json"), |found| {
        found["step_m"] = 0.25.into();
        found["rows"][0]["fence_between"] = "mesh fence".into();
    });
    let page_of_floors = after(&folder, &[]);
    let fence = "<td data-name=\"fence between\">mesh fence</td>";
    assert!(page_of_floors.contains(fence), "what is between on several floors");
    fs::write(out.join("approach.json"), found).unwrap();
    let page = after(&folder, &[&both[..], &["--dead", "camera:wall/back"]].concat());
    assert!(!page.contains(NEAR) && page.contains(WHAT_IF), "what if is not the plan");
    assert!(page.contains("without camera:wall/back"), "the case is named");
    assert_eq!(page.matches(PLAN).count(), 0);
    let page = after(&folder, &["approach", "--pose", "wall/front", "--out", text(&out)]);
    assert!(!page.contains(NEAR) && !page.contains(WHAT_IF), "another choice is not this one");
    assert!(page.contains("is of another choice, which is not shown here: camera:wall/front"), "it is told");
    assert_eq!(page.matches(PLAN).count(), 0);
    // The same poses and another representation.
    edit_json(&out.join("approach.json"), |found| {
        for (key, other) in [("combination", "both"), ("poses", BOTH), ("representation", "others")] {
            found[key] = other.into();
        }
    });
    let page = after(&folder, &[]);
    assert!(!page.contains(NEAR) && page.contains("is of another choice"), "another representation");
}

/// F1 and answers without a sensor are details then; and whoever plans signs at the end.
#[test]
fn requirements_lead_and_signatures_end_a_report() {
    let folder = shelf();
    let page = after(&folder, &[]);
    let place = |part: &str| page.find(part).unwrap_or_else(|| panic!("no {part}"));
    assert!(place("<ul class=\"verdicts\">") < place("<dl class=\"tiles\">"), "verdicts first");
    let (details, table) = (place("<details id=\"scores-of-best\">"), place("class=\"best\""));
    assert!(details < table && table < page[details..].find("</details>").unwrap() + details, "a detail");
    assert!(!page[place("<dl class=\"tiles\">")..details].contains("<dt>F1</dt>"), "F1 is no large number");
    let signed = &page[place("<section id=\"signed\">")..];
    let words = ["planned by", "checked by", "accepted by", "<th>date</th>", "<th>signature</th>"];
    assert!(words.iter().all(|word| signed.contains(word)), "{}", &signed[..600]);
    assert!(place("<section id=\"run\">") < place("<section id=\"signed\">"), "the last section");
}

const OLD_ROWS: &str = "Rows of conditions.csv rest on tables of the study that have changed";

#[test]
fn verdicts_are_of_what_the_study_requires_now() {
    let folder = shelf();
    // Those of the one requirement in its section; all together they stand on the first screen, too.
    let verdicts = |page: &str| {
        let (first, rest) = page.split_once("<section id=\"good\">").unwrap();
        let found = ["PASS", "FAIL", "OPEN"].map(|word| {
            let [in_all, in_section] =
                [first, rest].map(|part| part.matches(&format!("<li class=\"{word}\">")).count());
            assert!(in_all <= 1 && in_section >= in_all, "{word}: {in_all}, {in_section}");
            in_section
        });
        let all = ["FAIL", "OPEN", "PASS"].into_iter().zip([found[1], found[2], found[0]]);
        let (worst, _) = all.into_iter().find(|(_, count)| *count > 0).unwrap();
        for said in [format!("<p class=\"overall {worst}\">"), format!("<li class=\"{worst}\">")] {
            assert!(first.contains(&said), "no {said} on the first screen: {found:?}");
        }
        found
    };
    let [pass, fail, open] = verdicts(&after(&folder, &[]));
    assert_eq!([pass + fail, open], [1, 0], "as planned it is decided by the sweep");
    let page = after(&folder, &["judge", "--pose", BOTH]);
    assert_eq!(verdicts(&page), [pass, fail, 0]);
    assert!(page.contains("at most 58\u{a0}% is required") && page.contains("As decided by perirobot judge"));
    let others = "against other requirements";
    folder.edit("study.toml", "at_most = 0.58", "at_most = 0.99");
    let page = after(&folder, &[]);
    assert_eq!(verdicts(&page), [0, 0, 1]);
    assert!(page.contains(&format!("was judged {others}, or with other tables")));
    folder.edit("study.toml", "at_most = 0.99", "at_most = 0.58");
    // Another requirement may recommend another choice, so that the verdict is changed in place of the study.
    let file = folder.path("out/judge.json");
    let judged = fs::read(&file).unwrap();
    for other in [
        &[("score", "f1".into())][..],
        &[("region", "robot".into())],
        &[("over", "mean".into())],
        &[("at_least", 0.58.into()), ("at_most", Value::Null)],
    ] {
        edit_json(&file, |judged| {
            let verdict = &mut judged["sets"][0]["requirements"][0];
            other.iter().for_each(|(key, value): &(&str, Value)| verdict[*key] = value.clone());
        });
        let page = after(&folder, &[]);
        assert_eq!(verdicts(&page), [0, 0, 1], "{other:?}");
        assert!(page.contains(others), "{other:?}");
        fs::write(&file, &judged).unwrap();
    }
    // A verdict belongs to the tables that it rests on, and to no others.
    let plan = "at_most = 0.58\nunder = [\"as_planned\", \"mounting_error\", \"postures\"]";
    folder.edit("study.toml", "at_most = 0.58", plan);
    let tables = "\n[mounting_error]\ndraws = 2\nposition_m = 0.01\n[postures]\npeople = [\"small\"]\nspots = [[1, 0.5, 0]]\n";
    folder.edit("study.toml", "", tables);
    let page = after(&folder, &["judge", "--pose", BOTH]);
    assert_eq!(verdicts(&page)[2], 0, "all three are decided");
    assert!(!page.contains(OLD_ROWS));
    for (from, to, open) in [
        ("draws = 2", "draws = 3", 1),
        ("[[1, 0.5, 0]]", "[[1, 0.5, 90]]", 1),
        ("hazard = \"robot\"\n", "hazard = \"robot_swept\"\n", 1),
        ("intrusion_m = 0.4", "intrusion_m = 0.4 # as measured", 0),
    ] {
        let before = fs::read_to_string(folder.path("study.toml")).unwrap();
        folder.edit("study.toml", from, to);
        let page = after(&folder, &[]);
        assert_eq!(verdicts(&page)[2], open, "{to}");
        assert_eq!(page.contains(others), open > 0, "{to}");
        assert_eq!(page.contains(OLD_ROWS), open > 0, "{to}");
        fs::write(folder.path("study.toml"), before).unwrap();
    }
    folder.edit("study.toml", tables, "");
    folder.edit("study.toml", plan, "at_most = 0.58");
    after(&folder, &["judge", "--pose", BOTH]);
    // Of a condition that is added nothing is known, and one that is taken away is not shown.
    folder.edit(
        "study.toml",
        "at_most = 0.58",
        "at_most = 0.58\nunder = [\"as_planned\", \"one_sensor_dead\"]",
    );
    let page = after(&folder, &[]);
    assert_eq!(verdicts(&page), [pass, fail, 1]);
    assert!(page.contains("unknown (one sensor dead) is not decided yet") && !page.contains(others));
    folder.edit("study.toml", "\"as_planned\", ", "");
    let page = after(&folder, &[]);
    assert_eq!(verdicts(&page), [0, 0, 1], "as planned is not required");
    assert!(page.contains(others), "the folder's verdict is of something else");
    for name in ["judge.json", "requirements.csv"] {
        fs::remove_file(folder.path("out").join(name)).unwrap();
    }
    assert_eq!(verdicts(&after(&folder, &[])), [0, 0, 1], "what the sweep knows is not required");
    let page = after(&folder, &["judge", "--pose", BOTH]);
    let [pass, fail, open] = verdicts(&page);
    assert_eq!([pass + fail, open], [1, 0], "one sensor dead is decided");
}

/// What `judge` and `approach` wrote is read whole or not at all: nothing of it is left out without a word.
#[test]
fn what_an_older_program_or_an_accident_has_left_is_told() {
    let folder = shelf();
    let out = folder.path("out");
    after(&folder, &["judge", "--pose", BOTH]);
    after(&folder, &["approach", "--pose", BOTH, "--out", text(&out)]);
    for (name, table, again) in [
        ("judge.json", "requirements.csv", "run `perirobot judge` again"),
        ("approach.json", "approach.csv", "run `perirobot approach` again into this folder"),
    ] {
        let path = out.join(name);
        let written = fs::read(&path).unwrap();
        fs::remove_file(&path).unwrap();
        let older = format!("was written by an older perirobot without {name}");
        refused(&out, &[table, &older, again]);
        fs::write(&path, &written[..written.len() / 2]).unwrap();
        refused(&out, &[&format!("{name}: is cut off"), again]);
        let text = String::from_utf8(written.clone()).unwrap();
        fs::write(&path, text.replacen("\"poses\"", "\"place\"", 1)).unwrap();
        refused(&out, &[&format!("{name}: is not as it was written: missing field `poses`"), again]);
        fs::write(&path, text.replacen("\"format\": 1", "\"format\": 2", 1)).unwrap();
        refused(&out, &[&format!("{name}: has format 2, but this perirobot reads format 1"), again]);
        fs::write(&path, &written).unwrap();
        after(&folder, &[]);
    }
}
