//! How a report reads: a row for each set with its scores as columns, shares as percent, one region at a time, what would
//! help most.

use std::fs;

use serde_json::Value;

use super::report::{edit_json, unpacked};
use crate::common::program::{Folder, choose, perirobot, priced, text};

#[track_caller]
fn page(folder: &Folder) -> String {
    let out = folder.path("out");
    let outcome = perirobot(&["report", text(&out), "--best", "1", "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    fs::read_to_string(out.join("report.html")).unwrap()
}

/// The page of the front of a small study.
fn front() -> String {
    let folder = priced("\n[choose]\nobjective = \"f1\"\nregion = \"robot\"\nat_most = 3\n");
    let outcome = choose(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    page(&folder)
}

/// What stands between two texts, each time.
fn between<'a>(text: &'a str, begin: &str, end: &str) -> Vec<&'a str> {
    text.split(begin).skip(1).map(|rest| rest.split_once(end).unwrap().0).collect()
}

#[test]
fn a_front_has_one_row_for_each_set_in_a_region() {
    let page = front();
    let data: Value = serde_json::from_slice(&unpacked(&page, "data")).unwrap();
    let sets = data["combinations"].as_array().unwrap().len();
    assert!(sets >= 3, "{sets}");
    // Nobody is in the other regions, so that F1 alone names a best there; every region is a part to be shown alone.
    let regions = between(&page, "<div data-of-region=", "</table>");
    assert_eq!(regions.len(), 3);
    assert!(page.contains("id=\"region-of-best\""), "no selector of the region");
    let name = |row: &&str| between(row, "<td data-name=\"sensors\">", "</td>")[0].to_string();
    for region in regions {
        for group in between(region, "<tbody class=\"choices\">", "</tbody>") {
            let rows =
                group.split("<tr").filter(|row| row.contains("data-name=\"sensors\"")).collect::<Vec<_>>();
            let mut names: Vec<String> = rows.iter().map(name).collect();
            names.sort();
            names.dedup();
            assert_eq!((names.len(), rows.len()), (sets, sets), "{group}");
        }
        assert!(region.matches("best by ").count() <= 1, "the same rows by another score: {region}");
        assert!(!region.contains("worst "), "one moment is its own worst: {region}");
    }
    for gone in ["id=\"maps\"", "id=\"positions\"", "id=\"maxima\"", "id=\"table\"", "The same as tables"] {
        assert!(!page.contains(gone), "{gone}: a set has one place");
    }
}

/// Each point of the front selects the set that its words name.
#[test]
fn a_click_on_a_point_of_the_front_selects_its_set() {
    let folder = priced("\n[choose]\nobjective = \"human_seen\"\nregion = \"robot\"\nat_most = 3\n");
    assert_eq!(choose(&folder, "out", &[]).code, Some(0));
    let page = page(&folder);
    let data: Value = serde_json::from_slice(&unpacked(&page, "data")).unwrap();
    let front = between(&page, "<div id=\"front\">", "</figure>")[0];
    let sets = data["combinations"].as_array().unwrap();
    let points = between(front, "<g class=\"spot\"", "</g>");
    assert_eq!((points.len(), points.len() >= 3), (front.matches("<circle").count(), true), "{front}");
    for point in points {
        let series: usize = between(point, "data-series=\"", "\"")[0].parse().unwrap();
        let combination = data["series"][series]["combination"].as_u64().unwrap() as usize;
        let mut names: Vec<String> = Vec::new();
        for member in sets[combination]["members"].as_array().unwrap() {
            let sensor = &data["sensors"][member["sensor"].as_u64().unwrap() as usize];
            let candidate = member["candidates"][0].as_u64().unwrap() as usize;
            let name = sensor["poses"][candidate]["name"].as_str().unwrap();
            names.push(format!("{}:{name}", sensor["name"].as_str().unwrap()));
        }
        let poses = between(point, "<title>", "</title>")[0].rsplit_once(": ").unwrap().1;
        assert_eq!(poses, names.join(";"));
    }
    // A share is percent in its tables and on its axis.
    assert!(front.contains("human seen, %"), "{front}");
    let table = between(&page, "<div id=\"front\">", "</table>")[0].split_once("</figure>").unwrap().1;
    assert!(table.contains("\u{a0}%</td>") && !table.contains(">0."), "{table}");
}

#[test]
fn shares_are_percent_everywhere_and_f1_is_a_number() {
    let page = front();
    let data: Value = serde_json::from_slice(&unpacked(&page, "data")).unwrap();
    let region = between(&page, "<div data-of-region=", "</table>")[0];
    for measure in data["measures"].as_array().unwrap() {
        let (title, is_share) = (measure["title"].as_str().unwrap(), measure["is_share"].as_bool().unwrap());
        let cells = between(region, &format!("<td data-name=\"{title}\">"), "</td>");
        assert!(cells.len() > 3, "{title}");
        for cell in cells.into_iter().filter(|cell| *cell != "–") {
            assert_eq!(cell.ends_with("\u{a0}%"), is_share, "{title}: {cell}");
        }
    }
    let charts = page.clone() + &String::from_utf8(unpacked(&page, "charts")).unwrap();
    let unknown = between(&charts, "data-region=\"0\" data-score=\"6\"", "</svg>")[0];
    let ticks = between(unknown, "tick\"", "</text>");
    assert!(!ticks.is_empty() && ticks.iter().all(|tick| tick.ends_with("\u{a0}%")), "{ticks:?}");
}

#[test]
fn the_plan_outlines_the_region_that_is_asked_about() {
    let page = front();
    let plan = between(&page, "<figure class=\"floor-plan\">", "</svg>")[0];
    let outlines = plan.matches("class=\"region\"").count();
    assert_eq!(outlines, 1, "{outlines} of three regions");
    assert!(plan.contains(">region robot<") && !plan.contains(">region box<"), "{plan}");
}

#[test]
fn the_map_is_told_which_place_is_recommended_and_why() {
    let folder = Folder::new();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let page = page(&folder);
    let data: Value = serde_json::from_slice(&unpacked(&page, "data")).unwrap();
    let recommended = &data["recommended"];
    let why = recommended["why"].as_str().unwrap();
    assert!(why.contains("by body parts detected, then F1") && page.contains(why), "{why}");
    let score = &data["measures"][recommended["measure"].as_u64().unwrap() as usize];
    assert_eq!(score["name"], "parts_detected", "the page opens with the score that decided");
    assert!(page.contains("id=\"map-note\""));
}

#[test]
fn the_three_largest_gains_are_listed_in_order() {
    let folder = super::report::shelf();
    let pose = ["--pose", super::report::BOTH];
    let page_after = |edit: &dyn Fn(&mut Value)| {
        let out = folder.path("out");
        let arguments = [&["approach", text(&out)], &pose[..], &["--out", text(&out)]].concat();
        let outcome = perirobot(&arguments);
        assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
        edit_json(&out.join("approach.json"), edit);
        let page = page(&folder);
        let (_, help) = page.split_once("<section id=\"help\">").expect("a section of what helps");
        let help = help.split_once("</section>").unwrap().0.to_string();
        between(&help, "<li><strong>", "</li>").into_iter().map(String::from).collect::<Vec<_>>()
    };
    // Without a way that is too short, shares of the region: the largest first.
    let changes = page_after(&|found| {
        for row in found["rows"].as_array_mut().unwrap() {
            row["margin_m"] = 0.125.into();
        }
    });
    let shares: Vec<f64> =
        changes.iter().map(|change| between(change, "up to ", "\u{a0}%")[0].parse().unwrap()).collect();
    assert!((1..=3).contains(&shares.len()) && shares.is_sorted_by(|a, b| a >= b), "{changes:?}");
    assert!(changes[0].contains("% of region ") && changes[0].contains(" voxels"), "{changes:?}");
    // A way that is too short comes first.
    let changes = page_after(&|found| {
        for (number, row) in found["rows"].as_array_mut().unwrap().iter_mut().enumerate() {
            row["margin_m"] = (if number == 1 { -0.375 } else { 0.125 }).into();
            row["needed_m"] = 1.25.into();
            row["shadowed_by"] = "shelf".into();
        }
    });
    assert!(
        changes[0].starts_with("0.38 m</strong>: see behind shelf, or block the path there: "),
        "{changes:?}"
    );
    assert!(changes[0].contains("1.25 m are needed"), "{changes:?}");
    assert!(changes.len() > 1 && changes[1].contains("% of region "), "{changes:?}");
}
