//! Pictures of the scenes, and of the labels of the best choices of poses, by `render`.

use super::FiguredSweep;
use super::names::score_name;
use super::part::SweepPart;
use crate::render::{self, Colour, Wish};
use crate::report::series::Series;
use crate::report::table::number;
use perirobot_decide::view::{Choice, View};
use perirobot_march::Result;
use perirobot_march::backend::Backend;
use perirobot_sweep::results::Results;

/// Width and height in pixels, and the approximate number of dots.
const SIZE_PX: [u32; 2] = [800, 520];
const POINTS: usize = 1500;

/// The subject of a picture.
#[derive(Clone, Debug)]
pub(super) enum Pictured {
    /// A scene by its index, without sensors.
    Scene(usize),
    /// A choice of poses in the first drawn scene.
    Best {
        series: Series,
        choice: usize,
        scene: usize,
        /// `F1 in region robot: 0.173`, for each score that it maximises.
        by: Vec<String>,
    },
}

/// The best choice of each score in each region, over all combinations and representations, with words for its name;
/// equal choices share a picture.
pub(super) fn best(results: &Results, part: &SweepPart) -> Result<Vec<(Vec<String>, Pictured)>> {
    let mut found: Vec<(Vec<String>, Pictured)> = Vec::new();
    let whole = part.whole();
    let first = part.extents.iter().find_map(|extent| extent.scene).unwrap_or(0);
    for &region in &part.regions {
        for &score in &part.scores {
            let mut best: Option<(Series, usize, f64)> = None;
            for &series in &part.series {
                let ranked = series.best(results, &whole.moments, region, score)?;
                let Some(&(one, value)) = ranked.first() else { continue };
                if best.is_none_or(|(.., known)| score.merit(value) > score.merit(known)) {
                    best = Some((series, one, value));
                }
            }
            let Some((series, choice, value)) = best else { continue };
            let place = &results.regions[region];
            let reason = format!("{} in region {place} ({})", score_name(score), number(Some(value)));
            let known = found.iter_mut().find_map(|(_, pictured)| match pictured {
                Pictured::Best { series: s, choice: c, by, .. } if (*s, *c) == (series, choice) => Some(by),
                _ => None,
            });
            match known {
                Some(by) => by.push(reason),
                None => found.push((
                    vec!["best".into(), score.name().into(), place.clone()],
                    Pictured::Best { series, choice, scene: first, by: vec![reason] },
                )),
            }
        }
    }
    Ok(found)
}

/// The caption and the file of a picture.
pub(super) fn draw(
    sweep: &FiguredSweep,
    pictured: &Pictured,
    backend: &mut dyn Backend,
) -> Result<(String, Vec<u8>)> {
    let FiguredSweep { results, study, worlds, .. } = sweep;
    let plain = Wish { size_px: SIZE_PX, points: POINTS, ..Wish::default() };
    match pictured {
        Pictured::Scene(scene) => {
            let world = &worlds[results.scenes[*scene].moments.start];
            let bytes = render::draw(world, None, &plain, backend)?.png()?;
            Ok((format!("Scene {}, by role.", world.title(study)), bytes))
        }
        Pictured::Best { series, choice, scene, by } => {
            let world = &worlds[results.scenes[*scene].moments.start];
            let Series { combination, representation } = *series;
            let shown = Choice { combination, choice: *choice, representation, repeat: 0 };
            let view = View::new(study, world, shown, backend)?;
            let wish = Wish { colour: Colour::Label, ..plain };
            let bytes = render::draw(world, Some(&view), &wish, backend)?.png()?;
            let found = &results.combinations[combination];
            let caption = format!(
                "The best choice of poses by {}: {} ({}), as {}, in scene {}.",
                by.join(", by "),
                found.name_of(*choice),
                found.place_of(*choice),
                series.title(results),
                world.title(study),
            );
            Ok((caption, bytes))
        }
    }
}
