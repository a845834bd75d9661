//! The section on blind space: tables of reasons, and the cell in three dimensions.

use maud::{Markup, PreEscaped, html};

use super::first_screen::ShownPlan;
use crate::report::page::Findings;
use crate::report::page::cells::ExplainedVoxels;
use crate::report::page::leaders::{Leader, leaders};
use crate::report::page::missed::{MissedVoxels, missed_voxels};

/// The misses of the recommended choice, and of the best placements by each score.
pub(super) struct Blind<'a> {
    missed: Vec<MissedVoxels<'a>>,
    of_leaders: Vec<(Leader<'a>, Vec<MissedVoxels<'a>>)>,
    /// The picture of the recommended choice at its worst moment, as a data address.
    picture: Option<String>,
}

impl<'a> Blind<'a> {
    pub(super) fn new(findings: &Findings<'a>, picture: Option<String>) -> Blind<'a> {
        let results = findings.sweep.results;
        let missed_of = |asked| missed_voxels(results, findings.cells, asked);
        let leaders = leaders(results, findings.rankings).into_iter();
        Blind {
            missed: missed_of(ExplainedVoxels::Recommended),
            of_leaders: leaders
                .map(|leader| {
                    let missed =
                        missed_of(ExplainedVoxels::Best { best: leader.best, region: leader.region });
                    (leader, missed)
                })
                .collect(),
            picture,
        }
    }

    /// The section, with the floor plans of all scenes but the first.
    pub(super) fn view(&self, plans: &[ShownPlan]) -> Markup {
        html! {
            section #blind {
                h2 { "What stays blind, and why?" }
                @for missed in &self.missed { (missed.view()) }
                (cell(self.picture.as_deref()))
                h3 #reasons-title { "Why voxels stay unknown" }
                p #reasons-note.hint {
                    "Each unknown voxel of the region has the first reason that applies to the ray nearest to its centre. \
                     Monitored: a sensor looks there but cannot label it. reasons.csv has the totals of the \
                     best poses."
                }
                div #reasons.plot {}
                @if plans.len() > 1 { (floor_plans(&plans[1..])) }
                details.aside {
                    summary { "What the best placements by each score miss" }
                    @for (leader, all) in &self.of_leaders {
                        (leader.title())
                        @for missed in all { (missed.view()) }
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
                                "As the program draws what is recommended, at its worst moment: blue and green voxels are \
                                 labelled occupied, grey and orange ones are unknown."
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
