//! The section on requirements: their verdicts, the scores under each condition, and unnoticed approaches. The data
//! come from the files of `judge` and `approach` in the folder, if they belong to the recommended choice; otherwise
//! only the verdicts as planned are shown.

mod near;

use maud::{Markup, html};

use crate::report::page::judged::JudgedChoice;
use crate::report::page::measure;
use crate::report::page::plain_table::{Titled, plain};
use crate::report::page::recommended::Recommended;
use crate::report::page::verdicts::{ShownRequirement, not_judged, parted_by_now};
use crate::report::page::{Findings, ReportedSweep};
use crate::report::table::Table;
use near::read_approach;
use perirobot_decide::judge::{ConditionScore, JsonNumber, caveats_as_planned};
use perirobot_decide::view::Choice;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_march::voxel::{rounded_down, rounded_up};
use perirobot_scene::shell;
use perirobot_sweep::results::files::CONDITIONS;

/// Whether the choice meets the requirements.
#[derive(Debug, Default)]
pub(super) struct Good {
    /// The source of the verdicts, and parts of the folder that are not shown.
    notes: Vec<String>,
    /// The requirements with their verdicts.
    pub(super) required: Vec<ShownRequirement>,
    /// What speaks against the verdicts.
    caveats: Vec<String>,
    /// The verdicts of each of several judged choices, by name.
    judged: Vec<(String, Good)>,
    /// The scores under each condition, and the ways in.
    tables: Vec<Titled>,
    /// Floor plans of approach: names, and pictures as addresses.
    plans: Vec<(String, String)>,
    /// Commands for more details.
    commands: Vec<(String, String)>,
}

impl Good {
    /// The facts about the recommended choice.
    ///
    /// # Errors
    /// If a file of the folder cannot be read, or is not one of these tables.
    pub(super) fn new(findings: &Findings) -> Result<Good> {
        let mut good = findings.recommended.map(|one| good(findings, one)).transpose()?.unwrap_or_default();
        let refused = findings.refused.as_ref();
        good.notes
            .extend(refused.map(|why| format!("The paths of the nearest approach are not drawn: {why}")));
        Ok(good)
    }

    /// Only the verdicts on a choice, and their source.
    ///
    /// # Errors
    /// If a journal cannot be read.
    pub(super) fn from_verdicts(findings: &Findings, looked: Choice, names: &[String; 3]) -> Result<Good> {
        let (note, required, caveats) = match findings.judged.iter().find(|one| one.names == *names) {
            Some(one) => (one.note.clone(), one.required.clone(), one.verdicts.caveats.clone()),
            None => {
                let (note, required) = not_judged(&findings.sweep, &looked)?;
                let caveats = caveats_as_planned(findings.sweep.study, findings.sweep.worlds, &looked);
                (note, required, caveats)
            }
        };
        Ok(Good { notes: vec![note], required, caveats, ..Good::default() })
    }

    /// The section; `set` is the name of the choice.
    pub(super) fn view(&self, set: Option<&str>) -> Markup {
        html! {
            section #good {
                h2 { "Is it good enough?" }
                @if let Some(set) = set { p { "The verdicts and tables of this section are of " (set) "." } }
                @for note in &self.notes { p { (note) } }
                @if !self.required.is_empty() {
                    p.overall.(self.verdict()) { "By what the study requires, " (self.overall()) "." }
                    (self.view_verdicts())
                    (self.view_caveats())
                }
                @if !self.judged.is_empty() {
                    h3 { "All choices that were judged" }
                    @for (name, one) in &self.judged {
                        details.judged {
                            summary { b.(one.verdict()) { (one.verdict()) } " " (name) ": " (one.overall()) }
                            (one.view_verdicts())
                            (one.view_caveats())
                        }
                    }
                }
                @for table @ (title, _) in &self.tables { details { summary { (title) } (plain(table)) } }
                @for (name, address) in &self.plans {
                    figure.picture { img src=(address) alt=(name); figcaption { (name) } }
                }
                ul { @for (what, command) in &self.commands { li { "To " (what) ": " code { (command) } } } }
            }
        }
    }

    /// The requirements and their verdicts.
    pub(super) fn view_verdicts(&self) -> Markup {
        html! {
            ul.verdicts {
                @for one in &self.required {
                    @for verdict in &one.verdicts {
                        li.(verdict.verdict) {
                            b { (verdict.verdict) }
                            span { strong { (verdict.name) } " " (verdict.words) (one.view_safety_function()) }
                        }
                    }
                }
            }
        }
    }

    /// What speaks against the verdicts.
    pub(super) fn view_caveats(&self) -> Markup {
        html! { @for caveat in &self.caveats { p.overall.OPEN { strong { "But: " } (caveat) "." } } }
    }

    /// FAIL if a requirement is missed, else OPEN if one is not decided or there is none, else PASS.
    pub(super) fn verdict(&self) -> &'static str {
        match self.counts() {
            [_, 0, 0] if !self.required.is_empty() => "PASS",
            [_, 0, _] => "OPEN",
            _ => "FAIL",
        }
    }

    /// All verdicts in a line.
    pub(super) fn overall(&self) -> String {
        let [met, missed, open] = self.counts();
        let many = |count: usize| if count == 1 { "requirement" } else { "requirements" };
        let verdicts: Vec<&str> =
            self.required.iter().flat_map(|one| &one.verdicts).map(|one| one.verdict).collect();
        let all = self.required.len();
        let mut text = match [missed, open] {
            _ if all == 0 => return "not decided: the study names no requirement".into(),
            [0, 0] if !self.caveats.is_empty() => {
                format!("yes, but see below: {met} of {all} {} met", many(all))
            }
            [0, 0] => format!("yes: {met} of {all} {} met", many(all)),
            [0, _] => format!("not decided: {met} of {all} {} met, {open} not decided yet", many(all)),
            [_, 0] => format!("no: {met} of {all} {} met", many(all)),
            _ => format!("no: {met} of {all} {} met, {missed} missed, {open} not decided yet", many(all)),
        };
        if verdicts.len() > all {
            let pass = verdicts.iter().filter(|verdict| **verdict == "PASS").count();
            text += &format!(" ({pass} of {} verdicts are PASS)", verdicts.len());
        }
        text
    }

    /// The verdicts in a few words; `None` without requirements.
    pub(super) fn summary(&self) -> Option<String> {
        let [met, missed, open] = self.counts();
        let all = self.required.len();
        match [missed, open] {
            _ if all == 0 => None,
            [0, 0] => Some(format!("passes {met} of {all}")),
            [0, _] => Some(format!("{open} of {all} requirements not judged yet")),
            _ => Some(format!("fails {missed} of {all}")),
        }
    }

    /// The numbers of met, missed and open requirements.
    fn counts(&self) -> [usize; 3] {
        ["PASS", "FAIL", "OPEN"]
            .map(|verdict| self.required.iter().filter(|one| one.verdict() == verdict).count())
    }
}

fn good(findings: &Findings, recommended: &Recommended) -> Result<Good> {
    let Findings { sweep, rankings, judged, .. } = findings;
    let ReportedSweep { results, study, folder, folder_in_commands, .. } = *sweep;
    let series = rankings[recommended.series].series;
    let combination = &results.combinations[series.combination];
    let looked = recommended.choice(rankings);
    let own = recommended.names(results, rankings);
    let of_own = judged.iter().find(|one| one.names == own);
    let mut good = Good::from_verdicts(findings, looked, &own)?;
    let others = judged.iter().any(|one| one.names != own);
    good.judged = judged.iter().filter(|_| others).map(judged_good).collect();
    let [conditions, old] = parted_by_now(study, of_own.map_or(&[], |one| &one.verdicts.conditions));
    if !old.is_empty() {
        good.notes.push(format!(
            "Rows of {CONDITIONS} rest on tables of the study that have changed since perirobot judge ran, and are not \
             shown."
        ));
    }
    if !conditions.is_empty() {
        good.tables.push(("What if: each score under each condition".into(), table(&conditions)));
    }
    let near = read_approach(folder, &own)?;
    good.notes.extend(near.note);
    good.tables.extend(near.tables);
    good.plans = near.plans;
    let [named, poses, representation] = own;
    let words = |command: &str| {
        let folder = folder_in_commands.display().to_string();
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
    good.commands.push(("ask how near a person gets unnoticed".into(), words("approach")));
    Ok(good)
}

/// Scores under each condition.
fn table(scores: &[&ConditionScore]) -> Table {
    let columns = ["condition", "region", "score", "best", "mean", "quantile 05", "worst", "case", "scene"];
    let mut table = Table::new(&columns.map(|name| format!("<{name}")).each_ref().map(String::as_str));
    for one in scores {
        let mut row =
            vec![one.condition.name().into(), one.region.clone().unwrap_or_default(), one.score.clone()];
        row.extend(
            [one.best, one.mean, one.quantile_05, one.worst].map(|number| shortened(&one.score, number)),
        );
        row.extend([one.worst_at.case.clone(), one.worst_at.scene.clone().unwrap_or_default()]);
        table.row(row);
    }
    table
}

/// A share as percent, another value with at most four decimals; distances are rounded to the safe side.
fn shortened(score: &str, JsonNumber(value): JsonNumber) -> String {
    let text = value.to_string();
    let counted = Score::ALL.into_iter().find(|known| known.name() == score);
    match score {
        _ if counted.is_some_and(measure::is_share) => measure::percent(value, 1),
        _ if text.len() <= 6 => text,
        "nearest_unnoticed_m" | "approach_margin_m" => rounded_down(value, 4),
        "missed_m" => rounded_up(value, 4),
        _ => format!("{value:.4}"),
    }
}

/// A judged choice, by name.
fn judged_good(one: &JudgedChoice) -> (String, Good) {
    let [combination, poses, representation] = &one.names;
    let (required, caveats) = (one.required.clone(), one.verdicts.caveats.clone());
    let good = Good { required, caveats, ..Good::default() };
    (format!("{combination} · {poses} · {representation}"), good)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::page::verdicts::ShownVerdict;

    /// Checks the texts for these verdicts.
    #[track_caller]
    fn check(requirements: &[&[&'static str]], verdict: &str, words: &str) {
        let requirement = |verdicts: &&[&'static str]| {
            let one = |verdict: &&'static str| ShownVerdict {
                verdict,
                name: String::new(),
                words: String::new(),
                brief: String::new(),
            };
            let verdicts = verdicts.iter().map(one).collect();
            ShownRequirement { name: String::new(), asked: String::new(), safety_function: None, verdicts }
        };
        let good = Good { required: requirements.iter().map(requirement).collect(), ..Good::default() };
        assert_eq!((good.verdict(), good.overall().as_str()), (verdict, words));
    }

    #[test]
    fn all_verdicts_are_told_in_a_line() {
        check(&[], "OPEN", "not decided: the study names no requirement");
        check(&[&["PASS"]], "PASS", "yes: 1 of 1 requirement met");
        check(
            &[&["PASS", "FAIL"], &["PASS"]],
            "FAIL",
            "no: 1 of 2 requirements met (2 of 3 verdicts are PASS)",
        );
        check(&[&["PASS"], &["OPEN"]], "OPEN", "not decided: 1 of 2 requirements met, 1 not decided yet");
        let words = "no: 0 of 2 requirements met, 1 missed, 1 not decided yet (1 of 3 verdicts are PASS)";
        check(&[&["PASS", "OPEN"], &["FAIL"]], "FAIL", words);
    }
}
