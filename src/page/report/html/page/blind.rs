//! What stays blind, and why: tables, and the cell in three dimensions.

use maud::{Markup, PreEscaped, html};

use super::tables::{missed, title};
use crate::report::html::facts::Facts;
use crate::report::html::facts::answer::ShownPlan;

pub(super) fn section(facts: &Facts, picture: Option<&str>) -> Markup {
    let plans = facts.answer.as_ref().map_or(&[][..], |answer| &answer.plans[..]);
    html! {
        section #blind {
            h2 { "What stays blind, and why?" }
            @for why in &facts.missed { (missed(why)) }
            (cell(picture))
            h3 #reasons-title { "Why voxels stay unknown" }
            p #reasons-note.hint {
                "Each unknown voxel of the region has the first reason that applies to the ray nearest to its centre. \
                 Monitored: a sensor looks there, and something keeps it from knowing. reasons.csv has the totals of the \
                 best poses."
            }
            div #reasons.plot {}
            @if plans.len() > 1 { (floor_plans(&plans[1..])) }
            details.aside {
                summary { "What the best placements by each score miss" }
                @for region in &facts.regions {
                    @for best in &region.best {
                        (title(region, best))
                        @for why in &best.missed { (missed(why)) }
                    }
                }
            }
        }
    }
}

fn cell(picture: Option<&str>) -> Markup {
    html! {
        div #cell {
            h3 { "The cell, as the selected pose labels it" }
            form #layers.controls aria-label="Layers of the 3D view" {}
            form #causes.controls aria-label="Why voxels are unknown" {}
            p #cell-note {}
            div.beside {
                div {
                    div #view.plot.tall {}
                    figure #picture hidden[picture.is_none()] {
                        @if let Some(address) = picture {
                            img src=(address) alt="The recommended choice of poses, as the program draws it";
                            figcaption {
                                "As the program draws what is recommended, at its worst moment: what is blue and green is \
                                 called occupied, what is grey and orange is unknown."
                            }
                        }
                    }
                }
                div #sheet.sheets {}
            }
        }
    }
}

fn floor_plans(plans: &[ShownPlan]) -> Markup {
    html! {
        details {
            summary { "Floor plans of the other scenes" }
            div.plots-of-floor {
                @for plan in plans {
                    figure {
                        (PreEscaped(&plan.svg))
                        figcaption { p { (plan.title) ". " (plan.floor) } }
                    }
                }
            }
        }
    }
}
