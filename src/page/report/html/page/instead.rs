//! The best placements by each score, and how to read the scores.

use maud::{Markup, html};

use super::tables::plain;
use crate::report::html::facts::Facts;
use crate::report::html::facts::best::{BestRow, RegionBest};

/// The columns of the table of a region.
const COLUMNS: [&str; 13] = [
    "sensors · representation",
    "poses",
    "F1",
    "worst F1",
    "κ",
    "human seen",
    "worst human seen",
    "human claimed",
    "people detected",
    "parts detected",
    "worst parts detected",
    "unknown",
    "false alarm",
];

pub(super) fn section(facts: &Facts) -> Markup {
    html! {
        section #instead {
            h2 { "What is recommended, and what instead?" }
            @for region in &facts.regions {
                h3 { "Best placements in region “" (region.name) "”" }
                (best(region))
            }
            @if let Some(front) = &facts.front { @for table in &front.sets { (plain(table)) } }
            details {
                summary { "How to read these numbers" }
                (meanings(facts.plain_means))
            }
        }
    }
}

fn best(region: &RegionBest) -> Markup {
    html! {
        div.wide.cards tabindex="0" role="group" aria-label={ "Best placements in region " (region.name) } {
            table.best {
                thead { tr { @for name in COLUMNS { th { (name) } } } }
                @for best in &region.best {
                    tbody.choices {
                        tr.by { th colspan=(COLUMNS.len()) scope="rowgroup" { "best by " (best.by) } }
                        @for row in &best.rows { (row_of(region, row)) }
                    }
                }
                tbody.baselines {
                    tr.by { th colspan=(COLUMNS.len()) scope="rowgroup" { "answers without a sensor" } }
                    @for (name, values) in &region.baselines {
                        tr {
                            td colspan="2" { (name) }
                            @for (title, value) in values { td data-name=(title) { (value) } }
                        }
                    }
                }
            }
        }
        p { (region.below) }
        p { (region.near_side) }
    }
}

/// A placement; to click on its poses selects it everywhere.
fn row_of(region: &RegionBest, row: &BestRow) -> Markup {
    html! {
        tr class=[(!row.below.is_empty()).then_some("below")] {
            td data-name="sensors" { (row.series) }
            td {
                button.choose type="button" data-series=(row.series_number) data-choice=(row.choice)
                    data-region=(region.number) { (row.poses) }
                br;
                (row.place)
                @if !row.below.is_empty() { br; span.mark { "▼ " (row.below) } }
            }
            @for (name, cell) in &row.cells { td data-name=(name) { (cell) } }
        }
    }
}

fn meanings(plain_means: Option<&str>) -> Markup {
    html! {
        dl {
            dt { "F1, κ" }
            dd {
                "Agreement of what the sensors claim with what is there, over all voxels of the region (1 is perfect); \
                 unknown voxels count against a pose. F1 is 2 TP / (2 TP + FP + FN + UO + UF); κ is Cohen’s, of labels \
                 occupied, free and unknown against what is there. Means over scenes, snapshots and repeats, the worst of \
                 any beside them; [n] before a mean: only n of them have a value."
                @if let Some(plain) = plain_means { " " (plain) }
                " Answers without a sensor are there to compare: one that always says “occupied” beats many poses. The \
                 upper bound is what all positions of the study together could reach."
            }
            dt { "human seen" }
            dd {
                "Share of the people’s voxels in the region that returns truly come from, whatever distance they are read \
                 at, or that a presence sensor (pad, gate, cover, field, zone camera) feels. Only the near side of a body \
                 can be hit: it ends well below 1, while parts detected can reach it."
            }
            dt { "human claimed" }
            dd {
                "Share of the people’s voxels in the region that are labelled occupied, rightly or by noise: to be read \
                 with the false alarms."
            }
            dt { "people, parts detected" }
            dd {
                "A body part is detected if enough of its voxels are hit (min_hits of the study), a person if one part \
                 is, or if a presence sensor feels the person."
            }
            dt { "unknown" }
            dd { "Share of the region that no sensor says anything about." }
            dt { "false alarm" }
            dd { "Share of the free voxels with a label that are called occupied." }
            dt { "position, towards …, down, up" }
            dd {
                "Where the sensor’s origin is, in the world of the scene (z up; of pads and gates it is a corner), and \
                 how far it is from there to the next surface along each axis, in the scene’s files and not in voxels: of \
                 the first scene at its first snapshot, people and robots left out."
            }
            dt { "pan, tilt, roll" }
            dd {
                "Pan: where it looks, counter-clockwise from the x axis, seen from above. Tilt: above (+) or below (−) \
                 the horizon. Roll: clockwise about where it looks, seen from behind it. Straight down, the top of the \
                 picture is towards x at pan 0."
            }
        }
    }
}
