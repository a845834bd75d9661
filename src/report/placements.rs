//! Placements side by side: two or more choices of poses, of one sweep or of two, by every score, with what
//! the positions of their study could reach at most. It reads what was counted, and casts nothing.

use std::path::{Path, PathBuf};

use super::NEAR_SIDE;
use super::Series;
use super::best::{FEWER, cells, count};
use super::series;
use super::table::{NONE, Table, number};
use crate::error::Argument;
use crate::metrics::Score;
use crate::results::Results;
use crate::results::manifest::Manifest;
use crate::results::over::Over;
use crate::results::swept::CombinationResults;
use crate::view::names::{ChoiceNames, find_choices, unknown};
use crate::{Error, Result};

/// How many placements a table takes: as many as there are letters to call them.
pub const PLACEMENTS: std::ops::RangeInclusive<usize> = 2..=26;

/// What a score is over several scenes, snapshots and repeats, in the order of [`cells`].
const KINDS: [&str; 3] = ["mean", "worst", "pooled"];

/// One sweep or two, and the scenes over which their placements are compared.
pub struct Sweeps {
    all: Vec<FinishedSweep>,
    scopes: Vec<Scope>,
}

/// A finished sweep.
struct FinishedSweep {
    folder: PathBuf,
    results: Results,
    manifest: Manifest,
}

/// A scene, or several together.
struct Scope {
    title: String,
    /// Its moments in each sweep.
    moments: Vec<Vec<usize>>,
}

/// A choice of poses in one representation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RankedPlacement {
    sweep: usize,
    series: Series,
    choice: usize,
}

/// Which combination and representation placements are of.
#[derive(Clone, Copy, Debug, Default)]
pub struct Among<'a> {
    /// The combination; any, where it is not named.
    pub combination: Option<&'a str>,
    /// The representation.
    pub representation: Option<&'a str>,
}

impl Sweeps {
    /// Reads the folders of finished sweeps. `scene` is the one to be looked at; else it is all that the
    /// sweeps share. With them come sentences about what a reader should know.
    pub fn read(folders: &[PathBuf], scene: Option<&str>) -> Result<(Sweeps, Vec<String>)> {
        let (mut all, mut notes): (Vec<FinishedSweep>, Vec<String>) = (Vec::new(), Vec::new());
        for folder in folders {
            if all.iter().any(|sweep| is_same(&sweep.folder, folder)) {
                return Err(
                    Error::input(folder, "is named twice").wanted("name another sweep, or this one once")
                );
            }
            let (results, warnings) = Results::read(folder)?;
            notes.extend(warnings);
            all.push(FinishedSweep { folder: folder.clone(), results, manifest: Manifest::read(folder)? });
        }
        notes.extend(differences(&all));
        let scopes = scopes(&all, scene, &mut notes)?;
        Ok((Sweeps { all, scopes }, notes))
    }

    /// The regions that all sweeps have, or the one that is named, and a sentence about those that are left
    /// out.
    pub fn regions(&self, name: Option<&str>) -> Result<(Vec<String>, Option<String>)> {
        let names = |sweep: &FinishedSweep| sweep.results.regions.clone();
        let shared = shared(self.all.iter().map(names));
        if let Some(name) = name {
            let found = shared.iter().find(|region| *region == name).cloned();
            return found
                .map(|name| (vec![name], None))
                .ok_or_else(|| unknown(Argument::Region, Some(name), &shared));
        }
        if shared.is_empty() {
            let folders = self.all.iter().map(|sweep| sweep.folder.display().to_string());
            let what = "have no region in common: compare sweeps of studies that name their regions alike";
            return Err(Error::input(folders.collect::<Vec<_>>().join(" and "), what));
        }
        let left_out = left_out("region", &shared, self.all.iter().flat_map(names));
        Ok((shared, left_out))
    }

    /// The placements of these names in every sweep that has them, each once, and why a sweep has none.
    pub fn named(&self, poses: &[String], among: Among) -> Result<(Vec<RankedPlacement>, Vec<Error>)> {
        let (mut found, mut left_out): (Vec<RankedPlacement>, Vec<Error>) = (Vec::new(), Vec::new());
        for poses in poses {
            let each = self.all.iter().enumerate().map(|(sweep, _)| self.of_name(sweep, poses, among));
            let (those, mut errors): (Vec<_>, Vec<_>) = each.partition(|one| one.is_ok());
            if those.is_empty()
                && let Some(Err(error)) = errors.pop()
            {
                return Err(error);
            }
            left_out.extend(errors.into_iter().filter_map(Result::err));
            for placement in those.into_iter().flatten().flatten() {
                if !found.contains(&placement) {
                    found.push(placement);
                }
            }
        }
        Ok((found, left_out))
    }

    fn of_name(&self, sweep: usize, poses: &str, among: Among) -> Result<Vec<RankedPlacement>> {
        let FinishedSweep { folder, results, .. } = &self.all[sweep];
        let names: Vec<ChoiceNames> = results.combinations.iter().map(choice_names).collect();
        let found = find_choices(&names, poses, among.combination).map_err(|e| e.at(folder))?;
        let placement = |(combination, choice): (usize, usize)| {
            let known = &results.combinations[combination].representations;
            let representation =
                among.representation.map_or(Some(0), |name| known.iter().position(|k| k == name));
            let representation =
                representation.ok_or_else(|| unknown(Argument::Representation, among.representation, known));
            let series = Series { combination, representation: representation? };
            Ok(RankedPlacement { sweep, series, choice })
        };
        found.into_iter().map(placement).collect()
    }

    /// The best few placements of each sweep by a score in a region, of all combinations and representations
    /// together.
    pub fn best(
        &self,
        region: &str,
        score: Score,
        count: usize,
        among: Among,
    ) -> Result<Vec<RankedPlacement>> {
        let mut placements = Vec::new();
        for (sweep, FinishedSweep { results, .. }) in self.all.iter().enumerate() {
            let Some(at) = results.regions.iter().position(|name| name == region) else { continue };
            let moments = self.scopes[0].moments[sweep].iter().copied();
            let mut best: Vec<(RankedPlacement, f64)> = Vec::new();
            for series in self.among(sweep, among)? {
                let few = series.best(results, &moments, at, score)?.into_iter().take(count);
                best.extend(few.map(|(choice, value)| (RankedPlacement { sweep, series, choice }, value)));
            }
            best.sort_by(|a, b| score.merit(b.1).total_cmp(&score.merit(a.1)));
            placements.extend(best.into_iter().take(count).map(|(placement, _)| placement));
        }
        Ok(placements)
    }

    /// The series of a sweep that are asked for.
    fn among(&self, sweep: usize, among: Among) -> Result<Vec<Series>> {
        let results = &self.all[sweep].results;
        let known: Vec<&str> = results.combinations.iter().map(|c| c.name.as_str()).collect();
        if let Some(name) = among.combination.filter(|name| !known.contains(name)) {
            return Err(unknown(Argument::Combination, Some(name), &known));
        }
        let asked = |c: &usize| among.combination.is_none_or(|name| results.combinations[*c].name == name);
        let all = series(results, (0..known.len()).filter(asked));
        let name = |one: &Series| &results.combinations[one.combination].representations[one.representation];
        let asked = |one: &&Series| among.representation.is_none_or(|wanted| wanted == name(one));
        let found: Vec<Series> = all.iter().filter(asked).copied().collect();
        match found.is_empty() {
            true => Err(unknown(
                Argument::Representation,
                among.representation,
                &all.iter().map(name).collect::<Vec<_>>(),
            )),
            false => Ok(found),
        }
    }

    /// What the placements are called in the tables, where they are, and their names.
    pub fn key(&self, placements: &[RankedPlacement]) -> String {
        let mut text = String::new();
        for (letter, RankedPlacement { sweep, series, choice }) in ('A'..).zip(placements) {
            let FinishedSweep { folder, results, .. } = &self.all[*sweep];
            let combination = &results.combinations[series.combination];
            let [place, name] = [combination.place_of(*choice), combination.name_of(*choice)];
            let place = if place.is_empty() { "no place of its own" } else { &place };
            let of = if self.all.len() > 1 { format!(" · {}", folder.display()) } else { String::new() };
            text += &format!("\n{letter}  {place}\n   {name} · {}{of}\n", series.title(results));
        }
        text
    }

    /// The scores of some placements in a region that all sweeps have.
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
            // What is over one moment has one value.
            let kinds = match number {
                0 if self.has_several(scope) => 0..KINDS.len(),
                _ => 0..1,
            };
            for kind in kinds {
                for (row, score) in Score::ALL.into_iter().enumerate() {
                    let title = if kind == 0 && row == 0 { scope.title.clone() } else { String::new() };
                    let over = if row == 0 && self.has_several(scope) { KINDS[kind] } else { "" };
                    let mut cell = |over: Option<Over>| cells(over, &mut fewer)[kind].clone();
                    let of = |placement: &RankedPlacement| self.over(placement, scope, region, score);
                    let each: Vec<Option<Over>> = placements.iter().map(of).collect::<Result<_>>()?;
                    let difference = match each[..] {
                        [a, b] => Some(difference(value(a, kind), value(b, kind))),
                        _ => None,
                    };
                    let bound = |sweep: usize| self.bound(sweep, scope, region, score);
                    let bounds: Vec<String> = (0..self.all.len()).map(|sweep| cell(bound(sweep))).collect();
                    let begin = [title, over.into(), score.name().into()].into_iter();
                    let each: Vec<String> = each.into_iter().map(cell).collect();
                    table.row(begin.chain(each).chain(difference).chain(bounds));
                }
            }
        }
        let footnote = if fewer { FEWER } else { "" };
        Ok(format!("\nRegion {region}\n{footnote}{}{NEAR_SIDE}\n", table.text()))
    }

    /// A score of a placement.
    fn over(
        &self,
        placement: &RankedPlacement,
        scope: &Scope,
        region: &str,
        score: Score,
    ) -> Result<Option<Over>> {
        let RankedPlacement { sweep, series, choice } = *placement;
        let results = &self.all[sweep].results;
        let Some(region) = results.regions.iter().position(|name| name == region) else { return Ok(None) };
        results.over(scope.moments[sweep].iter().copied(), series.key(choice, region), score)
    }

    /// What the positions of a sweep could reach at most.
    fn bound(&self, sweep: usize, scope: &Scope, region: &str, score: Score) -> Option<Over> {
        let results = &self.all[sweep].results;
        let region = results.regions.iter().position(|name| name == region)?;
        let [(_, bound), ..] = results.baselines_over(scope.moments[sweep].iter().copied(), region, score);
        bound
    }

    /// Whether scores of a scope are over more than one moment or repeat.
    fn has_several(&self, scope: &Scope) -> bool {
        let mut each = self.all.iter().zip(&scope.moments);
        each.any(|(sweep, moments)| moments.len() * sweep.results.repeats > 1)
    }
}

/// In words, what decides the counts and is not the same in two sweeps.
fn differences(all: &[FinishedSweep]) -> Vec<String> {
    let [first, second] = all else { return Vec::new() };
    let [a, b] = [first, second].map(|sweep| sweep.folder.display().to_string());
    if first.manifest.fingerprint() == second.manifest.fingerprint() {
        return vec![format!("{a} and {b} are sweeps of the same study, and have the same scores")];
    }
    let mut notes = vec![format!("from {a} to {b}: {}", first.manifest.changes(&second.manifest).join("; "))];
    let size = |sweep: &FinishedSweep| sweep.manifest.identity.voxel_size_m;
    if size(first) != size(second) {
        notes.push("scores at different voxel sizes are not comparable".into());
    }
    notes
}

/// The scene that is asked for; else all that the sweeps share together, and each of them.
fn scopes(all: &[FinishedSweep], scene: Option<&str>, notes: &mut Vec<String>) -> Result<Vec<Scope>> {
    let names = |sweep: &FinishedSweep| {
        sweep.results.scenes.iter().map(|scene| scene.name.clone()).collect::<Vec<_>>()
    };
    let shared = shared(all.iter().map(names));
    let scope = |title: &str, of: &[String]| {
        let scenes = |sweep: &FinishedSweep| {
            let asked = sweep.results.scenes.iter().filter(|scene| of.contains(&scene.name));
            asked.flat_map(|scene| scene.moments.clone()).collect()
        };
        Scope { title: title.into(), moments: all.iter().map(scenes).collect() }
    };
    if let Some(name) = scene {
        let found = shared.iter().find(|known| *known == name);
        let found = found.ok_or_else(|| unknown(Argument::Scene, Some(name), &shared))?;
        return Ok(vec![scope(found, std::slice::from_ref(found))]);
    }
    if shared.is_empty() {
        notes.push("the sweeps have no scene in common: each is scored over all of its own".into());
        return Ok(vec![scope("own scenes", &all.iter().flat_map(names).collect::<Vec<_>>())]);
    }
    notes.extend(left_out("scene", &shared, all.iter().flat_map(names)));
    let each: Vec<Scope> = shared.iter().map(|name| scope(name, std::slice::from_ref(name))).collect();
    let together = (shared.len() > 1).then(|| scope(&count(shared.len(), "scene"), &shared));
    Ok(together.into_iter().chain(each).collect())
}

/// What all have, in the order of the first.
fn shared(mut all: impl Iterator<Item = Vec<String>>) -> Vec<String> {
    let first = all.next().unwrap_or_default();
    all.fold(first, |shared, names| shared.into_iter().filter(|name| names.contains(name)).collect())
}

/// A sentence about what one of the sweeps has alone.
fn left_out(what: &str, shared: &[String], all: impl Iterator<Item = String>) -> Option<String> {
    let alone: Vec<String> = all.filter(|name| !shared.contains(name)).collect();
    (!alone.is_empty()).then(|| format!("left out, since one sweep has no such {what}: {}", alone.join(", ")))
}

/// The names of a combination's choices.
fn choice_names(combination: &CombinationResults) -> ChoiceNames<'_> {
    let members = combination.members.iter().map(|member| {
        let poses = member.candidates.iter().map(|&candidate| member.poses[candidate].name.as_str());
        (member.sensor.as_str(), poses.collect())
    });
    ChoiceNames { combination: &combination.name, members: members.collect() }
}

/// Mean, worst or pooled.
fn value(over: Option<Over>, kind: usize) -> Option<f64> {
    let Over { mean, worst, pooled, .. } = over?;
    [Some(mean), Some(worst), pooled][kind]
}

/// The second less the first, with its sign.
fn difference(first: Option<f64>, second: Option<f64>) -> String {
    let Some((first, second)) = first.zip(second) else { return NONE.into() };
    let text = number(Some(second - first));
    if second > first && text != "0.000" { format!("+{text}") } else { text }
}

fn is_same(a: &Path, b: &Path) -> bool {
    let [a, b] = [a, b].map(std::fs::canonicalize);
    a.is_ok_and(|a| b.is_ok_and(|b| a == b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_has_a_sign_unless_it_rounds_to_nothing() {
        let told = [(0.25, 0.5), (0.5, 0.25), (0.5, 0.5), (0.5, 0.5004), (0.5004, 0.5)]
            .map(|(first, second)| difference(Some(first), Some(second)));
        assert_eq!(told, ["+0.250", "-0.250", "0.000", "0.000", "0.000"]);
        assert_eq!(difference(None, Some(1.0)), NONE);
    }
}
