//! The joints of a person: which there are, where they are, and the tables that they are read from, in any of the
//! layouts that detectors and body models write.

mod layout;

use std::path::PathBuf;

use glam::{DQuat, DVec3};

pub use layout::JointLayout;
pub(super) use layout::face;

use crate::source::{Sources, decimal_commas, refuse_other_separators, table_issue};
use crate::spelling::number;
use perirobot_march::Result;
use perirobot_march::error::Issue;

/// COCO's keypoints, in COCO's order. Left and right are the person's own.
pub const JOINTS: [&str; 17] = [
    "nose",
    "left_eye",
    "right_eye",
    "left_ear",
    "right_ear",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
    "left_hip",
    "right_hip",
    "left_knee",
    "right_knee",
    "left_ankle",
    "right_ankle",
];

/// A position in metres for each of [`JOINTS`]; an unknown joint has none.
pub type Keypoints = [Option<DVec3>; 17];

/// The place of the nose in [`JOINTS`].
pub const NOSE: usize = 0;
/// The places of the ears, left and right.
pub const EARS: [usize; 2] = [3, 4];
/// The places of the shoulders.
pub const SHOULDERS: [usize; 2] = [5, 6];
pub(super) const ELBOWS: [usize; 2] = [7, 8];
pub(super) const WRISTS: [usize; 2] = [9, 10];
/// The places of the hips.
pub const HIPS: [usize; 2] = [11, 12];
/// The places of the knees.
pub const KNEES: [usize; 2] = [13, 14];
/// The places of the ankles.
pub const ANKLES: [usize; 2] = [15, 16];

/// No joint lies further from the world's origin; numbers beyond it are millimetres, or nonsense.
pub(super) const FARTHEST_M: f64 = 1000.0;

/// A table of joints, and in which order it has them.
#[derive(Clone, Debug, PartialEq)]
pub struct KeypointFile {
    /// The table.
    pub path: PathBuf,
    /// The order of its rows.
    pub layout: JointLayout,
}

impl KeypointFile {
    /// Reads a CSV of a row for each joint of the layout, in its order, with the columns `x_m,y_m,z_m`, before them
    /// `joint` with the layout's names if the file has them, and behind them `confidence` if the file has it. A header
    /// row and `#` comments are optional; empty cells, cells that are all `nan` and a confidence of 0 mean an unknown
    /// joint.
    ///
    /// # Errors
    /// When the file cannot be read, a row is not as above, or no joint is known.
    pub fn read(&self, sources: &Sources) -> Result<Keypoints> {
        let joints =
            parse(&sources.text(&self.path)?, self.layout).map_err(|issue| issue.with_place(&self.path))?;
        placeholder_remarks(&joints).into_iter().for_each(|what| sources.remark(&self.path, what));
        Ok(joints)
    }
}

/// The joints of a person that ships.
pub fn load_shipped(person: &perirobot_shipped::Person) -> Result<Keypoints> {
    parse(person.joints, JointLayout::Coco17).map_err(|issue| issue.with_place(person.name).into())
}

/// The joints turned about the origin, then moved, as [`super::Mesh::transform`] does with a surface.
pub(crate) fn transform(keypoints: &Keypoints, rotation: DQuat, translation: DVec3) -> Keypoints {
    keypoints.map(|joint| joint.map(|position| rotation * position + translation))
}

fn parse(text: &str, layout: JointLayout) -> Result<Keypoints, Issue> {
    refuse_other_separators(text)?;
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let joints = layout.joints();
    let mut points: Vec<Option<DVec3>> = Vec::with_capacity(joints.len());
    let mut first = true;
    for record in reader.records() {
        let record = record.map_err(|e| table_issue(&e))?;
        let line = record.position().map_or(0, csv::Position::line);
        let cells: Vec<&str> = record.iter().take(6).collect();
        if std::mem::take(&mut first) && is_header(&cells) {
            continue;
        }
        let Some(joint) = joints.get(points.len()) else {
            return Err(Issue::too_large(format!("more than {} joints", joints.len()))
                .with_advice(format!("one row for each joint of {}", layout.describe()))
                .with_place(format!("line {line}")));
        };
        let point = parse_row(joint, layout, &cells).map_err(|issue| {
            let issue = match decimal_commas(record.iter(), 5) {
                Some(cause) => issue.with_advice(cause),
                None => issue,
            };
            issue.with_place(format!("line {line} ({joint})"))
        });
        points.push(point?);
    }
    if points.len() < joints.len() {
        return Err(Issue::says(format!("has {} joints", points.len())).with_advice(format!(
            "{} has {}, with empty cells where one is unknown",
            layout.describe(),
            joints.len()
        )));
    }
    let known: Vec<DVec3> = points.iter().flatten().copied().collect();
    // A row's number before its coordinates would be taken for x, and z for a confidence.
    let counts_rows = |first: usize| {
        points
            .iter()
            .enumerate()
            .all(|(row, point)| point.is_none_or(|point| point.x == (row + first) as f64))
    };
    if known.len() > 1 && (counts_rows(0) || counts_rows(1)) {
        return Err(numbered_rows("x_m is the number of the row in each row"));
    }
    if let [first, second, ..] = known[..]
        && second == first
        && known.iter().all(|point| *point == first)
    {
        return Err(
            Issue::says(format!("all of its joints are at {first}")).with_advice("give each its own place")
        );
    }
    if points.iter().all(Option::is_none) {
        return Err(Issue::says("all joints are empty").with_advice("give the position of at least one"));
    }
    Ok(layout.keypoints(&points))
}

/// What looks as if joints were not found, and the program that wrote the table filled in numbers for them. Joints of the
/// face may lie on each other.
fn placeholder_remarks(joints: &Keypoints) -> Vec<String> {
    let limbs = || joints.iter().zip(JOINTS).skip(SHOULDERS[0]).filter_map(|(at, name)| Some(((*at)?, name)));
    let mut places: Vec<(DVec3, Vec<&str>)> = Vec::new();
    for (at, name) in limbs() {
        match places.iter_mut().find(|(place, _)| *place == at) {
            Some((_, names)) => names.push(name),
            None => places.push((at, vec![name])),
        }
    }
    let is_odd = |(at, names): &(DVec3, Vec<&str>)| *at == DVec3::ZERO || names.len() > 1;
    let told = places.into_iter().filter(is_odd).map(|(DVec3 { x, y, z }, names)| {
        let names = names.join(" and ");
        format!("{names} at exactly {x}, {y}, {z}: leave the cells of a joint empty that was not found")
    });
    told.collect()
}

/// Refuses a column that only counts.
fn numbered_rows(what: &str) -> Issue {
    Issue::says(what).with_advice("remove the column that counts the rows; the columns are x_m,y_m,z_m")
}

fn is_header(cells: &[&str]) -> bool {
    let cells = cells.strip_prefix(&["joint"]).unwrap_or(cells);
    cells.strip_suffix(&["confidence"]).unwrap_or(cells) == ["x_m", "y_m", "z_m"]
}

fn parse_row(joint: &str, layout: JointLayout, cells: &[&str]) -> Result<Option<DVec3>, Issue> {
    // No name is a number.
    let is_name = |cell: &str| !cell.is_empty() && cell.parse::<f64>().is_err();
    let numbers = match cells {
        [name, rest @ ..] if rest.len() >= 3 && is_name(name) => {
            if *name != joint {
                let rule = format!("must be {joint} (the order of {})", layout.describe());
                return Err(Issue::value("joint", format!("{name:.40}"), rule));
            }
            rest
        }
        _ => cells,
    };
    let (coordinates, confidence) = match *numbers {
        [x, y, z] => ([x, y, z], None),
        [x, y, z, confidence] => ([x, y, z], Some(confidence)),
        _ => {
            let rule = "must be x_m,y_m,z_m, with the joint's name before or a confidence behind, if at all";
            return Err(Issue::says(rule));
        }
    };
    if let ([number, "", ""], Some("")) = (coordinates, confidence)
        && !number.is_empty()
    {
        return Err(numbered_rows("x_m is the number of the row"));
    }
    let confidence = confidence.filter(|cell| !cell.is_empty() || coordinates != [""; 3]);
    let is_known = confidence.map_or(Ok(true), |cell| match cell.parse::<f64>() {
        Ok(confidence) if confidence.is_finite() && confidence >= 0.0 => Ok(confidence > 0.0),
        _ => Err(Issue::value("confidence", format!("{cell:.40}"), "must be 0 (unknown) or more")),
    })?;
    let is_missing = |cell: &str| cell.is_empty() || number(cell).is_some_and(f64::is_nan);
    if !is_known || coordinates.iter().all(|cell| is_missing(cell)) {
        return Ok(None);
    }
    let mut position = DVec3::ZERO;
    for (axis, cell) in coordinates.iter().enumerate() {
        let number = cell.parse::<f64>().ok();
        // NaN compares false, and is refused with the rest.
        position[axis] = number.filter(|x| x.abs() <= FARTHEST_M).ok_or_else(|| {
            let key = ["x_m", "y_m", "z_m"][axis];
            let rule = format!("must be metres within {FARTHEST_M} of the origin, or all three empty or nan");
            Issue::value(key, format!("{cell:.40}"), rule)
        })?;
    }
    Ok(Some(position))
}

#[cfg(test)]
mod tests;
