//! Whether a sensor that a person placed could be fixed to anything there: it is in mid-air, or outside of the cell.

use perirobot_march::voxel::Grid;
use perirobot_scene::objects::Role;
use perirobot_study::input::{PLANNED, Study};
use perirobot_study::sensor::{Setting, Stance};
use perirobot_study::world::place::room_m;
use perirobot_study::world::{PlacementProblem, World};

/// How far from a sensor's place something must be that it can be fixed to.
const REACH_M: f64 = 0.25;

/// What is wrong with a sensor at a candidate at a moment: as the study says, or that a person placed it where nothing holds
/// it.
pub(super) fn placement_problem(
    world: &World,
    study: &Study,
    member: [usize; 2],
) -> Option<PlacementProblem> {
    let known = world.placement_problem(study, member);
    if known.as_ref().is_some_and(|problem| problem.is_impossible) {
        return known;
    }
    let loose = looseness(world, study, member);
    let told = |words: String| PlacementProblem { words, is_impossible: false };
    match (known, loose) {
        (_, Some(Looseness::Outside)) => Some(told("is outside of the cell: move it inside".into())),
        (None, Some(Looseness::MidAir)) => Some(told(format!(
            "hangs in mid-air, with nothing to fix it to within {REACH_M} m: move it to a wall, a post, a beam or the ceiling"
        ))),
        (known, _) => known,
    }
}

/// Why nothing holds a sensor.
#[derive(Clone, Copy)]
enum Looseness {
    Outside,
    MidAir,
}

/// Whether a sensor that a person placed is far from everything that stands in the cell, and from the cell's sides. What a
/// study lists may hang on something that is not modelled.
fn looseness(world: &World, study: &Study, [sensor, candidate]: [usize; 2]) -> Option<Looseness> {
    let spec = &study.sensors[sensor];
    let is_placed = spec.candidates[candidate].group.starts_with(PLANNED);
    let Setting::Pose(pose) = world.settings[sensor][candidate] else { return None };
    if !is_placed || spec.on.is_some() || spec.kind.stance() == Stance::Level {
        return None;
    }
    let truth = world.truth();
    let start = Grid::voxel_of(truth.grid.position_q16(pose.position_m));
    let reach = (REACH_M / truth.grid.voxel_size_m).ceil() as i32;
    let is_environment = |voxel| {
        let mut objects = truth.objects.iter();
        objects.any(|object| object.role == Role::Environment && object.voxels.get(voxel))
    };
    let ball = (-reach..=reach)
        .flat_map(|x| (-reach..=reach).flat_map(move |y| (-reach..=reach).map(move |z| [x, y, z])))
        .filter(|[x, y, z]| x * x + y * y + z * z <= reach * reach);
    let mut around = ball.map(|off| std::array::from_fn(|axis| start[axis] + off[axis]));
    if around.any(|voxel| truth.occupied.get(voxel) && is_environment(voxel)) {
        return None;
    }
    // The sides of the room may be walls that are not modelled. The grid is no measure, as it may grow with the sensors.
    let [low, high] = room_m(&truth);
    let axes = 0..3;
    let inwards =
        axes.map(|axis| (pose.position_m[axis] - low[axis]).min(high[axis] - pose.position_m[axis]));
    let inwards = inwards.fold(f64::INFINITY, f64::min);
    match inwards {
        inwards if inwards < -REACH_M => Some(Looseness::Outside),
        inwards if inwards <= REACH_M => None,
        _ => Some(Looseness::MidAir),
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use perirobot_march::backend::factory::BackendKind;
    use perirobot_scene::pose::Pose;
    use perirobot_study::input::{Overrides, Planned, PlannedAt};

    use super::super::Resolution;
    use super::super::tests::{ask, live, scenes};
    use super::*;

    /// A sensor that was placed far from everything hangs in mid-air, in the words that both answers have; it is counted.
    #[test]
    fn a_sensor_that_nothing_holds_is_told() {
        let study = Study::load(&scenes("tiny.toml"), &Overrides::default()).unwrap();
        let mut live = live(BackendKind::Cpu, study.clone());
        let pose = study.sensors[0].candidates[0].setting.pose();
        let world = live.worlds(Resolution::Fine).unwrap()[0].clone();
        let (truth, size) = (world.truth(), world.grid.size);
        let held = |at: DVec3| {
            let mut things =
                truth.objects.iter().filter(|object| object.role == Role::Environment).flat_map(|object| {
                    object
                        .voxels
                        .voxels()
                        .map(|voxel| world.grid.corner_m(voxel) + world.grid.voxel_size_m / 2.0)
                });
            things.any(|thing| thing.distance(at) < 0.2)
        };
        let (mut free, mut fixed) = (0, 0);
        for voxel in
            (0..size[0]).step_by(3).flat_map(|x| [3, 8, 12].map(|z| [x, size[1] / 2, z].map(|at| at as i32)))
        {
            let at = world.grid.corner_m(voxel) + world.grid.voxel_size_m / 2.0;
            let planned = Planned { sensor: 0, at: PlannedAt::Pose(Pose { position_m: at, ..pose }) };
            let answer = live.score(&ask(&[planned], 0, 0)).unwrap();
            let told = answer.problems.first().is_some_and(|problem| problem.words.contains("mid-air"));
            if told {
                assert!(!held(at), "{at}: {:?}", answer.problems);
                assert!(!answer.problems[0].is_left_out);
                let judged = live.judge(&[planned], None, &|| None).unwrap();
                assert_eq!(judged.problems, answer.problems, "{at}");
            }
            free += usize::from(told);
            fixed += usize::from(!told);
        }
        assert!(free > 0 && fixed > 0, "{free} {fixed}");
        let listed = Planned { sensor: 0, at: PlannedAt::Listed(0) };
        let answer = live.score(&ask(&[listed], 0, 0)).unwrap();
        assert!(
            answer.problems.iter().all(|problem| !problem.words.contains("mid-air")),
            "{:?}",
            answer.problems
        );
    }
}
