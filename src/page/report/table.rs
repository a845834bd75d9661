//! A table for people, with two writers: plain text here, HTML in `page/plain_table.rs`. Tables for programs (CSV and
//! Parquet, unrounded) are in `results/table`.

/// The text of a cell without a value.
pub(super) const NONE: &str = "–";

/// Widest aligned column; a cell may be longer. The standard library pads to at most 65,535.
const WIDEST: usize = 1000;

/// Rows of cells below a header; numbers are right-aligned, words left-aligned.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) columns: Vec<String>,
    /// The columns of words.
    words: Vec<bool>,
    pub(super) rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these columns; `<` before a name marks words, `>` numbers, the default. A name from a user's file
    /// needs one of them, since it may itself begin with either.
    pub(super) fn new(columns: &[&str]) -> Self {
        Table {
            columns: columns
                .iter()
                .map(|name| name.strip_prefix(['<', '>']).unwrap_or(name).to_string())
                .collect(),
            words: columns.iter().map(|name| name.starts_with('<')).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row; missing cells at its end are empty.
    pub(super) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// The lines, indented, each with a newline.
    pub(super) fn text(&self) -> String {
        let lines = || [&self.columns].into_iter().chain(&self.rows);
        let length = |cell: &String| cell.chars().count();
        let width = |column: usize| lines().filter_map(|row| row.get(column)).map(length).max();
        let widths: Vec<usize> =
            (0..self.words.len()).map(|column| width(column).unwrap_or(0).min(WIDEST)).collect();
        let mut text = String::new();
        for row in lines() {
            let mut line = String::new();
            for ((cell, &width), &words) in row.iter().zip(&widths).zip(&self.words) {
                line += &if words { format!("  {cell:<width$}") } else { format!("  {cell:>width$}") };
            }
            text += line.trim_end();
            text.push('\n');
        }
        text
    }
}

/// A score in a table.
pub(super) fn number(value: Option<f64>) -> String {
    // Zero has no sign.
    value.map_or(NONE.into(), |v| format!("{:.3}", if v.abs() < 0.0005 { 0.0 } else { v }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_what_they_hold() {
        let mut table = Table::new(&["<pose", "F1", "<at"]);
        table.row(["wände/1".into(), number(Some(0.5)), "x".into()]);
        table.row(["a".into(), number(None)]);
        let long = "x".repeat(65_536);
        let mut wide = Table::new(&["<name", "n"]);
        wide.row([long.clone(), "1".into()]);
        assert!(wide.text().ends_with(&format!("\n  {long}  1\n")));
        assert_eq!([-0.0004, -0.0006].map(|v| number(Some(v))), ["0.000", "-0.001"]);
        assert_eq!(table.text(), "  pose        F1  at\n  wände/1  0.500  x\n  a            –\n");
    }
}
