//! The plan of a study, as indexes of sensors and poses.

use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::pose::Pose;
use perirobot_study::input::{Planned, PlannedAt, Study};
use perirobot_study::sensor::{MountLink, Setting, Stance};

use super::{Loaded, Refused};
use crate::answers::MoveRequest;
use crate::document::{PlacedName, Pose6, rounded};

/// The indexes of placed sensors and their poses.
pub(super) fn placed_of(study: &Study, names: &[PlacedName]) -> Result<Vec<[usize; 2]>> {
    let index = |PlacedName { sensor, pose }: &PlacedName| {
        let number = study.sensors.iter().position(|known| known.name == *sensor)?;
        let candidates = &study.sensors[number].candidates;
        Some([number, candidates.iter().position(|known| known.name == *pose)?])
    };
    let found = |name: &PlacedName| {
        index(name).ok_or_else(|| {
            let words = format!("has no pose {:?} of sensor {:?}", name.pose, name.sensor);
            Error::from(Issue::says(words).with_place(&study.path))
        })
    };
    names.iter().map(found).collect()
}

/// Where a sensor of a plan is in the world at a moment, if a link carries it.
pub(super) fn place_on_link(loaded: &Loaded, planned: &Planned, moment: usize) -> Option<Pose> {
    let carrier = loaded.worlds.get(moment)?.carrier(planned.sensor)?;
    let own = match planned.at {
        PlannedAt::Pose(pose) => pose,
        PlannedAt::Listed(number) => match loaded.study.sensors[planned.sensor].candidates[number].setting {
            Setting::Pose(pose) => pose,
            _ => return None,
        },
    };
    Some(own.carried_by(&carrier))
}

/// A place in the world as the study says it: of a sensor that a link carries, that on the link at this moment.
pub(super) fn own_place(
    loaded: &Loaded,
    sensor: usize,
    at: &Pose6,
    moment: Option<usize>,
) -> Result<Pose6, Refused> {
    at.check()?;
    let Some(on) = &loaded.study.sensors[sensor].on else { return Ok(*at) };
    let carrier = moment.and_then(|moment| loaded.worlds.get(moment)?.carrier(sensor));
    let Some(link) = carrier else {
        let MountLink { object, link } = on;
        let words = format!("{object}/{link} carries the sensor: say at which moment it is moved");
        return Err(Refused(400, words));
    };
    let world = rounded(at, Stance::Facing);
    let back = link.rotation.inverse();
    Ok(Pose6::new(&Pose {
        position_m: back * (world.position_m - link.position_m),
        rotation: (back * world.rotation).normalize(),
    }))
}

/// The plan, with the change that a person is about to make at a moment.
pub(super) fn plan_of(
    loaded: &Loaded,
    change: Option<&MoveRequest>,
    moment: Option<usize>,
) -> Result<Vec<Planned>, Refused> {
    let Loaded { study, placed, .. } = loaded;
    let listed = |&[sensor, pose]: &[usize; 2]| Planned { sensor, at: PlannedAt::Listed(pose) };
    let mut plan: Vec<Planned> = placed.iter().map(listed).collect();
    let at = |sensor: usize, at: &Pose6| -> Result<PlannedAt, Refused> {
        let own = own_place(loaded, sensor, at, moment)?;
        Ok(PlannedAt::Pose(rounded(&own, study.sensors[sensor].kind.stance())))
    };
    match change {
        None => {}
        Some(MoveRequest { index: Some(index), at: to, pose, .. }) => {
            let Some(&[sensor, _]) = placed.get(*index) else { return Err(no_sensor(*index, placed.len())) };
            let named = pose.as_ref().and_then(|pose| {
                study.sensors[sensor].candidates.iter().position(|known| known.name == *pose)
            });
            plan[*index].at = match named {
                Some(pose) => PlannedAt::Listed(pose),
                None => at(sensor, to)?,
            };
        }
        Some(MoveRequest { add: Some(device), at: to, .. }) => {
            // A device of the catalogue has no rays before the study has it.
            let known = device.sensor.as_ref();
            let number = known.and_then(|name| study.sensors.iter().position(|sensor| sensor.name == *name));
            if let Some(sensor) = number {
                plan.push(Planned { sensor, at: at(sensor, to)? });
            }
        }
        Some(_) => return Err(Refused(400, "a move has an index of the plan, or what is added".into())),
    }
    Ok(plan)
}

pub(super) fn check_dead(dead: Option<usize>, plan: &[Planned]) -> Result<(), Refused> {
    match dead {
        Some(dead) if dead >= plan.len() => Err(no_sensor(dead, plan.len())),
        _ => Ok(()),
    }
}

pub(super) fn no_sensor(index: usize, count: usize) -> Refused {
    Refused(400, format!("there is no sensor {index}: {count} are placed"))
}

pub(super) fn no_moment(moment: usize, count: usize) -> Refused {
    Refused(400, format!("there is no moment {moment}: the study has {count}"))
}
