//! A catalogue of the user's own devices: a sensor that names one of them is the sensor with its keys, and what is wrong with
//! the file is told with the file.

use perirobot_study::input::{Overrides, Study};

use crate::common::program::{Edit, Folder, Outcome, perirobot, refused, text};

const CATALOGUE: &str = "\
[[model]]
name = \"ours-wide\"
title = \"Depth camera of the second line\"
source = \"offer 2026-117\"
[model.keys]
kind = \"rgbd\"
fov_deg = [87, 58]
resolution_px = [16, 9]
range_m = [0.2, 3.0]
cost = 380
";

/// The keys of the camera in the small study.
const KEYS: &str = "kind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [16, 9]\nrange_m = [0.2, 3.0]\n";

/// The small study with the catalogue, and the name of a device in place of the keys of its camera.
fn folder(model: &str) -> Folder {
    let folder = Folder::new();
    folder.write("ours.toml", CATALOGUE);
    folder.edit("study.toml", KEYS, &format!("model = \"{model}\"\n"));
    let study = std::fs::read_to_string(folder.path("study.toml")).unwrap();
    folder.write("study.toml", format!("catalogue = \"ours.toml\"\n{study}"));
    folder
}

fn check(folder: &Folder, more: &[&str]) -> Outcome {
    let study = folder.path("study.toml");
    perirobot(&[&["check", text(&study), "--backend", "cpu"], more].concat())
}

fn results(folder: &Folder) -> Vec<u8> {
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    std::fs::read(folder.path("out").join("results.csv")).unwrap()
}

#[test]
fn a_device_of_ones_own_is_its_keys() {
    let (plain, ours) = (Folder::new(), folder("ours-wide"));
    assert_eq!(results(&ours), results(&plain));
    // Its cost is that of the sensor, unless the study says otherwise.
    let cost = |folder: &Folder| {
        let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
        study.sensors[0].terms.cost.map(|cost| cost.to_text(None))
    };
    assert_eq!(cost(&ours).as_deref(), Some("380"));
    ours.edit("study.toml", "model = \"ours-wide\"", "model = \"ours-wide\"\ncost = 410");
    assert_eq!(cost(&ours).as_deref(), Some("410"));
}

#[test]
fn catalogues_that_cannot_be() {
    let wrong = |edits: &[Edit], expected: &[&str]| refused(&folder("ours-wide"), edits, expected);
    let ours = |from: &'static str, to: &'static str| ("ours.toml", from, to);
    wrong(
        &[("study.toml", "\"ours-wide\"", "\"ours-wyde\"")],
        &[
            "study.toml: sensor \"camera\".model = \"ours-wyde\": is not in the catalogue",
            "did you mean ours-wide?",
        ],
    );
    wrong(&[("study.toml", "\"ours.toml\"", "\"theirs.toml\"")], &["study.toml: catalogue: ", "theirs.toml"]);
    wrong(
        &[ours("ours-wide", "realsense-d435")],
        &["ours.toml: model \"realsense-d435\": is a device that ships"],
    );
    wrong(&[ours("kind = \"rgbd\"\n", "")], &["ours.toml: model \"ours-wide\".keys: no kind"]);
    wrong(
        &[ours("cost", "poses = []\ncost")],
        &["ours.toml: model \"ours-wide\": keys.poses belongs to a sensor"],
    );
    wrong(
        &[ours(
            "[model.keys]",
            "[model.price]\namount = 300\ncurrency = \"EUR\"\ndate = \"May\"\nsource = \"offer\"\n[model.keys]",
        )],
        &["ours.toml: model \"ours-wide\".price.date = \"May\": must be a year, month or day"],
    );
    wrong(&[ours("title", "tilte")], &["ours.toml: ", "tilte"]);
    wrong(&[ours("", CATALOGUE)], &["ours.toml: ", "ours-wide"]);
    wrong(&[ours("[[model]]", "[[model")], &["ours.toml: "]);
}

#[test]
fn a_list_price_is_named_wherever_it_is_a_cost() {
    let ours = folder("ours-wide");
    let price = "[model.price]\namount = 300\ncurrency = \"EUR\"\ndate = \"2026-11\"\nsource = \"offer\"\n[model.keys]";
    ours.edit("ours.toml", "[model.keys]", price);
    ours.edit("ours.toml", "cost = 380\n", "");
    let plain = check(&ours, &[]);
    assert!(!plain.stdout.contains("prices from the catalogue"), "{}", plain.stdout);
    ours.edit("study.toml", "model = \"ours-wide\"", "model = \"ours-wide\"\ncost = \"list\"");
    ours.edit("study.toml", "catalogue =", "currency = \"EUR\"\ncatalogue =");
    let listed = check(&ours, &[]);
    let expected = "prices from the catalogue, to be checked: camera 300 EUR (offer, 2026-11)";
    assert!(listed.stdout.contains(expected), "{}{}", listed.stdout, listed.stderr);
}

#[test]
fn devices_that_no_sensor_names_are_checked() {
    let ours = folder("ours-wide");
    let unnamed = |keys: &str| {
        ours.write("ours.toml", format!("{CATALOGUE}[[model]]\nname = \"ours-far\"\n[model.keys]\n{keys}\n"));
        check(&ours, &["--poses", "0"]).stderr
    };
    for right in [
        "kind = \"rgbd\"\nrange_m = [1, 9]",
        "kind = \"gate\"\nbox = { min_m = [0, 0, 0], max_m = [1, 1, 1] }",
    ] {
        let said = unnamed(right);
        assert!(!said.contains("ours-far"), "{right}: {said}");
    }
    for (wrong, expected) in [
        ("kind = \"rgbd\"\nrangem = 3", "rangem"),
        (
            "kind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [16, 9]\nrange_m = [3, 1]",
            "range_m = [3.0, 1.0]: must be",
        ),
        ("kind = \"lidarr\"", "lidarr"),
    ] {
        let said = unnamed(wrong);
        let has_all = ["catalogue \"ours.toml\".model \"ours-far\"", expected, "no sensor names this model"]
            .map(|part| said.contains(part));
        assert_eq!(has_all, [true; 3], "{wrong}: {said}");
    }
}
