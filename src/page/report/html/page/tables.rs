//! What several sections show: tables, mounting sheets, and why voxels are missed.

use maud::{Markup, html};

use crate::report::html::facts::Titled;
use crate::report::html::facts::best::{Best, RegionBest};
use crate::report::html::facts::mount::Sheet;
use crate::report::reasons::Explained;

/// A table under its title. On a phone each cell has the name of its column.
pub(super) fn plain((title, table): &Titled) -> Markup {
    html! {
        div.wide.cards tabindex="0" role="group" aria-label=(title) {
            table.plain {
                caption { (title) }
                thead { tr { @for name in &table.columns { th { (name) } } } }
                tbody {
                    @for row in &table.rows {
                        tr { @for (name, cell) in table.columns.iter().zip(row) { td data-name=(name) { (cell) } } }
                    }
                }
            }
        }
    }
}

/// The title of what is told of the best placement by a score.
pub(super) fn title(region: &RegionBest, best: &Best) -> Markup {
    html! { h4 { "The best by " (best.by) " in region “" (region.name) "”: " (best.rows[0].poses) } }
}

/// How to mount a sensor.
pub(super) fn sheet(sheet: &Sheet) -> Markup {
    html! {
        table.sheet {
            caption { "Mounting sheet: " (sheet.sensor) ", " (sheet.pose) }
            @for (name, value) in &sheet.lines { tr { th scope="row" { (name) } td { (value) } } }
            @if !sheet.device.is_empty() { tr { th scope="row" { "device" } td { (sheet.device) } } }
        }
    }
}

/// What a placement misses in a scene.
pub(super) fn missed((scene, why): &(String, &Explained)) -> Markup {
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
            ul { @for (cause, cure) in &why.advice { li { (cause) ": " (cure) } } }
        }
    }
}
