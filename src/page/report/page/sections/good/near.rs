//! How near somebody comes unnoticed: what `approach` has written into the folder, as far as it is of the choice that
//! is shown.

use std::fs;
use std::path::Path;

use base64::{Engine, prelude::BASE64_STANDARD as STANDARD};

use crate::report::page::kept::Kept;
use crate::report::page::plain_table::Titled;
use perirobot_decide::approach::{APPROACH, plan_names};
use perirobot_march::{Error, Result};

/// The largest floor plan that is put into the page.
const MOST_BYTES: u64 = 2_000_000;

/// The columns that are shown.
const COLUMNS: [&str; 13] = [
    "scene",
    "snapshot",
    "people",
    "body",
    "entry",
    "at_entry",
    "deepest_m",
    "noticed_m",
    "needed_m",
    "margin_m",
    "path_m",
    "shadowed_by",
    "unnoticed_m2",
];

/// What is known.
#[derive(Debug, Default)]
pub(super) struct Near {
    /// Of which choice the folder's table is, where it is of another one.
    pub(super) note: Option<String>,
    /// As planned, and what if.
    pub(super) tables: Vec<Titled>,
    /// Floor plans: their names, and the pictures as addresses.
    pub(super) plans: Vec<(String, String)>,
}

/// What the folder's table says of a choice. Only rows with everything as planned stand as the plan's. A floor plan
/// does not say of which choice it is: it is shown where all of the table is of this one, as planned.
///
/// # Errors
/// When a file cannot be read, or is no table.
pub(super) fn near(folder: &Path, own: &[String; 3]) -> Result<Near> {
    let [of_choice, others] = Kept::read(&folder.join(APPROACH))?.parted(|row| row.is_of(own));
    let [planned, altered] = of_choice.parted(|row| row.of("case").is_empty());
    let mut near = Near::default();
    if let Some(row) = others.rows().next().filter(|_| of_choice.is_empty()) {
        let [poses, combination, representation] =
            ["poses", "combination", "representation"].map(|name| row.of(name));
        near.note = Some(format!(
            "The folder's {APPROACH} is of another choice, which is not shown here: {poses} · {combination} · \
             {representation}."
        ));
    }
    if !planned.is_empty() {
        let title = "How near somebody comes unnoticed, as perirobot approach has found";
        near.tables.push((title.into(), planned.table(&COLUMNS)));
    }
    if !altered.is_empty() {
        let title = "What if: how near somebody comes unnoticed where not all is as planned";
        let columns: Vec<&str> = ["case"].into_iter().chain(COLUMNS).collect();
        near.tables.push((title.into(), altered.table(&columns)));
    }
    if altered.is_empty() && others.is_empty() {
        near.plans = plans(folder, &planned)?;
    }
    Ok(near)
}

/// The floor plans that `approach` has drawn with a table, as pictures.
fn plans(folder: &Path, table: &Kept) -> Result<Vec<(String, String)>> {
    let mut drawn: Vec<[&str; 3]> = Vec::new();
    // A body that does not stand on the floor has no area there, and no plan.
    for row in table.rows().filter(|row| !row.of("unnoticed_m2").is_empty()) {
        let plan = ["scene", "body", "people"].map(|name| row.of(name));
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
