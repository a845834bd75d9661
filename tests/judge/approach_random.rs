//! `perirobot approach` in random cells: numpy and scipy find the same, and so does any number of threads.

use std::fs;
use std::path::Path;

use crate::common::program::{shelf, text};
use crate::common::{Random, python};
use perirobot_decide::approach::{APPROACH, ApproachAnswer, Approaches, Ground, answers};
use perirobot_decide::view::watched::Watchers;
use perirobot_decide::view::{Choice, View};
use perirobot_march::backend::cpu::Cpu;
use perirobot_page::export::each_file;
use perirobot_scene::objects::build::build;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

/// A random cell: boxes, a robot that moves in some, a person in some, a camera or two that certify, and in some a pad,
/// a light curtain, a cover of the robot.
struct Cell {
    study: String,
    scene: String,
    nobody: String,
    case: String,
    companies: &'static [&'static str],
}

fn cell(random: &mut Random) -> Cell {
    // Whole voxels of 0.1 m, so that bodies and boxes are the same to everybody.
    let at = |random: &mut Random, n: i32| f64::from(random.between(0, 10 * n)) * 0.01;
    let size = |random: &mut Random| 0.1 + random.share() * 0.5;
    let mut scene = String::from(
        "interior = \"occupied\"\n[[object]]\nname = \"floor\"\nplane = { size_m = [2.4, 2] }\nposition_m = [0.6, 0.5, 0.02]\n",
    );
    for number in 0..random.between(1, 5) {
        let [a, b, c] = [(); 3].map(|()| size(random));
        let [x, y, z] = [12, 10, 8].map(|n| at(random, n));
        scene += &format!(
            "[[object]]\nname = \"box {number}\"\nbox = {{ size_m = [{a}, {b}, {c}] }}\nposition_m = [{x}, {y}, {z}]\n"
        );
    }
    let moves = random.one_in(3);
    let mut places = || format!("[{}, {}, 0.3]", at(random, 12), at(random, 10));
    let (first, second) = (places(), places());
    let motion =
        if moves { format!("[object.snapshots]\nposition_m = [{first}, {second}]\n") } else { String::new() };
    scene += &format!(
        "[[object]]\nname = \"robot\"\nrole = \"robot\"\nbox = {{ size_m = [0.15, 0.15, 0.5] }}\nposition_m = {first}\n{motion}"
    );
    // In some cells bodies walk over steps and under boards.
    let step_m = random.one_in(2).then(|| random.of(&[0.0, 0.05, 0.1, 0.2, 0.3]));
    if step_m.is_some() {
        for number in 0..random.between(3, 9) {
            let [x, y, z] = [12, 10, 4].map(|n| f64::from(random.between(0, n)) * 0.1 + 0.02);
            let [wide, deep] = [(); 2].map(|()| f64::from(random.between(2, 6)) * 0.1 - 0.04);
            let high = if random.one_in(3) { 0.04 } else { z };
            let middle = [x + wide / 2.0, y + deep / 2.0, z - high / 2.0];
            let size = [wide, deep, high];
            scene += &format!(
                "[[object]]\nname = \"step {number}\"\nbox = {{ size_m = {size:?} }}\nposition_m = {middle:?}\n"
            );
        }
    }
    // The sensors' voxels are solid: a ray tells nothing of the one that it begins in.
    let mut study = String::new();
    let mut housings = String::new();
    let sensors = random.between(1, 2);
    for number in 0..sensors {
        let place = [12, 10, 8].map(|n| f64::from(random.between(0, n - 1)) * 0.1 + 0.05);
        housings += &format!(
            "[[object]]\nname = \"housing {number}\"\nbox = {{ size_m = [0.04, 0.04, 0.04] }}\nposition_m = {place:?}\n"
        );
        let (pan, tilt) = (random.between(-180, 180), random.between(-60, 60));
        let range = random.of(&[0.5, 0.9, 4.0]);
        let optics = match random.below(3) {
            0 => "kind = \"lidar\"\nmount = \"facing\"\nfov_deg = [360, 80]\nresolution_deg = [5, 6]"
                .to_string(),
            _ => format!(
                "kind = \"rgbd\"\nfov_deg = [{}, 60]\nresolution_px = [40, 30]",
                random.between(40, 140)
            ),
        };
        study += &format!(
            "[[sensor]]\nname = \"sensor {number}\"\n{optics}\nrange_m = [0, {range}]\nno_return = \"free\"\n\
             [[sensor.poses]]\nname = \"p\"\nlist = [{{ position_m = {place:?}, facing = [1, 0, 0], pan_deg = {pan}, tilt_deg = {tilt} }}]\n"
        );
    }
    let (mut switches, mut names, mut cover) = (Vec::new(), Vec::new(), "null");
    // One that is tared does not feel what always stands on it.
    let switch = |low: [f64; 3], high: [f64; 3], tare: bool| {
        format!("{{\"low\": {low:?}, \"high\": {high:?}, \"tare\": {tare}}}")
    };
    // Sides lie between voxels.
    let tenths = |n: [i32; 3]| n.map(|n| f64::from(n) * 0.1);
    if random.one_in(2) {
        let (x, y) = (random.between(0, 6), random.between(0, 5));
        let (wide, deep) = (random.between(2, 5), random.between(2, 4));
        let ([low, high], tare) = ([tenths([x, y, 1]), tenths([x + wide, y + deep, 2])], random.one_in(2));
        study += &format!(
            "[[sensor]]\nname = \"pad\"\nkind = \"pad\"\ntare = {tare}\nsize_m = {:?}\n\
             [[sensor.poses]]\nname = \"p\"\nx_m = {}\ny_m = {}\nz_m = 0.05\n",
            &tenths([wide, deep, 0])[..2],
            low[0],
            low[1]
        );
        switches.push(switch(low, high, tare));
        names.push("pad");
    }
    if random.one_in(2) {
        let (x, z) = (random.between(1, 8), random.between(0, 2));
        let [low, high] = [tenths([x, 0, z]), tenths([x + 1, 9, z + 5])];
        study += &format!(
            "[[sensor]]\nname = \"gate\"\nkind = \"gate\"\nbox = {{ min_m = {low:?}, max_m = {high:?} }}\n\
             zone = {{ min_m = [0, 0, 0], max_m = {:?} }}\n",
            tenths([x, 9, 7])
        );
        switches.push(switch(low, high, false));
        names.push("gate");
    }
    if random.one_in(3) {
        study += "[[sensor]]\nname = \"cover\"\nkind = \"cover\"\ninflation_m = [0.25]\n";
        (cover, names) = ("0.25", [&names[..], &["cover"]].concat());
    }
    scene += &housings;
    let nobody = scene.clone();
    let has_person = random.one_in(2);
    if has_person {
        let [x, y] = [12, 10].map(|n| at(random, n));
        scene += &format!(
            "[[object]]\nname = \"person\"\nrole = \"human\"\nbox = {{ size_m = [0.2, 0.3, 0.7] }}\nposition_m = [{x}, {y}, 0.4]\n"
        );
    }
    let rays: Vec<String> = (0..sensors).map(|number| format!("sensor {number}")).collect();
    let members: Vec<&str> = rays.iter().map(String::as_str).chain(names).collect();
    let hazard = random.of(&["hazard = \"robot\"", "hazard = \"robot_swept\"", "region = \"tool\""]);
    let (name, region) =
        (hazard.split('"').nth(1).unwrap(), if hazard.starts_with("region") { "\"tool\"" } else { "null" });
    let min_voxels = random.between(1, 3);
    let floor = step_m.map_or(String::new(), |step_m| format!("floor = \"auto\"\nstep_m = {step_m}\n"));
    let step = step_m.map_or("null".into(), |step_m| step_m.to_string());
    let low = random.between(0, 3);
    let door = [[0.0, f64::from(low) * 0.1, 0.0], [0.4, f64::from(low + 6) * 0.1, 0.8]];
    let study = format!(
        "[grid]\nvoxel_size_m = 0.1\nbounds_m = {{ min = [0, 0, 0], max = [1.15, 0.95, 0.75] }}\n\
         [[scene]]\nfile = \"cell.toml\"\n[[region]]\nname = \"tool\"\nbox = {{ min_m = [0.5, 0.3, 0.1], max_m = [0.8, 0.6, 0.4] }}\n\
         {study}[[combination]]\nname = \"all\"\nsensors = {members:?}\n[[combination]]\nname = \"rays\"\nsensors = {rays:?}\n\
         [approach]\n{hazard}\nmin_voxels = {min_voxels}\n{floor}\
         [[approach.body]]\nname = \"person\"\ncylinder = {{ diameter_m = 0.3, height_m = 0.5 }}\n\
         [[approach.body]]\nname = \"hand\"\nball = {{ diameter_m = 0.2 }}\n\
         [[approach.body]]\nname = \"pole\"\nbox = {{ size_m = [0.1, 0.2, 0.4] }}\n\
         [[approach.entry]]\nname = \"edges\"\nedges = true\n\
         [[approach.entry]]\nname = \"door\"\nbox = {{ min_m = {:?}, max_m = {:?} }}\n",
        door[0], door[1]
    );
    let companies: &[&str] = if has_person { &["absent", "cover"] } else { &["absent"] };
    let case = format!(
        "{{\"voxel_m\": 0.1, \"floor_m\": 0, \"step_m\": {step}, \"snapshots\": {}, \"hazard\": \"{name}\", \"region\": {region}, \"companies\": {companies:?},\n\
         \"switches\": [{}], \"cover_m\": {cover},\n\
         \"bodies\": [{{\"name\": \"person\", \"cylinder\": [0.3, 0.5], \"on_floor\": true, \"min_voxels\": {min_voxels}}},\n\
         {{\"name\": \"hand\", \"ball\": 0.2, \"on_floor\": false, \"min_voxels\": {min_voxels}}},\n\
         {{\"name\": \"pole\", \"box\": [0.1, 0.2, 0.4], \"on_floor\": true, \"min_voxels\": {min_voxels}}}],\n\
         \"entries\": [{{\"name\": \"edges\", \"box\": null}}, {{\"name\": \"door\", \"box\": {door:?}}}]}}",
        1 + i32::from(moves),
        switches.join(", ")
    );
    Cell { study, scene, nobody, case, companies }
}

const FIRST: Choice = Choice { combination: 0, choice: 0, representation: 0, repeat: 0 };

fn asked<'a>(
    study: &'a Study,
    worlds: &'a [World],
) -> perirobot_march::Result<(Ground<'a>, Vec<ApproachAnswer>)> {
    let watchers = Watchers::new(study, FIRST);
    let ground = Ground::new(study, worlds, watchers.each())?;
    let (answers, _) = answers(&ground, worlds, &watchers, &|| None)?;
    Ok((ground, answers))
}

/// What sensors that cast say in the random cells.
const RAYS: Choice = Choice { combination: 1, ..FIRST };

/// The arrays of each snapshot of a scene.
fn export(folder: &Path, company: &str, study: &Study, worlds: &[World]) {
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let scenes = build(&study.scenes[0], &study.sources, study.voxel_size_m).unwrap();
    for (world, scene) in worlds.iter().zip(&scenes) {
        let view = View::new(study, world, RAYS, &mut cpu).unwrap();
        let name = folder.join(format!("{company}-{}.npz", world.snapshot));
        let keep = |file: perirobot_page::export::ExportedFile| match file.name == "view.npz" {
            true => perirobot_sweep::results::files::write_whole(&name, &file.bytes),
            false => Ok(()),
        };
        each_file(&view, scene, keep).unwrap();
    }
}

#[test]
fn numpy_and_scipy_find_the_same_in_random_cells() {
    let Some(interpreter) = python::python() else { return };
    const MADE: u32 = 90;
    let folder = tempfile::tempdir().unwrap();
    let (mut made, mut refused) = (0, 0);
    for seed in 0..300 {
        let random = &mut Random(seed);
        let Cell { study: text, scene, nobody, case, companies } = cell(random);
        let here = folder.path().join(format!("case-{seed:03}"));
        fs::create_dir(&here).unwrap();
        let load = |scene: &str| {
            fs::write(here.join("study.toml"), &text).unwrap();
            fs::write(here.join("cell.toml"), scene).unwrap();
            let study = Study::load(&here.join("study.toml"), &Overrides::default()).unwrap();
            let worlds = World::prepare_all(&study);
            (study, worlds)
        };
        let (study, worlds) = load(&scene);
        // Some have no robot in the grid, no room for a body, or a region inside something.
        let found = worlds
            .as_ref()
            .map_err(|e| e.to_string())
            .and_then(|worlds| asked(&study, worlds).map_err(|e| e.to_string()));
        let Ok((ground, answers)) = found else {
            fs::remove_dir_all(&here).unwrap();
            refused += 1;
            continue;
        };
        let approaches = Approaches::new(&study, &RAYS, String::new(), &[(ground, answers)]);
        fs::write(here.join(APPROACH), approaches.csv()).unwrap();
        fs::write(here.join("case.json"), case).unwrap();
        if companies.contains(&"cover") {
            export(&here, "cover", &study, worlds.as_ref().unwrap());
        }
        let (study, worlds) = load(&nobody);
        export(&here, "absent", &study, &worlds.unwrap());
        made += 1;
        if made == MADE {
            break;
        }
    }
    assert!(made == MADE, "{made} cells were asked, {refused} could not be");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/pandas/approach.py");
    python::run(&interpreter, &[script, text(folder.path())]).unwrap();
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let folder = shelf();
    let study = Study::load(
        &folder.path("study.toml"),
        &Overrides { voxel_size_m: Some(0.1), ..Overrides::default() },
    )
    .unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let answers = pool.install(|| asked(&study, &worlds).unwrap());
        Approaches::new(&study, &FIRST, String::new(), &[answers]).csv()
    };
    let one = on(1);
    assert!(one.len() > 500);
    assert!(on(2) == one && on(5) == one);
}
