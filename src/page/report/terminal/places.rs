//! The best places of an object among its candidates, for fixed sensors.

use crate::report::bound_note;
use crate::report::selection::ReportSelection;
use crate::report::series::rank;
use crate::report::table::{Table, number};
use perirobot_march::Result;
use perirobot_sweep::results::Results;

/// Places per list.
const SHOWN: usize = 3;

/// A table for each region and score: the places where a choice of poses has the best mean over their scenes, snapshots
/// and repeats, weighted if snapshots have weights, with that choice, and the worst place. Empty if no object has
/// candidate places.
pub fn render(results: &Results, selection: &ReportSelection) -> Result<String> {
    let places = results.places();
    if places.is_empty() {
        return Ok(String::new());
    }
    let is_weighted = results.dwell_s.is_some();
    let mut text = format!(
        "\nPLACES of [[candidate]]: where it should stand\n\
         The best {} of {} places, each by its best choice of poses, and the last. Mean and worst are over scenes, snapshots\n\
         and repeats at that place.\n",
        SHOWN.min(places.len()),
        places.len()
    );
    if is_weighted {
        text += "Weighted: the mean in which each snapshot weighs as long as it lasts (dwell_s of the scene); it ranks.\n";
    }
    for (score, region) in selection.parts() {
        let mut columns = vec!["<combination · representation", "<place"];
        columns.extend(is_weighted.then_some("weighted"));
        columns.extend(["mean", "worst", "pooled", "<poses", "<where"]);
        let mut table = Table::new(&columns);
        for series in selection.series(results) {
            let mut best = Vec::new();
            for place in &places {
                let moments = place.moments.iter().copied();
                let ranking = match is_weighted {
                    true => rank(
                        score,
                        series.weighted_mean(results, &moments, region, score)?.into_iter(),
                        &series.f1_means(results, &moments, region)?,
                    ),
                    false => series.best(results, &moments, region, score)?,
                };
                if let Some(&(choice, mean)) = ranking.first() {
                    best.push((place, choice, mean));
                }
            }
            best.sort_by(|a, b| score.merit(b.2).total_cmp(&score.merit(a.2)));
            let shown = best.iter().take(SHOWN).chain(best.iter().skip(SHOWN).next_back());
            for (rank, (place, choice, mean)) in shown.enumerate() {
                let moments = place.moments.iter().copied();
                let over = results.summarize(moments, series.key(*choice, region), score)?;
                let combination = &results.combinations[series.combination];
                let title = if rank == 0 { series.title(results) } else { String::new() };
                let last = if rank == SHOWN { " (the last)" } else { "" };
                let mut cells = vec![title, format!("{}{last}", place.name)];
                cells.extend(is_weighted.then(|| number(Some(*mean))));
                cells.extend([
                    number(over.map(|over| over.mean)),
                    number(over.map(|over| over.worst)),
                    number(over.and_then(|over| over.pooled)),
                    combination.label(*choice),
                    combination.place_of(*choice),
                ]);
                table.row(cells);
            }
        }
        text += &format!("\n{} in region {}\n{}", score.title(), results.regions[region], table.text());
        text += &bound_note(score);
    }
    Ok(text)
}
