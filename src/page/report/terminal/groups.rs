//! The best pose of each group of poses (a wall, the ceiling), and the group with the best of all. Only for
//! combinations in which one sensor has poses, since several sensors are not on one wall.

use std::ops::Range;

use crate::report::selection::ReportSelection;
use crate::report::series::Series;
use crate::report::table::{Table, number};
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_sweep::results::Results;

/// The best choice of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupBest {
    /// Name of the group.
    pub group: String,
    /// Index of the choice, and its mean over the moments; `None` if no choice has a value.
    pub best: Option<(usize, f64)>,
    /// Whether no other group has a better one.
    pub overall: bool,
}

/// The best of each group of a combination's poses, in study order, over some moments.
pub(crate) fn groups(
    results: &Results,
    [combination, representation, region]: [usize; 3],
    moments: &Range<usize>,
    score: Score,
) -> Result<Vec<GroupBest>> {
    let combined = &results.combinations[combination];
    let group = |choice: usize| combined.group_of(choice);
    let mut groups: Vec<GroupBest> = Vec::new();
    for name in (0..combined.choices()).filter_map(group) {
        // Poses of a group are consecutive, so the last group is usually the one.
        if !groups.iter().rev().any(|known| known.group == name) {
            groups.push(GroupBest { group: name.into(), best: None, overall: false });
        }
    }
    let best = Series { combination, representation }.best(results, moments, region, score)?;
    for entry in &mut groups {
        entry.best = best.iter().copied().find(|&(choice, _)| group(choice) == Some(entry.group.as_str()));
    }
    let most = best.first().map(|&(_, value)| value);
    groups.iter_mut().for_each(|entry| entry.overall = most.is_some() && entry.best.map(|b| b.1) == most);
    Ok(groups)
}

/// A table for each region and score; empty if no combination has several groups.
pub fn render(results: &Results, selection: &ReportSelection) -> Result<String> {
    let several = |series: &Series| {
        let combined = &results.combinations[series.combination];
        let mut groups = (0..combined.choices()).map(|choice| combined.group_of(choice));
        let first = groups.next().flatten();
        first.is_some() && groups.any(|group| group != first)
    };
    let all: Vec<Series> = selection.series(results).into_iter().filter(several).collect();
    if all.is_empty() {
        return Ok(String::new());
    }
    let mut text = String::from(
        "\nBEST POSE OF EACH GROUP (the paper's maps of walls and ceiling, Experiments 1 and 3)\n\
         By mean over snapshots and repeats; * marks the group that holds the best pose of all.\n",
    );
    for (score, region) in selection.parts() {
        let mut table = Table::new(&[
            "<scene",
            "<combination · representation",
            "<group",
            "best",
            "<",
            "<pose",
            "<place",
        ]);
        for scene in &results.scenes {
            for series in &all {
                let which = [series.combination, series.representation, region];
                let found = groups(results, which, &scene.moments, score)?;
                for (i, GroupBest { group, best, overall }) in found.into_iter().enumerate() {
                    let names = [scene.name.clone(), series.title(results)];
                    let names = if i == 0 { names } else { Default::default() };
                    let combination = &results.combinations[series.combination];
                    let pose =
                        best.map(|(choice, _)| [combination.label(choice), combination.place_of(choice)]);
                    let mark = if overall { "*" } else { "" };
                    let cells = [group, number(best.map(|b| b.1)), mark.into()];
                    table.row(names.into_iter().chain(cells).chain(pose.into_iter().flatten()));
                }
            }
            for (name, over) in results.baselines_over(scene.moments.clone(), region, score) {
                let what = [String::new(), String::new(), format!("baseline {name}")];
                table.row(what.into_iter().chain([number(over.map(|over| over.mean))]));
            }
        }
        text += &format!("\n{} in region {}\n{}", score.title(), results.regions[region], table.text());
    }
    Ok(text)
}
