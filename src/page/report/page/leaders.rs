//! The best placement of each region by each score that names a best, of which more is told than its scores.

use maud::{Markup, html};

use super::measure::{self, BESTS};
use super::ranking::{Ranking, firsts};
use perirobot_sweep::results::Results;

/// A choice of poses that no other is better than, by a score in a region.
#[derive(Debug)]
pub(super) struct Leader<'a> {
    /// Which of [`BESTS`].
    pub(super) best: usize,
    pub(super) region: usize,
    pub(super) combination: usize,
    pub(super) choice: usize,
    /// Where its sensors are, in words.
    pub(super) place: String,
    by: String,
    region_name: &'a str,
    poses: String,
}

/// The leaders of each region.
pub(super) fn leaders<'a>(results: &'a Results, rankings: &[Ranking]) -> Vec<Leader<'a>> {
    let of_region = |region: usize| {
        BESTS.into_iter().enumerate().filter_map(move |(best, by)| {
            let &(number, (choice, _)) = firsts(rankings, region, best).first()?;
            let number = rankings[number].series.combination;
            let combination = &results.combinations[number];
            Some(Leader {
                best,
                region,
                combination: number,
                choice,
                place: combination.place_of(choice),
                by: measure::title(by),
                region_name: &results.regions[region],
                poses: combination.label(choice),
            })
        })
    };
    (0..results.regions.len()).flat_map(of_region).collect()
}

impl Leader<'_> {
    /// The title of what is told of it.
    pub(super) fn title(&self) -> Markup {
        html! { h4 { "The best by " (self.by) " in region “" (self.region_name) "”: " (self.poses) } }
    }
}
