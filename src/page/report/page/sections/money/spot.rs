//! A point of a chart for a set: a click on it selects the set in the whole page.

use maud::{Markup, html};

use crate::render::svg::escape;

/// The selection after a click, and the part that opens.
#[derive(Clone, Debug)]
pub(super) struct Spot {
    pub(super) series: usize,
    pub(super) region: usize,
    /// The id of the part.
    pub(super) opens: String,
}

impl Spot {
    /// The end of a point's group.
    pub(super) const CLOSING: &str = "</g>";

    /// The start of a point's group.
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
