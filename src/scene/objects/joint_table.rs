//! Reads what a robot did as a table: a time and a value for each joint in a row, as recordings of joint states are
//! written. Between two rows the joints go evenly from one to the other; before the first and after the last they stay.
//! A joint that turns without end is often recorded within half a turn of 0: it goes the shorter way.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::source::{Sources, decimal_commas, refuse_other_separators, refuse_width, table_issue};
use perirobot_march::Result;
use perirobot_march::error::Issue;

/// Most values of a table: about 1 GB.
const MOST_VALUES: usize = 100_000_000;
/// No value is larger; beyond it there are slips of the pen.
const LARGEST: f64 = 1e6;

/// A table, and what the user says about it.
#[derive(Clone, Debug, PartialEq)]
pub struct JointTableFile {
    /// The file.
    pub path: PathBuf,
    /// In what its angles are.
    pub angles: AngleUnit,
}

/// In what angles are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum AngleUnit {
    /// Degrees.
    Deg,
    /// Radians, as ROS records them.
    Rad,
}

/// A table that was read: `time_s` and a column for each joint.
#[derive(Debug)]
pub struct JointTable {
    /// The columns but for the first.
    joints: Vec<String>,
    /// Strictly increasing, at least one.
    times_s: Vec<f64>,
    /// Row by row.
    values: Vec<f64>,
}

impl JointTable {
    /// Reads a CSV whose first column is `time_s` and whose others are named after joints.
    ///
    /// # Errors
    /// When the file cannot be read, a column has no name of its own, a cell is not a number, or times do not increase.
    pub fn load(path: &Path, sources: &Sources) -> Result<JointTable> {
        parse(&sources.table(path)?).map_err(|issue| issue.with_place(path).into())
    }

    /// Its first and its last time, in seconds.
    pub(super) fn span_s(&self) -> [f64; 2] {
        [self.times_s[0], self.times_s[self.times_s.len() - 1]]
    }

    /// Each joint and its value at a time; a whole turn of joints that turn without end is told by their names.
    pub(super) fn values_at(
        &self,
        time_s: f64,
        turn: impl Fn(&str) -> Option<f64>,
    ) -> impl Iterator<Item = (&str, f64)> {
        // How many rows lie at or before the time.
        let after = self.times_s.partition_point(|&row| row <= time_s);
        let last = self.times_s.len() - 1;
        let (row, next) = (after.saturating_sub(1), after.min(last));
        let gap_s = self.times_s[next] - self.times_s[row];
        let share = if gap_s > 0.0 { (time_s - self.times_s[row]) / gap_s } else { 0.0 };
        let value = move |row: usize, joint: usize| self.values[row * self.joints.len() + joint];
        self.joints.iter().enumerate().map(move |(joint, name)| {
            let (from, to) = (value(row, joint), value(next, joint));
            let way = match turn(name) {
                // Half a turn away goes as it is written.
                Some(turn) if (to - from).abs() > turn / 2.0 => {
                    to - from - turn * libm::round((to - from) / turn)
                }
                _ => to - from,
            };
            (name.as_str(), from + share * way)
        })
    }
}

fn parse(text: &str) -> Result<JointTable, Issue> {
    refuse_other_separators(text)?;
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let mut records = reader.records();
    let header = records.next().ok_or_else(|| Issue::says("has no header"))?.map_err(|e| table_issue(&e))?;
    let joints: Vec<String> = header.iter().skip(1).map(String::from).collect();
    if header.get(0) != Some("time_s") || joints.is_empty() {
        return Err(Issue::says(format!(
            "its header begins with {:.40?}",
            header.get(0).unwrap_or_default()
        ))
        .with_advice("must be time_s, then the names of joints"));
    }
    let mut seen = HashSet::new();
    if let Some(wrong) = joints.iter().find(|name| name.is_empty() || !seen.insert(name.as_str())) {
        return Err(Issue::says(format!("column {wrong:?}")).with_advice("each must have a name of its own"));
    }
    let (mut times_s, mut values): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    for record in records {
        let record = record.map_err(|e| table_issue(&e))?;
        let line = record.position().map_or(0, csv::Position::line);
        refuse_width(record.iter(), header.len())
            .map_err(|issue| issue.with_place(format!("line {line}")))?;
        let number = |(cell, column): (&str, &str)| {
            let number = cell.parse::<f64>().ok().filter(|number| number.abs() <= LARGEST);
            number.ok_or_else(|| {
                let rule = match decimal_commas(std::iter::once(cell), 1) {
                    Some(cause) => cause.into(),
                    None => format!("must be a number from -{LARGEST} to {LARGEST}"),
                };
                Issue::value(column, format!("{cell:.40}"), rule).with_place(format!("line {line}"))
            })
        };
        let row: Vec<f64> = record.iter().zip(&header).map(number).collect::<Result<_, _>>()?;
        if let Some(before) = times_s.last().filter(|before| **before >= row[0]) {
            let rule = format!("must increase, and is {before} before");
            return Err(Issue::value("time_s", row[0], rule).with_place(format!("line {line}")));
        }
        times_s.push(row[0]);
        values.extend_from_slice(&row[1..]);
        if values.len() > MOST_VALUES {
            return Err(Issue::too_large(format!("has more than {MOST_VALUES} values"))
                .with_advice("cut it, or thin it out"));
        }
    }
    if times_s.is_empty() {
        return Err(Issue::says("has no row").with_advice("one for each time"));
    }
    Ok(JointTable { joints, times_s, values })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_go_evenly_between_rows_and_stay_outside() {
        let table = parse("# recorded\ntime_s, a, b\n1, 0, 10\n2, 4, 10\n4, 0, -10\n").unwrap();
        assert_eq!(table.span_s(), [1.0, 4.0]);
        for (time_s, a, b) in [
            (-9.0, 0.0, 10.0),
            (1.0, 0.0, 10.0),
            (1.25, 1.0, 10.0),
            (2.0, 4.0, 10.0),
            (3.0, 2.0, 0.0),
            (4.0, 0.0, -10.0),
            (9.0, 0.0, -10.0),
        ] {
            assert_eq!(
                table.values_at(time_s, |_| None).collect::<Vec<_>>(),
                [("a", a), ("b", b)],
                "{time_s}"
            );
        }
    }

    #[test]
    fn joints_without_end_go_the_shorter_way() {
        let table = parse("time_s, wheel, arm\n0, 170, 170\n1, -170, -170\n2, 10, 10\n3, 730, 0\n").unwrap();
        let turn = |name: &str| (name == "wheel").then_some(360.0);
        for (time_s, wheel, arm) in [
            (0.0, 170.0, 170.0),
            (0.25, 175.0, 85.0),
            (0.5, 180.0, 0.0),
            (0.75, 185.0, -85.0),
            (1.0, -170.0, -170.0),
            // Half a turn is as it is written, and whole turns are none.
            (1.5, -80.0, -80.0),
            (2.5, 10.0, 5.0),
        ] {
            let found: Vec<_> = table.values_at(time_s, turn).collect();
            assert_eq!(found, [("wheel", wheel), ("arm", arm)], "{time_s}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, expected) in [
            ("", "has no header"),
            ("a,b\n0,1\n", "its header begins with \"a\": must be time_s, then"),
            ("time_s\n0\n", "must be time_s, then the names of joints"),
            ("time_s,a,a\n0,1,2\n", "column \"a\": each must have a name of its own"),
            ("time_s,a,\n0,1,2\n", "column \"\""),
            ("time_s,a\n", "has no row"),
            ("time_s,a\n0,1\n0,2\n", "line 3: time_s = 0: must increase, and is 0 before"),
            ("time_s,a\n0,one\n", "line 2: a = one: must be a number"),
            ("time_s,a\n0,nan\n", "line 2: a = nan: must be a number"),
            ("time_s,a\n0,1e7\n", "line 2: a = 1e7: must be a number"),
            ("time_s,a\n0\n", "line 2: has 1 fields, the header 2"),
            ("time_s;a\n0;1\n", "line 1: columns are separated by semicolons"),
            ("time_s,a\n0,5,1,25\n", "line 2: has 4 fields, the header 2: numbers have a decimal comma"),
            ("time_s,a\n0,\"1,25\"\n", "line 2: a = 1,25: numbers have a decimal comma"),
        ] {
            let error = parse(text).expect_err(text).to_string();
            assert!(error.contains(expected), "{error:?} lacks {expected:?}");
        }
    }
}
