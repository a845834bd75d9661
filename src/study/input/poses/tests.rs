use super::*;

/// The poses of one `[[sensor.poses]]` entry, written as TOML.
fn poses_of(stance: Stance, seed: u64, stream: u64, entry: &str) -> Result<Vec<Candidate>> {
    at_most(MAX_POSES, stance, seed, stream, entry)
}

fn at_most(most: usize, stance: Stance, seed: u64, stream: u64, entry: &str) -> Result<Vec<Candidate>> {
    let entry: PosesFile = toml::from_str(entry).unwrap();
    let at = Place::new(Path::new("study.toml"));
    let mut candidates = Vec::new();
    let (files, surfaces) = (&Sources::from_main(at.file), &Surfaces::default());
    let source = PoseSource { stance, seed, stream, most, ..source(files, surfaces) };
    expand(&at, &entry, &source, &mut candidates)?;
    Ok(candidates)
}

/// The source of a study without scenes.
pub(super) fn source<'a>(files: &'a Sources, surfaces: &'a Surfaces) -> PoseSource<'a> {
    PoseSource {
        sensor: "s",
        stance: Stance::Facing,
        seed: 1,
        stream: 0,
        most: MAX_POSES,
        files,
        on: None,
        scenes: &[],
        has_all_scenes: true,
        surfaces,
    }
}

#[track_caller]
fn poses(entry: &str) -> Vec<Candidate> {
    poses_of(Stance::Facing, 1, 0, entry).unwrap()
}

fn positions(candidates: &[Candidate]) -> Vec<[f64; 3]> {
    candidates.iter().map(|c| c.setting.pose().position_m.to_array()).collect()
}

#[test]
fn a_lattice_goes_x_outer_z_fastest_then_orientations() {
    let lattice = poses(
        "name = \"Right wall\"\nx_m = [0, 1]\ny_m = { start = 2, stop = 3, step = 1 }\nz_m = [5, 6]\n\
         facing = [1, 0, 0]\norientations_deg = [{}, { pan = 90 }]",
    );
    let names: Vec<_> = lattice.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names[..3], ["right-wall/0/0", "right-wall/0/1", "right-wall/1/0"]);
    assert_eq!((names.len(), names[15]), (16, "right-wall/7/1"));
    assert!(lattice.iter().all(|c| c.group == "right-wall"));
    let first: Vec<_> = positions(&lattice).into_iter().step_by(2).collect();
    let expected = [[0, 2, 5], [0, 2, 6], [0, 3, 5], [0, 3, 6], [1, 2, 5], [1, 2, 6], [1, 3, 5], [1, 3, 6]];
    assert_eq!(first, expected.map(|p| p.map(f64::from)));
    let ahead = |c: &Candidate| c.setting.pose().link().x_axis.to_array().map(|v| v.round());
    assert_eq!((ahead(&lattice[0]), ahead(&lattice[1])), ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]));
}

#[test]
fn a_lattice_has_its_stop() {
    let at = Place::new(Path::new("study.toml"));
    for (start, stop, step, count) in [
        (-2.2, 2.3, 0.5, 10),
        // 0.3 / 0.1 is 2.9999999999999996: still four points.
        (0.0, 0.3, 0.1, 4),
        (0.0, 0.29, 0.1, 3),
        (1.5, 1.5, 0.5, 1),
    ] {
        let values = axis(&at, "x_m", &Some(AxisValues::Steps { start, stop, step })).unwrap();
        assert_eq!(values.len(), count, "{start} to {stop} by {step}");
        assert!((values[0] - start).abs() < 1e-12 && values[count - 1] <= stop + 1e-9);
    }
}

#[test]
fn lists_keep_their_names_or_are_numbered() {
    let list = poses(
        "name = \"p\"\nlist = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }, \
         { name = \"Door\", position_m = [0, 0, 2], rpy_deg = [0, 0, 90], frame = \"link\" }]",
    );
    assert_eq!(list.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["p/0", "p/Door"]);
}

/// The draws of a seed are pinned: a library that changes them would silently change published studies.
#[test]
fn a_seed_means_these_poses() {
    let entry = "name = \"r\"\nfacing = [1, 0, 0]\n\
                 random = { count = 2, min_m = [0, 0, 0], max_m = [1, 2, 4], pan_deg = [-90, 90], tilt_deg = [0, 30] }";
    let drawn = poses_of(Stance::Facing, 7, 3, entry).unwrap();
    let in_draws: Vec<[f64; 3]> = positions(&drawn)
        .into_iter()
        .map(|[x, y, z]| [x, y / 2.0, z / 4.0].map(|share| share * 4_294_967_296.0))
        .collect();
    assert_eq!(in_draws, PINNED);
    assert_eq!(poses_of(Stance::Facing, 7, 3, entry).unwrap(), drawn, "the same again");
    assert_ne!(poses_of(Stance::Facing, 8, 3, entry).unwrap(), drawn, "another seed");
    assert_ne!(poses_of(Stance::Facing, 7, 4, entry).unwrap(), drawn, "another group");
    // A longer draw begins as the shorter.
    let more = poses_of(Stance::Facing, 7, 3, &entry.replace("count = 2", "count = 9")).unwrap();
    assert_eq!(more[..2], drawn[..]);
    for c in &more {
        let p = c.setting.pose().position_m;
        assert!(p.cmpge(DVec3::ZERO).all() && p.cmplt(DVec3::new(1.0, 2.0, 4.0)).all(), "{p}");
    }
}

const PINNED: [[f64; 3]; 2] =
    [[2_897_986_910.0, 2_847_227_336.0, 2_895_278_666.0], [3_161_318_518.0, 381_480_654.0, 185_663_351.0]];

#[test]
fn an_upright_lidar_takes_pan_but_no_tilt() {
    let entry =
        "name = \"p\"\nlist = [{ position_m = [0, 0, 1], facing = [1, 0, 0], pan_deg = 5, tilt_deg = 5 }]";
    let refused = poses_of(Stance::Upright, 1, 0, entry).unwrap_err().to_string();
    assert!(refused.contains("list[0].tilt_deg = 5: an upright lidar"), "{refused}");
    poses_of(Stance::Facing, 1, 0, entry).unwrap();
    poses_of(Stance::Upright, 1, 0, &entry.replace("tilt_deg = 5", "tilt_deg = 0")).unwrap();
}

#[test]
fn tables_give_one_sensors_poses_with_their_lines() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("poses.csv");
    let read = |text: &str, frame| {
        std::fs::write(&path, text).unwrap();
        let (files, surfaces) = (&Sources::from_main(&path), &Surfaces::default());
        table(&path, frame, &source(files, surfaces)).map_err(|e| e.to_string())
    };
    let text = "sensor,pose,x_m,y_m,z_m,qw,qx,qy,qz,note\ns,a,1,2,3,1,0,0,0,\nother,b,1,2,3,1,0,0,0,\n,,4,5,6,0,0,0,1,x\n";
    let found = read(text, RotationFrame::Link).unwrap();
    assert_eq!(found.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["a", "1"]);
    assert_eq!(found[1].1.position_m, DVec3::new(4.0, 5.0, 6.0));
    assert_eq!(found[1].1.rotation.to_array(), [0.0, 0.0, 1.0, 0.0], "kept as it is");
    // An identity in the optical frame looks up, with its x to the right.
    let optical = read(text, RotationFrame::Optical).unwrap();
    assert!((optical[0].1.link().x_axis - DVec3::Z).length() < 1e-12);
    let commented = "x_m,y_m,z_m,qw,qx,qy,qz\n# one\n\n# two\n1,2,3,1,0,0,0\n# three\n1,2,oops,1,0,0,0\n";
    let error = read(commented, RotationFrame::Link).unwrap_err();
    assert!(error.contains("poses.csv: line 7") && error.contains("z_m"), "{error}");
}

#[test]
fn what_stands_level_may_leave_out_where_it_faces() {
    let lattice = poses_of(Stance::Level, 1, 0, "name = \"p\"\nx_m = 1\ny_m = 2\nz_m = 0").unwrap();
    assert_eq!(lattice[0].setting.pose().link().x_axis, DVec3::X);
    let listed = "name = \"p\"\nlist = [{ position_m = [1, 2, 0], pan_deg = 90 }]";
    let pose = poses_of(Stance::Level, 1, 0, listed).unwrap()[0].setting.pose();
    assert!((pose.link().x_axis - DVec3::Y).length() < 1e-12);
    let tilted = poses_of(Stance::Level, 1, 0, &listed.replace("pan_deg = 90", "tilt_deg = 1")).unwrap_err();
    assert!(tilted.to_string().contains("list[0].tilt_deg = 1: it stands level"), "{tilted}");
    assert!(poses_of(Stance::Facing, 1, 0, listed).is_err(), "a camera must be told");
}

#[test]
fn a_study_has_only_so_many_poses() {
    let pose = "{ position_m = [0, 0, 0], facing = [1, 0, 0] }";
    for poses in [
        format!("list = [{pose}, {pose}, {pose}]"),
        "x_m = 0\ny_m = 0\nz_m = [1, 2, 3]\nfacing = [1, 0, 0]".into(),
        "facing = [1, 0, 0]\nrandom = { count = 3, min_m = [0, 0, 0], max_m = [1, 1, 1] }".into(),
    ] {
        let entry = format!("name = \"p\"\n{poses}");
        assert_eq!(at_most(3, Stance::Facing, 1, 0, &entry).unwrap().len(), 3);
        let what = at_most(2, Stance::Facing, 1, 0, &entry).unwrap_err().to_string();
        assert!(what.contains("with these, the study has more than 4000000 poses"), "{what}");
    }
}
