//! Where exactly sensors are mounted.

use maud::{Markup, PreEscaped, html};

use super::tables::{sheet, title};
use crate::report::html::facts::Facts;

pub(super) fn section(facts: &Facts) -> Markup {
    html! {
        section #where {
            h2 { "Where exactly?" }
            p.hint {
                "Distances are to the next surface along each axis, in the scene’s files and not in voxels, people and \
                 robots left out; the arrow shows where the sensor looks."
            }
            @for one in &facts.sheets {
                div.mount {
                    (sheet(one))
                    div.sketches { @for sketch in &one.sketches { (PreEscaped(sketch)) } }
                }
            }
            details.aside {
                summary { "Mounting sheets of the best placements by each score" }
                @for region in &facts.regions {
                    @for best in &region.best {
                        (title(region, best))
                        p { (best.rows[0].place) }
                        div.sheets { @for one in &best.sheets { (sheet(one)) } }
                    }
                }
            }
        }
    }
}
