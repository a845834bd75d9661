//! The cheapest sets that pass: for all requirements, at each speed of the robot, or without some of them, as a table,
//! with a chart of cost by speed. A click on one selects its set and opens its plan, mounting sheets and verdicts.

mod speed_chart;

use maud::{Markup, PreEscaped, html};

use super::spot::Spot;
use crate::report::page::Findings;
use crate::report::page::mount::{MountSheet, sheets};
use crate::report::page::recommended::{purchased_set, series_of, worst_moments};
use crate::report::page::sections::first_screen::{ShownPlan, draw_plan};
use crate::report::page::sections::good::Good;
use crate::report::purchased::{describe_aim, describe_bound, describe_cost, describe_speed};
use perirobot_decide::cheapest::{AimReport, PurchasePoint, PurchaseReport, PurchasedSet, ReasonReport};
use perirobot_decide::view::Choice;
use perirobot_march::Result;
use speed_chart::speed_chart;

/// The contents of the section.
pub(super) struct ShownPurchase {
    rows: Vec<PurchaseRow>,
    /// Cost by speed as SVG, if speeds were requested and one has a set.
    chart: Option<String>,
    sets: Vec<ShownSet>,
}

/// A question, and its cheapest set.
struct PurchaseRow {
    aim: String,
    verdict: &'static str,
    cost: String,
    count: String,
    bound: String,
    set: Option<SetLink>,
    poses: String,
    /// Why there is no set.
    reasons: Vec<ReasonReport>,
}

/// The selection after a click on a set, and the part that opens.
#[derive(Clone, Debug)]
struct SetLink {
    spot: Spot,
    /// PASS if it meets all requirements of the study, FAIL if it misses one, else OPEN; and the verdicts in a line.
    verdict: &'static str,
    overall: String,
}

/// A set with its details.
struct ShownSet {
    link: SetLink,
    name: String,
    poses: String,
    speed: Option<String>,
    good: Good,
    plan: ShownPlan,
    sheets: Vec<MountSheet>,
}

impl ShownPurchase {
    /// `None` for another question.
    ///
    /// # Errors
    /// If a journal cannot be read.
    pub(super) fn from_findings(findings: &Findings) -> Result<Option<ShownPurchase>> {
        let Some(report) = findings.sweep.purchase else { return Ok(None) };
        let mut sets = Vec::new();
        for (number, set) in report.sets().into_iter().enumerate() {
            sets.extend(ShownSet::new(findings, set, format!("set-{number}"))?);
        }
        let row = |point: &PurchasePoint| PurchaseRow::new(report, point, &sets);
        let rows = report.points.iter().map(row).collect();
        let chart = speed_chart(report, &|set| link_of(set, &sets));
        Ok(Some(ShownPurchase { rows, chart, sets }))
    }

    /// The chart, the table, and the sets.
    pub(super) fn view(&self) -> Markup {
        html! {
            div #purchase {
                h3 { "The cheapest sets that pass" }
                p.hint { "Click on a set to select it here and in the 3D view, and to open its plan, mounting sheets and verdicts." }
                @if let Some(chart) = &self.chart {
                    figure {
                        (PreEscaped(chart))
                        figcaption {
                            "The cheapest set at each speed of the robot. A disc is proven; a ring is the cheapest that was \
                             found, and no set below the end of its dashed line passes; a cross is a speed without a set."
                        }
                    }
                }
                div.wide.cards tabindex="0" role="group" aria-label="The cheapest sets that pass" {
                    table.plain {
                        thead { tr { @for name in COLUMNS { th { (name) } } } }
                        tbody { @for row in &self.rows { (row.view()) } }
                    }
                }
                @for set in &self.sets { (set.view()) }
            }
        }
    }
}

/// The columns of the table.
const COLUMNS: [&str; 7] = ["for", "", "cost", "sensors", "proof", "set", "all requirements"];

impl PurchaseRow {
    fn new(report: &PurchaseReport, point: &PurchasePoint, sets: &[ShownSet]) -> PurchaseRow {
        let found = point.set.as_ref();
        let or_empty = |text: Option<String>| text.unwrap_or_default();
        PurchaseRow {
            aim: match &point.aim {
                AimReport::Nearest(_) => format!("{}: the nearest", describe_aim(&point.aim)),
                aim => describe_aim(aim),
            },
            verdict: verdict(point),
            cost: or_empty(found.map(|set| describe_cost(report, &point.aim, set))),
            count: or_empty(found.map(|set| set.sensors.len().to_string())),
            bound: describe_bound(report, point),
            set: found.and_then(|set| link_of(set, sets)),
            poses: or_empty(found.map(PurchasedSet::poses)),
            reasons: point.reasons.clone(),
        }
    }

    fn view(&self) -> Markup {
        html! {
            tr {
                td data-name="for" { (self.aim) }
                td.(self.verdict) { b { (sign(self.verdict)) " " (self.verdict) } }
                td data-name="cost" { (self.cost) }
                td data-name="sensors" { (self.count) }
                td data-name="proof" { (self.bound) }
                td {
                    @match &self.set {
                        Some(link) => (link.spot.button(&self.poses)),
                        None => ul { @for one in &self.reasons { li { strong { (one.requirement) } ": " (one.why) } } },
                    }
                }
                @match &self.set {
                    Some(SetLink { verdict, overall, .. }) => {
                        td.(verdict) data-name="all requirements" { b { (sign(verdict)) " " (verdict) } " " (overall) }
                    }
                    None => td {},
                }
            }
        }
    }
}

/// PASS if a set was found, FAIL if it is proven that there is none, else OPEN.
fn verdict(point: &PurchasePoint) -> &'static str {
    match (&point.set, point.proven) {
        (Some(_), _) => "PASS",
        (None, true) => "FAIL",
        (None, false) => "OPEN",
    }
}

/// The sign of a verdict, readable without colours.
fn sign(verdict: &str) -> &'static str {
    match verdict {
        "PASS" => "✓",
        "FAIL" => "✗",
        _ => "?",
    }
}

/// The selection after a click on a set.
fn link_of(set: &PurchasedSet, sets: &[ShownSet]) -> Option<SetLink> {
    let poses = set.poses();
    sets.iter().find(|shown| shown.poses == poses).map(|shown| shown.link.clone())
}

impl ShownSet {
    /// `None` if the set was not swept.
    fn new(findings: &Findings, set: &PurchasedSet, opens: String) -> Result<Option<ShownSet>> {
        let Findings { sweep, rankings, surroundings, judged, recommended, .. } = findings;
        let Some(combination) = purchased_set(sweep, set) else { return Ok(None) };
        let (Some(series), Some(shown)) = (series_of(rankings, combination, 0), recommended) else {
            return Ok(None);
        };
        let (region, choice) =
            (shown.region, Choice { combination, choice: 0, representation: 0, repeat: 0 });
        let (moments, scene) = worst_moments(sweep, rankings[series].series.key(0, region), shown.score)?;
        let swept = &sweep.results.combinations[combination];
        let names = [set.name.clone(), set.poses(), swept.representations[0].clone()];
        let own = judged.iter().find(|one| one.names == names);
        let good = Good::from_verdicts(findings, choice, &names)?;
        let (_, plan) = draw_plan(sweep, (choice, region), (scene, moments[scene]), None);
        let [name, poses, _] = names;
        Ok(Some(ShownSet {
            link: SetLink {
                spot: Spot { series, region, opens },
                verdict: good.verdict(),
                overall: good.overall(),
            },
            name,
            poses,
            speed: own.and_then(|one| one.verdicts.allowed_speed).map(describe_speed),
            good,
            plan,
            sheets: sheets((sweep.study, sweep.worlds), surroundings, combination, 0),
        }))
    }

    fn view(&self) -> Markup {
        html! {
            details.aside id=(self.link.spot.opens) {
                summary { (self.name) ": " (self.poses) }
                p.overall.(self.good.verdict()) {
                    "By what the study requires, " b { (self.good.overall()) }
                    @if let Some(speed) = &self.speed { "; " (speed) }
                    "."
                }
                (self.good.view_verdicts())
                p { "In three dimensions: " (Spot { opens: "cell".into(), ..self.link.spot.clone() }.button("what it sees")) }
                (self.plan.view())
                div.sheets { @for one in &self.sheets { (one.view()) } }
            }
        }
    }
}
