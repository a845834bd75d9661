//! The best placement of each region by each score in [`BESTS`], which the page details.

use maud::{Markup, html};

use super::measure::{self, BESTS};
use super::ranking::{Ranking, firsts};
use perirobot_sweep::results::Results;

/// A best choice of poses, by a score in a region.
#[derive(Debug)]
pub(super) struct Leader<'a> {
    /// Index of the score in [`BESTS`].
    pub(super) best: usize,
    pub(super) region: usize,
    pub(super) combination: usize,
    pub(super) choice: usize,
    /// The places of its sensors, in words.
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
    /// The title of its details.
    pub(super) fn title(&self) -> Markup {
        html! { h4 { "The best by " (self.by) " in region “" (self.region_name) "”: " (self.poses) } }
    }
}
