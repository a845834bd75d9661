//! Whether the rays of a level scanner resolve what ISO 13855 needs at its height.
//!
//! # Theory
//! By public pages, a plane at a height H above the floor that people approach along needs a detection capability of at most
//! d = 50 mm + H / 15, so that no leg passes it. Between two rays at a distance an object as wide as their gap is always hit.

use perirobot_march::voxel::rounded_up;
use perirobot_study::input::Study;
use perirobot_study::sensor::{Approached, Setting};
use perirobot_study::world::World;

/// A warning for each scanner in a set of a study with `[stopping]` whose rays are too far apart at the end of its range, of its
/// fields, or of the regions.
pub fn check_resolution(study: &Study, world: &World) -> Vec<String> {
    if study.stopping.is_none() {
        return Vec::new();
    }
    let is_used = |sensor: &usize| {
        let mut members = study.combinations.iter().flat_map(|combination| &combination.members);
        members.any(|member| member.sensor == *sensor)
    };
    (0..study.sensors.len()).filter(is_used).filter_map(|sensor| warning(study, world, sensor)).collect()
}

fn warning(study: &Study, world: &World, number: usize) -> Option<String> {
    let sensor = &study.sensors[number];
    if sensor.kind.approached() != Some(Approached::AlongRays) || sensor.on.is_some() {
        return None;
    }
    let (spacing, [_, far_m]) = (sensor.kind.spacing()?, sensor.kind.range()?.range_m);
    let field_m = sensor.kind.as_scanner().and_then(|scanner| scanner.field_reach_m());
    let end_m = far_m.min(world.farthest_m(number)).min(field_m.unwrap_or(f64::INFINITY));
    // Only rays in one plane: others catch a leg at several heights.
    let (gap_m, None) = spacing.rectangle_m(end_m) else { return None };
    let heights = world.settings[number].iter().filter_map(|setting| match setting {
        Setting::Pose(pose) => Some(pose.position_m.z - world.floor.z_m),
        _ => None,
    });
    let lowest_m = heights.reduce(f64::min)?.max(0.0);
    let capability_m = needed_capability_m(lowest_m);
    let reach_m = spacing.reach_m([capability_m, f64::INFINITY]);
    (gap_m > capability_m).then(|| {
        format!(
            "sensor {:?}: at {end_m:.1} m its rays hit only objects of {} m or more, and ISO 13855 (as public pages tell) needs a \
             detection capability of {:.3} m for a plane {lowest_m:.2} m above the floor: it has that up to {:.1} m; cast more \
             rays, mount it nearer, or end its field or range_m there",
            sensor.name,
            rounded_up(gap_m, 3),
            capability_m,
            (reach_m * 10.0).floor() / 10.0
        )
    })
}

/// The detection capability that a plane at a height needs.
fn needed_capability_m(height_m: f64) -> f64 {
    0.05 + height_m / 15.0
}

#[cfg(test)]
mod tests {
    use super::needed_capability_m;

    #[test]
    fn a_higher_plane_may_be_coarser() {
        assert_eq!(needed_capability_m(0.0), 0.05);
        assert!((needed_capability_m(0.3) - 0.07).abs() < 1e-12);
    }
}
