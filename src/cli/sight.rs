//! What rays may miss, for `perirobot check`: objects between rays, and bodies nearer than a sensor measures.

use perirobot_page::report::wording::count;
use perirobot_study::input::Study;
use perirobot_study::sensor::range::Range;
use perirobot_study::sensor::{Sensor, Setting, Stance};
use perirobot_study::world::World;
use perirobot_study::world::near::{NearBlindness, near_blindness};

/// Distances at which the smallest object is listed, besides the end of the range, in metres.
const DISTANCES_M: [f64; 3] = [1.0, 2.0, 5.0];

/// Lines of each sensor with a field of view, for at most so many poses of it; one entry a sensor.
pub(super) fn lines(study: &Study, worlds: &[World], poses: usize) -> Vec<String> {
    let of = |(number, sensor): (usize, &Sensor)| {
        let near = nearest_share(study, &worlds[0], number, poses);
        let all: Vec<String> = [smallest(study, &worlds[0], number), near].into_iter().flatten().collect();
        let first = format!("sight of {:?}: ", sensor.name);
        (!all.is_empty()).then(|| format!("{first}{}\n", all.join(";\n  ")))
    };
    study.sensors.iter().enumerate().filter_map(of).collect()
}

/// The smallest objects that its rays surely hit.
fn smallest(study: &Study, world: &World, number: usize) -> Option<String> {
    let sensor = &study.sensors[number];
    let (spacing, range) = (sensor.kind.spacing()?, sensor.kind.range()?);
    let mut text = spacing.describe(&distances_m(range, world.farthest_m(number)));
    let heights = world.settings[number].iter().filter_map(|setting| match setting {
        Setting::Pose(pose) => Some(pose.position_m.z - world.floor.z_m),
        _ => None,
    });
    let lowest_m = heights.fold(f64::INFINITY, f64::min);
    if !sensor.resolutions_mm.is_empty() {
        let all: Vec<String> = sensor.resolutions_mm.iter().map(f64::to_string).collect();
        text += &format!(";\n  its field can be set to a resolution of {} mm", all.join(", "));
        if sensor.kind.stance() == Stance::Upright && lowest_m.is_finite() {
            let needed_mm = (50.0 + 1e3 * lowest_m.max(0.0) / 15.0).floor();
            text +=
                &format!("; {needed_mm} mm or finer is needed {lowest_m:.2} m above the floor (ISO 13855)");
        }
        text += ": both to be checked";
    }
    Some(text)
}

/// Some distances inside a range, and its end or that of the regions.
fn distances_m(range: &Range, farthest_m: f64) -> Vec<f64> {
    let [near_m, far_m] = range.range_m;
    let end_m = (far_m.min(farthest_m) * 10.0).round() / 10.0;
    let inside = DISTANCES_M.into_iter().filter(|distance| (near_m..end_m).contains(distance));
    inside.chain([end_m]).collect()
}

/// What is too near to it, at the pose of some at which that is most of a region, else of the floor.
fn nearest_share(study: &Study, world: &World, number: usize, poses: usize) -> Option<String> {
    let sensor = &study.sensors[number];
    let step = sensor.candidates.len().div_ceil(poses.max(1)).max(1);
    let all = (0..sensor.candidates.len()).step_by(step);
    let found: Vec<(usize, NearBlindness)> = all
        .filter_map(|candidate| Some((candidate, near_blindness(study, world, [number, candidate])?)))
        .collect();
    // The first of equals, of regions and of the floor each by itself.
    let first = |a: usize, b: usize| b.cmp(&a);
    let of_region = found
        .iter()
        .max_by(|a, b| a.1.largest_share().total_cmp(&b.1.largest_share()).then(first(a.0, b.0)))?;
    let of_floor = found.iter().max_by(|a, b| a.1.floor[0].cmp(&b.1.floor[0]).then(first(a.0, b.0)))?;
    let at = |candidate: usize| &sensor.candidates[candidate].name;
    let most = &of_region.1;
    let poses = count(found.len(), "pose");
    let largest = |share: String, candidate: usize| format!("{share} at most, at {}", at(candidate));
    let regions = most
        .describe_regions(study)
        .map_or("no part of a region".into(), |share| largest(share, of_region.0));
    let floor = of_floor.1.describe_floor().map(|share| format!("; {}", largest(share, of_floor.0)));
    let what = regions + &floor.unwrap_or_default();
    Some(format!("a body {} is not seen: {what} ({poses} tried)", most.describe_distance()))
}
