//! What a study contains, as tables for `perirobot check`.

use perirobot_march::backend::MEMORY_BYTES;
use perirobot_march::voxel::rounded_up;
use perirobot_page::report::wording::count;
use perirobot_scene::objects::spec::SceneSpec;
use perirobot_scene::truth::{ObjectVoxels, Truth};
use perirobot_study::input::{Combination, RegionSpec, Study};
use perirobot_study::sensor::Sensor;
use perirobot_study::world::{World, ray_table};
use perirobot_sweep::results::layout_of;

/// Approximate bytes per row of results: in the journal, in results.csv, and its share of scores.csv.
const ROW_BYTES: f64 = 500.0;

/// Lines of one screen; a longer list is shortened.
const SCREEN: usize = 32;
/// Entries shown of a shortened list.
const FEW: usize = 3;

/// The contents of a study in the order of the file: everything with `--all` or if it fits on a screen, else the first
/// entries of each list.
pub(super) fn tables(study: &Study, worlds: &[World], all: bool) -> String {
    let shortened = |most: usize| {
        let sections = [
            head(study),
            scenes(study, worlds, most),
            regions(study, worlds, most),
            sensors(study, most),
            combinations(study, most),
            stopping(study),
        ];
        sections.concat()
    };
    let whole = shortened(usize::MAX);
    if all || whole.lines().count() <= SCREEN { whole } else { shortened(FEW) }
}

/// The first `most` entries, and the number of the others.
pub(super) fn first_of(
    entries: impl ExactSizeIterator<Item = String>,
    most: usize,
    indent: &str,
    what: &str,
) -> String {
    let mut entries = entries;
    let mut text: String = entries.by_ref().take(most).collect();
    match entries.len() {
        0 => {}
        more => text += &format!("{indent}and {} (--all)\n", count(more, &format!("more {what}"))),
    }
    text
}

/// The distance that people must keep at the highest speed, and the values to check.
fn stopping(study: &Study) -> String {
    let Some(stopping) = &study.stopping else { return String::new() };
    let at = stopping.fastest();
    let head = format!("stopping: {} m at {} m/s\n", rounded_up(at.needed_m, 2), at.speed_m_s);
    let checks = stopping.to_be_checked().map(|line| format!("  {line}\n"));
    head + &checks.collect::<String>() + "\n"
}

fn head(study: &Study) -> String {
    let noiseless = if study.noiseless { ", noise switched off" } else { "" };
    let outside = if study.backdrop { ", a backdrop outside" } else { "" };
    let (size, seed) = (study.voxel_size_m, study.seed);
    let (path, repeats) = (study.path.display(), count(study.repeats as usize, "repeat"));
    format!("{path}: voxels of {size} m{outside}, {repeats}{noiseless}, seed {seed}\n\n")
}

fn scenes(study: &Study, worlds: &[World], most: usize) -> String {
    let one = |(index, scene): (usize, &SceneSpec)| {
        let mut text = format!(
            "scene {:?} ({}), {}\n",
            scene.name,
            scene.path.display(),
            count(scene.snapshots, "snapshot")
        );
        let Some(world) = worlds.iter().find(|world| world.scene == index) else { return text };
        let ([x, y, z], voxel_m) = (world.grid.size, study.voxel_size_m);
        let [a, b, c] = [x, y, z].map(|count| f64::from(count) * voxel_m);
        let voxels = world.grid.window().volume();
        text += &format!(
            "  grid {x} × {y} × {z} = {voxels} voxels, {a:.2} × {b:.2} × {c:.2} m; {} occupied\n",
            world.truth().occupied.count()
        );
        text += &format!("  floor at z {:.2} m: {}\n", world.floor.z_m + 0.0, world.floor.source.words());
        text += &objects(&world.truth(), most);
        text
    };
    // One scene with its objects fills a third of a screen.
    let scenes = if most == usize::MAX { most } else { 1 };
    first_of(study.scenes.iter().enumerate().map(one), scenes, "", "scene") + "\n"
}

fn objects(truth: &Truth, most: usize) -> String {
    let width = width(truth.objects.iter().map(|object| object.name.as_str()));
    let line = |object: &ObjectVoxels| {
        let [low, high] = object.bounds_m;
        let (size, role) = (high - low, format!("{:?}", object.role).to_lowercase());
        format!(
            "  {:<width$}  {role:<11}  {:.2} × {:.2} × {:.2} m, {} voxels\n",
            object.name,
            size.x,
            size.y,
            size.z,
            object.voxels.count()
        )
    };
    first_of(truth.objects.iter().map(|object| line(object)), most, "  ", "object")
}

fn regions(study: &Study, worlds: &[World], most: usize) -> String {
    let width = width(study.regions.iter().map(|(name, _)| name.as_str()));
    let line = |(index, (name, _)): (usize, &(String, RegionSpec))| {
        let counts = || worlds.iter().map(|world| world.regions[index].voxels.count());
        let voxels = match (counts().min(), counts().max()) {
            (Some(least), Some(most)) if least == most => format!("{most} voxels"),
            (Some(least), Some(most)) => format!("{least} to {most} voxels"),
            _ => "unknown".into(),
        };
        format!("  {name:<width$}  {voxels}\n")
    };
    format!("regions\n{}\n", first_of(study.regions.iter().enumerate().map(line), most, "  ", "region"))
}

fn sensors(study: &Study, most: usize) -> String {
    let width = width(study.sensors.iter().map(|sensor| sensor.name.as_str()));
    let one = |(number, sensor): (usize, &Sensor)| {
        let poses_of = count(sensor.candidates.len(), "pose");
        let each = if sensor.candidates.len() == 1 { "at" } else { "at each of" };
        let rays = ray_table(study, number)
            .map_or("no rays,".into(), |rays| format!("{} rays {each}", rays.dirs_q15.len()));
        let line = format!(
            "  {:<width$}  {:<11}  {rays} {poses_of}, read as {}\n",
            sensor.name,
            sensor.kind.name(),
            sensor.kind.representations().join(", ")
        );
        line + &poses(sensor)
    };
    let all = study.sensors.iter().enumerate().map(one);
    let prices = study.describe_list_prices().map_or(String::new(), |prices| format!("  {prices}\n"));
    format!("sensors\n{}{prices}\n", first_of(all, most, "  ", "sensor"))
}

/// The names of a sensor's poses: the first and the last of each group.
fn poses(sensor: &Sensor) -> String {
    let groups = sensor.candidates.chunk_by(|a, b| a.group == b.group);
    let names = groups.filter_map(|group| match group {
        [] => None,
        [one] => Some(one.name.clone()),
        [first, .., last] => Some(format!("{} to {}", first.name, last.name)),
    });
    let names: Vec<String> = names.filter(|name| !name.is_empty()).collect();
    if names.is_empty() { String::new() } else { format!("    poses {}\n", names.join(", ")) }
}

fn combinations(study: &Study, most: usize) -> String {
    let width = width(study.combinations.iter().map(|combination| combination.name.as_str()));
    let line = |combination: &Combination| {
        let (choices, representations) =
            (combination.choices(), combination.representation_count(&study.sensors));
        let choices = count(choices, "choice");
        format!(
            "  {:<width$}  {choices} of poses × {}\n",
            combination.name,
            count(representations, "representation")
        )
    };
    let all = first_of(study.combinations.iter().map(line), most, "  ", "combination");
    let layout = layout_of(study);
    let (choices, rows) = (layout.blocks() as u64 * layout.pose_choices() as u64, layout.rows());
    format!(
        "combinations\n{all}  {choices} scene-poses, each snapshot and repeat counted; {rows} rows of results\n\n"
    )
}

/// Memory and disk space of a sweep.
pub(super) fn room(study: &Study, memory: Option<u64>) -> String {
    let evidence = memory.unwrap_or(MEMORY_BYTES) >> 20;
    let disk = layout_of(study).rows() as f64 * ROW_BYTES;
    let held = held_mib().map_or(String::new(), |mib| format!("peak {mib} MiB so far, with all scenes; "));
    format!(
        "memory: {held}a sweep takes up to {evidence} MiB for evidence (--memory); disk: about {}",
        bytes(disk)
    )
}

/// Peak memory of the process, if the system reports it.
pub(super) fn held_mib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = peak.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kib >> 10)
}

/// Seconds in words, rounded as an estimate.
pub(super) fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => "less than a second".into(),
        s if s < 90.0 => format!("about {s:.0} s"),
        s if s < 5400.0 => format!("about {:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("about {:.1} h", s / 3600.0),
        s => format!("about {:.1} days", s / 86_400.0),
    }
}

fn bytes(bytes: f64) -> String {
    match bytes / 1e6 {
        mb if mb < 1.0 => "1 MB".into(),
        mb if mb < 1000.0 => format!("{mb:.0} MB"),
        mb => format!("{:.1} GB", mb / 1000.0),
    }
}

/// Widest column; a name may be longer. The standard library pads to at most 65,535.
const WIDEST: usize = 1000;

fn width<'a>(names: impl Iterator<Item = &'a str>) -> usize {
    names.map(|name| name.chars().count()).max().unwrap_or_default().min(WIDEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_name_does_not_widen_the_column_without_end() {
        let long = "x".repeat(70_000);
        assert_eq!([width([long.as_str(), "a"].into_iter()), width(["ab", "a"].into_iter())], [WIDEST, 2]);
    }

    #[test]
    fn times_and_sizes_are_rounded() {
        for (seconds, expected) in [
            (0.2, "less than a second"),
            (42.4, "about 42 s"),
            (600.0, "about 10 min"),
            (9000.0, "about 2.5 h"),
            (432_000.0, "about 5.0 days"),
        ] {
            assert_eq!(time(seconds), expected);
        }
        assert_eq!([bytes(1.0), bytes(35e6), bytes(2.25e9)], ["1 MB", "35 MB", "2.2 GB"]);
    }
}
