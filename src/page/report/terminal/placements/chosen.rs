//! The compared placements: those of given names, or the best few by a score.

use super::sweeps::{FinishedSweep, Scope, Sweeps};
use crate::report::series::{Series, choice_names, series};
use perirobot_decide::view::names::{ChoiceNames, find_choices, unknown};
use perirobot_march::error::Argument;
use perirobot_march::metrics::Score;
use perirobot_march::{Error, Result};
use perirobot_sweep::results::over::Over;

/// A choice of poses in one representation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RankedPlacement {
    pub(super) sweep: usize,
    pub(super) series: Series,
    pub(super) choice: usize,
}

/// A filter of placements.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlacementFilter<'a> {
    /// The combination; any if `None`.
    pub combination: Option<&'a str>,
    /// The representation.
    pub representation: Option<&'a str>,
}

impl Sweeps {
    /// The placements of these names in every sweep that has them, each once, and the errors of the others.
    pub fn find_all(
        &self,
        poses: &[String],
        among: PlacementFilter,
    ) -> Result<(Vec<RankedPlacement>, Vec<Error>)> {
        let (mut found, mut left_out): (Vec<RankedPlacement>, Vec<Error>) = (Vec::new(), Vec::new());
        for poses in poses {
            let each = self.all.iter().enumerate().map(|(sweep, _)| self.find_by_name(sweep, poses, among));
            let (those, mut errors): (Vec<_>, Vec<_>) = each.partition(|one| one.is_ok());
            if those.is_empty()
                && let Some(Err(error)) = errors.pop()
            {
                return Err(error);
            }
            left_out.extend(errors.into_iter().filter_map(Result::err));
            for placement in those.into_iter().flatten().flatten() {
                if !found.contains(&placement) {
                    found.push(placement);
                }
            }
        }
        Ok((found, left_out))
    }

    fn find_by_name(
        &self,
        sweep: usize,
        poses: &str,
        among: PlacementFilter,
    ) -> Result<Vec<RankedPlacement>> {
        let FinishedSweep { folder, results, .. } = &self.all[sweep];
        let names: Vec<ChoiceNames> = results.combinations.iter().map(choice_names).collect();
        let found = find_choices(&names, poses, among.combination).map_err(|e| e.with_place(folder))?;
        let placement = |(combination, choice): (usize, usize)| {
            let known = &results.combinations[combination].representations;
            let representation =
                among.representation.map_or(Some(0), |name| known.iter().position(|k| k == name));
            let representation = representation
                .ok_or_else(|| unknown(Argument("representation"), among.representation, known));
            let series = Series { combination, representation: representation? };
            Ok(RankedPlacement { sweep, series, choice })
        };
        found.into_iter().map(placement).collect()
    }

    /// The best few placements of each sweep by a score in a region, of all combinations and representations
    /// together.
    pub fn best(
        &self,
        region: &str,
        score: Score,
        count: usize,
        among: PlacementFilter,
    ) -> Result<Vec<RankedPlacement>> {
        let mut placements = Vec::new();
        for (sweep, FinishedSweep { results, .. }) in self.all.iter().enumerate() {
            let Some(at) = results.regions.iter().position(|name| name == region) else { continue };
            let moments = self.scopes[0].moments[sweep].iter().copied();
            let mut best: Vec<(RankedPlacement, f64)> = Vec::new();
            for series in self.select(sweep, among)? {
                let few = series.best(results, &moments, at, score)?.into_iter().take(count);
                best.extend(few.map(|(choice, value)| (RankedPlacement { sweep, series, choice }, value)));
            }
            best.sort_by(|a, b| score.merit(b.1).total_cmp(&score.merit(a.1)));
            placements.extend(best.into_iter().take(count).map(|(placement, _)| placement));
        }
        Ok(placements)
    }

    /// The requested series of a sweep.
    fn select(&self, sweep: usize, among: PlacementFilter) -> Result<Vec<Series>> {
        let results = &self.all[sweep].results;
        let known: Vec<&str> = results.combinations.iter().map(|c| c.name.as_str()).collect();
        if let Some(name) = among.combination.filter(|name| !known.contains(name)) {
            return Err(unknown(Argument("combination"), Some(name), &known));
        }
        let is_requested =
            |c: &usize| among.combination.is_none_or(|name| results.combinations[*c].name == name);
        let all = series(results, (0..known.len()).filter(is_requested));
        let name = |one: &Series| &results.combinations[one.combination].representations[one.representation];
        let is_requested = |one: &&Series| among.representation.is_none_or(|wanted| wanted == name(one));
        let found: Vec<Series> = all.iter().filter(is_requested).copied().collect();
        match found.is_empty() {
            true => Err(unknown(
                Argument("representation"),
                among.representation,
                &all.iter().map(name).collect::<Vec<_>>(),
            )),
            false => Ok(found),
        }
    }

    /// A score of a placement.
    pub(super) fn score(
        &self,
        placement: &RankedPlacement,
        scope: &Scope,
        region: &str,
        score: Score,
    ) -> Result<Option<Over>> {
        let RankedPlacement { sweep, series, choice } = *placement;
        let results = &self.all[sweep].results;
        let Some(region) = results.regions.iter().position(|name| name == region) else { return Ok(None) };
        results.summarize(scope.moments[sweep].iter().copied(), series.key(choice, region), score)
    }
}
