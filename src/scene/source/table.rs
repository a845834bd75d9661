//! Says what is wrong with a table (CSV) by its line and cell: rows that the parser refuses, and tables as spreadsheets
//! write them where the comma is the decimal sign: columns separated by semicolons or tabs, numbers with a decimal comma.

use csv::{DeserializeErrorKind, Error, ErrorKind};

use perirobot_march::error::Issue;

/// What is wrong with a table, as its parser found it.
pub fn table_issue(e: &Error) -> Issue {
    let line = |position: &Option<csv::Position>, issue: Issue| match position {
        Some(position) => issue.with_place(format!("line {}", position.line())),
        None => issue,
    };
    match e.kind() {
        ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let what = Issue::damaged(format!("has {len} cells"))
                .with_advice(format!("must be {expected_len}, as in the header"));
            line(pos, what)
        }
        ErrorKind::Deserialize { pos, err } => {
            let cell = err.field().map_or("a cell".into(), |cell| format!("cell {}", cell + 1));
            let what = match err.kind() {
                DeserializeErrorKind::ParseFloat(_) | DeserializeErrorKind::ParseInt(_) => Issue::damaged(
                    format!("{cell} is not a number"),
                )
                .with_advice("write it with a decimal point, as in 1.5, and cells with commas between them"),
                DeserializeErrorKind::UnexpectedEndOfRow => Issue::damaged("has too few cells"),
                other => Issue::damaged(other.to_string()),
            };
            line(pos, what)
        }
        ErrorKind::Utf8 { pos, .. } => {
            line(pos, Issue::says("is not UTF-8 text").with_advice("save it as UTF-8"))
        }
        _ => Issue::damaged("is not a table with commas between its cells"),
    }
}

/// Refuses a table whose first line is separated by semicolons or tabs.
///
/// # Errors
/// With the line, and what to write instead.
pub fn refuse_other_separators(text: &str) -> Result<(), Issue> {
    let mut lines = text.lines().enumerate();
    let first = lines.find(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let Some((number, line)) = first else { return Ok(()) };
    let unquoted = || line.split('"').step_by(2);
    let has = |sign: char| unquoted().any(|part| part.contains(sign));
    let separator = match (has(';'), has('\t') && !has(',')) {
        (true, _) => "semicolons",
        (_, true) => "tabs",
        _ => return Ok(()),
    };
    Err(Issue::says(format!("columns are separated by {separator}"))
        .with_advice("separate them by commas, and write numbers with a point, as in 0.5,1.25,2")
        .with_place(format!("line {}", number + 1)))
}

/// Refuses a row with another number of cells than its table has columns.
///
/// # Errors
/// With both numbers, and with the cause if decimal commas are one.
pub fn refuse_width<'c>(cells: impl Iterator<Item = &'c str> + Clone, columns: usize) -> Result<(), Issue> {
    let count = cells.clone().count();
    if count == columns {
        return Ok(());
    }
    let what = Issue::says(format!("has {count} fields, the header {columns}"));
    Err(match decimal_commas(cells, columns) {
        Some(cause) => what.with_advice(cause),
        None => what,
    })
}

/// What to do about a row whose numbers have decimal commas: a quoted cell that is one, or more cells than `columns`
/// and all numbers whole. `None` for other rows.
pub fn decimal_commas<'c>(
    cells: impl Iterator<Item = &'c str> + Clone,
    columns: usize,
) -> Option<&'static str> {
    let is_one = |cell: &str| cell.contains(',') && cell.replacen(',', ".", 1).parse::<f64>().is_ok();
    let numbers = || cells.clone().filter(|cell| cell.parse::<f64>().is_ok());
    let are_cut = cells.clone().count() > columns
        && numbers().count() >= 2
        && numbers().all(|cell| cell.parse::<i64>().is_ok());
    (cells.clone().any(is_one) || are_cut).then_some("numbers have a decimal comma: write 1.5, not 1,5")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_the_line_and_the_cell() {
        #[derive(Debug, serde::Deserialize)]
        #[expect(dead_code, reason = "it is only read")]
        struct ReadRow {
            x: f64,
            y: f64,
        }
        for (text, expected) in [
            ("x,y\n1,2\n1\n", "line 3: has 1 cells: must be 2, as in the header"),
            ("x,y\n1,two\n", "line 2: cell 2 is not a number: write it with a decimal point"),
            ("x;y\n1;2\n", "missing field `x`"),
        ] {
            let mut reader = csv::Reader::from_reader(text.as_bytes());
            let e = reader.deserialize::<ReadRow>().find_map(Result::err).unwrap();
            let said = table_issue(&e).to_string();
            assert!(said.contains(expected), "{said:?} lacks {expected:?}");
        }
    }

    #[test]
    fn separators_of_spreadsheets_are_named() {
        for (text, expected) in [
            ("time_s;a\n0;1\n", Some("line 1: columns are separated by semicolons: separate them by commas")),
            ("# by hand\n\n0,1;0,2;1,6\n", Some("line 3: columns are separated by semicolons")),
            ("x\ty\tz\n", Some("line 1: columns are separated by tabs")),
            ("\"a;b\",c\n", None),
            ("a, \tb\n", None),
            ("", None),
        ] {
            let found = refuse_other_separators(text).map_err(|issue| issue.to_string());
            match expected {
                Some(expected) => {
                    assert!(found.as_ref().is_err_and(|e| e.starts_with(expected)), "{found:?}")
                }
                None => assert_eq!(found, Ok(()), "{text:?}"),
            }
        }
    }

    #[test]
    fn decimal_commas_are_named() {
        for (row, columns, is_so) in [
            (&["nose", "0", "1", "0", "2", "1", "6"][..], 4, true),
            (&["0,1", "0.2", "0.3"], 3, true),
            (&["-1", "5", "2", "5"], 2, true),
            (&["nose", "0.1", "0.2", "1.6", "9"], 4, false),
            (&["1", "2", "3"], 3, false),
            (&["left,right", "2", "3"], 3, false),
        ] {
            assert_eq!(decimal_commas(row.iter().copied(), columns).is_some(), is_so, "{row:?}");
        }
    }
}
