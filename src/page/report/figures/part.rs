//! The part of a sweep in figures, and its scenes.

use std::ops::Range;

use super::FigureKind;
use crate::report::bounds::{best_without_sensor, upper_bound};
use crate::report::selection::ReportSelection;
use crate::report::series::Series;
use crate::report::wording::extent;
use perirobot_decide::view::names::unknown;
use perirobot_march::Result;
use perirobot_march::error::Argument;
use perirobot_march::metrics::Score;
use perirobot_sweep::results::Results;

/// With more scenes, only their mean is drawn.
const MOST_SCENES: usize = 12;

/// The requested part of a sweep; everything that is not named.
#[derive(Clone, Debug)]
pub struct WantedPart<'a> {
    /// Kinds of figures.
    pub kinds: Vec<FigureKind>,
    /// The region.
    pub region: Option<&'a str>,
    /// The combination.
    pub combination: Option<&'a str>,
    /// The representation.
    pub representation: Option<&'a str>,
    /// The scene.
    pub scene: Option<&'a str>,
    /// Scores, drawn side by side.
    pub scores: &'a [Score],
}

/// The same as indices of a sweep.
pub(super) struct SweepPart {
    pub(super) regions: Vec<usize>,
    pub(super) combinations: Vec<usize>,
    pub(super) series: Vec<Series>,
    pub(super) scores: Vec<Score>,
    /// All scenes together if there are several, then each; or the requested one.
    pub(super) extents: Vec<SceneRange>,
}

/// The scenes of a score.
#[derive(Clone, Debug)]
pub(super) struct SceneRange {
    /// The name in figures.
    pub(super) name: String,
    pub(super) moments: Range<usize>,
    /// The scene, if it is one.
    pub(super) scene: Option<usize>,
}

impl SweepPart {
    pub(super) fn new(results: &Results, wanted: &WantedPart) -> Result<SweepPart> {
        let selection = ReportSelection::resolve(results, wanted.region, wanted.combination, wanted.scores)?;
        let name = |one: &Series| &results.combinations[one.combination].representations[one.representation];
        let all = selection.series(results);
        let is_requested = |one: &&Series| wanted.representation.is_none_or(|wanted| wanted == name(one));
        let series: Vec<Series> = all.iter().filter(is_requested).copied().collect();
        if series.is_empty() {
            let mut known: Vec<&String> = all.iter().map(name).collect();
            known.dedup();
            return Err(unknown(Argument("representation"), wanted.representation, &known));
        }
        let ReportSelection { regions, combinations, scores } = selection;
        Ok(SweepPart { regions, combinations, series, scores, extents: extents(results, wanted.scene)? })
    }

    /// The first extent.
    pub(super) fn whole(&self) -> &SceneRange {
        &self.extents[0]
    }
}

fn extents(results: &Results, wanted: Option<&str>) -> Result<Vec<SceneRange>> {
    let of_scene = |scene: usize| {
        let found = &results.scenes[scene];
        SceneRange { name: found.name.clone(), moments: found.moments.clone(), scene: Some(scene) }
    };
    if let Some(name) = wanted {
        let known: Vec<&str> = results.scenes.iter().map(|scene| scene.name.as_str()).collect();
        let found = known.iter().position(|known| *known == name);
        let found = found.ok_or_else(|| unknown(Argument("scene"), Some(name), &known))?;
        return Ok(vec![of_scene(found)]);
    }
    let count = results.scenes.len();
    if count == 1 {
        return Ok(vec![of_scene(0)]);
    }
    let name = format!("mean of {count} scenes");
    let all = SceneRange { name, moments: results.moments(), scene: None };
    let each = (0..count).map(of_scene).filter(|_| count <= MOST_SCENES);
    Ok([all].into_iter().chain(each).collect())
}

impl SceneRange {
    /// The values in the mean of a score: `3 scenes, 10 repeats`.
    pub(super) fn is_mean_of(&self, results: &Results) -> String {
        let Some(scene) = self.scene else { return format!("the mean over {}", extent(results)) };
        let (name, moments) = (&results.scenes[scene].name, self.moments.len());
        let several = [(moments, "snapshots"), (results.repeats, "repeats")];
        let several: Vec<String> =
            several.iter().filter(|(n, _)| *n > 1).map(|(n, what)| format!("{n} {what}")).collect();
        match several.is_empty() {
            true => format!("what is counted in scene {name}"),
            false => format!("the mean over {} of scene {name}", several.join(" and ")),
        }
    }

    /// The upper bound and the best baseline, in words.
    pub(super) fn bounds(&self, results: &Results, region: usize, score: Score) -> String {
        let bound = upper_bound(results, self.moments.clone(), region, score);
        let bound = bound.map(|bound| format!("possible at most {bound:.3}"));
        let without = self.best_baseline(results, region, score);
        let without = without.map(|(name, value)| format!("without a sensor {value:.3} ({name})"));
        bound.into_iter().chain(without).collect::<Vec<_>>().join(" · ")
    }

    /// The best baseline without sensors.
    pub(super) fn best_baseline(
        &self,
        results: &Results,
        region: usize,
        score: Score,
    ) -> Option<(&'static str, f64)> {
        best_without_sensor(results, self.moments.clone(), region, score)
    }
}
