//! The corners of a field from a table, as makers' tools export them and `perirobot field` writes them.

use std::path::Path;

use serde::Deserialize;

use super::field::{FARTHEST_M, MAX_CORNERS, is_near};
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::source::{Sources, decimal_commas, refuse_other_separators, refuse_width, table_issue};

/// What the columns are.
const COLUMNS: &str =
    "the columns are x_m,y_m: a corner in the scanner's frame, x ahead and y left, in metres";

#[derive(Deserialize)]
struct CornerRow {
    x_m: f64,
    y_m: f64,
}

/// The corners of a table with the columns x_m,y_m, at most [`MAX_CORNERS`].
///
/// # Errors
/// With file, line and what the columns are.
pub(super) fn read_corners(path: &Path, sources: &Sources) -> Result<Vec<[f64; 2]>> {
    let text = sources.table(path)?;
    let unfit = |issue: Issue| Error::from(issue.cure(COLUMNS).with_place(path));
    refuse_other_separators(&text).map_err(unfit)?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let damaged = |e: csv::Error| unfit(table_issue(&e));
    let header = reader.headers().map_err(damaged)?.clone();
    let names: Vec<&str> = header.iter().collect();
    if !matches!(names[..], ["x_m", "y_m"] | ["y_m", "x_m"]) {
        let line = header.position().map_or(1, csv::Position::line);
        let what = format!("has the columns {:.80}", names.join(","));
        return Err(unfit(Issue::says(what).with_place(format!("line {line}"))));
    }
    let mut corners = Vec::new();
    for record in reader.records() {
        let record = record.map_err(damaged)?;
        let line = record.position().map_or(0, csv::Position::line);
        let in_line = |issue: Issue| unfit(issue.with_place(format!("line {line}")));
        refuse_width(record.iter(), header.len()).map_err(in_line)?;
        let CornerRow { x_m, y_m } = record.deserialize(Some(&header)).map_err(|e| {
            in_line(match decimal_commas(record.iter(), header.len()) {
                Some(cause) => Issue::says(cause),
                None => Issue { sites: Vec::new(), ..table_issue(&e) },
            })
        })?;
        if let Some(far) = [x_m, y_m].iter().find(|value| !is_near(value)) {
            let rule = format!("{far}: must be metres within {FARTHEST_M} of the scanner");
            return Err(in_line(Issue::says(rule)));
        }
        if corners.len() == MAX_CORNERS {
            return Err(in_line(Issue::says(format!(
                "is corner {}: at most {MAX_CORNERS} are possible",
                MAX_CORNERS + 1
            ))));
        }
        corners.push([x_m, y_m]);
    }
    Ok(corners)
}
