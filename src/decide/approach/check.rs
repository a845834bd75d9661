//! The part of `perirobot check` about approaches, without sensors: what `approach` and `judge` refuse, and entries that
//! begin too close.

use std::sync::Arc;

use super::ground::{Company, Ground};
use super::moments::ApproachMoment;
use super::needed;
use super::traps::traps;
use perirobot_march::Result;
use perirobot_march::voxel::rounded_down;
use perirobot_scene::truth::Truth;
use perirobot_study::input::{BodyShape, BodySpec, EntryPlace, Study};
use perirobot_study::world::World;

/// Warnings of each scene by name: entries that begin nearer to the hazard than is needed at the highest speed of the robot,
/// surfaces that walking bodies do not get to, and in the first scene bodies that pass between rays. Nothing is cast. Empty
/// if the study does not ask how near bodies come; entries are left out that are
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
    // Of scenes that could not be read nothing is known.
    let Some(first) = worlds.first() else { return Ok(Vec::new()) };
    let between = between_rays(study, first);
    let (mut study, entries) = (study.clone(), study.approach.entries.len());
    study.approach.entries.retain(|entry| stays(&entry.place));
    let scenes = worlds.chunk_by(|one, next| one.scene == next.scene);
    scenes
        .map(|of_scene| {
            let name = of_scene[0].name.as_str();
            let is_first = of_scene[0].scene == first.scene;
            let mut warnings: Vec<String> = between.iter().filter(|_| is_first).cloned().collect();
            let ground = Ground::new(&study, of_scene, &[])?;
            if study.stopping.is_none() && !ground.walks() {
                return Ok((name, warnings));
            }
            let truths: Vec<Arc<Truth>> = of_scene.iter().map(|world| Company::Absent.truth(world)).collect();
            let moment = ApproachMoment::new(&ground, Company::Absent, of_scene, &truths)?;
            warnings.extend(too_near(&ground, &moment));
            // With all entries: others may lead to what these do not.
            if study.approach.entries.len() == entries {
                warnings.extend(traps(&ground, &moment));
            }
            Ok((name, warnings))
        })
        .collect()
}

/// The bodies that are thinner than the gaps between the rays of a sensor, within its range and the regions.
fn between_rays(study: &Study, world: &World) -> Vec<String> {
    let warning = |number: usize, body: &BodySpec| {
        let sensor = &study.sensors[number];
        let (spacing, range) = (sensor.kind.spacing()?, sensor.kind.range()?);
        let reach_m = match body.shape {
            BodyShape::Ball { diameter_m } => spacing.reach_of_ball_m(diameter_m),
            BodyShape::Cylinder { diameter_m, height_m } => spacing.reach_m([diameter_m, height_m]),
            BodyShape::Box { size_m: [x, y, z] } => spacing.reach_m([x.min(y), z]),
        };
        let [_, far_m] = range.range_m;
        (reach_m < far_m.min(world.farthest_m(number))).then(|| {
            format!(
                "sensor {:?}, body {:?}: it may pass between the rays farther than {} m away: cast more rays, mount the \
                 sensor nearer, or end range_m there",
                sensor.name,
                body.name,
                rounded_down(reach_m, 2)
            )
        })
    };
    let of_sensor = |number| study.approach.bodies.iter().filter_map(move |body| warning(number, body));
    (0..study.sensors.len()).flat_map(of_sensor).collect()
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
