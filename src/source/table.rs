//! Says what is wrong with a table (CSV) by its line and cell, in place of what the parser says.

use csv::{DeserializeErrorKind, Error, ErrorKind};

use crate::error::Issue;

/// What is wrong with a table, as its parser found it.
pub(crate) fn table_issue(e: &Error) -> Issue {
    let line = |position: &Option<csv::Position>, issue: Issue| match position {
        Some(position) => issue.at(format!("line {}", position.line())),
        None => issue,
    };
    match e.kind() {
        ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let what = Issue::damaged(format!("has {len} cells"))
                .wanted(format!("must be {expected_len}, as in the header"));
            line(pos, what)
        }
        ErrorKind::Deserialize { pos, err } => {
            let cell = err.field().map_or("a cell".into(), |cell| format!("cell {}", cell + 1));
            let what = match err.kind() {
                DeserializeErrorKind::ParseFloat(_) | DeserializeErrorKind::ParseInt(_) => Issue::damaged(
                    format!("{cell} is not a number"),
                )
                .wanted("write it with a decimal point, as in 1.5, and cells with commas between them"),
                DeserializeErrorKind::UnexpectedEndOfRow => Issue::damaged("has too few cells"),
                other => Issue::damaged(other.to_string()),
            };
            line(pos, what)
        }
        ErrorKind::Utf8 { pos, .. } => line(pos, Issue::says("is not UTF-8 text").wanted("save it as UTF-8")),
        _ => Issue::damaged("is not a table with commas between its cells"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_the_line_and_the_cell() {
        #[derive(Debug, serde::Deserialize)]
        #[expect(dead_code, reason = "it is only read")]
        struct Row {
            x: f64,
            y: f64,
        }
        for (text, expected) in [
            ("x,y\n1,2\n1\n", "line 3: has 1 cells: must be 2, as in the header"),
            ("x,y\n1,two\n", "line 2: cell 2 is not a number: write it with a decimal point"),
            ("x;y\n1;2\n", "missing field `x`"),
        ] {
            let mut reader = csv::Reader::from_reader(text.as_bytes());
            let e = reader.deserialize::<Row>().find_map(Result::err).unwrap();
            let said = table_issue(&e).to_string();
            assert!(said.contains(expected), "{said:?} lacks {expected:?}");
        }
    }
}
