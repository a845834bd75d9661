//! How to read the scores, and the numbers of mounting sheets.

use maud::{Markup, html};

/// A list of terms; `plain_means` is the note on means of snapshots with weights.
pub(super) fn view(plain_means: Option<&str>) -> Markup {
    html! {
        p { "F1 and κ are numbers; all other scores are shares, in percent." }
        dl {
            dt { "F1, κ" }
            dd {
                "Agreement of the labels with the truth, over all voxels of the region (1 is perfect); \
                 unknown voxels count against a pose. F1 is 2 TP / (2 TP + FP + FN + UO + UF); κ is Cohen’s, of labels \
                 occupied, free and unknown against what is there. Means over scenes, snapshots and repeats, the worst of \
                 any beside them; [n] before a mean: only n of them have a value."
                @if let Some(plain) = plain_means { " " (plain) }
                " Answers without a sensor are there to compare: one that always says “occupied” beats many poses. The \
                 upper bound is what all positions of the study together could reach."
            }
            dt { "human seen" }
            dd {
                "Share of the people’s voxels in the region with a true return, independent of the measured \
                 distance, or detected by a presence sensor (pad, gate, cover, field, zone camera). Only the near side of a body \
                 can be hit: it stays well below 100 %, which parts detected can reach."
            }
            dt { "human claimed" }
            dd {
                "Share of the people’s voxels in the region that are labelled occupied, correctly or by noise: to be read \
                 with the false alarms."
            }
            dt { "people, parts detected" }
            dd {
                "A body part is detected if enough of its voxels are hit (min_hits of the study), a person if one part \
                 is, or if a presence sensor feels the person."
            }
            dt { "unknown" }
            dd { "Share of the region without a label." }
            dt { "false alarm" }
            dd { "Share of the labelled free voxels that are labelled occupied." }
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
