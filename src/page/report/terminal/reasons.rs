//! Why voxels of the regions stay unknown, with advice, for the best choices or for one.

use crate::report::explained::{Advice, Explained, explain};
use crate::report::reasons_file::names;
use crate::report::series::{Series, ValueAndF1, compare_merit, series};
use crate::report::table::Table;
use perirobot_decide::view::why::{CauseTally, Missed};
use perirobot_decide::view::{Choice, View};
use perirobot_march::Result;
use perirobot_march::metrics::{Confusion, Score};
use perirobot_study::world::place::Places;
use perirobot_sweep::results::Results;

/// The best choices by some scores over all scenes, snapshots and repeats, this many of each combination and
/// representation in each region, without duplicates: combination, choice and representation, in study order.
pub fn leaders(results: &Results, count: usize, scores: &[Score]) -> Result<Vec<[usize; 3]>> {
    let mut leaders = Vec::new();
    for one in series(results, 0..results.combinations.len()) {
        for region in 0..results.regions.len() {
            for &score in scores {
                let Series { combination, representation } = one;
                let best = one.best(results, &results.moments(), region, score)?;
                leaders.extend(
                    best.into_iter().take(count).map(|(choice, _)| [combination, choice, representation]),
                );
            }
        }
    }
    leaders.sort_unstable();
    leaders.dedup();
    Ok(leaders)
}

/// The best of all choices by a score in a region: combination, choice and representation; `None` if none has a value.
pub fn leader(results: &Results, region: usize, score: Score) -> Result<Option<[usize; 3]>> {
    let mut leader: Option<([usize; 3], ValueAndF1)> = None;
    for one in series(results, 0..results.combinations.len()) {
        let best = one.best(results, &results.moments(), region, score)?;
        let Some(&(choice, mean)) = best.first() else { continue };
        let f1 = results.summarize(results.moments(), one.key(choice, region), Score::F1)?;
        let own = (mean, f1.map(|over| over.mean));
        if leader.is_none_or(|(_, most)| compare_merit(score, own, most).is_gt()) {
            leader = Some(([one.combination, choice, one.representation], own));
        }
    }
    Ok(leader.map(|(choice, _)| choice))
}

/// The missed voxels of a view in some regions, with reasons and advice.
pub fn render(view: &View, missed: &[Missed], regions: impl IntoIterator<Item = usize>) -> String {
    let [combination, poses, representation] = names(view);
    let Choice { repeat, .. } = view.choice;
    let again = if view.study.repeats > 1 { format!(", repeat {repeat}") } else { String::new() };
    let spec = &view.study.combinations[view.choice.combination];
    let place = Places::new(view.study, view.world).describe_choice(spec, view.choice.choice);
    let mut text = format!(
        "\n{poses} · {combination} · {representation} · scene {}{again}\n",
        view.world.title(view.study)
    );
    if !place.is_empty() {
        text += &format!("{place}\n");
    }
    for region in regions {
        text += &region_reasons(
            view,
            &view.study.regions[region].0,
            &view.counts(region),
            view.tally(missed, region),
        );
    }
    text
}

fn region_reasons(view: &View, region: &str, counts: &Confusion, tallies: Vec<CauseTally>) -> String {
    let explained = explain(view, counts, tallies);
    let [reason, object, numbers @ ..] = explained.columns();
    let columns: Vec<String> = [reason, object]
        .map(|name| format!("<{name}"))
        .into_iter()
        .chain(numbers.map(String::from))
        .collect();
    let Explained { headline, rows, monitored, advice, .. } = explained;
    let mut text = format!("\n{region} region: {headline}\n");
    if rows.is_empty() {
        return text;
    }
    let mut table = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
    rows.into_iter().for_each(|row| table.row(row));
    text += &table.text();
    text += &format!("  {monitored}\n");
    for Advice { cause, cure, .. } in advice {
        text += &format!("  {cause}: {cure}\n");
    }
    text
}
