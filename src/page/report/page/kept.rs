//! Tables that `judge` and `approach` have written into the folder, and which of their rows are of a choice.

use std::path::Path;

use crate::report::table::Table;
use perirobot_march::voxel::{rounded_down, rounded_up};
use perirobot_march::{Error, Result};

/// The columns that say of which choice a row is.
const OF: [&str; 3] = ["combination", "poses", "representation"];

/// A table, or some rows of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kept {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Kept {
    /// The table in a file; without a row where there is no such file.
    ///
    /// # Errors
    /// When the file cannot be read, or is no table.
    pub(crate) fn read(path: &Path) -> Result<Kept> {
        if !path.exists() {
            return Ok(Kept::default());
        }
        let wrong =
            |e: csv::Error| Error::input(path, format!("cannot be read: {e}")).wanted("make it again");
        let mut csv = csv::Reader::from_path(path).map_err(wrong)?;
        let names = csv.headers().map_err(wrong)?.iter().map(String::from).collect();
        let rows = csv.records().map(|row| Ok(row.map_err(wrong)?.iter().map(String::from).collect()));
        Ok(Kept { names, rows: rows.collect::<Result<_>>()? })
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    pub(crate) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|values| Row { names: &self.names, values })
    }

    /// The rows that are meant, and the others.
    pub(crate) fn parted(&self, is_meant: impl Fn(&Row) -> bool) -> [Kept; 2] {
        [true, false].map(|wanted| {
            let rows = self.rows().filter(|row| is_meant(row) == wanted);
            Kept { names: self.names.clone(), rows: rows.map(|row| row.values.to_vec()).collect() }
        })
    }

    /// Some of its columns, those that it has.
    pub(super) fn table(&self, wanted: &[&str]) -> Table {
        let found: Vec<usize> =
            wanted.iter().filter_map(|name| self.names.iter().position(|known| known == name)).collect();
        let columns: Vec<String> =
            found.iter().map(|&column| format!("<{}", self.names[column].replace('_', " "))).collect();
        let mut table = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
        for row in &self.rows {
            let row = Row { names: &self.names, values: row };
            table.row(found.iter().map(|&column| row.shortened(column)));
        }
        table
    }
}

/// A row of a table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row<'k> {
    names: &'k [String],
    values: &'k [String],
}

impl<'k> Row<'k> {
    /// What is in a column; nothing where the table has none of this name.
    pub(super) fn of(&self, name: &str) -> &'k str {
        let column = self.names.iter().position(|known| known == name);
        column.map_or("", |column| self.values[column].as_str())
    }

    /// What is in a column, a number with at most four digits after the point; distances are rounded to the safe side.
    fn shortened(&self, column: usize) -> String {
        let text = &self.values[column];
        let value = match text.parse::<f64>() {
            Ok(value) if text.len() > 6 => value,
            _ => return text.clone(),
        };
        let is_kept = |name: &str| ["deepest_m", "noticed_m", "margin_m"].contains(&name);
        let is_kept = is_kept(&self.names[column])
            || ["nearest_unnoticed_m", "approach_margin_m"].contains(&self.of("score"));
        match self.names[column].as_str() {
            "needed_m" => rounded_up(value, 4),
            _ if is_kept => rounded_down(value, 4),
            _ if self.of("score") == "missed_m" => rounded_up(value, 4),
            _ => format!("{value:.4}"),
        }
    }

    /// Of which choice it is: combination, poses and representation.
    pub(crate) fn choice(&self) -> [String; 3] {
        OF.map(|column| self.of(column).to_string())
    }

    /// Whether it is of a choice: of this combination, these poses and this representation.
    pub(crate) fn is_of(&self, choice: &[String; 3]) -> bool {
        OF.iter().zip(choice).all(|(column, name)| self.of(column) == name)
    }
}
