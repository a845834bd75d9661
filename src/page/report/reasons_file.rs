//! The table `reasons`, made for pandas: why voxels of the regions stay unknown. `view::why` defines the reasons.
//!
//! | column | |
//! |---|---|
//! | `scene`, `snapshot`, `repeat`, `combination`, `poses`, `representation`, `region` | as in `results` |
//! | `reason` | one of those of [`perirobot_decide::view::why`] |
//! | `object` | the object that hides a hidden voxel, or blinds the ray of a blind one; else empty |
//! | `monitored` | 1 if a sensor watches the voxels anyway (the paper's monitored, but occluded), else 0 |
//! | `voxels_occupied`, `voxels_free` | the part of the row's `uo` and `uf` in `results` with this reason |
//! | `voxels_human` | the part of its `uo_human` |
//!
//! Reasons without voxels have no row; the others add up to the unknown voxels of a row of `results`.

use std::path::Path;

use perirobot_decide::view::View;
use perirobot_decide::view::why::Missed;
use perirobot_march::Result;
use perirobot_sweep::results::columns::{pose_names, representation_names};
use perirobot_sweep::results::table::{
    Column, ColumnKind, Datum, RowSink, TableFile, TableFormat, csv_bytes,
};

/// The name of the file, without its extension.
pub const REASONS: &str = "reasons";

/// The table during writing. If it is dropped before [`ReasonsFile::finish`], no file is left.
pub struct ReasonsFile {
    table: TableFile,
    rows: u64,
}

impl ReasonsFile {
    /// Starts the table.
    pub fn create(folder: &Path, format: TableFormat) -> Result<ReasonsFile> {
        let path = folder.join(format!("{REASONS}.{}", format.extension()));
        Ok(ReasonsFile { table: TableFile::create(&path, format, &columns())?, rows: 0 })
    }

    /// Appends the rows of a view: region by region, in the order of the reasons.
    pub fn add(&mut self, view: &View, missed: &[Missed]) -> Result<()> {
        each(view, missed, &mut |fields| {
            self.rows += 1;
            self.table.row(fields)
        })
    }

    /// Its final path.
    pub fn path(&self) -> &Path {
        self.table.path()
    }

    /// Moves the table to its path; returns the number of rows.
    pub fn finish(self) -> Result<u64> {
        self.table.finish()?;
        Ok(self.rows)
    }
}

/// The table of one view as CSV, in memory.
pub fn csv(view: &View, missed: &[Missed]) -> Result<Vec<u8>> {
    csv_bytes(&columns(), |sink| each(view, missed, sink))
}

fn columns() -> Vec<Column> {
    let of_kind = |kind: ColumnKind| move |name: &str| Column::new(name, kind);
    let mut columns = vec![Column::new("scene", ColumnKind::Text)];
    columns.extend(["snapshot", "repeat"].map(of_kind(ColumnKind::Count)));
    let texts = ["combination", "poses", "representation", "region", "reason", "object"];
    columns.extend(texts.map(of_kind(ColumnKind::Text)));
    let counts = ["monitored", "voxels_occupied", "voxels_free", "voxels_human"];
    columns.extend(counts.map(of_kind(ColumnKind::Count)));
    columns
}

fn each(view: &View, missed: &[Missed], sink: RowSink) -> Result<()> {
    let [combination, poses, representation] = names(view);
    for (region, (name, _)) in view.study.regions.iter().enumerate() {
        for tally in view.tally(missed, region) {
            let object = view.object(&tally.cause).unwrap_or_default();
            let mut fields = vec![Datum::Text(&view.world.name)];
            fields.extend([view.world.snapshot, view.choice.repeat].map(|n| Datum::Count(n as u64)));
            let reason = tally.cause.reason;
            let texts = [&combination, &poses, &representation, name, reason.name(), object];
            fields.extend(texts.map(Datum::Text));
            let counts = [reason.is_monitored().into(), tally.occupied, tally.free, tally.human];
            fields.extend(counts.map(Datum::Count));
            sink(&fields)?;
        }
    }
    Ok(())
}

/// Combination, poses and representation of a view, as in the columns of `results`.
pub(super) fn names(view: &View) -> [String; 3] {
    let combination = &view.study.combinations[view.choice.combination];
    let representation =
        representation_names(view.study, combination).swap_remove(view.choice.representation);
    [combination.name.clone(), pose_names(view.study, combination, view.choice.choice), representation]
}
