//! What was assumed, and what was run.

use maud::{Markup, html};

use super::tables::plain;
use crate::report::html::facts::Facts;

pub(super) fn section(facts: &Facts) -> Markup {
    html! {
        section #run {
            h2 { "What was run, and what was assumed?" }
            div #assumed {
                h3 { "What was assumed" }
                p {
                    "Scores come from a model of the cell, voxel by voxel. They say which placements are worth trying, \
                     not that a cell is safe. The model knows rays with Gaussian noise, returns lost by chance, mounts \
                     that are as far off as the study says, still snapshots, and the geometry it was given: no \
                     reflections, no motion blur, no other error of a calibration, no failing sensor. Check the chosen \
                     placement on the real cell, by the standards that apply there."
                }
                ul { @for sentence in &facts.assumed { li { (sentence) } } }
            }
            h3 { "What was run" }
            table.lines {
                @for (name, value) in &facts.run.lines { tr { th scope="row" { (name) } td { (value) } } }
            }
            @for table in &facts.run.tables { (plain(table)) }
        }
    }
}
