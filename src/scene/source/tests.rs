use std::fs;
use std::os::unix::fs::symlink;

use tempfile::TempDir;

use super::*;

/// A study's folder in a folder, with a file in it and one beside it.
fn folders() -> (TempDir, PathBuf) {
    let all = tempfile::tempdir().unwrap();
    fs::create_dir_all(all.path().join("study/parts")).unwrap();
    fs::write(all.path().join("study/study.toml"), "abc").unwrap();
    fs::write(all.path().join("study/parts/a.stl"), "abc").unwrap();
    fs::write(all.path().join("secret.toml"), "secret").unwrap();
    let study = all.path().join("study");
    (all, study)
}

/// Of "abc", as in FIPS 180.
const ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

#[track_caller]
fn assert_refused<T: std::fmt::Debug>(outcome: Result<T>, expected: &[&str]) {
    let what = outcome.unwrap_err().to_string();
    expected.iter().for_each(|part| assert!(what.contains(part), "no {part:?} in {what}"));
    assert!(!what.contains("secret\n"), "{what}");
}

#[test]
fn what_lies_in_the_folder_is_read_and_listed_once_as_it_was_named() {
    let (_all, study) = folders();
    let main = study.join("study.toml");
    let sources = Sources::from_main(&main);
    assert_eq!(sources.text(&main).unwrap(), "abc");
    let clone = sources.clone();
    for _ in 0..2 {
        assert_eq!(clone.bytes(&study.join("./parts/a.stl")).unwrap(), b"abc");
    }
    let listed = ["parts/a.stl", "study.toml"].map(|path| ReadFile { path: path.into(), sha256: ABC.into() });
    assert_eq!(sources.read_files(), listed);
}

#[test]
fn what_lies_elsewhere_is_refused_unless_it_is_allowed() {
    let (all, study) = folders();
    let sources = Sources::from_main(&study.join("study.toml"));
    let expected = ["secret.toml: lies outside of ", "study.toml is: put it there", "allow outside"];
    let (dots, whole) = (study.join("../secret.toml"), all.path().join("secret.toml"));
    assert_refused(sources.text(&dots), &expected);
    assert_refused(sources.text(&whole), &expected);
    symlink("../secret.toml", study.join("link.toml")).unwrap();
    assert_refused(sources.table(&study.join("link.toml")), &["link.toml: lies outside of "]);
    symlink("..", study.join("up")).unwrap();
    assert_refused(sources.bytes(&study.join("up/secret.toml")), &["up/secret.toml: lies outside of "]);
    assert_eq!(sources.read_files(), []);
    // A link that stays inside leads out of nothing.
    symlink("up/study/parts", study.join("round")).unwrap();
    assert_eq!(sources.bytes(&study.join("round/a.stl")).unwrap(), b"abc");
    let free = sources.allow_outside();
    assert_eq!(free.text(&dots).unwrap(), "secret");
    let paths: Vec<_> = free.read_files().into_iter().map(|file| file.path).collect();
    assert_eq!(paths, [Path::new("../secret.toml"), Path::new("round/a.stl")]);
}

#[test]
fn a_folder_whose_name_begins_alike_is_another() {
    let (all, study) = folders();
    fs::create_dir(all.path().join("study2")).unwrap();
    fs::write(all.path().join("study2/a.stl"), "").unwrap();
    let sources = Sources::from_main(&study.join("study.toml"));
    assert_refused(sources.bytes(&study.join("../study2/a.stl")), &["lies outside of "]);
}

#[test]
fn a_main_file_that_is_a_link_is_the_users_own_choice() {
    let (_all, study) = folders();
    symlink("../secret.toml", study.join("main.toml")).unwrap();
    assert_eq!(
        Sources::from_main(&study.join("main.toml")).text(&study.join("main.toml")).unwrap(),
        "secret"
    );
}

#[test]
fn packages_are_read_and_listed_by_their_names() {
    let (all, study) = folders();
    let package = all.path().join("ros/arm");
    fs::create_dir_all(package.join("meshes")).unwrap();
    fs::write(package.join("meshes/base.stl"), "abc").unwrap();
    let sources = Sources::from_main(&study.join("study.toml")).with_package("arm", &package);
    assert_eq!(sources.bytes(&package.join("meshes/base.stl")).unwrap(), b"abc");
    let listed = ReadFile { path: "package://arm/meshes/base.stl".into(), sha256: ABC.into() };
    assert_eq!(sources.read_files(), [listed]);
    assert_refused(sources.bytes(&package.join("../../secret.toml")), &["lies outside of "]);
}

#[test]
fn only_regular_files_of_a_sane_size_are_opened() {
    let (_all, study) = folders();
    let sources = Sources::from_main(&study.join("study.toml")).allow_outside();
    assert_refused(sources.bytes(&study.join("parts")), &["parts: is not a regular file"]);
    assert_refused(sources.bytes(Path::new("/dev/zero")), &["/dev/zero: is not a regular file"]);
    assert_refused(sources.bytes(&study.join("gone.stl")), &["gone.stl: cannot be read: "]);
    let pipe = study.join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    assert_refused(sources.bytes(&pipe), &["pipe: is not a regular file"]);
    // A file of holes takes no room on the disk.
    let large = File::create(study.join("large")).unwrap();
    large.set_len((64 << 20) + 1).unwrap();
    assert_refused(
        sources.text(&study.join("large")),
        &["large: has 67108865 bytes: at most 64 MiB are read"],
    );
    large.set_len((1 << 30) + 1).unwrap();
    let expected = ["large: has 1073741825 bytes: at most 1024 MiB are read"];
    assert_refused(sources.bytes(&study.join("large")), &expected);
    assert_refused(sources.table(&study.join("large")), &expected);
    fs::write(study.join("latin"), [0xe9]).unwrap();
    assert_refused(sources.text(&study.join("latin")), &["latin: is not UTF-8 text"]);
}

#[test]
fn a_file_that_differs_in_case_is_named() {
    let (_all, study) = folders();
    let sources = Sources::from_main(&study.join("study.toml"));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("gone.stl", study.join("dangling.stl")).unwrap();
        assert_refused(
            sources.bytes(&study.join("dangling.stl")),
            &["dangling.stl: is a link to gone.stl, which is not there"],
        );
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("round.stl", study.join("round.stl")).unwrap();
        let round = sources.bytes(&study.join("round.stl"));
        assert_refused(
            round,
            &["round.stl: is behind links that lead in a circle: put the file there, or mend the link"],
        );
    }
    let namesake = "; there is \"a.stl\": upper and lower case are told apart";
    assert_refused(sources.bytes(&study.join("parts/A.STL")), &["A.STL: cannot be read: ", namesake]);
    fs::write(study.join("Hall.stl"), "").unwrap();
    assert_refused(sources.bytes(&study.join("hall.stl")), &["there is \"Hall.stl\""]);
    let silent = |path: &Path| !sources.bytes(path).unwrap_err().to_string().contains("there is");
    assert!(silent(&study.join("parts/b.stl")));
    assert!(silent(&study.join("../SECRET.toml")), "of other folders nothing is told");
}

#[test]
fn a_file_that_is_not_there_is_told_the_nearest_name() {
    let (_all, study) = folders();
    let sources = Sources::from_main(&study.join("study.toml"));
    for name in ["crate.glb", "crate.stl", "fence.stl"] {
        fs::write(study.join("parts").join(name), "").unwrap();
    }
    let told = |path: &str, expected: &str| {
        assert_refused(sources.bytes(&study.join(path)), &["cannot be read: ", expected])
    };
    told("parts/crates.stl", "; there is \"crate.stl\": is that meant?");
    told("parts/crates.glb", "; there is \"crate.glb\": is that meant?");
    told("parts/fence.step", "; there is \"fence.stl\": is that meant?");
    told("part/crate.stl", "; there is no folder \"part\" in ");
    told("part/crate.stl", "; there is \"parts\": is that meant?");
    let silent = |path: &Path| !sources.bytes(path).unwrap_err().to_string().contains("there is");
    assert!(silent(&study.join("parts/robot.stl")), "nothing is alike");
    assert!(silent(&study.join("../SECRETS.toml")), "of other folders nothing is told");
}

#[test]
fn a_file_that_changes_between_two_reads_is_refused() {
    let (_all, study) = folders();
    let (sources, part) = (Sources::from_main(&study.join("study.toml")), study.join("parts/a.stl"));
    sources.bytes(&part).unwrap();
    fs::write(&part, "abd").unwrap();
    assert_refused(sources.bytes(&part), &["a.stl: changed while it was being read"]);
    // By another of its names, too.
    assert_refused(sources.bytes(&study.join("parts/../parts/a.stl")), &["changed while it was being read"]);
    fs::write(&part, "abc").unwrap();
    assert_eq!(sources.bytes(&part).unwrap(), b"abc");
}

#[test]
fn a_file_in_the_working_folder_has_a_folder_too() {
    let sources = Sources::from_main(Path::new("Cargo.toml"));
    sources.text(Path::new("source/limit.rs")).unwrap();
    assert_refused(sources.text(Path::new("/etc/hostname")), &["lies outside of "]);
    assert_eq!(sources.read_files()[0].path, Path::new("source/limit.rs"));
}

#[test]
fn a_file_in_memory_is_read_instead_of_one_on_the_disk() {
    let (_all, study) = folders();
    let (main, part) = (study.join("study.toml"), study.join("parts/a.stl"));
    let sources = Sources::from_main(&main).with_file(&part, b"other".into());
    assert_eq!(sources.bytes(&part).unwrap(), b"other");
    assert_eq!(sources.text(&main).unwrap(), "abc");
    let listed = sources.read_files();
    let names: Vec<_> = listed.iter().map(|file| file.path.to_str().unwrap()).collect();
    assert_eq!(names, ["parts/a.stl", "study.toml"]);
    assert_ne!(listed[0].sha256, ABC);
}
