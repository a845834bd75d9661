//! Pictures: CPU, GPU and oracle draw the same bytes; those that ship are what the commands beside them draw;
//! wishes that cannot be met are refused.

use std::path::Path;

use crate::common;
use crate::common::program::{Folder, perirobot, text};
use perirobot_decide::view::{ChoiceSelector, View, find};
use perirobot_march::backend::{Backend, cpu::Cpu, gpu::Gpu, oracle::Oracle};
use perirobot_page::render::{Colour, Wish, draw};
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

/// Where commands of pictures stand, beside the pictures.
const PICTURES: [&str; 3] =
    ["scenes/paper/PICTURES.md", "scenes/tutorial/README.md", "scenes/palletiser/README.md"];

fn in_project(file: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

#[test]
fn every_backend_draws_the_same_bytes() {
    let overrides = Overrides { voxel_size_m: Some(0.1), ..Default::default() };
    let study = Study::load(&in_project("scenes/paper/exp1.toml"), &overrides).unwrap();
    let worlds = World::prepare(&study, 0).unwrap();
    let mut backends: Vec<Box<dyn Backend>> =
        vec![Box::new(Oracle::default()), Box::new(Cpu::new(None).unwrap())];
    if let Some(adapter) = common::adapter() {
        backends.push(Box::new(Gpu::new(&adapter).unwrap()));
    }
    // Volumes around joints are a veil, and noise puts returns beside what they hit.
    let wanted = ChoiceSelector {
        poses: "camera:left-wall/15/1".into(),
        representation: Some("box".into()),
        ..ChoiceSelector::default()
    };
    let (world, choice) = find(&study, &worlds, &wanted).unwrap();
    let mut drawn: Vec<[Vec<u8>; 2]> = Vec::new();
    for backend in &mut backends {
        let view = View::new(&study, world, choice, &mut **backend).unwrap();
        let pictures = [("iso", Colour::Label, Some(&view)), ("2.5,1.5,2.2", Colour::Height, None)];
        drawn.push(pictures.map(|(eye, colour, view)| {
            let wish = Wish {
                eye: eye.parse().unwrap(),
                look_at_m: None,
                fov_rad: 0.9,
                size_px: [240, 300],
                colour,
                only_region: None,
                cut_above_m: None,
                open_m: 0.1,
                points: 500,
                ways: Vec::new(),
                case: String::new(),
            };
            draw(world, view, &wish, &mut **backend).unwrap().png().unwrap()
        }));
        let last = drawn.len() - 1;
        assert!(drawn[last] == drawn[0], "{} draws otherwise than the oracle", backend.name());
    }
    let again = format!("{} backends", drawn.len());
    assert!(drawn[0][0] != drawn[0][1] && drawn[0][0].len() > 2000, "{again}");
}

/// The commands of the pictures that ship in the folder of a list, in words.
fn commands(list: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(in_project(list)).unwrap();
    let (joined, folder) = (text.replace("\\\n", " "), list.rsplit_once('/').unwrap().0);
    let lines = joined.lines().filter_map(|line| line.trim().strip_prefix("perirobot render "));
    let here = lines.filter(|line| line.contains(&format!("--out {folder}/")));
    here.map(|line| line.split_whitespace().map(|word| word.trim_matches('\'').to_string()).collect())
        .collect()
}

#[test]
fn the_pictures_that_ship_are_those_of_their_commands() {
    for list in PICTURES {
        let shipped = std::fs::read_dir(in_project(list).with_file_name("")).unwrap();
        let is_png = |path: &Path| path.extension().is_some_and(|extension| extension == "png");
        let pictures = shipped.filter(|entry| is_png(&entry.as_ref().unwrap().path())).count();
        assert_eq!(commands(list).len(), pictures, "{list} has a command for each picture");
    }
    let commands = PICTURES.map(commands).concat();
    let folder = tempfile::tempdir().unwrap();
    for words in commands {
        let place = words.iter().position(|word| word == "--out").unwrap() + 1;
        let (file, made) = (words[place].clone(), folder.path().join("made.png"));
        let mut arguments = [&["render".to_string()], &words[..]].concat();
        arguments[place + 1] = text(&made).into();
        let outcome = perirobot(&arguments);
        assert_eq!(outcome.code, Some(0), "{words:?}: {}", outcome.stderr);
        let (old, new) = (pixels(&in_project(&file)), pixels(&made));
        let differing = old.iter().zip(&new).filter(|(a, b)| a != b).count();
        assert!(
            old.len() == new.len() && differing == 0,
            "{differing} of {} bytes of {file} differ; draw it anew: perirobot render {}",
            new.len(),
            words.join(" ")
        );
        let bytes = std::fs::metadata(in_project(&file)).unwrap().len();
        assert!(bytes < 150_000, "{file} has {bytes} bytes");
    }
}

/// What a picture shows; another version of a packer may give other bytes.
fn pixels(path: &Path) -> Vec<u8> {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels
}

#[test]
fn wishes_that_cannot_be_met_are_refused() {
    let folder = Folder::new();
    let (study, out) = (folder.path("study.toml"), folder.path("x.png"));
    let render = |more: &[&str]| {
        let fixed = ["render", text(&study), "--backend", "cpu"];
        perirobot(&[&fixed, more].concat())
    };
    let before = folder.names();
    let cases: [(&[&str], &[&str]); 14] = [
        (&["--out", "x.jpg"], &["--out x.jpg", "must end in .png"]),
        (&["--from", "above"], &["--from", "2.8,1.8,2.7", "iso, top"]),
        (&["--from", "0,0,0", "--look-at", "0,0,0"], &["--from equals --look-at"]),
        (&["--from", "0,0,900"], &["--from", "along z", "--voxel-size"]),
        (&["--look-at", "1,2"], &["--look-at", "three numbers"]),
        (&["--fov-deg", "180"], &["--fov-deg 180", "from 1 to 150"]),
        (&["--size", "10x9999"], &["--size", "from 64 to 4096"]),
        (&["--open", "1000"], &["--open 1000", "from 0 to 100"]),
        (&["--cut-above", "-3"], &["--cut-above leave nothing"]),
        (&["--only-region", "moon"], &["--only-region moon", "there are robot, box, human"]),
        (&["--colour", "label"], &["--colour label", "--pose"]),
        (&["--pose", "camera:moon/0/0"], &["--pose camera:moon/0/0", "camera:wall/0/0"]),
        (&["--scene", "hall"], &["--scene hall", "there are cell"]),
        (&["--snapshot", "3"], &["--snapshot 3", "must be from 0 to 0"]),
    ];
    for (more, expected) in cases {
        let place: &[&str] = if more.contains(&"--out") { &[] } else { &["--out", text(&out)] };
        let outcome = render(&[more, place].concat());
        assert_eq!(outcome.code, Some(2), "{more:?}: {}", outcome.stderr);
        for fragment in expected {
            assert!(outcome.stderr.contains(fragment), "{more:?}: no {fragment:?} in {}", outcome.stderr);
        }
        assert_eq!(folder.names(), before, "{more:?}");
    }
    let outcome = render(&[
        "--pose",
        "camera:wall/1/0",
        "--from",
        "-0.5,0.3,1.2",
        "--size",
        "400x300",
        "--out",
        text(&out),
    ]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert_eq!(pixels(&out).len(), 3 * 400 * 300);
    let plan = folder.path("plan.svg");
    let outcome = render(&["--pose", "camera:wall/1/0", "--out", text(&plan)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let svg = std::fs::read_to_string(&plan).unwrap();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let words: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
    for wanted in ["Floor plan of cell", "crate", "operator", "A", "A  camera:wall/1/0", "robot"] {
        assert!(words.contains(&wanted), "no {wanted:?} in {words:?}");
    }
}
