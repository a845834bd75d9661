//! A table under its title, for several sections.

use maud::{Markup, html};

use crate::report::table::Table;

/// A table and its title.
pub(super) type Titled = (String, Table);

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
