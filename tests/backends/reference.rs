//! One scene of the paper's authors, with the counts that their own code printed (opt-in: the data carries no
//! licence and is not part of this project). Set PERIROBOT_REFERENCE to a folder that holds `human4/`.
//!
//! Equal counts are not possible: their code casts only toward occupied voxels, carves a second time to the
//! hit voxel's centre, and measures range to centres; it detects a hidden keypoint at what hides it; its pads
//! and zones snap the map between sensors; its covers grow by city blocks. What must agree is the size of the
//! regions, the ranking of the poses, for points the best pose too, and the size of the scores.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::common;
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::metrics::Confusion;
use perirobot_scene::source::Sources;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;
use perirobot_sweep::scoring::{Row, run};

/// Their counts of one pose (or choice of poses) in one region, and whatever else stood in the row.
struct Theirs {
    columns: Vec<String>,
    counts: Confusion,
}

/// Where their scene lies, or `None` and a note.
fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("PERIROBOT_REFERENCE");
    if folder.is_none() {
        common::say("SKIPPED: PERIROBOT_REFERENCE is not set, nothing was compared with the authors' code");
    }
    Some(Path::new(&folder?).join("human4").canonicalize().unwrap())
}

#[test]
fn the_authors_poses_rank_alike() {
    let Some(folder) = folder() else { return };
    let theirs = read(&folder.join("camera_counts.csv"), 10);
    let of = |representation: &str, region: &str| -> Vec<&Theirs> {
        theirs.iter().filter(|t| t.columns[8] == representation && t.columns[9] == region).collect()
    };
    assert_eq!(of("points", "robot").len(), 173, "poses of the reference");

    let temp = tempfile::tempdir().unwrap();
    let rows: String = of("points", "robot").iter().map(|t| t.columns[..8].join(",") + "\n").collect();
    std::fs::write(temp.path().join("poses.csv"), format!("pose,x_m,y_m,z_m,qw,qx,qy,qz\n{rows}")).unwrap();
    let sensors = "[[sensor]]\nname = \"camera\"\nkind = \"rgbd\"\nfov_deg = [87, 58]\n\
         resolution_px = [1280, 720]\nrange_m = [0.6, 6.0]\n\
         representations = [\"points\", \"spheres\", \"cylinders\", \"box\"]\n\
         [[sensor.poses]]\nname = \"theirs\"\ncsv = \"poses.csv\"\nframe = \"optical\"\n\
         [[sensor]]\nname = \"zone\"\nkind = \"rgb\"\nfov_deg = [87, 58]\nresolution_px = [1280, 720]\n\
         range_m = [0.0, 10.0]\notherwise = \"free\"\nsame_poses_as = \"camera\"\n\
         zone = { min_m = [-0.5, -1, 0], max_m = [2, 1, 3] }\n";
    let strict = sensors[sensors.rfind("[[sensor]]").unwrap()..].replace("\"zone\"", "\"strict\"");
    let strict = strict + "keypoint_tolerance_m = 0.05\nmin_keypoints = 2\n";
    let study = study(temp.path(), &folder, &format!("{sensors}{strict}"));
    let (world, rows) = swept(&study);
    assert_eq!(world.truth().occupied.count(), 46_505);

    let best = [("robot", "725"), ("human", "660")];
    for (r, (region, best_pose)) in best.into_iter().enumerate() {
        for (way, name) in ["points", "spheres", "cylinders", "box"].into_iter().enumerate() {
            let is = |row: &&Row| (row.combination, row.representation) == (0, way);
            let ours: Vec<Confusion> =
                rows.iter().filter(|row| row.region == r && is(row)).map(|row| row.counts).collect();
            let theirs = of(name, region);
            assert_eq!(ours.len(), theirs.len());
            assert_eq!(ours[0].total(), theirs[0].counts.total(), "voxels of region {region}");
            let pose = |i: usize| theirs[i].columns[0].as_str();
            let counts: Vec<Confusion> = theirs.iter().map(|t| t.counts).collect();
            for found in rank(&format!("{name}, {region}"), &ours, &counts) {
                if name == "points" {
                    assert!(
                        ours.iter().all(|c| c.fp == 0 && c.fn_ == 0),
                        "without noise nothing is mistaken"
                    );
                    assert!(
                        found.rho >= 0.998 && found.median <= 0.005 && found.largest <= 0.06,
                        "{found:?}"
                    );
                    assert_eq!(found.best.map(pose), [best_pose; 2], "{region}");
                } else {
                    assert!(found.rho >= 0.9, "{found:?}");
                }
            }
        }
    }

    // A zone is on or off. Theirs is on in fewer poses, never where ours is off: it seems to want a joint
    // that is within a voxel of what is seen, where ours allows for a body around it. With that asked of two
    // joints, ours is much like it.
    let on = |combination: usize, pose: &str| {
        let is = |row: &&Row| (row.combination, row.region) == (combination, 0);
        let name = |row: &Row| &study.sensors[0].candidates[row.choice].name;
        let found = rows.iter().filter(is).find(|row| name(row).rsplit('/').next() == Some(pose));
        found.expect("all their poses are ours").counts.tp > 0
    };
    // Their zone camera lacks one of the poses.
    let theirs: Vec<(&str, bool)> =
        of("zone", "robot").iter().map(|t| (t.columns[0].as_str(), t.counts.tp > 0)).collect();
    assert_eq!(theirs.len(), 172);
    assert!(theirs.iter().all(|(pose, theirs)| !theirs || on(1, pose)));
    let alike = theirs.iter().filter(|(pose, theirs)| *theirs == on(2, pose)).count();
    common::say(&format!("zone: {alike} of {} poses on or off as theirs", theirs.len()));
    assert!(alike >= 155, "{alike}");
}

#[test]
fn the_authors_combinations_rank_alike() {
    let Some(folder) = folder() else { return };
    let theirs = read(&folder.join("multi_sensor_counts.csv"), 8);
    let temp = tempfile::tempdir().unwrap();
    let study = study(temp.path(), &folder, &multi_sensors(&theirs));
    let (_, rows) = swept(&study);
    for (r, region) in ["robot", "human"].into_iter().enumerate() {
        let theirs: Vec<&Theirs> = theirs.iter().filter(|t| t.columns[7] == region).collect();
        assert_eq!(theirs.len(), 56, "choices of the reference");
        let ours: Vec<Confusion> = theirs
            .iter()
            .map(|t| {
                let wanted: HashSet<&str> = t.columns[0].split('_').collect();
                let is_it = |row: &&Row| {
                    let combination = &study.combinations[row.combination];
                    let members = combination.members.iter().zip(combination.choice(row.choice));
                    let names = members.map(|(m, c)| study.sensors[m.sensor].candidates[c].name.as_str());
                    let names = names.filter(|name| *name != "known");
                    row.region == r && names.map(short).collect::<HashSet<_>>() == wanted
                };
                rows.iter().find(is_it).unwrap_or_else(|| panic!("{} is not ours", t.columns[0])).counts
            })
            .collect();
        let counts: Vec<Confusion> = theirs.iter().map(|t| t.counts).collect();
        assert_eq!(ours[0].total(), counts[0].total(), "voxels of region {region}");
        // Kappa of combinations is only reported. It is 0.00 to 0.03 here, and two habits of theirs decide
        // its order: a pad's column begins in the floor's own layer (a triggered pad is right about the
        // floor, a silent one wrong) and is a voxel wider, so that three more pads feel a leg of the table.
        let [f1, _kappa] = rank(&format!("combinations, {region}"), &ours, &counts);
        assert!(f1.rho >= 0.9 && f1.median <= 0.005, "{f1:?}");
    }
}

/// The name that the reference gives to one of our candidates: `pads/p03` is p03, a cover of 0.2 m is r2.
fn short(name: &str) -> &str {
    match name {
        "0.1" => "r1",
        "0.2" => "r2",
        "0.3" => "r3",
        other => other.rsplit('/').next().unwrap(),
    }
}

/// Their pads, camera poses, covers, and the known robot, in all combinations.
fn multi_sensors(theirs: &[Theirs]) -> String {
    let singles = theirs.iter().filter(|t| !t.columns[0].contains('_') && t.columns[7] == "robot");
    let (mut pads, mut pans) = (String::new(), String::new());
    for t in singles {
        let [name, x0, _, y0, _, pan, ..] = &t.columns[..] else { panic!("eight columns") };
        if !x0.is_empty() {
            pads += &format!("{{ name = {name:?}, position_m = [{x0}, {y0}, 0] }},\n");
        }
        if !pan.is_empty() {
            pans += &format!(
                "{{ name = {name:?}, position_m = [0.1, 0, 1.15], facing = [1, 0, 0], pan_deg = {pan} }},\n"
            );
        }
    }
    let combined =
        ["pads", "camera", "cover", "pads camera", "pads cover", "camera cover", "pads camera cover"];
    let combined: String = combined
        .iter()
        .map(|names| {
            let quoted: Vec<String> = names.split(' ').map(|name| format!("{name:?}")).collect();
            format!("[[combination]]\nsensors = [{}, \"robot\"]\n", quoted.join(", "))
        })
        .collect();
    format!(
        "[[sensor]]\nname = \"pads\"\nkind = \"pad\"\nsize_m = [1.0, 0.75]\nheight_m = 3.0\ntare = false\n\
         [[sensor.poses]]\nname = \"pads\"\nlist = [{pads}]\n\
         [[sensor]]\nname = \"camera\"\nkind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [1280, 720]\n\
         range_m = [0.3, 3.0]\n[[sensor.poses]]\nname = \"base\"\nlist = [{pans}]\n\
         [[sensor]]\nname = \"cover\"\nkind = \"cover\"\ninflation_m = [0.1, 0.2, 0.3]\n\
         [[sensor]]\nname = \"robot\"\nkind = \"known_robot\"\n{combined}"
    )
}

/// How alike two lists of scores are.
#[derive(Debug)]
#[allow(dead_code)] // some fields are only printed
struct Likeness {
    what: String,
    rho: f64,
    /// Indices of our best and theirs.
    best: [usize; 2],
    /// Of the absolute differences.
    median: f64,
    largest: f64,
}

/// Compares F1 and kappa of the same poses.
fn rank(what: &str, ours: &[Confusion], theirs: &[Confusion]) -> [Likeness; 2] {
    let scores = [("F1", Confusion::f1 as fn(&Confusion) -> _), ("kappa", Confusion::kappa)];
    let likeness = scores.map(|(score, of)| {
        let a: Vec<f64> = ours.iter().map(|c| of(c).unwrap()).collect();
        let b: Vec<f64> = theirs.iter().map(|c| of(c).unwrap()).collect();
        let mut off: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).collect();
        off.sort_by(f64::total_cmp);
        let top = |v: &[f64]| (0..v.len()).max_by(|&i, &j| v[i].total_cmp(&v[j])).unwrap();
        Likeness {
            what: format!("{what}, {score}"),
            rho: spearman(&a, &b),
            best: [top(&a), top(&b)],
            median: off[off.len() / 2],
            largest: off[off.len() - 1],
        }
    });
    likeness.iter().for_each(|l| common::say(&format!("{l:?}")));
    likeness
}

/// Their rows: text columns, then six counts from column `first` on.
fn read(path: &Path, first: usize) -> Vec<Theirs> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let row = |row: csv::StringRecord| {
        let mut counts = [0; perirobot_march::metrics::COUNTERS];
        (0..6).for_each(|i| counts[i] = row[first + i].parse().unwrap());
        let columns = row.iter().take(first).map(String::from).collect();
        Theirs { columns, counts: Confusion::from_counts(counts) }
    };
    reader.records().map(Result::unwrap).map(row).collect()
}

/// Their scene and regions with sensors, as a study of ours in a folder.
fn study(temp: &Path, folder: &Path, sensors: &str) -> Study {
    let map = |name: &str| format!("{:?}", folder.join(name));
    let scene = format!(
        "[[object]]\nname = \"cell\"\ninterior = \"free\"\noctomap = {}\n\
         [[object]]\nname = \"operator\"\nrole = \"human\"\ntag_only = true\noctomap = {}\nkeypoints = {}\n\
         [[object]]\nname = \"robot\"\nrole = \"robot\"\ntag_only = true\noctomap = {}\n",
        map("model.bt"),
        map("human.bt"),
        map("keypoints.csv"),
        map("robot.bt")
    );
    let study = format!(
        "fusion = \"octomap\"\n[[scene]]\nfile = \"scene.toml\"\n\
         [[region]]\nname = \"robot\"\nsphere = {{ center_m = [0, 0, 1], radius_m = 1.5 }}\n\
         [[region]]\nname = \"human\"\nbox = {{ min_m = [-0.25, -1.45, 0], max_m = [0.9, 0, 1.95] }}\n{sensors}"
    );
    std::fs::write(temp.join("scene.toml"), scene).unwrap();
    std::fs::write(temp.join("study.toml"), study).unwrap();
    // Their maps lie where they are.
    let path = temp.join("study.toml");
    Study::read(&path, &Overrides::default(), Sources::from_main(&path).allow_outside()).unwrap()
}

fn swept(study: &Study) -> (World, Vec<Row>) {
    let worlds = World::prepare_all(study).unwrap();
    let rows = run(study, &worlds, &mut Cpu::new(None).unwrap()).unwrap();
    (worlds.into_iter().next().unwrap(), rows)
}

/// Rank correlation; ties share their mean rank.
fn spearman(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (ranks(a), ranks(b));
    let mean = (a.len() as f64 - 1.0) / 2.0;
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt()
}

fn ranks(values: &[f64]) -> Vec<f64> {
    let below = |v: f64| values.iter().filter(|&&w| w < v).count() as f64;
    let equal = |v: f64| values.iter().filter(|&&w| w == v).count() as f64;
    values.iter().map(|&v| below(v) + (equal(v) - 1.0) / 2.0).collect()
}
