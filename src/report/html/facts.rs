//! The words and tables of the page that need no script: the best placements and how to mount them, what was
//! assumed, what was run. They are what a printed report holds.

mod best;
mod mount;
mod run;

use super::ReportedSweep;
use super::cells::Cells;
use super::ranking::Ranking;
use super::surroundings::Surroundings;
use crate::Result;
use crate::metrics::Score;
use crate::report::distribution;
use crate::report::maxima;
use crate::report::maxima::most_sensors;
use crate::report::table::number;

/// What the template shows.
#[derive(Debug)]
pub(super) struct Facts<'a> {
    pub(super) study: String,
    pub(super) extent: String,
    pub(super) assumed: Vec<String>,
    pub(super) regions: Vec<best::RegionBest<'a>>,
    pub(super) run: run::RunFacts,
    pub(super) distributions: Vec<Plain>,
    pub(super) maxima: Vec<Plain>,
    pub(super) moves: bool,
}

/// A table of words and numbers.
#[derive(Debug)]
pub(super) struct Plain {
    pub(super) title: String,
    pub(super) columns: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

impl<'a> Facts<'a> {
    pub(super) fn new(
        sweep: &ReportedSweep<'a>,
        rankings: &[Ranking],
        cells: &'a Cells,
        surroundings: &Surroundings,
    ) -> Result<Facts<'a>> {
        let ReportedSweep { results, study, .. } = *sweep;
        Ok(Facts {
            study: study.path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            extent: crate::report::best::extent(results),
            assumed: run::assumed(sweep),
            regions: (0..results.regions.len())
                .map(|region| best::region(sweep, rankings, (cells, surroundings), region))
                .collect::<Result<_>>()?,
            run: run::run(sweep),
            distributions: distributions(sweep, rankings)?,
            maxima: maxima_tables(sweep)?,
            moves: results.moments().len() > results.scenes.len(),
        })
    }
}

/// The scores in each region.
fn parts(sweep: &ReportedSweep) -> impl Iterator<Item = (usize, Score)> {
    let regions = 0..sweep.results.regions.len();
    regions.flat_map(|region| Score::ALL.map(|score| (region, score)))
}

fn title(sweep: &ReportedSweep, (region, score): (usize, Score)) -> String {
    format!("{} in region {}", score.title(), sweep.results.regions[region])
}

fn distributions(sweep: &ReportedSweep, rankings: &[Ranking]) -> Result<Vec<Plain>> {
    let results = sweep.results;
    let table = |part: (usize, Score)| {
        let mut rows: Vec<Vec<String>> = Vec::new();
        for scene in &results.scenes {
            for ranking in rankings {
                let values = ranking.series.over(results, &scene.moments, part.0, part.1)?;
                let values = values.into_iter().flatten().map(|over| over.mean).collect();
                let d = distribution::distribution(values);
                let five = d.map(|d| [d.min, d.lower_quartile, d.median, d.upper_quartile, d.max]);
                let five = five.map_or([None; 5], |five| five.map(Some)).map(number);
                let n = d.map_or(0, |d| d.values).to_string();
                let names = [scene.name.clone(), ranking.series.title(results), n];
                rows.push(names.into_iter().chain(five).collect());
            }
        }
        let columns = [
            "scene",
            "sensors · representation",
            "poses",
            "min",
            "lower quartile",
            "median",
            "upper quartile",
            "max",
        ];
        Ok(Plain { title: title(sweep, part), columns: columns.map(String::from).into(), rows })
    };
    parts(sweep).map(table).collect()
}

fn maxima_tables(sweep: &ReportedSweep) -> Result<Vec<Plain>> {
    let results = sweep.results;
    // Sensors alone are compared in the first table.
    if results.combinations.len() < 2 || results.combinations.iter().all(|c| c.members.len() < 2) {
        return Ok(Vec::new());
    }
    let full = most_sensors(results);
    let table = |part: (usize, Score)| {
        let of = |combination| maxima::maxima(results, combination, part.0, part.1);
        let of_full = full.map(of).transpose()?.and_then(|maxima| maxima.mean);
        let rows = (0..results.combinations.len()).map(|combination| {
            let found = of(combination)?;
            let scenes = found.scenes.iter().map(|maximum| number(maximum.map(|m| m.value)));
            let last = [number(found.mean), number(maxima::relative(found.mean, of_full))];
            let name = results.combinations[combination].name.clone();
            Ok([name].into_iter().chain(scenes).chain(last).collect())
        });
        let scenes = results.scenes.iter().map(|scene| scene.name.clone());
        let columns = ["sensors".to_string()].into_iter().chain(scenes);
        let relative =
            full.map_or("relative".into(), |full| format!("relative to {}", results.combinations[full].name));
        let columns = columns.chain(["mean".into(), relative]).collect();
        Ok(Plain { title: title(sweep, part), columns, rows: rows.collect::<Result<_>>()? })
    };
    parts(sweep).map(table).collect()
}
