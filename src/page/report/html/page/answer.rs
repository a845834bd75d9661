//! The first screen: what is recommended, its numbers, whether it is good enough, and a floor plan.

use maud::{Markup, PreEscaped, html};

use crate::report::html::facts::Facts;
use crate::report::html::facts::answer::{Answer, AnswerSensor, ShownPlan, Tile};
use crate::report::html::facts::good::Good;

pub(super) fn section(facts: &Facts) -> Markup {
    match &facts.answer {
        Some(answer) => html! {
            section #answer {
                (said(answer, &facts.good))
                @if let Some(plan) = answer.plans.first() { (floor_plan(plan)) }
            }
        },
        None => html! {
            p.disclaimer {
                "A planning aid, not a validation: " a href="#assumed" { "what was assumed" }
                ". No choice of poses has a score, so nothing is recommended."
            }
        },
    }
}

fn said(answer: &Answer, good: &Good) -> Markup {
    html! {
        div.said {
            p.asked { (answer.asked) }
            div.named { h2 { "Recommended" } p { (answer.set) } }
            ul.sensors { @for sensor in &answer.sensors { (placed(sensor)) } }
            p.overall.(good.verdict()) { strong { "Good enough?" } " " b { (good.overall()) } }
            p.note {
                "This is " (answer.why) ". " a href="#instead" { "What instead?" } " " a href="#where" { "Where exactly?" }
            }
            dl.tiles { @for tile in &answer.tiles { (shown(tile)) } }
            p.note { (answer.counted) "." }
            @for thinned in &answer.thinned { p.note.thinned { (thinned) } }
            @if !good.required.is_empty() {
                ul.verdicts {
                    @for one in &good.required {
                        li.(one.verdict()) {
                            b { (one.verdict()) }
                            span { strong { (one.name) } " " span.note { (one.asked) ": " (one.found()) } }
                        }
                    }
                }
            }
            p.disclaimer { "A planning aid, not a validation: " a href="#assumed" { "what was assumed" } "." }
        }
    }
}

fn placed(sensor: &AnswerSensor) -> Markup {
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

fn shown(tile: &Tile) -> Markup {
    html! {
        div {
            dt { (tile.name) }
            dd {
                strong { (tile.value) }
                span { (tile.meaning) }
                @for note in &tile.notes { span { (note) } }
            }
        }
    }
}

fn floor_plan(plan: &ShownPlan) -> Markup {
    html! {
        figure.floor-plan {
            (PreEscaped(&plan.svg))
            figcaption {
                ul.legend {
                    @for (sign, meaning) in &plan.legend {
                        li {
                            svg.plan viewBox="0 0 24 16" width="24" height="16" aria-hidden="true" { (PreEscaped(sign)) }
                            (meaning)
                        }
                    }
                }
                p { (plan.title) ". " (plan.floor) }
            }
        }
    }
}
