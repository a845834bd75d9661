//! What verdicts on a choice take for granted, and what speaks against it.

use perirobot_march::Result;
use perirobot_study::input::Study;
use perirobot_study::world::{World, tripping_object};

use super::what_if::WhatIf;
use crate::approach::{Ground, passed_latches, unproven_latches};
use crate::view::Choice;

/// Latches that are not proven to hold, curtains that people step over, and switches that things trip. `grounds` are the scenes in
/// which approaches are asked for the choice; empty if they are not.
///
/// # Errors
/// When a snapshot has no hazard.
pub(super) fn caveats(what_if: &WhatIf, choice: &Choice, grounds: &[Ground]) -> Result<Vec<String>> {
    if grounds.is_empty() {
        return Ok(caveats_as_planned(what_if.study, what_if.worlds, choice));
    }
    Ok([passed_latches(what_if.study, choice, grounds)?, of_members(what_if)].concat())
}

/// The same where no approach is asked, so that no latch is proven.
pub fn caveats_as_planned(study: &Study, worlds: &[World], choice: &Choice) -> Vec<String> {
    [unproven_latches(study, choice), of_members(&WhatIf::new(study, worlds, choice))].concat()
}

/// What each sensor of a choice tells by itself.
fn of_members(WhatIf { study, worlds, members, .. }: &WhatIf) -> Vec<String> {
    let of_one = |&member: &[usize; 3]| {
        low_curtain(study, worlds, member).into_iter().chain(tripped(study, worlds, member))
    };
    members.iter().flat_map(of_one).collect()
}

/// How high a light curtain must at least end so that people do not step over it: the highest of two beams in ISO 13855, as
/// public pages tell.
const HIGHEST_BEAM_M: f64 = 0.9;

/// A curtain that latches and that people can step over, which bodies that approach do not do.
fn low_curtain(study: &Study, worlds: &[World], [sensor, candidate, _]: [usize; 3]) -> Option<String> {
    let (spec, world) = (&study.sensors[sensor], worlds.first()?);
    if !spec.kind.latches() {
        return None;
    }
    let truth = world.truth();
    let from_m = world.station(study, &truth, [sensor, candidate, 0]).pose().position_m.z - world.floor.z_m;
    let ends_m = from_m + spec.kind.prisms().first()?.z_m[1];
    (ends_m < HIGHEST_BEAM_M).then(|| {
        format!(
            "sensor {:?}: people step over it, since it ends {ends_m:.2} m above the floor, and ISO 13855 (as public pages \
             tell) needs {HIGHEST_BEAM_M} m or more; bodies of [approach] do not step over",
            spec.name
        )
    })
}

/// A switch that objects alone trip at some moments.
fn tripped(study: &Study, worlds: &[World], [sensor, candidate, _]: [usize; 3]) -> Option<String> {
    let spec = &study.sensors[sensor];
    let by = |world: &World| tripping_object(study, world, [sensor, candidate]);
    let names: Vec<String> = worlds.iter().filter_map(by).collect();
    let first = names.first()?;
    Some(format!(
        "sensor {:?}: {first:?} trips it at {} of {} moments, and it reports occupied then, with or without people",
        spec.name,
        names.len(),
        worlds.len()
    ))
}
