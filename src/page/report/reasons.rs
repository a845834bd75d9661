//! The table `reasons`, made for pandas, and its words for people: why voxels of the regions stay unknown,
//! and what would help. `view::why` defines the reasons.
//!
//! | column | |
//! |---|---|
//! | `scene`, `snapshot`, `repeat`, `combination`, `poses`, `representation`, `region` | as in `results` |
//! | `reason` | one of those of [`perirobot_decide::view::why`] |
//! | `object` | what hides a hidden voxel, or blinds the ray of a blind one; else empty |
//! | `monitored` | 1 if some sensor watches the voxels all the same (the paper's monitored, but occluded), 0 if none does |
//! | `voxels_occupied`, `voxels_free` | how many of the row's `uo` and `uf` in `results` have this reason |
//! | `voxels_human` | how many of its `uo_human` |
//!
//! Reasons that no voxel has have no row; those of a row of `results` add up to its unknown voxels.

use std::path::Path;

use super::table::Table;
use super::{Series, series};
use perirobot_decide::view::why::{Cause, CauseTally, Missed, Reason};
use perirobot_decide::view::{Choice, View};
use perirobot_march::Result;
use perirobot_march::metrics::{Confusion, Score};
use perirobot_study::world::place::Places;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::columns::{pose_names, representation_names};
use perirobot_sweep::results::table::{Column, ColumnKind, Datum, TableFile, TableFormat};

/// The name of the file, without its extension.
pub const REASONS: &str = "reasons";

/// The table on its way into a folder. Dropped before [`ReasonsFile::finish`], it leaves nothing behind.
pub struct ReasonsFile {
    table: TableFile,
    rows: u64,
}

impl ReasonsFile {
    /// Begins the table.
    pub fn create(folder: &Path, format: TableFormat) -> Result<ReasonsFile> {
        let of_kind = |kind: ColumnKind| move |name: &str| Column::new(name, kind);
        let mut columns = vec![Column::new("scene", ColumnKind::Text)];
        columns.extend(["snapshot", "repeat"].map(of_kind(ColumnKind::Count)));
        let texts = ["combination", "poses", "representation", "region", "reason", "object"];
        columns.extend(texts.map(of_kind(ColumnKind::Text)));
        let counts = ["monitored", "voxels_occupied", "voxels_free", "voxels_human"];
        columns.extend(counts.map(of_kind(ColumnKind::Count)));
        let path = folder.join(format!("{REASONS}.{}", format.extension()));
        Ok(ReasonsFile { table: TableFile::create(&path, format, &columns)?, rows: 0 })
    }

    /// Appends the rows of a view: region by region, in the order of the reasons.
    pub fn add(&mut self, view: &View, missed: &[Missed]) -> Result<()> {
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
                self.table.row(&fields)?;
                self.rows += 1;
            }
        }
        Ok(())
    }

    /// Where it will be.
    pub fn path(&self) -> &Path {
        self.table.path()
    }

    /// Puts the table in its place; how many rows it has.
    pub fn finish(self) -> Result<u64> {
        self.table.finish()?;
        Ok(self.rows)
    }
}

/// Combination, poses and representation of what is looked at, as in the columns of `results`.
fn names(view: &View) -> [String; 3] {
    let combination = &view.study.combinations[view.choice.combination];
    let representation =
        representation_names(view.study, combination).swap_remove(view.choice.representation);
    [combination.name.clone(), pose_names(view.study, combination, view.choice.choice), representation]
}

/// The best choices by some scores over all scenes, snapshots and repeats, this many of each combination and
/// representation in each region, without duplicates: combination, choice and representation, in study order.
pub fn leaders(results: &Results, count: usize, scores: &[Score]) -> Result<Vec<[usize; 3]>> {
    let mut leaders = Vec::new();
    for one in series(results, 0..results.combinations.len()) {
        for region in 0..results.regions.len() {
            for &score in scores {
                let Series { combination, representation } = one;
                let best = one.best(results, &results.moments(), region, score)?;
                leaders.extend(
                    best.into_iter().take(count).map(|(choice, _)| [combination, choice, representation]),
                );
            }
        }
    }
    leaders.sort_unstable();
    leaders.dedup();
    Ok(leaders)
}

/// The best choice of all by a score in a region: combination, choice and representation; `None` where
/// nothing has a value.
pub fn leader(results: &Results, region: usize, score: Score) -> Result<Option<[usize; 3]>> {
    let mut leader: Option<([usize; 3], f64)> = None;
    for one in series(results, 0..results.combinations.len()) {
        let best = one.best(results, &results.moments(), region, score)?;
        let Some(&(choice, mean)) = best.first() else { continue };
        if leader.is_none_or(|(_, most)| score.merit(mean) > score.merit(most)) {
            leader = Some(([one.combination, choice, one.representation], mean));
        }
    }
    Ok(leader.map(|(choice, _)| choice))
}

/// Least share of the unknown voxels, in percent, for which a reason gets advice.
const WORTH_ADVICE: u64 = 10;

/// Most pieces of advice for a region.
const MOST_ADVICE: usize = 3;

/// The voxels that a view misses in some regions and why, with advice.
pub fn render(view: &View, missed: &[Missed], regions: impl IntoIterator<Item = usize>) -> String {
    let [combination, poses, representation] = names(view);
    let Choice { repeat, .. } = view.choice;
    let again = if view.study.repeats > 1 { format!(", repeat {repeat}") } else { String::new() };
    let asked = &view.study.combinations[view.choice.combination];
    let place = Places::new(view.study, view.world).of_choice(asked, view.choice.choice);
    let mut text = format!(
        "\n{poses} · {combination} · {representation} · scene {}{again}\n",
        view.world.title(view.study)
    );
    if !place.is_empty() {
        text += &format!("{place}\n");
    }
    for region in regions {
        text +=
            &of_region(view, &view.study.regions[region].0, &view.counts(region), view.tally(missed, region));
    }
    text
}

fn of_region(view: &View, region: &str, counts: &Confusion, tallies: Vec<CauseTally>) -> String {
    let explained = explain(view, counts, tallies);
    let [reason, object, numbers @ ..] = explained.columns();
    let columns: Vec<String> = [reason, object]
        .map(|name| format!("<{name}"))
        .into_iter()
        .chain(numbers.map(String::from))
        .collect();
    let Explained { headline, rows, monitored, advice } = explained;
    let mut text = format!("\n{region} region: {headline}\n");
    if rows.is_empty() {
        return text;
    }
    let mut table = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
    rows.into_iter().for_each(|row| table.row(row));
    text += &table.text();
    text += &format!("  {monitored}\n");
    for (cause, cure) in advice {
        text += &format!("  {cause}: {cure}\n");
    }
    text
}

/// Why voxels of a region stay unknown, for people.
#[derive(Clone, Debug)]
pub(super) struct Explained {
    /// How many, and the most frequent causes.
    pub(super) headline: String,
    /// For each cause, the most frequent first: reason, object, share, voxels, occupied, a person's, free.
    pub(super) rows: Vec<[String; 7]>,
    /// How many are monitored all the same.
    pub(super) monitored: String,
    /// Causes, and what would help.
    pub(super) advice: Vec<(String, String)>,
}

impl Explained {
    /// The columns of its rows.
    pub(super) fn columns(&self) -> [&'static str; 7] {
        ["reason", "object", "share", "voxels", "occupied", "a person's", "free"]
    }
}

/// Explains the unknown voxels of a region by their tallies.
pub(super) fn explain(view: &View, counts: &Confusion, mut tallies: Vec<CauseTally>) -> Explained {
    let unknown = counts.uo + counts.uf;
    // Ties keep the order of the reasons.
    tallies.sort_by_key(|tally| std::cmp::Reverse(tally.voxels()));
    let of_all = percent(unknown, counts.total());
    let people = match counts.human.uo {
        0 => String::new(),
        some => format!(", {some} of them a person's"),
    };
    let mut headline = format!("{of_all} unknown ({unknown} of {} voxels{people})", counts.total());
    if !tallies.is_empty() {
        let phrase = |tally: &CauseTally| {
            format!("{} {}", percent(tally.voxels(), unknown), phrase(view, &tally.cause))
        };
        let phrases: Vec<_> = tallies.iter().take(MOST_ADVICE).map(phrase).collect();
        let more = if tallies.len() > MOST_ADVICE { ", …" } else { "" };
        headline += &format!(": {}{more}", phrases.join(", "));
    }
    let row = |tally: &CauseTally| {
        let CauseTally { cause, occupied, free, human } = tally;
        let object = view.object(cause).unwrap_or_default().to_string();
        let [voxels, occupied, human, free] =
            [tally.voxels(), *occupied, *human, *free].map(|n| n.to_string());
        [cause.reason.name().into(), object, percent(tally.voxels(), unknown), voxels, occupied, human, free]
    };
    let monitored: u64 =
        tallies.iter().filter(|t| t.cause.reason.is_monitored()).map(CauseTally::voxels).sum();
    let worth = tallies.iter().filter(|t| 100 * t.voxels() >= WORTH_ADVICE * unknown).take(MOST_ADVICE);
    Explained {
        headline,
        rows: tallies.iter().map(row).collect(),
        monitored: format!(
            "monitored, but not known: {}; not monitored: {}",
            percent(monitored, unknown),
            percent(unknown - monitored, unknown)
        ),
        advice: worth.map(|t| (phrase(view, &t.cause), advice(view, &t.cause))).collect(),
    }
}

/// Rounded, but not to 0 % unless there is none, nor to 100 % unless it is all.
fn percent(part: u64, of: u64) -> String {
    match (200 * part + of) / (2 * of).max(1) {
        0 if part > 0 => "<1 %".into(),
        100 if part < of => ">99 %".into(),
        rounded => format!("{rounded} %"),
    }
}

/// A cause in words.
pub(super) fn phrase(view: &View, cause: &Cause) -> String {
    let object = view.object(cause).unwrap_or_default();
    match cause.reason {
        Reason::OutOfView => "out of view".into(),
        Reason::OutOfRange => "out of range".into(),
        Reason::Silent => "under a switch that is off".into(),
        Reason::BetweenRays => "between rays".into(),
        Reason::Hidden => format!("hidden by {object}"),
        Reason::Blind => format!("lost to {object}, too near to the lens"),
        Reason::NoReturn => "nothing behind to return the ray".into(),
        Reason::Misread => "misread by noise".into(),
        Reason::Cancelled => "voted down".into(),
    }
}

/// A sentence that says what would help.
fn advice(view: &View, cause: &Cause) -> String {
    let object = view.object(cause).unwrap_or_default();
    match cause.reason {
        Reason::OutOfView => {
            "turn the sensor there, move it back, take a wider field of view, or add a sensor".into()
        }
        Reason::OutOfRange => "move the sensor nearer, or take one that measures farther".into(),
        Reason::Silent => {
            "an idle switch proves nothing here; where the device's does, say otherwise = \"free\"".into()
        }
        Reason::BetweenRays => "move the sensor nearer, or take one with a finer resolution".into(),
        Reason::Hidden => {
            format!("look past {object}, from above or from its other side, or add a sensor there")
        }
        Reason::Blind => {
            format!("move the sensor away from {object}, or, if that is its own mount, say near_ignore_m")
        }
        Reason::NoReturn => {
            "face a wall or the floor; where silence does certify free space, say no_return = \"free\", and \
                             of an open hall outside = \"backdrop\""
                .into()
        }
        Reason::Misread => {
            "readings scatter by more than a voxel: take a steadier sensor, or larger voxels".into()
        }
        Reason::Cancelled => {
            "sensors contradict each other; fusion = \"occupied_wins\" keeps the cautious answer".into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_not_rounded_to_nothing_or_all() {
        let shares = [(0, 10), (1, 1000), (1, 200), (1, 3), (999, 1000), (10, 10), (0, 0)];
        assert_eq!(
            shares.map(|(part, of)| percent(part, of)),
            ["0 %", "<1 %", "1 %", "33 %", ">99 %", "100 %", "0 %"]
        );
    }
}
