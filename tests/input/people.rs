//! The people that ship: each is a body on the floor as large as its file says, and crossed with what a robot does each
//! is met in every posture of it.

use std::fs;
use std::path::Path;

use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

const PEOPLE: [(&str, [f64; 2]); 10] = [
    ("standing", [1.65, 1.85]),
    ("reaching", [1.5, 1.8]),
    ("bent", [0.8, 1.2]),
    ("crouching", [0.8, 1.25]),
    ("kneeling", [1.1, 1.4]),
    ("lying", [0.2, 0.5]),
    ("small", [1.4, 1.6]),
    ("tall", [1.85, 2.05]),
    ("sitting", [1.2, 1.45]),
    ("carrying", [1.65, 1.85]),
];

const VOXEL_M: f64 = 0.025;

#[test]
fn people_stand_on_the_floor_and_meet_every_moment_of_the_robot() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/people");
    let mut names: Vec<String> =
        fs::read_dir(&shipped).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    let mut expected = PEOPLE.map(|(name, _)| format!("{name}.csv"));
    expected.sort();
    assert_eq!(names, expected);
    let folder = tempfile::tempdir().unwrap();
    for name in &names {
        fs::copy(shipped.join(name), folder.path().join(name)).unwrap();
    }
    let files: Vec<String> = PEOPLE.iter().map(|(name, _)| format!("\"{name}.csv\"")).collect();
    let scene = format!(
        "[[object]]\nname = \"floor\"\nplane = {{ size_m = [4, 4] }}\n\
         [[object]]\nname = \"arm\"\nrole = \"robot\"\nbox = {{ size_m = [0.2, 0.2, 0.2] }}\n\
         [object.snapshots]\nposition_m = [[1.5, 0, 0.5], [1.5, 0, 1.0]]\n\
         [[object]]\nname = \"person\"\nmannequin = \"standing.csv\"\n\
         [object.snapshots]\nmannequin = [{}]\ncross = true\n",
        files.join(", ")
    );
    fs::write(folder.path().join("cell.toml"), scene).unwrap();
    let study = format!(
        "[grid]\nvoxel_size_m = {VOXEL_M}\nbounds_m = {{ min = [-2, -2, -0.2], max = [2, 2, 2.2] }}\n\
         [[scene]]\nfile = \"cell.toml\"\n[[region]]\nname = \"all\"\nbox = {{ min_m = [-2, -2, 0], max_m = [2, 2, 2] }}\n\
         [[sensor]]\nname = \"camera\"\nkind = \"rgbd\"\nfov_deg = [60, 40]\nresolution_px = [4, 3]\nrange_m = [0.3, 4]\n\
         [[sensor.poses]]\nname = \"corner\"\nx_m = -1.8\ny_m = 0\nz_m = 2\nfacing = [1, 0, 0]\n"
    );
    let path = folder.path().join("study.toml");
    fs::write(&path, study).unwrap();
    let study = Study::load(&path, &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    assert_eq!(worlds.len(), 20);
    for (number, world) in worlds.iter().enumerate() {
        let (name, [least, most]) = PEOPLE[number / 2];
        let truth = world.truth();
        let [person, arm] = ["person", "arm"].map(|name| {
            let object = truth.objects.iter().find(|object| object.name == name).unwrap();
            object.bounds_m
        });
        // The arm is in one of its two places, each with each person.
        assert!((arm[0].z - [0.4, 0.9][number % 2]).abs() < 1e-6, "{name}: {arm:?}");
        assert!((-0.03..0.06).contains(&person[0].z), "{name} begins at {} m", person[0].z);
        assert!((least..most).contains(&person[1].z), "{name} ends at {} m", person[1].z);
        let size = person[1] - person[0];
        assert!(size.x < 2.0 && size.y < 0.8, "{name}: {size}");
    }
}
