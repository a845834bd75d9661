//! The inputs that fuzzing begins with, and those that it found to matter, read once more without libFuzzer:
//! each has to return. `tests/fuzz/README.md` tells how more are thought up.

use std::fs;
use std::path::Path;

#[allow(unreachable_pub)]
#[path = "../fuzz/entries.rs"]
mod entries;
#[allow(unreachable_pub)]
#[path = "../fuzz/folders.rs"]
mod folders;

/// Feeds a target the files of its corpus, and each cut short and with its middle byte changed.
fn feed(target: &str, entry: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus").join(target);
    let mut files = 0;
    for file in fs::read_dir(&folder).unwrap() {
        let path = file.unwrap().path();
        let mut bytes = fs::read(&path).unwrap();
        assert!(bytes.len() <= 8 << 10, "{} is too large to begin with", path.display());
        println!("{}", path.display());
        entry(&bytes);
        let middle = bytes.len() / 2;
        entry(&bytes[..middle]);
        if let Some(byte) = bytes.get_mut(middle) {
            *byte ^= 0x55;
        }
        entry(&bytes);
        files += 1;
    }
    assert!(files > 0, "{} is empty", folder.display());
}

/// One test a target, so that a failure names it.
macro_rules! targets {
    ($($target:ident),*) => {
        $(
            #[test]
            fn $target() {
                feed(stringify!($target), entries::$target);
            }
        )*

        #[test]
        fn every_folder_has_its_target() {
            let targets = [$(stringify!($target)),*];
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus");
            for entry in fs::read_dir(folder).unwrap() {
                let name = entry.unwrap().file_name().into_string().unwrap();
                assert!(targets.contains(&name.as_str()), "{name}");
            }
        }
    };
}

targets!(
    study,
    gltf,
    stl,
    obj,
    collada,
    urdf,
    sdf,
    octomap,
    npz,
    mcap,
    pcd,
    ply,
    poses,
    rays,
    camera_info,
    joints,
    bvh,
    joint_table,
    journal,
    manifest
);
