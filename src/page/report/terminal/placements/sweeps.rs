//! The folders of the compared sweeps, one or two, with their common scenes and regions.

use std::path::{Path, PathBuf};

use crate::report::wording::count;
use perirobot_decide::view::names::unknown;
use perirobot_march::error::Argument;
use perirobot_march::metrics::Score;
use perirobot_march::{Error, Result};
use perirobot_sweep::results::Results;
use perirobot_sweep::results::manifest::Manifest;
use perirobot_sweep::results::over::Over;

/// One sweep or two, with the compared scenes.
pub struct Sweeps {
    pub(super) all: Vec<FinishedSweep>,
    pub(super) scopes: Vec<Scope>,
}

/// A finished sweep.
pub(super) struct FinishedSweep {
    pub(super) folder: PathBuf,
    pub(super) results: Results,
    manifest: Manifest,
}

/// A scene, or several together.
pub(super) struct Scope {
    pub(super) title: String,
    /// Its moments in each sweep.
    pub(super) moments: Vec<Vec<usize>>,
}

impl Sweeps {
    /// Reads the folders of finished sweeps. `scene` is the compared one; otherwise all common scenes. Returns notes
    /// for the reader as well.
    pub fn read(folders: &[PathBuf], scene: Option<&str>) -> Result<(Sweeps, Vec<String>)> {
        let (mut all, mut notes): (Vec<FinishedSweep>, Vec<String>) = (Vec::new(), Vec::new());
        for folder in folders {
            if all.iter().any(|sweep| is_same(&sweep.folder, folder)) {
                return Err(Error::input(folder, "is named twice")
                    .with_advice("name another sweep, or this one once"));
            }
            let (results, warnings) = Results::read(folder)?;
            notes.extend(warnings);
            all.push(FinishedSweep { folder: folder.clone(), results, manifest: Manifest::read(folder)? });
        }
        notes.extend(differences(&all));
        let scopes = scopes(&all, scene, &mut notes)?;
        Ok((Sweeps { all, scopes }, notes))
    }

    /// The common regions, or only the named one, and a note on the omitted ones.
    pub fn regions(&self, name: Option<&str>) -> Result<(Vec<String>, Option<String>)> {
        let names = |sweep: &FinishedSweep| sweep.results.regions.clone();
        let shared = intersect(self.all.iter().map(names));
        if let Some(name) = name {
            let found = shared.iter().find(|region| *region == name).cloned();
            return found
                .map(|name| (vec![name], None))
                .ok_or_else(|| unknown(Argument("region"), Some(name), &shared));
        }
        if shared.is_empty() {
            let folders = self.all.iter().map(|sweep| sweep.folder.display().to_string());
            let what = "have no region in common: compare sweeps of studies that name their regions alike";
            return Err(Error::input(folders.collect::<Vec<_>>().join(" and "), what));
        }
        let left_out = left_out("region", &shared, self.all.iter().flat_map(names));
        Ok((shared, left_out))
    }

    /// The upper bound of a sweep's positions.
    pub(super) fn bound(&self, sweep: usize, scope: &Scope, region: &str, score: Score) -> Option<Over> {
        let results = &self.all[sweep].results;
        let region = results.regions.iter().position(|name| name == region)?;
        let [(_, bound), ..] = results.baselines_over(scope.moments[sweep].iter().copied(), region, score);
        bound
    }

    /// Whether scores of a scope are over more than one moment or repeat.
    pub(super) fn has_several(&self, scope: &Scope) -> bool {
        let mut each = self.all.iter().zip(&scope.moments);
        each.any(|(sweep, moments)| moments.len() * sweep.results.repeats > 1)
    }
}

/// The differences of two sweeps that affect counts, in words.
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

/// The requested scene; else all common scenes together, and each of them.
fn scopes(all: &[FinishedSweep], scene: Option<&str>, notes: &mut Vec<String>) -> Result<Vec<Scope>> {
    let names = |sweep: &FinishedSweep| {
        sweep.results.scenes.iter().map(|scene| scene.name.clone()).collect::<Vec<_>>()
    };
    let shared = intersect(all.iter().map(names));
    let scope = |title: &str, of: &[String]| {
        let scenes = |sweep: &FinishedSweep| {
            let requested = sweep.results.scenes.iter().filter(|scene| of.contains(&scene.name));
            requested.flat_map(|scene| scene.moments.clone()).collect()
        };
        Scope { title: title.into(), moments: all.iter().map(scenes).collect() }
    };
    if let Some(name) = scene {
        let found = shared.iter().find(|known| *known == name);
        let found = found.ok_or_else(|| unknown(Argument("scene"), Some(name), &shared))?;
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

/// The common names of all lists, in the order of the first.
fn intersect(mut all: impl Iterator<Item = Vec<String>>) -> Vec<String> {
    let first = all.next().unwrap_or_default();
    all.fold(first, |shared, names| shared.into_iter().filter(|name| names.contains(name)).collect())
}

/// A note on names in only one of the sweeps.
fn left_out(what: &str, shared: &[String], all: impl Iterator<Item = String>) -> Option<String> {
    let alone: Vec<String> = all.filter(|name| !shared.contains(name)).collect();
    (!alone.is_empty()).then(|| format!("left out, since one sweep has no such {what}: {}", alone.join(", ")))
}

fn is_same(a: &Path, b: &Path) -> bool {
    let [a, b] = [a, b].map(std::fs::canonicalize);
    a.is_ok_and(|a| b.is_ok_and(|b| a == b))
}
