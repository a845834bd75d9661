//! The first screen: the question, the recommended choice, a few large numbers with their bounds, and the floor plan.

mod answer;
mod tile;

use maud::{Markup, PreEscaped, html};

use super::good::Good;
use crate::render::plan::{FloorPlan, region_plan, swatch};
use crate::report::page::question::question;
use crate::report::page::recommended::Recommended;
use crate::report::page::{Findings, ReportedSweep};
use crate::report::purchased::describe_heading;
use crate::report::wording::extent;
use answer::PurchaseAnswer;
use perirobot_decide::approach::Way;
use perirobot_decide::view::Choice;
use perirobot_march::Result;
use perirobot_study::sensor::Sensor;
use tile::{BigNumber, blind_share, cost_of, tiles};

/// The first screen.
#[derive(Debug)]
pub(super) struct FirstScreen {
    /// The answer, if the question was the cheapest set.
    answer: Option<PurchaseAnswer>,
    /// The title of the choice.
    heading: &'static str,
    /// The question, as a sentence.
    asked: String,
    /// The names of the recommended choice, the subject of all numbers.
    pub(super) set: String,
    /// Its distinction.
    why: String,
    pub(super) sensors: Vec<RecommendedSensor>,
    /// Its cost, if known.
    pub(super) cost: Option<String>,
    /// The unwatched share of the first plan's floor.
    pub(super) blind_floor: String,
    /// The sensors that cast fewer rays than their devices.
    thinned: Vec<String>,
    /// The region and the extent.
    counted: String,
    tiles: Vec<BigNumber>,
    /// The plan of the scene with the worst score comes first.
    pub(super) plans: Vec<ShownPlan>,
}

/// A sensor of the recommended choice.
#[derive(Debug)]
pub(super) struct RecommendedSensor {
    /// Its letter in the plan.
    letter: String,
    name: String,
    place: String,
    cost: String,
}

/// A plan with its legend.
#[derive(Debug)]
pub(super) struct ShownPlan {
    pub(super) svg: String,
    pub(super) title: String,
    /// The sign and its meaning.
    legend: Vec<(String, String)>,
    pub(super) floor: String,
}

impl FirstScreen {
    /// For the recommended choice; `None` if no choice has a score.
    pub(super) fn from_recommended(findings: &Findings) -> Result<Option<FirstScreen>> {
        findings.recommended.map(|one| FirstScreen::new(findings, one)).transpose()
    }

    fn new(findings: &Findings, recommended: &Recommended) -> Result<FirstScreen> {
        let Findings { sweep, rankings, ways, .. } = findings;
        let ReportedSweep { results, study, .. } = *sweep;
        let series = rankings[recommended.series].series;
        let combination = &results.combinations[series.combination];
        let (choice, region) = (recommended.choice, recommended.region);
        let looked = recommended.choice(rankings);
        let plan = |scene: usize| {
            draw_plan(sweep, (looked, region), (scene, recommended.moments[scene]), ways.get(scene))
        };
        let others = (0..results.scenes.len()).filter(|scene| *scene != recommended.scene);
        let plans: Vec<(FloorPlan, ShownPlan)> =
            [recommended.scene].into_iter().chain(others).map(plan).collect();
        let spec = &study.combinations[series.combination];
        let currency = study.currency.as_deref();
        let named = spec.members.iter().zip(combination.poses(choice)).zip(&plans[0].0.sensors);
        let sensors = named.map(|((member, (of, pose)), (letter, _))| RecommendedSensor {
            letter: letter.clone().unwrap_or_default(),
            name: of.sensor.clone(),
            place: if pose.place.is_empty() { pose.name.clone() } else { pose.place.clone() },
            cost: cost_text(&study.sensors[member.sensor], currency),
        });
        let members = spec.members.iter().map(|member| &study.sensors[member.sensor]);
        let mut thinned: Vec<String> = members
            .filter_map(|sensor| Some(format!("“{}” {}.", sensor.name, sensor.thinned.as_ref()?)))
            .collect();
        // A set may contain a sensor twice.
        thinned.dedup();
        Ok(FirstScreen {
            thinned,
            answer: PurchaseAnswer::from_findings(findings),
            heading: sweep.purchase.map_or("Recommended", describe_heading),
            asked: question(sweep),
            set: format!("{} ({})", combination.name, combination.name_of(choice)),
            why: recommended.why.clone(),
            sensors: sensors.collect(),
            cost: cost_of(study, series.combination).map(|cost| cost.to_text(currency)),
            blind_floor: blind_share(plans[0].0.floor_m2),
            counted: format!(
                "The numbers are those of {}; all but floor and cost: {} in region {}, over {}",
                combination.name,
                if results.moments().len() > 1 { "means" } else { "counted" },
                results.regions[region],
                extent(results)
            ),
            tiles: tiles(sweep, rankings, recommended, plans[0].0.floor_m2)?,
            plans: plans.into_iter().map(|(_, shown)| shown).collect(),
        })
    }

    /// The section.
    pub(super) fn view(&self, good: &Good) -> Markup {
        html! {
            section #answer {
                @if let Some(answer) = &self.answer { (answer.view()) }
                (self.render_text(good))
                @if let Some(plan) = self.plans.first() { (plan.view()) }
            }
        }
    }

    fn render_text(&self, good: &Good) -> Markup {
        html! {
            div.said {
                p.asked { (self.asked) }
                div.named { h2 { (self.heading) } p { (self.set) } }
                ul.sensors { @for sensor in &self.sensors { (render_sensor(sensor)) } }
                p.overall.(good.verdict()) { strong { "Good enough?" } " " b { (good.overall()) } }
                (good.view_caveats())
                p.note {
                    "This is " (self.why) ". " a href="#instead" { "What instead?" } " " a href="#where" { "Where exactly?" }
                }
                @if !good.required.is_empty() { (render_verdicts(good)) }
                dl.tiles { @for tile in &self.tiles { (tile.view()) } }
                p.disclaimer { "A planning aid, not a validation: " a href="#assumed" { "what was assumed" } "." }
                p.note { (self.counted) "." }
                @for thinned in &self.thinned { p.note.thinned { (thinned) } }
            }
        }
    }
}

/// The requirements with their verdicts in a few words.
fn render_verdicts(good: &Good) -> Markup {
    html! {
        ul.verdicts {
            @for one in &good.required {
                li.(one.verdict()) {
                    b { (one.verdict()) }
                    span {
                        strong { (one.name) } " " span.note { (one.asked) ": " (one.describe_found()) }
                        (one.view_safety_function())
                    }
                }
            }
        }
    }
}

/// The screen if no choice has a score.
pub(super) fn render_empty() -> Markup {
    html! {
        p.disclaimer {
            "A planning aid, not a validation: " a href="#assumed" { "what was assumed" }
            ". No choice of poses has a score, so nothing is recommended."
        }
    }
}

impl ShownPlan {
    /// The plan with its legend.
    pub(super) fn view(&self) -> Markup {
        html! {
            figure.floor-plan {
                (PreEscaped(&self.svg))
                figcaption {
                    ul.legend {
                        @for (sign, meaning) in &self.legend {
                            li {
                                svg.plan viewBox="0 0 24 16" width="24" height="16" aria-hidden="true" { (PreEscaped(sign)) }
                                (meaning)
                            }
                        }
                    }
                    p { (self.title) ". " (self.floor) }
                }
            }
        }
    }
}

/// The plan of a choice in a scene at a moment, with the outline of its region, and the ways in if known.
pub(super) fn draw_plan(
    sweep: &ReportedSweep,
    (looked, region): (Choice, usize),
    (scene, moment): (usize, usize),
    near: Option<&Vec<Way>>,
) -> (FloorPlan, ShownPlan) {
    let of_scene = sweep.results.scenes[scene].moments.clone();
    let plan = region_plan(
        (sweep.study, &sweep.worlds[of_scene.clone()]),
        moment - of_scene.start,
        Some(looked),
        region,
    );
    let plan = plan.with_ways(near.map_or(&[], Vec::as_slice));
    let [floor, blind, hardly] = plan.floor_m2;
    let name = &sweep.results.scenes[scene].name;
    let when = match of_scene.len() {
        1 => String::new(),
        _ => format!(", snapshot {} (its worst)", moment - of_scene.start),
    };
    let shown = ShownPlan {
        svg: plan.inline(),
        title: format!("Floor plan of {name}{when}"),
        legend: plan.legend.iter().map(|(class, meaning)| (swatch(class), meaning.clone())).collect(),
        floor: format!(
            "Of {floor:.1} m² of floor, {blind:.1} m² are blind, and above another {hardly:.1} m² less than half is watched, \
             without people."
        ),
    };
    (plan, shown)
}

fn render_sensor(sensor: &RecommendedSensor) -> Markup {
    html! {
        li {
            @if !sensor.letter.is_empty() { b.letter { (sensor.letter) } }
            span {
                strong { (sensor.name) } " " (sensor.place)
                @if !sensor.cost.is_empty() { " " span.note { "· cost " (sensor.cost) } }
            }
        }
    }
}
/// The cost of a sensor, marked if it is a list price.
fn cost_text(sensor: &Sensor, currency: Option<&str>) -> String {
    let mark = if sensor.list_price.is_some() { " (list price, to be checked)" } else { "" };
    sensor.terms.cost.map_or(String::new(), |cost| cost.to_text(currency) + mark)
}
