//! Unnoticed approaches: the files of `approach` in the folder, if they belong to the shown choice.

use std::fs;
use std::path::Path;

use base64::{Engine, prelude::BASE64_STANDARD as STANDARD};

use crate::report::page::plain_table::Titled;
use crate::report::table::Table;
use perirobot_decide::approach::{APPROACH, ApproachRow, Approaches, plan_names};
use perirobot_march::voxel::{rounded_down, rounded_up};
use perirobot_march::{Error, Result};

/// The largest floor plan in the page.
const MOST_BYTES: u64 = 2_000_000;

/// The shown columns.
const COLUMNS: [&str; 13] = [
    "scene",
    "snapshot",
    "people",
    "body",
    "entry",
    "at entry",
    "deepest m",
    "noticed m",
    "needed m",
    "margin m",
    "path m",
    "shadowed by",
    "unnoticed m2",
];

/// The column of studies in which bodies walk on what carries them.
const FENCE: &str = "fence between";

/// The column of choices with curtains that latch.
const LATCHES: &str = "latches passed";

/// The facts.
#[derive(Debug, Default)]
pub(super) struct Near {
    /// The choice of the folder's table, if it is another one.
    pub(super) note: Option<String>,
    /// As planned, and altered.
    pub(super) tables: Vec<Titled>,
    /// Floor plans: names, and pictures as addresses.
    pub(super) plans: Vec<(String, String)>,
}

/// The folder's data on a choice. Only the results as planned are shown as the plan's. A floor plan does not name its
/// choice: it is shown if the folder's table is for this one, as planned.
///
/// # Errors
/// If a file cannot be read; those of [`Approaches::read`].
pub(super) fn read_approach(folder: &Path, own: &[String; 3]) -> Result<Near> {
    let mut near = Near::default();
    let Some(approaches) = Approaches::read(folder)?.filter(|found| !found.rows.is_empty()) else {
        return Ok(near);
    };
    let names @ [combination, poses, representation] = approaches.names();
    if names != *own {
        near.note = Some(format!(
            "The folder's {APPROACH} is of another choice, which is not shown here: {poses} · {combination} · \
             {representation}."
        ));
    } else if approaches.case.is_empty() {
        let title = "How near a person gets unnoticed, as perirobot approach has found";
        near.tables
            .push((title.into(), table(&columns(&approaches), &approaches.rows, cells_of(&approaches))));
        near.plans = plans(folder, &approaches.rows)?;
    } else {
        let title = "What if: how near a person gets unnoticed where not all is as planned";
        let columns: Vec<&str> = ["case"].into_iter().chain(columns(&approaches)).collect();
        let cells = cells_of(&approaches);
        let with_case = |row: &ApproachRow| [vec![approaches.case.clone()], cells(row)].concat();
        near.tables.push((title.into(), table(&columns, &approaches.rows, with_case)));
    }
    Ok(near)
}

/// The shown columns; with `floor = "auto"` also the fence, and the latches if one is passed.
fn columns(approaches: &Approaches) -> Vec<&'static str> {
    let latches = has_passed(approaches).then_some(LATCHES);
    COLUMNS.into_iter().chain(latches).chain(approaches.step_m.map(|_| FENCE)).collect()
}

/// Whether a body gets past a curtain that latches.
fn has_passed(approaches: &Approaches) -> bool {
    approaches.rows.iter().any(|row| !row.latches_passed.is_empty())
}

/// The cells in these columns.
fn cells_of(approaches: &Approaches) -> impl Fn(&ApproachRow) -> Vec<String> {
    let (fence, latches) = (approaches.step_m.is_some(), has_passed(approaches));
    move |row| {
        let passed = latches.then(|| row.latches_passed.join(", "));
        let between = fence.then(|| row.fence_between.clone().unwrap_or_default());
        cells(row).into_iter().chain(passed).chain(between).collect()
    }
}

fn table(columns: &[&str], rows: &[ApproachRow], cells: impl Fn(&ApproachRow) -> Vec<String>) -> Table {
    let columns: Vec<String> = columns.iter().map(|name| format!("<{name}")).collect();
    let mut table = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
    rows.iter().for_each(|row| table.row(cells(row)));
    table
}

/// The shown cells of a row; distances are rounded to the safe side.
fn cells(row: &ApproachRow) -> Vec<String> {
    let cell = |number: Option<f64>, shown: &dyn Fn(f64) -> String| number.map_or(String::new(), shown);
    let down = |number| cell(number, &|metres| rounded_down(metres, 4));
    let up = |number| cell(number, &|metres| rounded_up(metres, 4));
    let plain = |number| cell(number, &|number| format!("{number:.4}"));
    vec![
        row.scene.clone(),
        row.snapshot.map_or("*".into(), |snapshot| snapshot.to_string()),
        row.people.name().into(),
        row.body.clone(),
        row.entry.clone(),
        row.at_entry.name().into(),
        down(row.deepest_m),
        down(row.noticed_m),
        up(row.needed_m),
        down(row.margin_m),
        plain(row.path_m),
        row.shadowed_by.clone().unwrap_or_default(),
        plain(row.unnoticed_m2),
    ]
}

/// The floor plans of `approach` next to a table, as pictures.
fn plans(folder: &Path, rows: &[ApproachRow]) -> Result<Vec<(String, String)>> {
    let mut drawn: Vec<[&str; 3]> = Vec::new();
    // A body above the floor has no area and no plan.
    for row in rows.iter().filter(|row| row.unnoticed_m2.is_some()) {
        let plan = [&row.scene, &row.body, row.people.name()];
        if !drawn.contains(&plan) {
            drawn.push(plan);
        }
    }
    let mut plans = Vec::new();
    for name in plan_names(drawn.into_iter()) {
        let path = folder.join(&name);
        if fs::metadata(&path).is_ok_and(|found| found.is_file() && found.len() <= MOST_BYTES) {
            let bytes = fs::read(&path).map_err(|e| Error::io(&path, "cannot be read", e))?;
            plans.push((name, format!("data:image/svg+xml;base64,{}", STANDARD.encode(bytes))));
        }
    }
    Ok(plans)
}
