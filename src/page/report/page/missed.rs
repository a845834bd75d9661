//! The misses of a choice of poses in each scene, and their reasons.

use maud::{Markup, html};

use super::cells::{Cells, ExplainedVoxels};
use crate::report::explained::Explained;
use perirobot_sweep::results::Results;

/// The voxels that stay unknown in a scene at its worst moment.
#[derive(Debug)]
pub(super) struct MissedVoxels<'a> {
    /// The scene and its moment, in words.
    scene: String,
    why: &'a Explained,
}

/// The explained misses of a choice, scene by scene.
pub(super) fn missed_voxels<'a>(
    results: &Results,
    cells: &'a Cells,
    of: ExplainedVoxels,
) -> Vec<MissedVoxels<'a>> {
    let mut missed = Vec::new();
    for scene in &results.scenes {
        let there = cells.labels.iter().filter(|labels| scene.moments.contains(&labels.moment));
        for labels in there {
            let when = match scene.moments.len() {
                1 => String::new(),
                _ => format!(", snapshot {} (its worst)", labels.moment - scene.moments.start),
            };
            let when = if results.repeats > 1 { when + ", first repeat" } else { when };
            let here = labels.explained.iter().filter(|(asked, _)| *asked == of);
            missed
                .extend(here.map(|(_, why)| MissedVoxels { scene: format!("“{}”{when}", scene.name), why }));
        }
    }
    missed
}

impl MissedVoxels<'_> {
    /// An expandable line with a table.
    pub(super) fn view(&self) -> Markup {
        let MissedVoxels { scene, why } = self;
        html! {
            details {
                summary { "What it misses in scene " (scene) ": " (why.headline) }
                div.wide.cards tabindex="0" role="group" aria-label={ "Why voxels stay unknown in scene " (scene) } {
                    table.why {
                        thead {
                            tr { @for name in why.columns() { th { (name) } } }
                        }
                        tbody {
                            @for row in &why.rows {
                                tr { @for (name, cell) in why.columns().iter().zip(row) { td data-name=(name) { (cell) } } }
                            }
                        }
                    }
                }
                p { (why.monitored) }
                ul { @for one in &why.advice { li { (one.cause) ": " (one.cure) } } }
            }
        }
    }
}
