//! Rays with ends worked out by hand, in an open row of ten voxels of a metre with a wall at the end.

use std::fs;

use super::*;
use perirobot_march::backend::oracle::Oracle;
use perirobot_study::input::Overrides;

const SCENE: &str =
    "[[object]]\nname = \"wall\"\nbox = { size_m = [1, 9.9, 0.5] }\nposition_m = [9.5, 4.95, 0.75]\n";

/// Four rays from (0.5, 4.5, 0.75): ahead to the wall 8.5 m away, back and to both sides out of the grid.
fn ends_of(range_m: &str, outside: &str) -> EndCounts {
    let folder = tempfile::tempdir().unwrap();
    let study = format!(
        "[grid]\nvoxel_size_m = 1\nbounds_m = {{ min = [0, 0, 0], max = [9.9, 9.9, 2.9] }}\noutside = {outside:?}\n\
         [[scene]]\nfile = \"cell.toml\"\n[[region]]\nname = \"all\"\nbox = {{ min_m = [0, 0, 0], max_m = [10, 10, 1] }}\n\
         [[sensor]]\nname = \"ring\"\nkind = \"rays\"\ndirections = \"ring.csv\"\nrange_m = {range_m}\n\
         [[sensor.poses]]\nname = \"p\"\nlist = [{{ position_m = [0.5, 4.5, 0.75], facing = [1, 0, 0] }}]\n\
         [[sensor]]\nname = \"robot\"\nkind = \"pad\"\nsize_m = [1, 1]\nposes = [{{ name = \"q\", x_m = 2, y_m = 2, z_m = 0 }}]\n"
    );
    for (name, text) in [
        ("study.toml", study.as_str()),
        ("cell.toml", SCENE),
        ("ring.csv", "x,y,z\n1,0,0\n-1,0,0\n0,1,0\n0,-1,0\n"),
    ] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let study = Study::load(&folder.path().join("study.toml"), &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    let ends = ends(&study, &worlds, 3, &mut Oracle::default()).unwrap();
    assert_eq!(ends[1], EndCounts::default(), "a pad casts nothing");
    ends[0].clone()
}

#[test]
fn rays_return_or_leave_or_end_too_near_or_too_far() {
    let ends = |returns, too_near, too_far, left| EndCounts { poses: 1, returns, too_near, too_far, left };
    assert_eq!(ends_of("[0.1, 20]", "nothing"), ends(1, 0, 0, 3));
    assert_eq!(ends_of("[0.1, 20]", "backdrop"), ends(1, 0, 0, 3));
    assert_eq!(ends_of("[9, 20]", "nothing"), ends(0, 1, 0, 3));
    // Half a metre back is the border; the sides are 4.5 and 5.5 m away.
    assert_eq!(ends_of("[0.1, 5]", "nothing"), ends(0, 0, 2, 2));
    assert_eq!(ends_of("[0.1, 0.4]", "nothing"), ends(0, 0, 4, 0));
}

#[test]
fn poses_that_choices_share_are_counted_once() {
    let paper = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/paper/exp2.toml");
    let study = Study::load(paper.as_ref(), &Overrides::default()).unwrap();
    let triplet = |choice| PoseChoice { combination: 0, choice };
    // A pad, a camera, a robot; the cover has three settings and varies fastest.
    assert_eq!(poses(&study, &[0, 1, 2].map(triplet)), 6);
    assert_eq!(poses(&study, &[0, 3].map(triplet)), 5, "another pose of the camera");
    assert_eq!(poses(&study, &[triplet(0), triplet(0)]), 4);
}

#[test]
fn two_measurements_tell_two_costs_apart() {
    // 3 s per pose, half a second per choice.
    assert_eq!(solve_two([[10.0, 10.0], [2.0, 100.0]], [35.0, 56.0]), [3.0, 0.5]);
    assert_eq!(
        solve_two([[10.0, 10.0], [20.0, 20.0]], [30.0, 60.0]),
        [3.0, 0.0],
        "they cannot be told apart"
    );
    // A busy machine: a negative result becomes zero, and the other kind gets all time.
    assert_eq!(solve_two([[10.0, 10.0], [2.0, 100.0]], [1.0, 54.0]), [0.0, 0.5]);
    assert_eq!(solve_two([[10.0, 10.0], [2.0, 100.0]], [30.0, 0.0]), [2.5, 0.0]);
    assert_eq!(solve_two([[0.0, 0.0], [0.0, 0.0]], [0.0, 0.0]), [0.0, 0.0]);
}

#[test]
fn rows_of_choices_begin_everywhere_and_hold_none_twice() {
    assert_eq!(rows_of(8, 5), [0, 1, 2, 3, 4]);
    let some = rows_of(80, 10_000);
    assert!(some.len() > 60 && some.len() <= 80, "{}", some.len());
    assert!(some.windows(2).all(|pair| pair[0] < pair[1]) && some.iter().all(|&choice| choice < 10_000));
    assert_eq!(some[..10], [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
    assert!(some[some.len() / 2] > 3000, "{some:?}");
    assert_eq!(rows_of(1 << 20, 1000).len(), 1000);
}
