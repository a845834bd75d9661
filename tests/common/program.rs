//! Runs the program on a small study in a folder of its own. Each test file uses its part of this.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// A study with every kind of poses; its scene has one body of every simple kind. 0.1 s in a debug build.
pub(crate) const STUDY: &str = r#"seed = 7
[grid]
voxel_size_m = 0.1
[[scene]]
file = "cell.toml"
[[region]]
name = "robot"
sphere = { center_m = [0.2, 0.3, 0.4], radius_m = 0.6 }
[[region]]
name = "box"
box = { min_m = [-0.5, -0.5, 0.1], max_m = [0.5, 0.5, 1.1] }
[[region]]
name = "human"
human_box = { object = "operator", margin_m = 0.2 }
[[sensor]]
name = "camera"
kind = "rgbd"
fov_deg = [87, 58]
resolution_px = [16, 9]
range_m = [0.2, 3.0]
near_ignore_m = 0.05
[[sensor.poses]]
name = "wall"
x_m = { start = -1.0, stop = 1.0, step = 1.0 }
y_m = -0.75
z_m = [1.2]
facing = [0, 1, 0]
orientations_deg = [{ pan = 0, tilt = 0 }, { pan = -20, tilt = -30 }]
[[sensor.poses]]
name = "random"
facing = [0, 0, -1]
random = { count = 2, min_m = [-0.9, -0.6, 1.3], max_m = [0.9, 0.6, 1.5], pan_deg = [-180, 180], tilt_deg = [-30, 30] }
[[sensor]]
name = "lidar"
kind = "lidar"
fov_deg = [360, 90]
resolution_deg = [8, 12]
range_m = [0.1, 5.0]
[[sensor.poses]]
name = "posts"
list = [
    { name = "upright", position_m = [-0.9, 0.6, 0.9], facing = [1, -0.5, 0], pan_deg = 10 },
    { name = "leaning", position_m = [0.95, -0.6, 1.1], rpy_deg = [0, 30, 135] },
    { name = "corner", position_m = [0.1, 0.1, 1.3], quaternion = { w = 1, x = 0, y = 0, z = 0 } },
]
"#;

/// The scene of [`STUDY`].
pub(crate) const SCENE: &str = r#"interior = "free"
[[object]]
name = "walls"
room = { size_m = [2.4, 1.8, 1.6] }
position_m = [0, 0, 0.8]
[[object]]
name = "crate"
box = { size_m = [0.4, 0.4, 0.4] }
position_m = [0.7, 0.4, 0.25]
[[object]]
name = "panel"
plane = { size_m = [0.4, 0.6] }
position_m = [-0.6, 0.1, 0.5]
rpy_deg = [0, 90, 0]
[[object]]
name = "ball"
sphere = { radius_m = 0.12 }
position_m = [-0.7, -0.5, 0.3]
[[object]]
name = "arm"
role = "robot"
capsule = { radius_m = 0.1, length_m = 0.6 }
position_m = [0.2, 0.3, 0.45]
quaternion = { w = 1, x = 0, y = 0, z = 0 }
[[object]]
name = "operator"
role = "human"
cylinder = { radius_m = 0.15, height_m = 1.2 }
position_m = [0.1, -0.45, 0.65]
"#;

/// What a run of the program left.
pub(crate) struct Outcome {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// Runs the program from the project's folder.
pub(crate) fn perirobot<S: AsRef<OsStr>>(arguments: &[S]) -> Outcome {
    let mut command = Command::new(env!("CARGO_BIN_EXE_perirobot"));
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Outcome { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// A folder with the small study, which goes when the test ends.
pub(crate) struct Folder(TempDir);

impl Folder {
    pub(crate) fn new() -> Folder {
        let folder = Folder(tempfile::tempdir().unwrap());
        folder.write("study.toml", STUDY);
        folder.write("cell.toml", SCENE);
        folder
    }

    /// The small study in two scenes, with noise and two repeats.
    pub(crate) fn noisy() -> Folder {
        let folder = Folder::new();
        folder.write("second.toml", fs::read(folder.path("cell.toml")).unwrap());
        folder.edit("second.toml", "position_m = [0.1, -0.45, 0.65]", "position_m = [0.3, -0.4, 0.65]");
        folder.edit("study.toml", "seed = 7", "seed = 7\nrepeats = 2");
        folder.edit("study.toml", "[[region]]", "[[scene]]\nfile = \"second.toml\"\n[[region]]");
        folder.edit("study.toml", "range_m = [0.1, 5.0]", "range_m = [0.1, 5.0]\nnoise = { std_m = 0.1 }");
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).unwrap();
    }

    /// Replaces the first `from` in a file, or appends where `from` is empty.
    #[track_caller]
    pub(crate) fn edit(&self, name: &str, from: &str, to: &str) {
        let text = fs::read_to_string(self.path(name)).unwrap();
        assert!(text.contains(from), "{name} has no {from:?}");
        let edited = if from.is_empty() { text + to } else { text.replacen(from, to, 1) };
        self.write(name, edited);
    }

    /// Sweeps the study into the folder `out`, on one plain thread.
    pub(crate) fn sweep(&self, more: &[&str]) -> Outcome {
        let (study, out) = (self.path("study.toml"), self.path("out"));
        let fixed = ["sweep", text(&study), "--out", text(&out), "--backend", "cpu"];
        perirobot(&[&fixed, more].concat())
    }

    /// Names of all files and folders in the folder, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        names(self.0.path())
    }
}

/// Of `scenes/approach.toml`, without what it requires: tests change the regions that this is about.
pub(crate) fn shelf() -> Folder {
    let folder = Folder::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    folder.write("study.toml", fs::read(root.join("approach.toml")).unwrap());
    folder.edit("study.toml", "approach/cell.toml", "cell.toml");
    let text = fs::read_to_string(folder.path("study.toml")).unwrap();
    let required = text.split_once("[[require]]").unwrap().1.split_once("# Invented").unwrap().0;
    folder.edit("study.toml", &format!("[[require]]{required}"), "");
    folder.write("cell.toml", fs::read(root.join("approach/cell.toml")).unwrap());
    folder
}

/// Speeds for the small study: at 0.25 m/s 0.32125 m are needed, at 0.5 m/s 0.445, at 1 m/s 0.73.
pub(crate) const STOPPING: &str = "\n[stopping]\nformula = \"speed_and_separation\"\nrobot_speeds_m_s = [0.25, 0.5, 1.0]\n\
    sensor_reaction_s = 0.05\ncontrol_reaction_s = 0.05\nrobot_deceleration_m_s2 = 5\nhuman_speed_m_s = 1.6\n\
    intrusion_m = 0.02\nperson_uncertainty_m = 0.03\nrobot_uncertainty_m = 0\n";

/// The small study with costs, and what is looked for.
pub(crate) fn priced(choose: &str) -> Folder {
    let folder = Folder::new();
    folder.edit("study.toml", "name = \"camera\"", "name = \"camera\"\ncost = 250.0");
    folder.edit("study.toml", "name = \"lidar\"", "name = \"lidar\"\ncost = 499.5\nat_most = 1");
    folder.edit("study.toml", "", choose);
    folder
}

/// Chooses sets of the study into a folder below it; on the CPU unless something else is said.
pub(crate) fn choose(folder: &Folder, out: &str, more: &[&str]) -> Outcome {
    let (study, out) = (folder.path("study.toml"), folder.path(out));
    let backend: &[&str] = if more.contains(&"--backend") { &[] } else { &["--backend", "cpu"] };
    let fixed = ["choose", text(&study), "--out", text(&out), "--progress", "none"];
    perirobot(&[&fixed, backend, more].concat())
}

/// Rows of a CSV file, each by the names of its columns.
pub(crate) fn rows(path: &Path) -> Vec<HashMap<String, String>> {
    let mut csv = csv::Reader::from_path(path).unwrap();
    csv.deserialize().map(|row| row.unwrap()).collect()
}

/// Names in a folder, sorted.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// A path that is text.
pub(crate) fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// `(file, from, to)`: replaces text of a file; an empty `from` appends.
pub(crate) type Edit<'a> = (&'a str, &'a str, &'a str);

/// The study in the folder, with these edits, must be refused as bad input in words that hold all of
/// `expected`, before any ray is cast, and leave nothing behind.
#[track_caller]
pub(crate) fn refused(folder: &Folder, edits: &[Edit], expected: &[&str]) {
    for (file, from, to) in edits {
        folder.edit(file, from, to);
    }
    let before = folder.names();
    let outcome = folder.sweep(&[]);
    let what = format!("{edits:?}: {:?}\n{}", outcome.code, outcome.stderr);
    assert_eq!(outcome.code, Some(2), "{what}");
    for fragment in expected {
        assert!(outcome.stderr.contains(fragment), "no {fragment:?} in {what}");
    }
    assert!(outcome.stderr.lines().any(|line| line.starts_with("error: ")), "{what}");
    for unwanted in ["panicked", "RUST_BACKTRACE", "running on"] {
        assert!(!outcome.stderr.contains(unwanted), "{what}");
    }
    assert_eq!(outcome.stdout, "", "{what}");
    assert_eq!(folder.names(), before, "{what}");
}
