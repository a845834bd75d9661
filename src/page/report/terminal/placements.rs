//! Placements side by side: two or more choices of poses, of one sweep or of two, by every score, with the upper bound
//! of their study's positions. The scores are existing counts; nothing is cast.

mod chosen;
mod sweeps;

use super::best::{FEWER, cells};
use crate::report::NEAR_SIDE;
use crate::report::table::{NONE, Table, number};
pub use chosen::{PlacementFilter, RankedPlacement};
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_sweep::results::over::Over;
use sweeps::FinishedSweep;
pub use sweeps::Sweeps;

/// The number of placements in a table: limited by the letters.
pub const PLACEMENTS: std::ops::RangeInclusive<usize> = 2..=26;

/// The aggregates of a score over several scenes, snapshots and repeats, in the order of [`cells`].
const KINDS: [&str; 3] = ["mean", "worst", "pooled"];

impl Sweeps {
    /// The letters of the placements in the tables, with their places and names.
    pub fn key(&self, placements: &[RankedPlacement]) -> String {
        let mut text = String::new();
        for (letter, RankedPlacement { sweep, series, choice }) in ('A'..).zip(placements) {
            let FinishedSweep { folder, results, .. } = &self.all[*sweep];
            let combination = &results.combinations[series.combination];
            let [place, name] = [combination.place_of(*choice), combination.name_of(*choice)];
            let place = if place.is_empty() { "no place" } else { &place };
            let source = if self.all.len() > 1 { format!(" · {}", folder.display()) } else { String::new() };
            text += &format!("\n{letter}  {place}\n   {name} · {}{source}\n", series.title(results));
        }
        text
    }

    /// The scores of some placements in a common region of all sweeps.
    pub fn render(&self, region: &str, placements: &[RankedPlacement]) -> Result<String> {
        let letters: Vec<String> = ('A'..).take(placements.len()).map(String::from).collect();
        let bounds = self.all.iter().map(|sweep| match self.all.len() {
            1 => "upper bound".into(),
            _ => format!("upper bound, {}", sweep.folder.display()),
        });
        let compared = (placements.len() == 2).then(|| "B − A".to_string());
        let columns =
            ["<", "<", "<"].map(String::from).into_iter().chain(letters).chain(compared).chain(bounds);
        let columns: Vec<String> = columns.collect();
        let mut table = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
        let mut fewer = false;
        for (number, scope) in self.scopes.iter().enumerate() {
            // Over one moment all aggregates are equal; for single scenes the mean suffices.
            let kinds = if number == 0 && self.has_several(scope) { 0..KINDS.len() } else { 0..1 };
            for kind in kinds {
                for (row, score) in Score::ALL.into_iter().enumerate() {
                    let title = if kind == 0 && row == 0 { scope.title.as_str() } else { "" };
                    let over = if row == 0 && self.has_several(scope) { KINDS[kind] } else { "" };
                    let score_of = |placement| self.score(placement, scope, region, score);
                    let each: Vec<Option<Over>> = placements.iter().map(score_of).collect::<Result<_>>()?;
                    let difference = match each[..] {
                        [a, b] => Some(difference(value(a, kind), value(b, kind))),
                        _ => None,
                    };
                    let mut cell = |over| cells(over, &mut fewer)[kind].clone();
                    let each: Vec<String> = each.into_iter().map(&mut cell).collect();
                    let bounds =
                        (0..self.all.len()).map(|sweep| cell(self.bound(sweep, scope, region, score)));
                    let begin = [title, over, score.name()].map(String::from).into_iter();
                    table.row(begin.chain(each).chain(difference).chain(bounds));
                }
            }
        }
        let footnote = if fewer { FEWER } else { "" };
        Ok(format!("\nRegion {region}\n{footnote}{}{NEAR_SIDE}\n", table.text()))
    }
}

/// Mean, worst or pooled.
fn value(over: Option<Over>, kind: usize) -> Option<f64> {
    let Over { mean, worst, pooled, .. } = over?;
    [Some(mean), Some(worst), pooled][kind]
}

/// The second minus the first, with its sign.
fn difference(first: Option<f64>, second: Option<f64>) -> String {
    let Some((first, second)) = first.zip(second) else { return NONE.into() };
    let text = number(Some(second - first));
    if second > first && text != "0.000" { format!("+{text}") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_has_a_sign_unless_it_rounds_to_nothing() {
        let texts = [(0.25, 0.5), (0.5, 0.25), (0.5, 0.5), (0.5, 0.5004), (0.5004, 0.5)]
            .map(|(first, second)| difference(Some(first), Some(second)));
        assert_eq!(texts, ["+0.250", "-0.250", "0.000", "0.000", "0.000"]);
        assert_eq!(difference(None, Some(1.0)), NONE);
    }
}
