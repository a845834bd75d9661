//! Small cells with reasons worked out by hand. `proof` tests all other cells.

pub(crate) mod proof;

use tempfile::TempDir;

use super::*;
use crate::view::Choice;
use perirobot_march::backend::cpu::Cpu;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

/// A prepared study, from its text, that of its scene `cell.toml`, and other files.
pub(crate) fn ready(study: &str, scene: &str, others: &[(&str, String)]) -> (Study, Vec<World>) {
    let folder = TempDir::new().unwrap();
    let files = [("study.toml", study.to_string()), ("cell.toml", scene.to_string())];
    files
        .iter()
        .chain(others)
        .for_each(|(name, text)| std::fs::write(folder.path().join(name), text).unwrap());
    let study = Study::load(&folder.path().join("study.toml"), &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    (study, worlds)
}

/// The first choice of the first combination.
const FIRST: Choice = Choice { combination: 0, choice: 0, representation: 0, repeat: 0 };

/// Reason, object and voxels of the unknown space in a study's first region.
fn reasons(study: &str, scene: &str, others: &[(&str, String)]) -> Vec<(&'static str, String, u64)> {
    let (study, worlds) = ready(study, scene, others);
    let view = View::new(&study, &worlds[0], FIRST, &mut Cpu::new(Some(1)).unwrap()).unwrap();
    let tallies = view.tally(&view.why_in_regions(), 0);
    let counts = view.counts(0);
    let together = |of: fn(&CauseTally) -> u64| tallies.iter().map(of).sum::<u64>();
    assert_eq!((together(|t| t.occupied), together(|t| t.free)), (counts.uo, counts.uf));
    let named = |t: &CauseTally| {
        (t.cause.reason.name(), view.object(&t.cause).unwrap_or_default().to_string(), t.voxels())
    };
    tallies.iter().map(named).collect()
}

fn finding(reason: &'static str, object: &str, voxels: u64) -> (&'static str, String, u64) {
    (reason, object.into(), voxels)
}

/// A corridor of 10 × 3 × 3 voxels of a metre, and one ray along its middle from the middle of its first voxel.
fn corridor(keys: &str) -> String {
    format!(
        "[grid]\nvoxel_size_m = 1\nbounds_m = {{ min = [0, 0, 0], max = [9.5, 2.5, 2.5] }}\n\
         [[scene]]\nfile = \"cell.toml\"\n\
         [[region]]\nname = \"all\"\nbox = {{ min_m = [0, 0, 0], max_m = [10, 3, 3] }}\n\
         [[sensor]]\nname = \"ray\"\nkind = \"rays\"\ndirections = \"ray.csv\"\n{keys}\n\
         [[sensor.poses]]\nname = \"p\"\nlist = [{{ position_m = [0.5, 1.5, 1.5], facing = [1, 0, 0] }}]\n"
    )
}

/// Boxes of half a metre, each in the middle of a voxel: its name, its place, more of its keys.
fn boxes(all: &[(&str, [i32; 3], &str)]) -> String {
    let one = |(name, at, more): &(&str, [i32; 3], &str)| {
        let [x, y, z] = at.map(|x| f64::from(x) + 0.5);
        format!(
            "[[object]]\nname = \"{name}\"\nbox = {{ size_m = [0.5, 0.5, 0.5] }}\nposition_m = [{x}, {y}, {z}]\n{more}\n"
        )
    };
    format!("interior = \"free\"\n{}", all.iter().map(one).collect::<String>())
}

fn reasons_in_corridor(keys: &str, all: &[(&str, [i32; 3], &str)]) -> Vec<(&'static str, String, u64)> {
    reasons(&corridor(keys), &boxes(all), &[("ray.csv", "x,y,z\n1,0,0\n".into())])
}

#[test]
fn behind_a_box_all_is_hidden_by_it() {
    // Six free voxels and the box are known, three behind it are not; the other 80 are beside the only ray.
    let all = [("box", [6, 1, 1], "")];
    assert_eq!(
        reasons_in_corridor("range_m = [0, 20]", &all),
        [finding("out_of_view", "", 80), finding("hidden", "box", 3)]
    );
    // It is entered at 5.5, and x = 4 at 3.5: beyond 3.6 is out of range, and the voxels before are not certified.
    assert_eq!(
        reasons_in_corridor("range_m = [0, 3.6]", &all),
        [finding("out_of_view", "", 80), finding("out_of_range", "", 5), finding("no_return", "", 5)]
    );
    // Too close to be measured: the whole row is lost, including the box.
    assert_eq!(
        reasons_in_corridor("range_m = [6, 20]", &all),
        [finding("out_of_view", "", 80), finding("blind", "box", 10)]
    );
    // The lens ignores its own housing, and sees the hall.
    assert_eq!(
        reasons_in_corridor("range_m = [6, 20]\nnear_ignore_m = 6", &all),
        [finding("out_of_view", "", 80), finding("no_return", "", 10)]
    );
}

#[test]
fn the_object_that_hides_is_the_first_that_stops_rays() {
    let shared = |more: [&str; 3]| {
        let all =
            [("first", [6, 1, 1], more[0]), ("second", [6, 1, 1], more[1]), ("other", [8, 1, 1], more[2])];
        reasons_in_corridor("range_m = [0, 20]", &all).swap_remove(1)
    };
    assert_eq!(shared(["", "", ""]), finding("hidden", "first", 3));
    assert_eq!(shared(["optical = \"see_through\"", "", ""]), finding("hidden", "second", 3));
    assert_eq!(shared(["tag_only = true", "", ""]), finding("hidden", "second", 3));
    // No object stops the ray at x = 6; behind x = 8 one voxel is hidden; the 80 beside the ray come first.
    let see_through = "optical = \"see_through\"";
    assert_eq!(shared([see_through, see_through, ""]), finding("hidden", "other", 1));
}

/// A hall of 9 × 9 × 9 voxels of a metre, and a camera of 90° × 90° that looks along x from the middle of its side.
fn hall(keys: &str) -> String {
    format!(
        "[grid]\nvoxel_size_m = 1\nbounds_m = {{ min = [0, 0, 0], max = [8.5, 8.5, 8.5] }}\n\
         [[scene]]\nfile = \"cell.toml\"\n\
         [[region]]\nname = \"all\"\nbox = {{ min_m = [0, 0, 0], max_m = [9, 9, 9] }}\n\
         [[sensor]]\nname = \"camera\"\nkind = \"rgbd\"\nfov_deg = [90, 90]\nresolution_px = [180, 180]\n{keys}\n\
         [[sensor.poses]]\nname = \"p\"\nlist = [{{ position_m = [0.25, 4.5, 4.5], facing = [1, 0, 0] }}]\n"
    )
}

/// A wall of 3 × 3 voxels, 3.75 m in front of the camera.
const WALL: &str = "interior = \"free\"\n[[object]]\nname = \"wall\"\nbox = { size_m = [0.5, 2.5, 2.5] }\n\
                    position_m = [4.5, 4.5, 4.5]\n";

#[test]
fn the_shadow_of_a_wall() {
    // The shadow is 1.5 / 3.75 = 0.4 as wide, to each side, as it is far. A voxel is completely in it if its outer edge
    // at its near side is: |y| + ½ ≤ 0.4 (x − ½). 0.4 · 4.75 = 1.9 and 0.4 · 5.75 = 2.3 take |y| up to 1, 0.4 · 6.75 =
    // 2.7 and 0.4 · 7.75 = 3.1 up to 2: two layers of 3 × 3 voxels and two of 5 × 5.
    let all = reasons(&hall("range_m = [0, 30]\nno_return = \"free\""), WALL, &[]);
    assert_eq!(all.len(), 2, "{all:?}");
    assert_eq!((all[0].0, &all[1]), ("out_of_view", &finding("hidden", "wall", 68)));
}

#[test]
fn a_hall_that_says_nothing() {
    // Only the wall is seen: the rest of the view is in front of it (known), behind it, or silent.
    let all = reasons(&hall("range_m = [0, 30]"), WALL, &[]);
    let names: Vec<_> = all.iter().map(|(reason, object, _)| (*reason, object.as_str())).collect();
    assert_eq!(names, [("out_of_view", ""), ("hidden", "wall"), ("no_return", "")]);
    let (study, worlds) = ready(&hall("range_m = [0, 30]"), WALL, &[]);
    let view = View::new(&study, &worlds[0], FIRST, &mut Cpu::new(Some(1)).unwrap()).unwrap();
    for missed in view.why_in_regions() {
        for [x, y, z] in missed.voxels.voxels() {
            let (ahead, aside) = (f64::from(x) + 0.25, f64::from((y - 4).abs().max((z - 4).abs())));
            let expected = match missed.cause.reason {
                Reason::OutOfView => aside > 0.98 * ahead - 0.5,
                Reason::Hidden => x > 4 && aside < 0.41 * ahead,
                _ => aside > 0.39 * ahead && aside < ahead + 1.0,
            };
            assert!(expected, "{:?} at {x} {y} {z}", missed.cause);
        }
    }
}

/// A hall of 61 × 1 × 21 voxels of a metre, and a LIDAR with rings 2° apart at one end; the region is a column 50 m
/// away.
fn rings(range_max_m: u32) -> String {
    format!(
        "[grid]\nvoxel_size_m = 1\nbounds_m = {{ min = [0, 0, 0], max = [60.5, 0.5, 20.5] }}\n\
         [[scene]]\nfile = \"cell.toml\"\n\
         [[region]]\nname = \"column\"\nbox = {{ min_m = [50, 0, 6], max_m = [51, 1, 16] }}\n\
         [[sensor]]\nname = \"lidar\"\nkind = \"lidar\"\nfov_deg = 1\nresolution_deg = 0.5\n\
         rings_deg = [-4, -2, 0, 2, 4]\nrange_m = [0, {range_max_m}]\nno_return = \"free\"\n\
         [[sensor.poses]]\nname = \"p\"\nlist = [{{ position_m = [0.5, 0.5, 10.5], facing = [1, 0, 0] }}]\n"
    )
}

#[test]
fn rings_two_degrees_apart_miss_a_voxel_between_them() {
    // From 49.5 to 50.5 m ahead the rings are 1.73 to 1.76 and 3.46 to 3.53 m above and below 10.5: they cross 6, 7, 8,
    // 10, 12, 13 and 14. Their field ends 5° up, 4.37 m: that is in 14, and 15 has its centre at 5.
    let far_corner = boxes(&[("stone", [60, 0, 0], "")]);
    assert_eq!(
        reasons(&rings(100), &far_corner, &[]),
        [finding("out_of_view", "", 1), finding("between_rays", "", 2)]
    );
    assert_eq!(
        reasons(&rings(30), &far_corner, &[]),
        [finding("out_of_view", "", 1), finding("out_of_range", "", 9)]
    );
}

#[test]
fn a_switch_that_is_off_certifies_nothing() {
    let gate = |otherwise: &str| {
        let study = corridor("range_m = [0, 20]");
        let head = study.split("[[sensor]]").next().unwrap();
        format!(
            "{head}[[sensor]]\nname = \"gate\"\nkind = \"gate\"\nbox = {{ min_m = [8, 0, 0], max_m = [9, 3, 3] }}\n\
             zone = {{ min_m = [0, 0, 0], max_m = [4, 3, 3] }}\notherwise = \"{otherwise}\"\n"
        )
    };
    let scene = boxes(&[("box", [6, 1, 1], "")]);
    assert_eq!(
        reasons(&gate("unknown"), &scene, &[]),
        [finding("out_of_view", "", 54), finding("silent", "", 36)]
    );
    assert_eq!(reasons(&gate("free"), &scene, &[]), [finding("out_of_view", "", 54)]);
}

#[test]
fn of_several_sensors_the_one_that_came_nearest_gives_the_reason() {
    let second = "[[sensor]]\nname = \"back\"\nkind = \"rays\"\ndirections = \"ray.csv\"\nrange_m = [0, 20]\n\
                  [[sensor.poses]]\nname = \"p\"\nlist = [{ position_m = [9.5, 1.5, 1.5], facing = [-1, 0, 0] }]\n\
                  [[combination]]\nsensors = [\"ray\", \"back\"]\n";
    let study = corridor("range_m = [0, 20]") + second;
    let all = [("near", [2, 1, 1], ""), ("far", [6, 1, 1], "")];
    let ray = [("ray.csv", "x,y,z\n1,0,0\n".to_string())];
    // The first knows 0 to 2, and the near box hides the rest; the second knows 6 to 9, and the far one hides the rest:
    // for voxels unknown to both, the first sensor determines the object.
    assert_eq!(
        reasons(&study, &boxes(&all), &ray),
        [finding("out_of_view", "", 80), finding("hidden", "near", 3)]
    );
    // The far box is entered at 2.5: if the second's range ends before that, nothing returns from 7 to 9, a later
    // reason than a hidden one, and what is beyond is hidden, a later reason than out of range.
    let shorter = format!("{}{}", corridor("range_m = [0, 20]"), second.replace("[0, 20]", "[0, 2.4]"));
    assert_eq!(
        reasons(&shorter, &boxes(&all), &ray),
        [finding("out_of_view", "", 80), finding("hidden", "near", 4), finding("no_return", "", 3)]
    );
}

#[test]
fn votes_that_cancel_are_named() {
    let ray = [("ray.csv", "x,y,z\n1,0,0\n".to_string())];
    let (study, worlds) = ready(&corridor("range_m = [0, 20]"), &boxes(&[("box", [6, 1, 1], "")]), &ray);
    let mut view = View::new(&study, &worlds[0], FIRST, &mut Cpu::new(Some(1)).unwrap()).unwrap();
    // No study can produce it with few sensors: 3511, 847 and 405 have no small common multiples.
    let mut one = BitGrid::nowhere().to_window(view.labels.free.window());
    one.set([3, 1, 1]);
    view.labels.free.remove(&one);
    let missed = view.why_in_regions();
    let last = missed.last().unwrap();
    assert_eq!((last.cause, &last.voxels), (Cause { reason: Reason::Cancelled, object: None }, &one.trim()));
}
