//! One scene of the paper's authors, with the counts that their own code printed (opt-in: the data carries no licence
//! and is not part of this project). Set PERIROBOT_REFERENCE to a folder that holds `human4/`.
//!
//! Equal counts are not possible: their code casts only toward occupied voxels, carves a second time to the hit
//! voxel's centre, and measures range to centres. What must agree is the size of the regions, the ranking of the
//! poses, the best pose, and the size of the scores.

mod common;

use std::collections::BTreeMap;
use std::path::Path;

use perirobot::backend::cpu::Cpu;
use perirobot::metrics::Confusion;
use perirobot::study::Study;
use perirobot::sweep::{World, run};

/// Their counts of one pose in one region.
struct Theirs {
    pose: String,
    columns: [String; 7],
    counts: Confusion,
}

#[test]
fn the_authors_poses_rank_alike() {
    let Some(folder) = std::env::var_os("PERIROBOT_REFERENCE") else {
        common::say("SKIPPED: PERIROBOT_REFERENCE is not set, nothing was compared with the authors' code");
        return;
    };
    let folder = Path::new(&folder).join("human4");
    let theirs = read(&folder.join("camera_counts.csv"));
    assert_eq!(theirs["robot"].len(), 173, "poses of the reference");

    let study = study(&folder, &theirs["robot"]);
    let world = World::prepare(&study, &study.scenes[0]).unwrap().remove(0);
    assert_eq!(world.truth.occupied.count(), 46_505);
    let mut cpu = Cpu::new(None).unwrap();
    let rows = run(&study, std::slice::from_ref(&world), &mut cpu, |_| {}).unwrap();

    let best = [("robot", "725"), ("human", "660")];
    for (r, (region, best_pose)) in best.into_iter().enumerate() {
        let theirs = &theirs[region];
        let ours: Vec<Confusion> = rows.iter().filter(|row| row.region == r).map(|row| row.counts).collect();
        assert_eq!(ours.len(), theirs.len());
        assert_eq!(ours[0].total(), theirs[0].counts.total(), "voxels of region {region}");
        assert!(ours.iter().all(|c| c.fp == 0 && c.fn_ == 0), "without noise nothing is mistaken");
        for (score, of) in [("F1", Confusion::f1 as fn(&Confusion) -> _), ("kappa", Confusion::kappa)] {
            let a: Vec<f64> = ours.iter().map(|c| of(c).unwrap()).collect();
            let b: Vec<f64> = theirs.iter().map(|t| of(&t.counts).unwrap()).collect();
            let rho = spearman(&a, &b);
            let mut off: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).collect();
            off.sort_by(f64::total_cmp);
            let (median, largest) = (off[off.len() / 2], off[off.len() - 1]);
            let top =
                |v: &[f64]| theirs[(0..v.len()).max_by(|&i, &j| v[i].total_cmp(&v[j])).unwrap()].pose.clone();
            eprintln!(
                "{region} {score}: rho {rho:.4}, best pose {} (theirs {}), |difference| median {median:.4}, largest {largest:.4}",
                top(&a),
                top(&b)
            );
            assert!(rho >= 0.998, "{region} {score}: Spearman's rho is {rho}");
            assert_eq!((top(&a), top(&b)), (best_pose.into(), best_pose.into()), "{region} {score}");
            assert!(median <= 0.005 && largest <= 0.06, "{region} {score}: off by {median}, {largest}");
        }
    }
}

/// Their rows of the raw points, by region, in their order.
fn read(path: &Path) -> BTreeMap<String, Vec<Theirs>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let mut regions: BTreeMap<String, Vec<Theirs>> = BTreeMap::new();
    for row in reader.records().map(Result::unwrap).filter(|row| &row[8] == "points") {
        let mut counts = [0; perirobot::metrics::COUNTERS];
        (0..6).for_each(|i| counts[i] = row[10 + i].parse().unwrap());
        let columns = std::array::from_fn(|i| row[1 + i].to_string());
        let counts = Confusion::from_counts(counts);
        regions.entry(row[9].into()).or_default().push(Theirs { pose: row[0].into(), columns, counts });
    }
    regions
}

/// Their scene, regions, camera and poses as a study of ours.
fn study(folder: &Path, poses: &[Theirs]) -> Study {
    let temp = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| std::fs::write(temp.path().join(name), text).unwrap();
    let rows: String = poses.iter().map(|p| format!("{},{}\n", p.pose, p.columns.join(","))).collect();
    write("poses.csv", format!("pose,x_m,y_m,z_m,qw,qx,qy,qz\n{rows}"));
    let folder = folder.canonicalize().unwrap();
    let map = |name: &str| format!("{:?}", folder.join(name));
    write(
        "scene.toml",
        format!(
            "[[object]]\nname = \"cell\"\ninterior = \"free\"\noctomap = {}\n\
             [[object]]\nname = \"operator\"\nrole = \"human\"\ntag_only = true\noctomap = {}\n\
             [[object]]\nname = \"robot\"\nrole = \"robot\"\ntag_only = true\noctomap = {}\n",
            map("model.bt"),
            map("human.bt"),
            map("robot.bt")
        ),
    );
    write(
        "study.toml",
        "[[scene]]\nfile = \"scene.toml\"\n\
         [[region]]\nname = \"robot\"\nsphere = { center_m = [0, 0, 1], radius_m = 1.5 }\n\
         [[region]]\nname = \"human\"\nbox = { min_m = [-0.25, -1.45, 0], max_m = [0.9, 0, 1.95] }\n\
         [[sensor]]\nname = \"camera\"\nkind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [1280, 720]\n\
         range_m = [0.6, 6.0]\n[[sensor.poses]]\nname = \"theirs\"\ncsv = \"poses.csv\"\nframe = \"optical\"\n"
            .into(),
    );
    Study::load(&temp.path().join("study.toml"), None).unwrap()
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
