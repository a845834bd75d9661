//! The front of the sets that were chosen: cost, or how many sensors, against the score, with what no set is
//! above, and the same as tables.

use maud::{Markup, html};

use crate::report::chosen_sets;
use crate::report::page::plain_table::{Titled, plain};
use perirobot_decide::choose::{Chosen, StepReport};

/// Size of the picture, and the room for its axes, in pixels.
const SIZE: [f64; 2] = [720.0, 380.0];
const LEFT: f64 = 64.0;
const RIGHT: f64 = 16.0;
const ABOVE: f64 = 16.0;
const BELOW: f64 = 52.0;
/// About so many marks an axis has.
const MARKS: f64 = 6.0;
/// Colours of sets of one sensor, two and so on, that colour-blind people tell apart.
const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];

/// What the page shows.
#[derive(Debug)]
pub(super) struct CostPlot {
    /// How the front is read, a sentence each.
    notes: Vec<String>,
    picture: Picture,
    /// The front, and where its sensors are.
    tables: Vec<Titled>,
}

/// The front as it is drawn, in pixels.
#[derive(Debug)]
struct Picture {
    size: [f64; 2],
    /// Left, upper, right and lower edge of the plot.
    edges: [f64; 4],
    across: PlotAxis,
    up: PlotAxis,
    steps: Vec<DrawnStep>,
}

/// An axis: its title, and where its marks are.
#[derive(Debug)]
struct PlotAxis {
    title: String,
    marks: Vec<(f64, String)>,
}

/// A step: its best set as a point, and what no set is above as a line to where the step ends.
#[derive(Debug)]
struct DrawnStep {
    at: [f64; 2],
    words: String,
    sensors: usize,
    colour: &'static str,
    proven: bool,
    /// Height of the bound, and how far right it holds.
    bound: Option<[f64; 2]>,
}

/// A range of values over pixels.
struct PlotScale {
    values: [f64; 2],
    pixels: [f64; 2],
}

impl PlotScale {
    fn position(&self, value: f64) -> f64 {
        let [low, high] = self.values;
        let [from, to] = self.pixels;
        // Tenths of a pixel do.
        (10.0 * (from + (value - low) / (high - low) * (to - from))).round() / 10.0
    }

    /// Round numbers within the range: 1, 2 or 5 times a power of ten apart, and no less than `least`.
    fn marks(&self, least: f64) -> Vec<(f64, String)> {
        let [low, high] = self.values;
        let wanted = (high - low) / MARKS;
        let power = 10f64.powf(wanted.log10().floor());
        let apart = [1.0, 2.0, 5.0, 10.0].map(|n| n * power).into_iter().find(|step| *step >= wanted);
        let apart = apart.unwrap_or(wanted).max(least);
        let digits = (-apart.log10().floor()).max(0.0) as usize;
        let first = (low / apart - 1e-9).ceil() as i64;
        let last = (high / apart + 1e-9).floor() as i64;
        let mark = |i: i64| {
            let value = i as f64 * apart;
            (self.position(value), format!("{value:.digits$}"))
        };
        (first..=last).map(mark).collect()
    }
}

impl CostPlot {
    pub(super) fn new(chosen: &Chosen) -> CostPlot {
        let tables = vec![
            ("The front: the best set of each size and step of cost".into(), chosen_sets::front(chosen)),
            ("Where the sensors are".into(), chosen_sets::places(chosen)),
        ];
        CostPlot {
            notes: chosen_sets::reading_guide(chosen).lines().map(String::from).collect(),
            picture: picture(chosen),
            tables,
        }
    }

    /// The picture and its tables.
    pub(super) fn view(&self) -> Markup {
        html! {
            div #front {
                figure {
                    (render_picture(&self.picture))
                    figcaption {
                        "A point is the best set of at most so many sensors, full where it is proven; the line from it, \
                         dashed where it is not proven, is what no set of at most as many for that cost or less is above."
                    }
                }
                ul { @for note in &self.notes { li { (note) } } }
                @for table in &self.tables { (plain(table)) }
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

fn picture(chosen: &Chosen) -> Picture {
    let steps = &chosen.report.steps;
    let priced = !steps.is_empty() && steps.iter().all(|step| step.best.cost.is_some());
    let xs = || steps.iter().map(|step| step_x(step, priced));
    let ends = steps.iter().filter_map(|step| step.budget).map(|budget| budget.amount()).filter(|_| priced);
    let highest = xs().chain(ends).fold(0.0, f64::max);
    let ys = || steps.iter().flat_map(|step| step.no_set_is_above.into_iter().chain([step.best.score]));
    let (low, high) = (ys().fold(0.0, f64::min), ys().fold(0.0, f64::max));
    let edges = [LEFT, ABOVE, SIZE[0] - RIGHT, SIZE[1] - BELOW];
    let room = |value: f64| if value > 0.0 { 1.06 * value } else { 1.0 };
    let x = PlotScale {
        values: if priced { [0.0, room(highest)] } else { [0.5, highest.max(1.0) + 0.5] },
        pixels: [edges[0], edges[2]],
    };
    let y = PlotScale { values: [low, low + room(high - low)], pixels: [edges[3], edges[1]] };
    let drawn = |step: &StepReport| {
        let value = step_x(step, priced);
        let until = match step.budget.filter(|_| priced) {
            Some(budget) => budget.amount(),
            None if priced => x.values[1],
            None => value + 0.4,
        };
        DrawnStep {
            at: [x.position(value), y.position(step.best.score)],
            words: format!(
                "{}: {}",
                chosen_sets::describe_score(&step.best, chosen.asked.objective.title()),
                step.best.name()
            ),
            sensors: step.at_most,
            colour: COLOURS[(step.at_most - 1) % COLOURS.len()],
            proven: step.proven,
            bound: step.no_set_is_above.map(|bound| [y.position(bound), x.position(until)]),
        }
    };
    let title = if priced { "cost" } else { "sensors" };
    Picture {
        size: SIZE,
        edges,
        steps: steps.iter().map(drawn).collect(),
        across: PlotAxis { title: title.into(), marks: x.marks(if priced { 0.0 } else { 1.0 }) },
        up: PlotAxis { title: chosen.asked.objective.title().into(), marks: y.marks(0.0) },
    }
}

fn render_picture(picture: &Picture) -> Markup {
    let Picture { size: [width, height], edges: [left, top, right, bottom], across, up, steps } = picture;
    html! {
        svg viewBox={ "0 0 " (width) " " (height) } role="img" aria-label={ (across.title) " against " (up.title) } {
            @for (x, words) in &across.marks {
                path.mesh d={ "M" (x) " " (top) "V" (bottom) } {}
                text x=(x) y=(bottom + 18.0) text-anchor="middle" { (words) }
            }
            @for (y, words) in &up.marks {
                path.mesh d={ "M" (left) " " (y) "H" (right) } {}
                text x=(left - 8.0) y=(y + 4.0) text-anchor="end" { (words) }
            }
            text x=(right) y=(height - 8.0) text-anchor="end" { (across.title) }
            text x="6" y=(top + 10.0) { (up.title) }
            @for step in steps { (point(step)) }
        }
    }
}

fn point(step: &DrawnStep) -> Markup {
    let [x, y] = step.at;
    let (class, filled) = if step.proven { ("proven", step.colour) } else { ("open", "#fff") };
    let dashes = (!step.proven).then_some("6 4");
    html! {
        @if let Some([height, end]) = step.bound {
            path.bound stroke=(step.colour) stroke-dasharray=[dashes] d={ "M" (x) " " (y) "V" (height) "H" (end) } {}
        }
        circle.(class) cx=(x) cy=(y) r="5" stroke=(step.colour) fill=(filled) { title { (step.words) } }
        text x=(x) y=(y - 9.0) text-anchor="middle" { (step.sensors) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_round_numbers_within_the_range() {
        let marks = |values: [f64; 2], least: f64| {
            let scale = PlotScale { values, pixels: [0.0, 100.0] };
            scale.marks(least).into_iter().map(|(_, text)| text).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(marks([0.0, 1900.0], 0.0), "0 500 1000 1500");
        assert_eq!(marks([0.0, 0.8], 0.0), "0.0 0.2 0.4 0.6 0.8");
        assert_eq!(marks([0.0, 0.07], 0.0), "0.00 0.02 0.04 0.06");
        assert_eq!(marks([-0.1, 0.5], 0.0), "-0.1 0.0 0.1 0.2 0.3 0.4 0.5");
        assert_eq!(marks([0.5, 3.5], 1.0), "1 2 3");
    }
}
