//! The front of the sets that were chosen: cost, or how many sensors, against the score, with what no set is
//! above, and the same as tables.

use maud::{Markup, PreEscaped, html};

use crate::report::charts::axis::AxisScale;
use crate::report::charts::sheet::Sheet;
use crate::report::chosen_sets;
use crate::report::colours;
use crate::report::page::plain_table::{Titled, plain};
use perirobot_decide::choose::{Chosen, StepReport};

/// Size of the picture, and the room for its axes; on a phone its words are larger.
const SIZE: [f64; 2] = [520.0, 330.0];
const LEFT: f64 = 54.0;
const RIGHT: f64 = 14.0;
const ABOVE: f64 = 30.0;
const BELOW: f64 = 44.0;

/// What the page shows.
#[derive(Debug)]
pub(super) struct CostPlot {
    /// How the front is read, a sentence each.
    notes: Vec<String>,
    /// The front as SVG.
    picture: String,
    /// The front, and where its sensors are.
    front: Titled,
    places: Titled,
}

impl CostPlot {
    pub(super) fn new(chosen: &Chosen) -> CostPlot {
        CostPlot {
            notes: chosen_sets::reading_guide(chosen).lines().map(String::from).collect(),
            picture: draw(chosen),
            front: (
                "The front: the best set of each size and step of cost".into(),
                chosen_sets::front(chosen),
            ),
            places: ("Where the sensors are".into(), chosen_sets::places(chosen)),
        }
    }

    /// The picture and its tables.
    pub(super) fn view(&self) -> Markup {
        html! {
            div #front {
                figure {
                    (PreEscaped(&self.picture))
                    figcaption {
                        "A point is the best set of as many sensors or fewer, full where it is proven; the line from it, \
                         dashed where it is not proven, is what no set of at most as many for that cost or less is above."
                    }
                }
                ul { @for note in &self.notes { li { (note) } } }
                (plain(&self.front))
                details { summary { (self.places.0) } (plain(&self.places)) }
            }
        }
    }
}

/// What a step is drawn at: its cost, or how many sensors it has where there are no costs.
fn step_x(step: &StepReport, priced: bool) -> f64 {
    match step.best.cost.filter(|_| priced) {
        Some(cost) => cost.amount(),
        None => step.at_most as f64,
    }
}

fn draw(chosen: &Chosen) -> String {
    let (steps, score) = (&chosen.report.steps, chosen.asked.objective.title());
    let priced = !steps.is_empty() && steps.iter().all(|step| step.best.cost.is_some());
    let xs = || steps.iter().map(|step| step_x(step, priced));
    let ends = steps.iter().filter_map(|step| step.budget).map(|budget| budget.amount()).filter(|_| priced);
    let highest = xs().chain(ends).fold(0.0, f64::max);
    let ys = || steps.iter().flat_map(|step| step.no_set_is_above.into_iter().chain([step.best.score]));
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
    sheet.words("", [6.0, 16.0], score);
    up.draw_beside(&mut sheet, [left, right]);
    sheet.y = bottom;
    across.draw_below(&mut sheet, top, name);
    sheet.y = SIZE[1];
    for step in steps {
        let value = step_x(step, priced);
        let until = match step.budget.filter(|_| priced) {
            Some(budget) => budget.amount(),
            None if priced => across.ends[1],
            None => value + 0.4,
        };
        let [x, y] = [across.position(value), up.position(step.best.score)];
        let (fill, dashes) = if step.proven { ("proven", "none") } else { ("open", "6 4") };
        let colour = colours::series(step.at_most - 1);
        if let Some(bound) = step.no_set_is_above {
            let path = format!("M{x} {y}V{}H{}", up.position(bound), across.position(until));
            sheet.line("bound", (colour, dashes), &path);
        }
        let words = format!("{}: {}", chosen_sets::describe_score(chosen, &step.best), step.best.name());
        sheet.point(fill, [x, y], colour, &words);
        sheet.words("mid over", [x, y - 9.0], &step.at_most.to_string());
    }
    sheet.finish("chart broad", SIZE[0])
}
