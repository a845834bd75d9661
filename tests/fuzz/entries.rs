//! What is done with a stranger's bytes, one function a kind of file: they are written into a folder, and
//! read as the program would read them. Each has to return, whatever the bytes are. libFuzzer makes up the
//! bytes; `tests/input/corpus.rs` brings those that are kept.

use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec3;
use perirobot_march::Result;
use perirobot_scene::objects::build::build;
use perirobot_scene::objects::gltf::{Gltf, WhichClip};
use perirobot_scene::objects::keypoints::{JointLayout, KeypointFile};
use perirobot_scene::objects::{Scene, collada, obj, octomap, stl};
use perirobot_scene::recording::{Recording, RecordingSelection};
use perirobot_scene::source::Sources;
use perirobot_study::input::{Overrides, Study, load_scene};
use perirobot_study::world::World;
use tempfile::TempDir;

pub use super::folders::{journal, manifest};

/// What two files in one input are parted by: a study and, below, its scene `cell.toml`; a manifest and its
/// poses.
const CUT: &[u8] = b"\n----\n";
/// Files that any input may name.
const BESIDE: [(&str, &[u8]); 6] = [
    ("body.stl", include_bytes!("corpus/stl/binary.stl")),
    ("part.bin", include_bytes!("corpus/urdf/shapes.urdf")),
    ("part.obj", include_bytes!("corpus/obj/cube.obj")),
    ("ring.csv", include_bytes!("corpus/rays/three.csv")),
    ("robot.urdf", include_bytes!("corpus/urdf/shapes.urdf")),
    ("somebody.csv", include_bytes!("corpus/joints/operator.csv")),
];
/// A study is made ready in a small grid of coarse voxels, and only if it has no more than so many poses and
/// [`MOST_SNAPSHOTS`]: how long a large one takes is its author's choice.
const MOST_POSES: usize = 200;
const MOST_SNAPSHOTS: usize = 4;

thread_local! {
    /// Written again and again; in memory, if TMPDIR says so.
    static FOLDER: TempDir = {
        let folder = tempfile::tempdir().expect("a folder for temporary files");
        for (name, bytes) in BESIDE {
            fs::write(folder.path().join(name), bytes).expect("a folder that can be written to");
        }
        folder
    };
}

/// A study with its scene, up to the moment when rays would be cast.
pub fn study(bytes: &[u8]) {
    let [study, cell] = parted(bytes);
    file("cell.toml", cell);
    let path = file("study.toml", study);
    let overrides = Overrides { voxel_size_m: Some(0.1), noiseless: false };
    let Ok(mut study) = Study::load(&path, &overrides) else { return };
    let poses: usize = study.sensors.iter().map(|sensor| sensor.candidates.len()).sum();
    let snapshots: usize = study.scenes.iter().map(|scene| scene.snapshots).sum();
    if poses <= MOST_POSES && snapshots <= MOST_SNAPSHOTS {
        study.bounds_m = Some([DVec3::splat(-2.0), DVec3::splat(2.0)]);
        let _ = World::prepare_all(&study);
    }
}

/// A glTF file, `.glb` or `.gltf`, as it stands and in its animation.
pub fn gltf(bytes: &[u8]) {
    let path = file("part.glb", bytes);
    let Ok(gltf) = Gltf::load(&path, &Sources::from_main(&path)) else { return };
    let _ = gltf.parts(None);
    if let Ok(clip) = gltf.clip(&WhichClip::Only) {
        let [first, last] = clip.span_s();
        let _ = gltf.parts(Some((&clip, (first + last) / 2.0)));
    }
}

/// An STL file, binary or text.
pub fn stl(bytes: &[u8]) {
    let path = file("part.stl", bytes);
    let _ = stl::load(&path, &Sources::from_main(&path));
}

/// A Wavefront OBJ file.
pub fn obj(bytes: &[u8]) {
    let path = file("part.obj", bytes);
    let _ = obj::load(&path, &Sources::from_main(&path));
}

/// A COLLADA file.
pub fn collada(bytes: &[u8]) {
    let path = file("part.dae", bytes);
    let _ = collada::load(&path, &Sources::from_main(&path));
}

/// A robot: both of its geometries, posed.
pub fn urdf(bytes: &[u8]) {
    file("arm.urdf", bytes);
    for geometry in ["collision", "visual"] {
        let _ =
            scene(&format!("[[object]]\nname = \"arm\"\nurdf = \"arm.urdf\"\ngeometry = \"{geometry}\"\n"));
    }
}

/// A world of Gazebo, both of its geometries.
pub fn sdf(bytes: &[u8]) {
    file("world.sdf", bytes);
    for geometry in ["collision", "visual"] {
        let _ = scene(&format!(
            "[[object]]\nname = \"world\"\nsdf = \"world.sdf\"\nmodels = [\".\"]\ngeometry = \"{geometry}\"\n"
        ));
    }
}

/// An OctoMap.
pub fn octomap(bytes: &[u8]) {
    let path = file("map.bt", bytes);
    let _ = octomap::read(&path, &Sources::from_main(&path));
}

/// Labels in an archive of numpy's.
pub fn npz(bytes: &[u8]) {
    let path = file("labels.npz", bytes);
    let _ = Recording::read(&path, RecordingSelection::default(), &Sources::from_main(&path));
}

/// A bag of ROS, whole and one message of it.
pub fn mcap(bytes: &[u8]) {
    let path = file("scan.mcap", bytes);
    for message in [None, Some(1)] {
        let asked = RecordingSelection { message, ..RecordingSelection::default() };
        let _ = Recording::read(&path, asked, &Sources::from_main(&path));
    }
}

/// A cloud of the Point Cloud Library.
pub fn pcd(bytes: &[u8]) {
    let path = file("scan.pcd", bytes);
    let _ = Recording::read(&path, RecordingSelection::default(), &Sources::from_main(&path));
}

/// A cloud as the vertices of a PLY file.
pub fn ply(bytes: &[u8]) {
    let path = file("scan.ply", bytes);
    let _ = Recording::read(&path, RecordingSelection::default(), &Sources::from_main(&path));
}

/// A table of poses.
pub fn poses(bytes: &[u8]) {
    file("poses.csv", bytes);
    sensor("kind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [4, 3]", "csv = \"poses.csv\"");
}

/// A table of directions.
pub fn rays(bytes: &[u8]) {
    file("rays.csv", bytes);
    let pose = "list = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }]";
    sensor("kind = \"rays\"\ndirections = \"rays.csv\"", pose);
}

/// What ROS knows of a camera.
pub fn camera_info(bytes: &[u8]) {
    file("left.yaml", bytes);
    let pose = "list = [{ position_m = [0, 0, 1], facing = [1, 0, 0] }]";
    sensor("kind = \"rgbd\"\ncamera_info = \"left.yaml\"", pose);
}

/// A table of a person's joints, and the body around them.
pub fn joints(bytes: &[u8]) {
    let path = file("person.csv", bytes);
    for layout in [JointLayout::Coco17, JointLayout::Halpe26, JointLayout::Smpl24] {
        let _ = KeypointFile { path: path.clone(), layout }.read(&Sources::from_main(&path));
    }
    let _ = scene("[[object]]\nname = \"person\"\nmannequin = \"person.csv\"\n");
}

/// Motion capture, in its first frame and in a later one.
pub fn bvh(bytes: &[u8]) {
    file("walk.bvh", bytes);
    let _ = scene(
        "[[object]]\nname = \"person\"\nmannequin = \"walk.bvh\"\nunit = \"cm\"\n\
         snapshots = { animation = { times_s = [0, 0.5] } }\n",
    );
}

/// What a robot did, as a table of its joints.
pub fn joint_table(bytes: &[u8]) {
    file("did.csv", bytes);
    let _ = scene(
        "[[object]]\nname = \"arm\"\nurdf = \"robot.urdf\"\n\
         snapshots = { animation = { joints = \"did.csv\", angles = \"rad\", times_s = [0, 0.5] } }\n",
    );
}

/// Two files that come in one input.
pub(crate) fn parted(bytes: &[u8]) -> [&[u8]; 2] {
    let cut = bytes.windows(CUT.len()).position(|window| window == CUT).unwrap_or(bytes.len());
    [&bytes[..cut], bytes.get(cut + CUT.len()..).unwrap_or_default()]
}

/// A study of one sensor with these keys and these poses.
fn sensor(keys: &str, poses: &str) {
    file("cell.toml", b"[[object]]\nname = \"box\"\nbox = { size_m = [1, 1, 1] }\n");
    let study = format!(
        "scene = [{{ file = \"cell.toml\" }}]\nregion = [{{ name = \"r\", box = {{ min_m = [0, 0, 0], max_m = [1, 1, 1] }} }}]\n\
         [[sensor]]\nname = \"s\"\nrange_m = [0.1, 3]\n{keys}\n[[sensor.poses]]\nname = \"p\"\n{poses}\n"
    );
    let _ = Study::load(&file("study.toml", study.as_bytes()), &Overrides::default());
}

fn scene(text: &str) -> Result<Vec<Scene>> {
    let path = file("cell.toml", text.as_bytes());
    let sources = Sources::from_main(&path);
    build(&load_scene(&path, &sources)?, &sources, 0.1)
}

/// Writes a file into the folder that all inputs of a thread share.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    FOLDER.with(|folder| {
        let path = Path::join(folder.path(), name);
        fs::write(&path, bytes).expect("a folder that can be written to");
        path
    })
}
