//! The part of `perirobot check` about approaches, without sensors: what `approach` and `judge` refuse, and entries that
//! begin too close.

use std::sync::Arc;

use super::ground::{Company, Ground};
use super::moments::ApproachMoment;
use super::needed;
use super::traps::traps;
use perirobot_march::Result;
use perirobot_scene::truth::Truth;
use perirobot_study::input::{EntryPlace, Study};
use perirobot_study::world::World;

/// Of each scene by name, which entries begin nearer to the hazard than is needed at the highest speed of the robot, and
/// which surfaces bodies do not get to that walk, as warnings. Nothing is cast. Nothing is said where the study does not ask how near bodies come, and of entries that are
/// light curtains with several poses.
///
/// # Errors
/// When an approach cannot be asked of a scene: those of [`Ground::from_scenes`].
pub fn check_approach<'w>(study: &Study, worlds: &'w [World]) -> Result<Vec<(&'w str, Vec<String>)>> {
    let asks = study.has_approach || study.requirements.iter().any(|one| one.is_of_nearness());
    let stays = |place: &EntryPlace| match place {
        EntryPlace::Gate(sensor) => study.sensors[*sensor].candidates.len() == 1,
        EntryPlace::Box { .. } | EntryPlace::Edges => true,
    };
    if !asks || !study.approach.entries.iter().any(|entry| stays(&entry.place)) {
        return Ok(Vec::new());
    }
    let (mut study, entries) = (study.clone(), study.approach.entries.len());
    study.approach.entries.retain(|entry| stays(&entry.place));
    let scenes = worlds.chunk_by(|one, next| one.scene == next.scene);
    scenes
        .map(|worlds| {
            let ground = Ground::new(&study, worlds, &[])?;
            if study.stopping.is_none() && !ground.walks() {
                return Ok((worlds[0].name.as_str(), Vec::new()));
            }
            let truths: Vec<Arc<Truth>> = worlds.iter().map(|world| Company::Absent.truth(world)).collect();
            let moment = ApproachMoment::new(&ground, Company::Absent, worlds, &truths)?;
            let mut warnings = too_near(&ground, &moment);
            // With all entries: others may lead to what these do not.
            if study.approach.entries.len() == entries {
                warnings.extend(traps(&ground, &moment));
            }
            Ok((worlds[0].name.as_str(), warnings))
        })
        .collect()
}

/// The entries that begin too near, each with its body.
fn too_near(ground: &Ground, moment: &ApproachMoment) -> Vec<String> {
    let Some(stopping) = &ground.study.stopping else { return Vec::new() };
    let grid = &ground.worlds[0].grid;
    let warning = |([body, entry], squared): ([usize; 2], Option<u32>)| {
        let (body, entry) = (&ground.bodies[body].name, &ground.study.approach.entries[entry].name);
        let what = needed::begins_too_near(stopping, squared?, grid)?;
        Some(format!("entry {entry:?}, body {body:?}: {what}"))
    };
    moment.entries().into_iter().filter_map(warning).collect()
}
