//! The words, drawings and tables of the page that need no script: what is recommended and how to mount it, whether
//! it is good enough, what was assumed, what was run. They are what a printed report holds.

pub(super) mod answer;
pub(super) mod best;
pub(super) mod front;
pub(super) mod good;
pub(super) mod mount;
mod near;
mod run;
mod sketch;
pub(super) mod verdicts;

use super::ReportedSweep;
use super::cells::{Asked, Cells};
use super::judged::Judged;
use super::ranking::{Ranking, maxima_of};
use super::recommended::Recommended;
use super::surroundings::Surroundings;
use crate::report::maxima::most_sensors;
use crate::report::reasons::Explained;
use crate::report::table::Table;
use crate::report::{PLAIN_MEANS, distribution, maxima};
use perirobot_decide::approach::Way;
use perirobot_march::Result;
use perirobot_march::metrics::Score;

/// A table and its title.
pub(super) type Titled = (String, Table);

/// What the page shows.
#[derive(Debug)]
pub(super) struct Facts<'a> {
    pub(super) title: String,
    /// The study's name, in a string of a style sheet, and the day: they stand on each page in print.
    pub(super) study_in_css: String,
    pub(super) day: String,
    /// The first screen; `None` where no choice has a score.
    pub(super) answer: Option<answer::Answer>,
    pub(super) sheets: Vec<mount::Sheet>,
    pub(super) missed: Vec<(String, &'a Explained)>,
    pub(super) good: good::Good,
    pub(super) assumed: Vec<String>,
    pub(super) regions: Vec<best::RegionBest<'a>>,
    pub(super) run: run::RunFacts,
    pub(super) distributions: Vec<Titled>,
    pub(super) maxima: Vec<Titled>,
    pub(super) moves: bool,
    /// What is said of means where snapshots have weights.
    pub(super) plain_means: Option<&'static str>,
    /// Of sets that were chosen.
    pub(super) front: Option<front::FrontFacts>,
}

impl<'a> Facts<'a> {
    pub(super) fn new(
        sweep: &ReportedSweep<'a>,
        (rankings, recommended, judged): (&[Ranking], Option<&Recommended>, &[Judged]),
        (cells, near): (&'a Cells, &[Vec<Way>]),
        surroundings: &Surroundings,
    ) -> Result<Facts<'a>> {
        let ReportedSweep { results, study, .. } = *sweep;
        let sheets = recommended.map(|one| {
            mount::sheets(sweep, surroundings, rankings[one.series].series.combination, one.choice)
        });
        Ok(Facts {
            title: answer::title(sweep),
            study_in_css: in_css(&study.path.file_stem().unwrap_or_default().to_string_lossy()),
            day: run::now("%Y-%m-%d"),
            answer: recommended.map(|one| answer::answer(sweep, rankings, one, near)).transpose()?,
            sheets: sheets.unwrap_or_default(),
            missed: best::missed(results, cells, Asked::Recommended),
            good: recommended
                .map(|one| good::good(sweep, (rankings, one), judged))
                .transpose()?
                .unwrap_or_default(),
            assumed: run::assumed(sweep),
            regions: (0..results.regions.len())
                .map(|region| best::region(sweep, rankings, (cells, surroundings), region))
                .collect::<Result<_>>()?,
            run: run::run(sweep),
            distributions: distributions(sweep, rankings),
            maxima: maxima_tables(sweep, rankings),
            plain_means: results.dwell_s.as_ref().map(|_| PLAIN_MEANS),
            moves: results.moments().len() > results.scenes.len(),
            front: sweep.chosen.map(front::front),
        })
    }
}

/// Words in a string of a style sheet: what is no letter or digit is spelt by its number.
fn in_css(words: &str) -> String {
    let spelt = |letter: char| match letter.is_ascii_alphanumeric() || letter == ' ' {
        true => letter.to_string(),
        false => format!("\\{:x} ", u32::from(letter)),
    };
    words.chars().map(spelt).collect()
}

/// The scores in each region.
fn parts(sweep: &ReportedSweep) -> impl Iterator<Item = (usize, Score)> {
    let regions = 0..sweep.results.regions.len();
    regions.flat_map(|region| Score::ALL.map(|score| (region, score)))
}

fn title(sweep: &ReportedSweep, (region, score): (usize, Score)) -> String {
    format!("{} in region {}", score.title(), sweep.results.regions[region])
}

fn distributions(sweep: &ReportedSweep, rankings: &[Ranking]) -> Vec<Titled> {
    let results = sweep.results;
    let table = |(region, score): (usize, Score)| {
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
        for (number, scene) in results.scenes.iter().enumerate() {
            for ranking in rankings {
                let found = ranking.spread(region, number, score).map(|spread| spread.distribution);
                table.row(distribution::row(results, scene, ranking.series, found));
            }
        }
        (title(sweep, (region, score)), table)
    };
    parts(sweep).map(table).collect()
}

fn maxima_tables(sweep: &ReportedSweep, rankings: &[Ranking]) -> Vec<Titled> {
    let results = sweep.results;
    // Sensors alone are compared in the first table.
    if results.combinations.len() < 2 || results.combinations.iter().all(|c| c.members.len() < 2) {
        return Vec::new();
    }
    let full = most_sensors(results);
    let relative =
        full.map_or("relative".into(), |full| format!("relative to {}", results.combinations[full].name));
    let scenes: Vec<String> = results.scenes.iter().map(|scene| format!(">{}", scene.name)).collect();
    let scenes = scenes.iter().map(String::as_str);
    let columns: Vec<&str> = ["<sensors"].into_iter().chain(scenes).chain(["mean", &relative]).collect();
    let table = |part: (usize, Score)| {
        let of = |combination| maxima_of(results, rankings, combination, part);
        let of_full = full.and_then(|full| of(full).mean);
        let mut table = Table::new(&columns);
        for combination in 0..results.combinations.len() {
            table.row(maxima::row(results, &of(combination), of_full));
        }
        (title(sweep, part), table)
    };
    parts(sweep).map(table).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn nothing_ends_a_string_of_a_style_sheet() {
        assert_eq!(super::in_css("my cell"), "my cell");
        assert_eq!(super::in_css("a\"</b>-ü"), "a\\22 \\3c \\2f b\\3e \\2d \\fc ");
    }
}
