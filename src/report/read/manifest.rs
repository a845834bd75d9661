//! What a summary needs of `manifest.json`: scenes with their regions and baselines, combinations with their sensors.

use std::path::Path;

use serde::Deserialize;

use super::{CURE, MOST_VOXELS};
use crate::metrics::Confusion;
use crate::report::results::{CombinationResults, Results, SceneResults};
use crate::sweep::table::BETWEEN_MEMBERS;
use crate::sweep::world::Baselines;
use crate::{Error, Result, SEMANTICS_VERSION};

/// No sweep has more choices or repeats; beyond it, products of counts would not be numbers any more.
const MOST: usize = 100_000_000;

#[derive(Deserialize)]
struct ManifestFile {
    perirobot: String,
    semantics_version: u32,
    repeats: usize,
    scenes: Vec<SceneFile>,
    sensors: Vec<SensorFile>,
    combinations: Vec<CombinationFile>,
}

#[derive(Deserialize)]
struct SceneFile {
    name: String,
    snapshot: usize,
    regions: Vec<RegionFile>,
}

#[derive(Deserialize)]
struct RegionFile {
    name: String,
    baselines: BaselinesFile,
}

#[derive(Clone, Copy, Deserialize)]
struct BaselinesFile {
    all_occupied: Confusion,
    all_free: Confusion,
    nothing_seen: Confusion,
    ceiling: Confusion,
}

#[derive(Deserialize)]
struct SensorFile {
    name: String,
    representations: Vec<String>,
}

#[derive(Deserialize)]
struct CombinationFile {
    name: String,
    sensors: Vec<String>,
    choices: usize,
}

/// Results without choices and counts, how many choices each combination has, and warnings.
pub(super) fn read(path: &Path) -> Result<(Results, Vec<usize>, Vec<String>)> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "cannot be read", e))?;
    tracing::info!("read {}: {} bytes", path.display(), text.len());
    let says = |what: String| Error::input(path.display(), format!("{what}; {CURE}"));
    let file: ManifestFile = serde_json::from_str(&text).map_err(|e| says(e.to_string()))?;
    let choices: Vec<usize> = file.combinations.iter().map(|combination| combination.choices).collect();
    for number in choices.iter().chain([&file.repeats]) {
        if !(1..=MOST).contains(number) {
            return Err(says(format!("choices or repeats = {number}: must be from 1 to {MOST}")));
        }
    }
    let mut warnings = Vec::new();
    if file.semantics_version != SEMANTICS_VERSION {
        warnings.push(format!(
            "{}: perirobot {} counted by version {} of the rules, this is perirobot {} with version \
             {SEMANTICS_VERSION}: do not hold these scores against new ones; sweep again to compare",
            path.display(),
            file.perirobot,
            file.semantics_version,
            env!("CARGO_PKG_VERSION"),
        ));
    }
    let together = |region: &RegionFile| {
        let BaselinesFile { all_occupied, all_free, nothing_seen, ceiling } = region.baselines;
        let all = [all_occupied, all_free, nothing_seen, ceiling];
        if all.iter().flat_map(Confusion::counts).any(|count| count > MOST_VOXELS) {
            return Err(says(format!(
                "region {:?} has more voxels in its baselines than a grid",
                region.name
            )));
        }
        Ok(Baselines { all_occupied, all_free, nothing_seen, ceiling })
    };
    let Some(first) = file.scenes.first() else { return Err(says("scenes is empty".into())) };
    let regions: Vec<String> = first.regions.iter().map(|region| region.name.clone()).collect();
    let mut scenes: Vec<SceneResults> = Vec::new();
    let mut baselines = Vec::new();
    for scene in &file.scenes {
        if !scene.regions.iter().map(|region| &region.name).eq(&regions) {
            return Err(says(format!("scene {:?} has other regions than the first", scene.name)));
        }
        let moment = baselines.len();
        match scenes.last_mut() {
            Some(last) if last.name == scene.name && last.moments.len() == scene.snapshot => {
                last.moments.end += 1;
            }
            _ if scene.snapshot == 0 => {
                scenes.push(SceneResults { name: scene.name.clone(), moments: moment..moment + 1 });
            }
            _ => return Err(says(format!("scene {:?}: snapshot {} is alone", scene.name, scene.snapshot))),
        }
        baselines.push(scene.regions.iter().map(together).collect::<Result<_>>()?);
    }
    let combinations = file.combinations.iter().map(|entry| combination(entry, &file.sensors));
    let combinations = combinations.collect::<Result<_, String>>().map_err(says)?;
    let counts = Vec::new();
    Ok((
        Results { scenes, regions, repeats: file.repeats, combinations, baselines, counts },
        choices,
        warnings,
    ))
}

/// A combination without choices; its representations are every one of each sensor with every one of the others, those
/// of the last sensor varying fastest.
fn combination(entry: &CombinationFile, sensors: &[SensorFile]) -> Result<CombinationResults, String> {
    let mut representations: Option<Vec<String>> = None;
    for name in &entry.sensors {
        let Some(sensor) = sensors.iter().find(|sensor| sensor.name == *name) else {
            return Err(format!("combination {:?} has a sensor {name:?} that is not there", entry.name));
        };
        representations = Some(match representations {
            None => sensor.representations.clone(),
            Some(before) => before
                .iter()
                .flat_map(|one| {
                    sensor.representations.iter().map(move |r| format!("{one}{BETWEEN_MEMBERS}{r}"))
                })
                .collect(),
        });
    }
    let representations =
        representations.ok_or_else(|| format!("combination {:?} has no sensor", entry.name))?;
    Ok(CombinationResults {
        name: entry.name.clone(),
        sensors: entry.sensors.clone(),
        representations,
        choices: Vec::new(),
    })
}
