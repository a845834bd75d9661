//! A chart of one score in one region: the page shows some initially and contains the others compressed; the script
//! shows those of the selected score, and marks the selected choice at the chart's marks.

use maud::{Markup, PreEscaped, html};

use super::measure;
use crate::report::charts::axis::AxisScale;
use crate::report::charts::sheet::{Sheet, cut, width_of};
use perirobot_march::metrics::Score;
use perirobot_sweep::results::Results;

/// Its width: about that of a phone, so that words appear there in their drawn size.
pub(super) const WIDTH: f64 = 360.0;

/// Ratio of the width of letters on screens, whose fonts differ, to print.
const SCREEN: f64 = 1.14;

/// Gap between a row and its name.
const GAP: f64 = 6.0;

/// The scores of the initial distributions.
pub(super) const ALWAYS: [Score; 4] = [Score::F1, Score::Kappa, Score::HumanSeen, Score::PartsDetected];

/// The charts of each score in each region at one place of the page.
#[derive(Debug)]
pub(super) struct ScoreCharts {
    pub(super) place: &'static str,
    pub(super) charts: Vec<ScoreChart>,
    /// The scores of the initial page, also without scripts.
    pub(super) first: &'static [Score],
}

impl ScoreCharts {
    fn charts(&self, are_first: bool) -> impl Iterator<Item = &ScoreChart> {
        self.charts.iter().filter(move |chart| self.first.contains(&chart.score) == are_first)
    }

    /// The initial charts.
    pub(super) fn view(&self) -> Markup {
        html! { div.plots id=(self.place) { @for chart in self.charts(true) { (chart.view()) } } }
    }

    /// The others, compressed into the page.
    pub(super) fn others(&self) -> Markup {
        html! { div data-place=(self.place) { @for chart in self.charts(false) { (chart.view()) } } }
    }
}

/// A chart with its subject.
#[derive(Debug)]
pub(super) struct ScoreChart {
    region: usize,
    score: Score,
    title: String,
    /// `None` if no choice has a value.
    drawn: Option<(String, AxisScale)>,
}

impl ScoreChart {
    /// The drawing of a function on an empty sheet with a scale.
    pub(super) fn new(
        results: &Results,
        (region, score): (usize, Score),
        what: &str,
        draw: impl FnOnce(&mut Sheet) -> Option<AxisScale>,
    ) -> ScoreChart {
        let (name, several) = (&results.regions[region], results.regions.len() > 1);
        let of_score = format!("{what}{}", measure::title(score));
        let mut sheet = Sheet::new(&format!("{of_score} in region {name}"));
        let scale = draw(&mut sheet);
        let title = if several { format!("{of_score} · region {name}") } else { of_score };
        ScoreChart { region, score, title, drawn: scale.map(|scale| (sheet.finish("chart", WIDTH), scale)) }
    }

    /// The chart under its title.
    fn view(&self) -> Markup {
        html! {
            div data-region=(self.region) data-score=(self.score as usize) {
                p.title { (self.title) }
                @match &self.drawn {
                    Some((svg, scale)) => {
                        div data-zero=(scale.position(0.0)) data-one=(scale.position(1.0)) { (PreEscaped(svg)) }
                    }
                    None => p.none { "No choice of poses has a value here." }
                }
            }
        }
    }
}

/// The words below an axis.
pub(super) fn axis_words(score: Score) -> &'static str {
    if score.less_is_better() { "less is better" } else { "more is better" }
}

/// Approximate width of words on a screen.
pub(super) fn screen_width(words: &str) -> f64 {
    SCREEN * width_of(words)
}

/// Width of the names at the left, at most a part of the total.
pub(super) fn names_width<'a>(names: impl Iterator<Item = &'a str>, most: f64) -> f64 {
    names.map(|name| 2.0 * GAP + screen_width(name)).fold(0.0, f64::max).min(most * WIDTH)
}

/// Writes the name of a row in front of it.
pub(super) fn write_name(sheet: &mut Sheet, left: f64, y: f64, name: &str) {
    sheet.words("end", [left - GAP, y], &cut(name, (left - GAP) / SCREEN));
}
