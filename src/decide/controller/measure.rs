//! What is measured of several sets of sensors at every moment.

use super::separation::{Separation, Surroundings};
use crate::view::{Choice, Viewer};
use perirobot_march::backend::Backend;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_study::study::Study;
use perirobot_study::world::World;
use perirobot_sweep::sweep::Watch;

/// What is measured of each set: repeat by repeat, and in each repeat world by world. A set is a choice of the study, in
/// all of its repeats; `None` is one of which no sensor speaks. Distances from the robot are computed once for each world.
///
/// # Errors
/// When the backend fails; `Error::Stopped`.
pub(crate) fn measure(
    study: &Study,
    worlds: &[World],
    sets: &[Option<Choice>],
    backend: &mut dyn Backend,
    watch: &mut dyn Watch,
) -> Result<Vec<Vec<Separation>>> {
    let repeats = study.repeats as usize;
    let mut measured = vec![vec![Separation::default(); worlds.len() * repeats]; sets.len()];
    let mut viewer = Viewer::new(study, backend)?;
    for (number, world) in worlds.iter().enumerate() {
        let surroundings = Surroundings::new(world);
        for (set, of_set) in sets.iter().zip(&mut measured) {
            for repeat in 0..repeats {
                if let Some(why) = watch.stop() {
                    return Err(Error::Stopped(Issue::says(why)));
                }
                let view = set.map(|choice| viewer.view(world, Choice { repeat, ..choice })).transpose()?;
                of_set[repeat * worlds.len() + number] =
                    surroundings.separation(view.as_ref().map(|view| &view.labels));
                watch.finished(1);
            }
        }
    }
    Ok(measured)
}
