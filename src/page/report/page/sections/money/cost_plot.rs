//! The front of the chosen sets: cost, or the number of sensors, against the score, with the upper bound, and the same
//! as tables.

use maud::{Markup, PreEscaped, html};

use super::spot::Spot;
use crate::report::charts::axis::AxisScale;
use crate::report::charts::sheet::Sheet;
use crate::report::chosen_sets;
use crate::report::colours;
use crate::report::page::Findings;
use crate::report::page::measure;
use crate::report::page::plain_table::{Titled, plain};
use crate::report::page::question::IN_WORDS;
use crate::report::page::recommended::{region_of, series_of};
use perirobot_decide::choose::{Chosen, SetReport, StepReport};
use perirobot_sweep::results::columns::BETWEEN_MEMBERS;

/// Size of the picture, and the margins of its axes; on a phone its words are larger.
const SIZE: [f64; 2] = [520.0, 330.0];
const LEFT: f64 = 54.0;
const RIGHT: f64 = 14.0;
const ABOVE: f64 = 30.0;
const BELOW: f64 = 44.0;

/// The contents of the section.
#[derive(Debug)]
pub(super) struct CostPlot {
    /// How to read the front, a sentence each.
    notes: Vec<String>,
    /// The front as SVG.
    picture: String,
    /// The front, and the places of its sensors.
    front: Titled,
    places: Titled,
}

impl CostPlot {
    pub(super) fn new(findings: &Findings, chosen: &Chosen) -> CostPlot {
        let clicked = |step: &StepReport| ClickedSet::new(findings, chosen, &step.best);
        CostPlot {
            notes: chosen_sets::reading_guide(chosen).lines().map(String::from).collect(),
            picture: draw(chosen, &chosen.report.steps.iter().map(clicked).collect::<Vec<_>>()),
            front: (
                "The front: the best set of each size and step of cost".into(),
                chosen_sets::front(chosen, &IN_WORDS),
            ),
            places: ("Where the sensors are".into(), chosen_sets::places(chosen)),
        }
    }

    /// The picture with its tables.
    pub(super) fn view(&self) -> Markup {
        html! {
            div #front {
                figure {
                    (PreEscaped(&self.picture))
                    figcaption {
                        "A point is the best set of at most that many sensors, filled if it is proven: click on it to select \
                         the set. ✓ and ✗: whether it meets all requirements, as judge found. No set of at most as many \
                         sensors for that cost or less is above the line from it, which is dashed if it is not proven."
                    }
                }
                ul { @for note in &self.notes { li { (note) } } }
                (plain(&self.front))
                details { summary { (self.places.0) } (plain(&self.places)) }
            }
        }
    }
}

/// What a click on a set selects.
struct ClickedSet {
    spot: Spot,
    /// Whether it meets all requirements, if `judge` decided that.
    passes: Option<bool>,
}

impl ClickedSet {
    /// `None` of a set without scores.
    fn new(findings: &Findings, chosen: &Chosen, set: &SetReport) -> Option<ClickedSet> {
        let Findings { sweep, rankings, judged, .. } = findings;
        let poses = set.poses.join(BETWEEN_MEMBERS);
        let combination = sweep.results.combinations.iter().position(|one| one.name_of(0) == poses)?;
        let series = series_of(rankings, combination, 0)?;
        let region = region_of(sweep, &chosen.asked.region)?;
        let own =
            judged.iter().find(|one| one.choice.is_some_and(|choice| choice.combination == combination));
        let spot = Spot { series, region, opens: "cell".into() };
        Some(ClickedSet { spot, passes: own.map(|one| one.passes()) })
    }
}

/// The x value of a step: its cost, or its number of sensors if there are no costs.
fn step_x(step: &StepReport, priced: bool) -> f64 {
    match step.best.cost.filter(|_| priced) {
        Some(cost) => cost.amount(),
        None => step.at_most as f64,
    }
}

fn draw(chosen: &Chosen, clicked: &[Option<ClickedSet>]) -> String {
    let (steps, objective) = (&chosen.report.steps, chosen.asked.objective);
    let (score, whole) = match measure::is_share(objective) {
        true => (format!("{}, %", measure::title(objective)), 100.0),
        false => (measure::title(objective), 1.0),
    };
    let priced = !steps.is_empty() && steps.iter().all(|step| step.best.cost.is_some());
    let xs = || steps.iter().map(|step| step_x(step, priced));
    let ends = steps.iter().filter_map(|step| step.budget).map(|budget| budget.amount()).filter(|_| priced);
    let highest = xs().chain(ends).fold(0.0, f64::max);
    let ys = || {
        let each = steps.iter().flat_map(|step| step.no_set_is_above.into_iter().chain([step.best.score]));
        each.map(|value| whole * value)
    };
    let (low, high) = (ys().fold(0.0, f64::min), ys().fold(0.0, f64::max));
    let [left, top, right, bottom] = [LEFT, ABOVE, SIZE[0] - RIGHT, SIZE[1] - BELOW];
    let room = |value: f64| if value > 0.0 { 1.06 * value } else { 1.0 };
    let across = match priced {
        true => AxisScale::new([0.0, room(highest)], [left, right]),
        false => AxisScale::from_whole_numbers([0.5, highest.max(1.0) + 0.5], [left, right]),
    };
    let up = AxisScale::new([low, low + room(high - low)], [bottom, top]);
    let name = match (priced, &chosen.asked.currency) {
        (true, Some(currency)) => &format!("cost, {currency}"),
        (true, None) => "cost",
        (false, _) => "sensors",
    };
    let mut sheet = Sheet::new(&format!("{name} against {score}"));
    sheet.words("", [6.0, 16.0], &score);
    up.draw_beside(&mut sheet, [left, right]);
    sheet.y = bottom;
    across.draw_below(&mut sheet, top, name);
    sheet.y = SIZE[1];
    for (step, clicked) in steps.iter().zip(clicked) {
        let value = step_x(step, priced);
        let until = match step.budget.filter(|_| priced) {
            Some(budget) => budget.amount(),
            None if priced => across.ends[1],
            None => value + 0.4,
        };
        let [x, y] = [across.position(value), up.position(whole * step.best.score)];
        let (fill, dashes) = if step.proven { ("proven", "none") } else { ("open", "6 4") };
        let colour = colours::series(step.at_most - 1);
        if let Some(bound) = step.no_set_is_above {
            let path = format!("M{x} {y}V{}H{}", up.position(whole * bound), across.position(until));
            sheet.line("bound", (colour, dashes), &path);
        }
        let words =
            format!("{}: {}", chosen_sets::describe_score(chosen, &IN_WORDS, &step.best), step.best.name());
        sheet.add(&clicked.as_ref().map_or(String::new(), |set| set.spot.opening()));
        sheet.point(fill, [x, y], colour, &words);
        sheet.add(clicked.as_ref().map_or("", |_| Spot::CLOSING));
        let sign = match clicked.as_ref().and_then(|set| set.passes) {
            Some(true) => " ✓",
            Some(false) => " ✗",
            None => "",
        };
        sheet.words("mid over", [x, y - 9.0], &format!("{}{sign}", step.at_most));
    }
    sheet.finish("chart broad", SIZE[0])
}
