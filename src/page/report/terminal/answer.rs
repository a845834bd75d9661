//! The first answer of a sweep: the best choice of poses of each sensor and combination by the study's question, with
//! the upper bound of all positions and the scores of trivial answers.

use crate::report::NEAR_SIDE;
use crate::report::best_choice::AskedScore;
use crate::report::series::{Series, rank, series};
use crate::report::table::{NONE, Table, number};
use crate::report::wording::extent;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_study::input::Study;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::over::Over;

/// Most sensors and combinations, times representations, with a line.
const MOST_LINES: usize = 10;

/// The scores of every answer.
const SCORES: [Score; 4] = [Score::PartsDetected, Score::HumanSeen, Score::Kappa, Score::F1];

/// The best choice of poses of a sensor or a combination.
struct BestChoice {
    series: Series,
    choice: Option<usize>,
    /// The scores of the columns.
    scores: Vec<Option<Over>>,
    /// The number of its choices with an F1 below that of a sensor stuck at `occupied`.
    below: usize,
}

/// The answer, over all scenes, snapshots and repeats.
///
/// # Errors
/// Those of a journal that cannot be read.
pub fn render(study: &Study, results: &Results) -> Result<String> {
    let AskedScore { region, score, source } = AskedScore::new(study, results);
    let baselines = |score: Score| results.baselines_over(results.moments(), region, score);
    // Without people some scores have no value anywhere.
    let has_value = |score: Score| baselines(score)[0].1.is_some_and(|over| over.values > 0);
    let others = SCORES.into_iter().filter(|&other| other != score && has_value(other));
    let scores: Vec<Score> = std::iter::once(score).chain(others).collect();
    let f1_of = |name: &str| {
        let all = baselines(Score::F1);
        all.into_iter().find(|(known, _)| *known == name).and_then(|(_, over)| Some(over?.mean))
    };
    let stuck = f1_of(STUCK);
    let all = series(results, 0..results.combinations.len());
    let best = |&series: &Series| best(results, series, (region, &scores), stuck);
    let best = all.iter().map(best).collect::<Result<Vec<_>>>()?;
    let is_several = results.moments().len() * results.repeats > 1;
    let mut header = vec!["<".to_string()];
    for (number, score) in scores.iter().enumerate() {
        header.push(score.title().into());
        header.extend((number == 0 && is_several).then(|| "worst".into()));
    }
    header.extend(["<poses", "<place"].map(String::from));
    let mut table = Table::new(&header.iter().map(String::as_str).collect::<Vec<_>>());
    let cells = |scores: &[Option<Over>]| {
        let mut cells: Vec<String> = scores.iter().map(|over| number(over.map(|over| over.mean))).collect();
        if is_several {
            cells.insert(1, number(scores[0].map(|over| over.worst)));
        }
        cells
    };
    for one in best.iter().take(MOST_LINES) {
        let combination = &results.combinations[one.series.combination];
        // For several sensors the names must suffice.
        let place = |choice| match combination.members.as_slice() {
            [_] => combination.place_of(choice),
            _ => String::new(),
        };
        let (poses, place) = one
            .choice
            .map_or((NONE.into(), String::new()), |choice| (combination.label(choice), place(choice)));
        let title = one.series.title(results);
        table.row(std::iter::once(title).chain(cells(&one.scores)).chain([poses, place]));
    }
    for (number, meaning) in TRIVIAL {
        let values: Vec<_> = scores.iter().map(|&score| baselines(score)[number].1).collect();
        table
            .row(std::iter::once(meaning.into()).chain(cells(&values)).chain([String::new(), String::new()]));
    }
    let name = &results.regions[region];
    let mut text =
        format!("\nBest poses by {} in region {name}{source}; {}\n", score.title(), extent(results));
    text += &table.text();
    if best.len() > MOST_LINES {
        let more = best.len() - MOST_LINES;
        text += &format!("  and {more} more\n");
    }
    let below: usize = best.iter().map(|one| one.below).sum();
    if let Some(stuck) = stuck.filter(|_| below > 0 && study.requirements.is_empty()) {
        let choices: usize = all.iter().map(|one| results.combinations[one.combination].choices()).sum();
        text += &format!(
            "\nA sensor stuck at \"occupied\" has F1 {stuck:.3}, and {below} of {choices} placements have less: compare kappa\n\
             or parts_detected, which are 0 for it.\n"
        );
    }
    if scores.contains(&Score::HumanSeen) {
        text += &format!("\n{NEAR_SIDE}\n");
    }
    Ok(text)
}

/// The trivial answer of a useless sensor.
const STUCK: &str = "all occupied";

/// The printed baselines, with their names.
const TRIVIAL: [(usize, &str); 2] = [(0, "all positions together"), (1, "stuck at \"occupied\"")];

/// The best choice by the first score.
fn best(
    results: &Results,
    series: Series,
    (region, scores): (usize, &[Score]),
    stuck: Option<f64>,
) -> Result<BestChoice> {
    let moments = results.moments();
    let (by, f1) = (
        series.summarize(results, &moments, region, scores[0])?,
        series.summarize(results, &moments, region, Score::F1)?,
    );
    let mean = |over: &Option<Over>| Some(over.as_ref()?.mean);
    let f1_means: Vec<Option<f64>> = f1.iter().map(mean).collect();
    let choice = rank(scores[0], by.iter().map(mean), &f1_means).first().map(|(choice, _)| *choice);
    let below = f1.iter().flatten().filter(|over| stuck.is_some_and(|stuck| over.mean < stuck)).count();
    let scores = scores.iter().map(|&score| match choice {
        Some(choice) => results.summarize(moments.clone(), series.key(choice, region), score),
        None => Ok(None),
    });
    Ok(BestChoice { series, choice, scores: scores.collect::<Result<_>>()?, below })
}
