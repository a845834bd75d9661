//! Axes for scores over the snapshots of a moving scene; the script draws the curves of the selected choice.

use maud::{Markup, PreEscaped, html};

use crate::report::charts::axis::AxisScale;
use crate::report::charts::sheet::Sheet;
use crate::report::page::Findings;
use perirobot_sweep::results::swept::SceneResults;

/// Sizes of the drawing and its margins; on a phone its words are larger.
const WIDTH: f64 = 480.0;
const HEIGHT: f64 = 240.0;
const LEFT: f64 = 50.0;
const EDGE: f64 = 12.0;

/// The axes of a scene.
#[derive(Debug)]
pub(super) struct TimeChart {
    scene: usize,
    svg: String,
    across: AxisScale,
    up: AxisScale,
}

/// A chart for each moving scene.
pub(super) fn time_charts(findings: &Findings) -> Vec<TimeChart> {
    let scenes = findings.sweep.results.scenes.iter().enumerate();
    let moving = scenes.filter(|(_, scene)| scene.moments.len() > 1);
    let least = findings.scores.iter().map(|scores| scores.least_at_moments).fold(0.0, f64::min);
    let draw = |(scene, found): (usize, &SceneResults)| {
        let last = (found.moments.len() - 1) as f64;
        let across = AxisScale::from_whole_numbers([0.0, last], [LEFT, WIDTH - EDGE]);
        // No score is above 1; κ may be below 0.
        let up = AxisScale::new([least, 1.0], [HEIGHT, EDGE]);
        let mut sheet = Sheet::new(&format!("Scores over time in scene {}", found.name));
        up.draw_beside(&mut sheet, [LEFT, WIDTH - EDGE]);
        sheet.y = HEIGHT;
        across.draw_below(&mut sheet, EDGE, "snapshot");
        sheet.add("<g class=\"lines\"/>\n");
        sheet.y += 44.0;
        TimeChart { scene, svg: sheet.finish("chart broad", WIDTH), across, up }
    };
    moving.map(draw).collect()
}

impl TimeChart {
    /// The chart, with placeholders for the script: a title, curves and a legend.
    pub(super) fn view(&self) -> Markup {
        let TimeChart { scene, svg, across, up } = self;
        html! {
            div data-scene=(scene) {
                p.title {}
                div data-first=(across.position(0.0)) data-second=(across.position(1.0))
                    data-zero=(up.position(0.0)) data-one=(up.position(1.0)) { (PreEscaped(svg)) }
                ul.legend {}
            }
        }
    }
}
