//! Measured distances for several sets of sensors at every moment.

use super::separation::{MeasuredSurroundings, Separation};
use crate::view::{Choice, Viewer};
use perirobot_march::Result;
use perirobot_march::backend::Backend;
use perirobot_march::progress::Progress;
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// The measured distances of each set: repeat by repeat, and then world by world. A set is a choice of the study, in
/// all of its repeats; `None` is a set without active sensors. Distances from the robot are computed once for each
/// world.
///
/// # Errors
/// If the backend fails; `Error::Stopped`.
pub(crate) fn measure(
    study: &Study,
    worlds: &[World],
    sets: &[Option<Choice>],
    backend: &mut dyn Backend,
    progress: &dyn Progress,
) -> Result<Vec<Vec<Separation>>> {
    let repeats = study.repeats as usize;
    let mut measured = vec![vec![Separation::default(); worlds.len() * repeats]; sets.len()];
    let mut viewer = Viewer::new(study, backend)?;
    for (number, world) in worlds.iter().enumerate() {
        let surroundings = MeasuredSurroundings::new(world);
        for (set, of_set) in sets.iter().zip(&mut measured) {
            for repeat in 0..repeats {
                progress.check_stop()?;
                let view = set.map(|choice| viewer.view(world, Choice { repeat, ..choice })).transpose()?;
                of_set[repeat * worlds.len() + number] =
                    surroundings.separation(view.as_ref().map(|view| &view.labels));
                progress.advance(1);
            }
        }
    }
    Ok(measured)
}
