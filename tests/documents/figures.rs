//! Figures: their boxes, bars, colours and curves are where the rows of results.csv put them, worked out here from those
//! rows; pictures are those of `render`; what cannot be drawn is left out or refused, and nothing is half-written.

use std::collections::BTreeSet;
use std::fs;

use crate::common::program::{Folder, names, perirobot, rows, text};
use perirobot_scene::shell;
use perirobot_sweep::results::manifest::Manifest;
use roxmltree::{Document, Node};

/// Draws figures of the folder's sweep into `figures`.
#[track_caller]
fn figures(folder: &Folder, more: &[&str]) {
    let (swept, out) = (folder.path("out"), folder.path("figures"));
    let fixed = ["figures", text(&swept), "--out", text(&out), "--backend", "cpu", "--progress", "none"];
    let outcome = perirobot(&[&fixed, more].concat());
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
}

/// The small study, swept.
fn swept() -> Folder {
    let folder = Folder::new();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    folder
}

/// A figure of the sweep.
#[track_caller]
fn drawn(folder: &Folder, file: &str) -> String {
    fs::read_to_string(folder.path("figures/out").join(file)).unwrap()
}

fn of_class<'a>(document: &'a Document, class: &str) -> Vec<Node<'a, 'a>> {
    document.descendants().filter(|node| node.attribute("class") == Some(class)).collect()
}

fn length(node: &Node, name: &str) -> f64 {
    node.attribute(name).unwrap().parse().unwrap()
}

fn told<'a>(node: &Node<'a, 'a>) -> &'a str {
    node.first_element_child().and_then(|title| title.text()).unwrap_or_default()
}

/// From places to numbers, by the first and the last of some texts that stand beside an axis.
fn scale(texts: &[Node], along: &str) -> impl Fn(f64) -> f64 + use<> {
    let at = |node: &Node| (length(node, along), node.text().unwrap().parse::<f64>().unwrap());
    let [(a, low), (b, high)] = [at(&texts[0]), at(texts.last().unwrap())];
    // Letters beside an axis hang a little below their line.
    let shift = if along == "y" { 4.0 } else { 0.0 };
    move |place| low + (place + shift - a) / (b - a) * (high - low)
}

/// F1 of each pose of a sensor in the region `robot`, as results.csv has them in the scene's only snapshot.
fn f1_of(folder: &Folder, sensor: &str) -> Vec<(String, f64)> {
    let all = rows(&folder.path("out/results.csv")).into_iter();
    let here = all.filter(|row| row["combination"] == sensor && row["region"] == "robot");
    here.map(|row| (row["poses"].clone(), row["f1"].parse().unwrap())).collect()
}

#[track_caller]
fn assert_near(found: f64, expected: f64, near: f64, what: &str) {
    assert!((found - expected).abs() <= near, "{what}: {found}, not {expected}");
}

#[test]
fn boxes_are_where_the_quartiles_are() {
    let folder = swept();
    figures(&folder, &["--only", "distributions", "--score", "f1", "--region", "robot"]);
    let svg = drawn(&folder, "distributions-robot.svg");
    let document = Document::parse(&svg).unwrap();
    let value = scale(&of_class(&document, "soft mid tick"), "x");
    let boxes = of_class(&document, "box");
    let medians = of_class(&document, "median");
    assert_eq!(boxes.len(), 2);
    for (sensor, (found, median)) in ["camera", "lidar"].into_iter().zip(boxes.iter().zip(&medians)) {
        let mut all: Vec<f64> = f1_of(&folder, sensor).into_iter().map(|(_, f1)| f1).collect();
        all.sort_by(f64::total_cmp);
        // 8 poses: places 7/4, 7/2 and 21/4; 3 poses: 1/2, 1 and 3/2.
        let between = |below: usize, part: f64| all[below] + part * (all[below + 1] - all[below]);
        let [lower, middle, upper] = match all.len() {
            8 => [between(1, 0.75), between(3, 0.5), between(5, 0.25)],
            3 => [between(0, 0.5), all[1], between(1, 0.5)],
            other => panic!("{sensor} has {other} poses"),
        };
        let left = length(found, "x");
        assert_near(value(left), lower, 0.001, sensor);
        assert_near(value(left + length(found, "width")), upper, 0.001, sensor);
        let x = median.attribute("d").unwrap()[1..].split(' ').next().unwrap();
        assert_near(value(x.parse().unwrap()), middle, 0.001, sensor);
        let words = format!("quartiles {lower:.3} and {upper:.3}, median {middle:.3}");
        assert!(told(found).contains(&words), "{sensor}: {words:?} is not in {:?}", told(found));
        // The same as the table of `summary` has.
        let summary =
            perirobot(&["summary", text(&folder.path("out")), "--region", "robot", "--score", "f1"]).stdout;
        let row = summary.lines().find(|line| line.contains(&format!("{sensor} · "))).unwrap();
        for number in [lower, middle, upper].map(|number| format!("{number:.3}")) {
            assert!(row.contains(&number), "{sensor}: no {number} in {row}");
        }
    }
}

#[test]
fn bars_are_as_long_as_the_maxima() {
    let folder = swept();
    figures(&folder, &["--only", "maxima", "--score", "f1", "--region", "robot"]);
    let svg = drawn(&folder, "maxima-robot.svg");
    let document = Document::parse(&svg).unwrap();
    let (value, bars) = (scale(&of_class(&document, "soft mid tick"), "x"), of_class(&document, "bar"));
    assert_eq!(bars.len(), 2);
    for (sensor, bar) in ["camera", "lidar"].into_iter().zip(&bars) {
        let most = f1_of(&folder, sensor).into_iter().map(|(_, f1)| f1).fold(0.0, f64::max);
        assert_near(value(length(bar, "x")), 0.0, 0.001, sensor);
        assert_near(value(length(bar, "x") + length(bar, "width")), most, 0.001, sensor);
        assert!(told(bar).starts_with(&format!("{sensor}, cell: {most:.3}")), "{}", told(bar));
    }
}

#[test]
fn places_have_the_colour_of_their_best_orientation() {
    let folder = swept();
    figures(
        &folder,
        &["--only", "placements", "--score", "f1", "--region", "robot", "--combination", "camera"],
    );
    assert_eq!(names(&folder.path("figures/out")), ["placements-robot-camera-points.svg"]);
    let svg = drawn(&folder, "placements-robot-camera-points.svg");
    let document = Document::parse(&svg).unwrap();
    let spots = of_class(&document, "spot");
    let poses = f1_of(&folder, "camera");
    // Two orientations at each of three places, and two places by chance.
    let f1 = |name: &str| poses.iter().find(|(known, _)| known == &format!("camera:{name}")).unwrap().1;
    let mut best: Vec<f64> =
        (0..3).map(|n| f1(&format!("wall/{n}/0")).max(f1(&format!("wall/{n}/1")))).collect();
    best.extend([f1("random/0"), f1("random/1")]);
    let mut expected: Vec<String> = best.iter().map(|value| format!("{value:.3}")).collect();
    let of = |spot: &Node| told(spot).split(": ").nth(1).unwrap().to_string();
    let mut found: Vec<String> = spots.iter().map(of).collect();
    expected.sort();
    found.sort();
    assert_eq!(found, expected);
    let (low, high) = best.iter().fold((1.0f64, 0.0f64), |(low, high), &v| (low.min(v), high.max(v)));
    // Five colours of viridis, a quarter of the range from each other.
    let ramp = [
        [68.0, 1.0, 84.0],
        [59.0, 82.0, 139.0],
        [33.0, 145.0, 140.0],
        [94.0, 201.0, 98.0],
        [253.0, 231.0, 37.0],
    ];
    for spot in &spots {
        let name = told(spot).split(": ").next().unwrap();
        let place = (f1(name) - low) / (high - low) * 4.0;
        let (below, part) = ((place as usize).min(3), place - (place as usize).min(3) as f64);
        let colour = spot.attribute("fill").unwrap();
        for (n, (a, b)) in ramp[below].iter().zip(ramp[below + 1]).enumerate() {
            let channel = u8::from_str_radix(&colour[1 + 2 * n..3 + 2 * n], 16).unwrap();
            assert_near(channel.into(), a + (b - a) * part, 1.5, &format!("{name} {colour}"));
        }
    }
}

#[test]
fn curves_go_through_the_score_of_each_snapshot() {
    let folder = Folder::new();
    let moving = "snapshots = { position_m = [[0.1, -0.45, 0.65], [0.4, -0.4, 0.65], [0.6, 0.0, 0.65]] }";
    folder.edit("cell.toml", "position_m = [0.1, -0.45, 0.65]", moving);
    assert_eq!(folder.sweep(&[]).code, Some(0));
    figures(
        &folder,
        &["--only", "snapshots", "--score", "f1", "--region", "human", "--combination", "camera"],
    );
    let svg = drawn(&folder, "snapshots-human-cell.svg");
    let document = Document::parse(&svg).unwrap();
    let value = scale(&of_class(&document, "soft end"), "y");
    let curves = of_class(&document, "curve");
    let best = curves.iter().find(|curve| told(curve).contains("(best by mean")).unwrap();
    let name = told(best).split(": ").next().unwrap();
    let all = rows(&folder.path("out/results.csv"));
    let here = all.iter().filter(|row| row["poses"] == format!("camera:{name}") && row["region"] == "human");
    let expected: Vec<f64> = here.map(|row| row["f1"].parse().unwrap()).collect();
    let path = best.attribute("d").unwrap().replace(['M', 'L'], " ");
    let ys: Vec<f64> = path.split_whitespace().skip(1).step_by(2).map(|y| y.parse().unwrap()).collect();
    assert_eq!((ys.len(), expected.len()), (3, 3), "{path}");
    for (y, expected) in ys.iter().zip(&expected) {
        assert_near(value(*y), *expected, 0.002, name);
    }
    let mean = expected.iter().sum::<f64>() / 3.0;
    assert!(told(best).contains(&format!("mean {mean:.3}")), "{}", told(best));
}

#[test]
fn a_page_lists_every_figure_and_says_what_is_left_out() {
    let folder = Folder::noisy();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    figures(&folder, &["--region", "robot"]);
    let page = fs::read_to_string(folder.path("figures/README.md")).unwrap();
    let files = names(&folder.path("figures/out"));
    let listed: BTreeSet<&str> = page
        .lines()
        .filter_map(|line| line.split_once("](<out/"))
        .filter_map(|(_, file)| file.strip_suffix(">)"))
        .collect();
    assert_eq!(listed, files.iter().map(String::as_str).collect());
    assert!(page.contains("Left out: no scene moves."), "{page}");
    let manifest = Manifest::read(&folder.path("out")).unwrap();
    let command = shell::command(&manifest.provenance.about.command);
    assert!(page.contains(&format!("\n    {command}\n")), "no {command} in {page}");
    let bytes = |file: &String| fs::read(folder.path("figures/out").join(file)).unwrap();
    let before: Vec<Vec<u8>> = files.iter().map(bytes).collect();
    for (file, bytes) in files.iter().zip(&before).filter(|(file, _)| file.ends_with(".svg")) {
        let svg = std::str::from_utf8(bytes).unwrap();
        let document = Document::parse(svg).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert!(document.descendants().all(|node| !node.has_tag_name("script")), "{file}");
        // Everything stands on the paper.
        let [width, height] = ["width", "height"].map(|name| length(&document.root_element(), name));
        for node in document.descendants().filter(|node| node.has_attribute("x")) {
            let (x, y) = (length(&node, "x"), length(&node, "y"));
            assert!((0.0..=width).contains(&x) && (0.0..=height).contains(&y), "{file}: {x}, {y}");
        }
    }
    let kinds = ["distributions", "placements", "maxima", "snapshots"];
    figures(&folder, &[&kinds.map(|kind| ["--only", kind]).concat()[..], &["--region", "robot"]].concat());
    assert!(files.iter().map(bytes).eq(before), "drawn again, other bytes");
}

#[test]
fn pictures_are_those_of_render() {
    let folder = swept();
    figures(&folder, &["--only", "pictures", "--score", "f1", "--region", "human"]);
    let page = fs::read_to_string(folder.path("figures/README.md")).unwrap();
    let all = rows(&folder.path("out/results.csv")).into_iter().filter(|row| row["region"] == "human");
    let f1 = |row: &std::collections::HashMap<String, String>| row["f1"].parse::<f64>().unwrap();
    let best = all.reduce(|a, b| if f1(&b) > f1(&a) { b } else { a }).unwrap();
    let caption = format!("by F1 in region human ({:.3}): {}", f1(&best), best["poses"]);
    assert!(page.contains(&caption), "no {caption:?} in {page}");
    let (study, made) = (folder.path("study.toml"), folder.path("made.png"));
    let fixed = [
        "render",
        text(&study),
        "--backend",
        "cpu",
        "--size",
        "800x520",
        "--points",
        "1500",
        "--out",
        text(&made),
    ];
    for (file, more) in
        [("picture-scene-cell.png", &[][..]), ("picture-best-f1-human.png", &["--pose", &best["poses"]])]
    {
        assert_eq!(perirobot(&[&fixed, more].concat()).code, Some(0));
        assert!(
            fs::read(&made).unwrap() == fs::read(folder.path("figures/out").join(file)).unwrap(),
            "{file}"
        );
    }
}

#[test]
fn what_cannot_be_drawn_is_refused_and_nothing_is_written() {
    let folder = swept();
    let (swept, out) = (folder.path("out"), folder.path("figures"));
    fs::create_dir(folder.path("other")).unwrap();
    fs::create_dir(folder.path("other/out")).unwrap();
    let other = folder.path("other/out");
    for file in names(&swept) {
        fs::copy(swept.join(&file), other.join(&file)).unwrap();
    }
    let before = folder.names();
    let file = folder.path("cell.toml");
    let cases: [(&[&str], &[&str]); 6] = [
        (&["--region", "moon"], &["--region moon", "robot"]),
        (&["--combination", "moon"], &["--combination moon", "camera"]),
        (&["--representation", "moon"], &["--representation moon", "points"]),
        (&["--scene", "moon"], &["--scene moon", "cell"]),
        (&[text(&other)], &["another folder is also called out"]),
        (&[text(&file)], &["is not a folder: name one"]),
    ];
    for (more, expected) in cases {
        let fixed = ["figures", text(&swept), "--out", text(&out), "--backend", "cpu"];
        let outcome = perirobot(&[&fixed, more].concat());
        assert_eq!(outcome.code, Some(2), "{more:?}: {}", outcome.stderr);
        for fragment in expected {
            assert!(outcome.stderr.contains(fragment), "{more:?}: no {fragment:?} in {}", outcome.stderr);
        }
        assert_eq!(folder.names(), before, "{more:?}");
    }
    // A sweep that is not finished is refused as `summary` does.
    fs::write(other.join("counts.journal"), &fs::read(swept.join("counts.journal")).unwrap()[..200]).unwrap();
    let summary = perirobot(&["summary", text(&other)]);
    let unfinished = perirobot(&["figures", text(&other), "--out", text(&out), "--backend", "cpu"]);
    assert_eq!((unfinished.code, &unfinished.stderr), (Some(2), &summary.stderr));
    assert_eq!(folder.names(), before);
}

#[test]
fn regions_whose_names_differ_in_case_alone_have_files_of_their_own() {
    let folder = Folder::new();
    folder.edit("study.toml", "name = \"robot\"", "name = \"Human\"");
    assert_eq!(folder.sweep(&[]).code, Some(0));
    figures(&folder, &["--only", "maxima"]);
    let files = names(&folder.path("figures/out"));
    let plain: BTreeSet<String> = files.iter().map(|file| file.to_lowercase()).collect();
    assert!(files.len() > 1 && plain.len() == files.len(), "{files:?}");
}
