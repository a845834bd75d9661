//! Is it good enough? The verdicts on what a study requires, what scores are under each condition, and how near
//! somebody comes unnoticed: from the files that `judge` and `approach` have written into the folder, as far as they
//! are of the recommended choice, and where there are none, the verdicts with everything as planned.

use super::Titled;
use super::kept::Kept;
use super::near::near;
use super::verdicts::{ShownVerdict, verdicts};
use crate::Result;
use crate::report::html::ReportedSweep;
use crate::report::html::ranking::Ranking;
use crate::report::html::recommended::Recommended;
use crate::results::files::CONDITIONS;
use crate::shell;
use crate::view::Choice;

/// Whether it is good enough.
#[derive(Debug, Default)]
pub(in crate::report::html) struct Good {
    /// Where the verdicts are from, and what of the folder is not shown.
    pub(in crate::report::html) notes: Vec<String>,
    pub(in crate::report::html) verdicts: Vec<ShownVerdict>,
    /// What scores are under each condition, and the ways in.
    pub(in crate::report::html) tables: Vec<Titled>,
    /// Floor plans of approach: their names, and the pictures as addresses.
    pub(in crate::report::html) plans: Vec<(String, String)>,
    /// How more is found out: commands.
    pub(in crate::report::html) commands: Vec<(String, String)>,
}

/// What is known of the recommended choice.
///
/// # Errors
/// When a file of the folder cannot be read, or is none of these tables.
pub(super) fn good(sweep: &ReportedSweep, rankings: &[Ranking], recommended: &Recommended) -> Result<Good> {
    let ReportedSweep { results, study, folder, .. } = *sweep;
    let series = rankings[recommended.series].series;
    let combination = &results.combinations[series.combination];
    let looked = Choice {
        combination: series.combination,
        choice: recommended.choice,
        representation: series.representation,
        repeat: 0,
    };
    let own = [
        combination.name.clone(),
        combination.name_of(recommended.choice),
        combination.representations[series.representation].clone(),
    ];
    let (note, verdicts) = verdicts(sweep, &looked, &own)?;
    let mut good = Good { notes: vec![note], verdicts, ..Good::default() };
    let [conditions, _] = Kept::read(&folder.join(CONDITIONS))?.parted(|row| row.is_of(&own));
    if !conditions.is_empty() {
        let wanted =
            ["condition", "region", "score", "best", "mean", "quantile_05", "worst", "case", "scene"];
        good.tables.push(("What if: each score under each condition".into(), conditions.table(&wanted)));
    }
    let near = near(folder, &own)?;
    good.notes.extend(near.note);
    good.tables.extend(near.tables);
    good.plans = near.plans;
    let [named, poses, representation] = own;
    let words = |command: &str| {
        let folder = folder.display().to_string();
        let mut words =
            vec!["perirobot".to_string(), command.into(), folder.clone(), "--pose".into(), poses.clone()];
        if results.combinations.len() > 1 {
            words.extend(["--combination".into(), named.clone()]);
        }
        if combination.representations.len() > 1 {
            words.extend(["--representation".into(), representation.clone()]);
        }
        if command == "approach" {
            words.extend(["--out".into(), folder]);
        }
        shell::command(&words)
    };
    if !study.requirements.is_empty() {
        good.commands.push(("judge it also with a sensor dead or a mount knocked".into(), words("judge")));
    }
    good.commands.push(("ask how near somebody comes unnoticed".into(), words("approach")));
    Ok(good)
}
