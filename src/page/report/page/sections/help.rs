//! The most useful changes: the largest gains according to the folder, sorted. Ways in that come too near are first,
//! since they decide whether the robot may run; then the largest causes of unknown space.

use maud::{Markup, html};

use crate::report::page::Findings;
use crate::report::page::cells::ExplainedVoxels;
use crate::report::page::measure::percent;
use perirobot_decide::approach::{ApproachRow, Approaches};
use perirobot_march::Result;
use perirobot_march::voxel::{rounded_down, rounded_up};

/// The most changes listed.
const MOST: usize = 3;

/// The most useful changes of the recommended choice.
#[derive(Debug)]
pub(super) struct Help {
    /// The gain of each change, with its description.
    changes: Vec<(String, String)>,
    /// The source of the numbers.
    source: &'static str,
}

impl Help {
    /// `None` if no useful change is known.
    ///
    /// # Errors
    /// Those of [`Approaches::read`].
    pub(super) fn from_findings(findings: &Findings) -> Result<Option<Help>> {
        let Some(recommended) = findings.recommended else { return Ok(None) };
        let region = &findings.sweep.results.regions[recommended.region];
        let mut changes = short_ways(findings)?;
        changes.extend(unknown_causes(findings, region));
        changes.truncate(MOST);
        let source = "The largest gains first, for the recommended set: metres to the distance that is needed, then shares of \
             the region at the worst moment of each scene.";
        Ok((!changes.is_empty()).then_some(Help { changes, source }))
    }

    /// The section.
    pub(super) fn view(&self) -> Markup {
        html! {
            section #help {
                h2 { "What would help most?" }
                ol { @for (gain, change) in &self.changes { li { strong { (gain) } ": " (change) "." } } }
                p.hint { (self.source) }
            }
        }
    }
}

/// The ways in of the recommended choice that come too near, the worst of each entry, shortest first.
fn short_ways(findings: &Findings) -> Result<Vec<(String, String)>> {
    let own = findings.recommended.map(|one| one.names(findings.sweep.results, findings.rankings));
    let found = Approaches::read(findings.sweep.folder)?;
    let is_own = |found: &Approaches| {
        found.case.is_empty()
            && own.as_ref().is_some_and(|own| found.names() == own.each_ref().map(|name| &name[..]))
    };
    let rows = found.filter(is_own).map_or(Vec::new(), |found| found.rows);
    let mut short: Vec<(f64, &ApproachRow)> =
        rows.iter().filter_map(|row| Some((row.margin_m.filter(|margin| *margin < 0.0)?, row))).collect();
    short.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut worst: Vec<(f64, &ApproachRow)> = Vec::new();
    for (margin, row) in short {
        if !worst.iter().any(|(_, known)| (&known.scene, &known.entry) == (&row.scene, &row.entry)) {
            worst.push((margin, row));
        }
    }
    Ok(worst.into_iter().map(|(margin, row)| describe_way(margin, row)).collect())
}

fn describe_way(margin: f64, row: &ApproachRow) -> (String, String) {
    let ApproachRow { body, entry, shadowed_by, deepest_m, noticed_m, needed_m, .. } = row;
    let place = match shadowed_by {
        Some(object) => format!("see behind {object}, or block the path there"),
        None => "watch the path there, or block it".into(),
    };
    let near = [*deepest_m, *noticed_m].into_iter().flatten().reduce(f64::min);
    let near = near.map_or(String::new(), |near| format!(" comes as near as {} m", rounded_down(near, 2)));
    let needed = needed_m.map_or(String::new(), |needed| format!(", {} m are needed", rounded_up(needed, 2)));
    let change = format!("{place}: {body} from {entry}{near}{needed}");
    (format!("{} m", rounded_up(-margin, 2)), change)
}

/// The largest causes of unknown space in the region, over all scenes.
fn unknown_causes(findings: &Findings, region: &str) -> Vec<(String, String)> {
    let explained = findings.cells.labels.iter().flat_map(|labels| &labels.explained);
    let own = explained.filter(|(of, _)| *of == ExplainedVoxels::Recommended).map(|(_, why)| why);
    let (mut causes, mut total): (Vec<(&str, &str, u64, u64)>, u64) = (Vec::new(), 0);
    for why in own {
        total += why.total;
        for one in &why.advice {
            match causes.iter_mut().find(|(cause, ..)| *cause == one.cause) {
                Some((_, _, voxels, human)) => (*voxels, *human) = (*voxels + one.voxels, *human + one.human),
                None => causes.push((&one.cause, &one.cure, one.voxels, one.human)),
            }
        }
    }
    causes.sort_by_key(|(_, _, voxels, _)| std::cmp::Reverse(*voxels));
    let change = |(cause, cure, voxels, human): (&str, &str, u64, u64)| {
        let people = if human > 0 { format!(", {human} of them people’s") } else { String::new() };
        let gain = format!("up to {} of region {region}", percent(voxels as f64 / total as f64, 1));
        (gain, format!("{cure} ({cause}: {voxels} voxels{people})"))
    };
    causes.into_iter().map(change).collect()
}
