//! A point of a chart that stands for a set: a click on it selects the set in the whole page.

use maud::{Markup, html};

use crate::render::svg::escape;

/// What a click selects, and what it opens.
#[derive(Clone, Debug)]
pub(super) struct Spot {
    pub(super) series: usize,
    pub(super) region: usize,
    /// The id of the part of the page.
    pub(super) opens: String,
}

impl Spot {
    /// Ends the group of a point.
    pub(super) const CLOSING: &str = "</g>";

    /// Begins the group of a point.
    pub(super) fn opening(&self) -> String {
        let Spot { series, region, opens } = self;
        format!(
            "<g class=\"spot\" data-series=\"{series}\" data-choice=\"0\" data-region=\"{region}\" data-opens=\"{}\">",
            escape(opens)
        )
    }

    /// The same as a button.
    pub(super) fn button(&self, words: &str) -> Markup {
        html! {
            button.choose type="button" data-series=(self.series) data-choice="0" data-region=(self.region)
                data-opens=(self.opens) { (words) }
        }
    }
}
