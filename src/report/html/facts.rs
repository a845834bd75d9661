//! The words and tables of the page that need no script: the best placements and how to mount them, what was
//! assumed, what was run. They are what a printed report holds.

mod best;
mod front;
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
use crate::report::table::Table;

/// A table and its title.
pub(super) type Titled = (String, Table);

/// What the template shows.
#[derive(Debug)]
pub(super) struct Facts<'a> {
    pub(super) study: String,
    pub(super) extent: String,
    pub(super) assumed: Vec<String>,
    pub(super) regions: Vec<best::RegionBest<'a>>,
    pub(super) run: run::RunFacts,
    pub(super) distributions: Vec<Titled>,
    pub(super) maxima: Vec<Titled>,
    pub(super) moves: bool,
    /// Of sets that were chosen.
    pub(super) front: Option<front::FrontFacts>,
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
            front: sweep.chosen.map(front::front),
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

fn distributions(sweep: &ReportedSweep, rankings: &[Ranking]) -> Result<Vec<Titled>> {
    let results = sweep.results;
    let table = |part: (usize, Score)| {
        let mut table = Table::new(&[
            "<scene",
            "<sensors · representation",
            "poses",
            "min",
            "lower quartile",
            "median",
            "upper quartile",
            "max",
        ]);
        for scene in &results.scenes {
            for ranking in rankings {
                table.row(distribution::row(results, scene, ranking.series, part)?);
            }
        }
        Ok((title(sweep, part), table))
    };
    parts(sweep).map(table).collect()
}

fn maxima_tables(sweep: &ReportedSweep) -> Result<Vec<Titled>> {
    let results = sweep.results;
    // Sensors alone are compared in the first table.
    if results.combinations.len() < 2 || results.combinations.iter().all(|c| c.members.len() < 2) {
        return Ok(Vec::new());
    }
    let full = most_sensors(results);
    let relative =
        full.map_or("relative".into(), |full| format!("relative to {}", results.combinations[full].name));
    let scenes: Vec<String> = results.scenes.iter().map(|scene| format!(">{}", scene.name)).collect();
    let scenes = scenes.iter().map(String::as_str);
    let columns: Vec<&str> = ["<sensors"].into_iter().chain(scenes).chain(["mean", &relative]).collect();
    let table = |part: (usize, Score)| {
        let of = |combination| maxima::maxima(results, combination, part.0, part.1);
        let of_full = full.map(of).transpose()?.and_then(|maxima| maxima.mean);
        let mut table = Table::new(&columns);
        for combination in 0..results.combinations.len() {
            table.row(maxima::row(results, &of(combination)?, of_full));
        }
        Ok((title(sweep, part), table))
    };
    parts(sweep).map(table).collect()
}
